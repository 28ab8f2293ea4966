// The pickle stack machine without its power to call: see pickle.h. Instruction codes after Python's
// pickletools.
#include "core/head/pickle.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <limits>
#include <optional>

#include "core/base/number_text.h"

namespace likeness {
namespace {

using Kind = PickleKind;

constexpr std::size_t kMaxNodes = 500'000;  // FLAME's files have a few hundred
constexpr std::size_t kMaxMarks = 10'000;   // Python's own picklers stop at about 1,000 levels
constexpr std::size_t kMaxName = 200;       // of a module or class

class Machine {
 public:
  Machine(std::span<const std::byte> file, PickleDocument& document) : file_(file), document_(document) {}

  // False after the first fault.
  bool run() {
    bool running = true;
    while (running && !error_) {
      instruction_ = at_;
      const std::uint8_t code = byte();
      if (error_) break;
      running = code != '.';
      if (running) step(code);
    }
    if (!error_) {
      document_.root = pop();
      document_.end = at_;
    }
    return !error_;
  }
  const Error& error() const { return *error_; }

 private:
  void fail(const std::string& what) {
    if (error_) return;
    error_ = Error{ErrorCode::bad_input,
                   fmt::format("The pickle cannot be read at byte {}: {}.", instruction_, what),
                   "The file is damaged, cut short or of another kind; get it again from where it came from.",
                   document_.name};
  }

  // -- The file
  std::string_view take(std::uint64_t count) {
    if (error_) return {};
    if (count > file_.size() - at_) {
      fail(fmt::format("{} bytes are needed and {} are left", count, file_.size() - at_));
      return {};
    }
    const std::string_view bytes(reinterpret_cast<const char*>(file_.data()) + at_, std::size_t(count));
    at_ += std::size_t(count);
    return bytes;
  }
  std::uint8_t byte() {
    const std::string_view one = take(1);
    return one.empty() ? 0 : std::uint8_t(one[0]);
  }
  std::uint64_t unsigned_of(int bytes) {
    const std::string_view raw = take(std::uint64_t(bytes));
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < raw.size(); ++i) value |= std::uint64_t(std::uint8_t(raw[i])) << (8 * i);
    return value;
  }
  std::string_view line() {
    const char* begin = reinterpret_cast<const char*>(file_.data()) + at_;
    const std::size_t left = file_.size() - at_;
    const void* found = left > 0 ? std::memchr(begin, '\n', left) : nullptr;
    if (!found) {
      fail("a line has no end");
      return {};
    }
    const std::size_t length = std::size_t(static_cast<const char*>(found) - begin);
    at_ += length + 1;
    return {begin, length};
  }

  // -- The stack
  PickleRef make(PickleNode node) {
    if (document_.nodes.size() >= kMaxNodes) {
      fail(fmt::format("it holds more than {} values", kMaxNodes));
      return 0;
    }
    node.offset = std::uint32_t(instruction_);
    document_.nodes.push_back(std::move(node));
    return PickleRef(document_.nodes.size() - 1);
  }
  void push(PickleRef ref) { stack_.push_back(ref); }
  void push_new(PickleNode node) { push(make(std::move(node))); }
  void push_text(Kind kind, std::string_view text) {
    PickleNode node;
    node.kind = kind, node.text = text;
    push_new(std::move(node));
  }
  void push_integer(std::int64_t value, Kind kind = Kind::integer) {
    PickleNode node;
    node.kind = kind, node.integer = value;
    push_new(std::move(node));
  }
  void push_items(Kind kind, std::vector<PickleRef> items) {
    PickleNode node;
    node.kind = kind, node.items = std::move(items);
    push_new(std::move(node));
  }
  std::size_t floor() const { return marks_.empty() ? 0 : marks_.back(); }
  PickleRef pop() {
    if (error_) return 0;
    if (stack_.size() <= floor()) {
      fail("the stack is empty");
      return 0;
    }
    const PickleRef top = stack_.back();
    stack_.pop_back();
    return top;
  }
  std::vector<PickleRef> pop_many(std::size_t count) {
    if (error_ || stack_.size() - floor() < count) {
      fail("the stack is empty");
      return {};
    }
    std::vector<PickleRef> items(stack_.end() - std::ptrdiff_t(count), stack_.end());
    stack_.resize(stack_.size() - count);
    return items;
  }
  std::vector<PickleRef> pop_to_mark() {
    if (error_ || marks_.empty()) {
      fail("a mark is missing");
      return {};
    }
    const std::size_t mark = marks_.back();
    marks_.pop_back();
    std::vector<PickleRef> items(stack_.begin() + std::ptrdiff_t(mark), stack_.end());
    stack_.resize(mark);
    return items;
  }
  // The value on top, which must be one of two kinds; nullptr after a fault.
  PickleNode* top(Kind kind, Kind other, const char* what) {
    if (error_) return nullptr;
    if (stack_.size() <= floor()) {
      fail("the stack is empty");
      return nullptr;
    }
    PickleNode& node = document_.nodes[stack_.back()];
    if (node.kind == kind || node.kind == other) return &node;
    fail(fmt::format("{} is expected on the stack", what));
    return nullptr;
  }
  void add_items(PickleNode* container, const std::vector<PickleRef>& items) {
    if (container) container->items.insert(container->items.end(), items.begin(), items.end());
  }
  // Elements for a list that is on top; those of objects that extend list or dict are dropped.
  void append(const std::vector<PickleRef>& items) {
    PickleNode* list = top(Kind::list, Kind::object, "a list");
    if (list && list->kind == Kind::list) add_items(list, items);
  }
  void set_items(const std::vector<PickleRef>& items) {
    PickleNode* dict = top(Kind::dict, Kind::object, "a dict");
    if (items.size() % 2 != 0) return fail("a key has no value");
    if (dict && dict->kind == Kind::dict) add_items(dict, items);
  }

  // -- Memo
  void memoize(std::uint64_t index) {
    if (error_) return;
    if (stack_.size() <= floor()) return fail("the stack is empty");
    if (index > file_.size()) return fail(fmt::format("memo {} is out of range", index));
    if (index >= memo_.size()) memo_.resize(std::size_t(index) + 1, kNoRef);
    memo_[std::size_t(index)] = stack_.back();
    ++memo_count_;
  }
  void recall(std::uint64_t index) {
    if (error_) return;
    if (index >= memo_.size() || memo_[std::size_t(index)] == kNoRef)
      return fail(fmt::format("memo {} was never set", index));
    push(memo_[std::size_t(index)]);
  }

  // -- Numbers and texts
  std::int64_t decimal(std::string_view text) {
    std::int64_t value = 0;
    if (text.ends_with('L')) text.remove_suffix(1);
    const auto parsed = std::from_chars(text.data(), text.data() + text.size(), value);
    if (parsed.ec == std::errc::result_out_of_range)
      return text.starts_with('-') ? std::numeric_limits<std::int64_t>::min()
                                   : std::numeric_limits<std::int64_t>::max();
    if (parsed.ec != std::errc() || parsed.ptr != text.data() + text.size() || text.empty())
      fail("a number is expected");
    return value;
  }
  void push_long(std::string_view raw) {  // little-endian two's complement of any length
    const bool negative = !raw.empty() && (raw.back() & 0x80);
    std::uint64_t value = negative ? ~std::uint64_t(0) : 0;
    bool fits = true;
    for (std::size_t i = 0; i < raw.size(); ++i) {
      const auto digit = std::uint8_t(raw[i]);
      if (i < 8)
        value = (value & ~(std::uint64_t(0xff) << (8 * i))) | std::uint64_t(digit) << (8 * i);
      else
        fits = fits && digit == (negative ? 0xff : 0);
    }
    if (raw.size() > 8 && (std::int64_t(value) < 0) != negative) fits = false;
    if (!fits)
      value = negative ? std::uint64_t(std::numeric_limits<std::int64_t>::min())
                       : std::uint64_t(std::numeric_limits<std::int64_t>::max());
    push_integer(std::int64_t(value));
  }
  void push_real(double value) {
    PickleNode node;
    node.kind = Kind::real, node.real = value;
    push_new(std::move(node));
  }
  void push_binary_float() {
    const std::string_view raw = take(8);
    std::uint64_t bits = 0;
    for (const char c : raw) bits = bits << 8 | std::uint8_t(c);
    push_real(std::bit_cast<double>(bits));
  }
  void push_text_float() {
    std::string_view text = line();
    double value = 0;
    if (!take_number(text, value) && !error_) fail("a number is expected");
    push_real(value);
  }
  // Protocol 0's str: a Python literal in quotes.
  void push_quoted() {
    std::string_view text = line();
    if (text.size() < 2 || text.front() != text.back() || (text.front() != '\'' && text.front() != '"'))
      return fail("quoted text is expected");
    text = text.substr(1, text.size() - 2);
    if (text.find('\\') == std::string_view::npos) return push_text(Kind::bytes, text);
    std::string plain;
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] != '\\' || i + 1 == text.size()) {
        plain += text[i];
        continue;
      }
      const char c = text[++i];
      unsigned code = 0;
      if (c == 'x' && i + 2 < text.size() &&
          std::from_chars(text.data() + i + 1, text.data() + i + 3, code, 16).ptr == text.data() + i + 3) {
        plain += char(code);
        i += 2;
      } else {
        plain += c == 'n' ? '\n' : c == 't' ? '\t' : c == 'r' ? '\r' : c;
      }
    }
    document_.decoded.push_back(std::move(plain));
    push_text(Kind::bytes, document_.decoded.back());
  }
  // Protocol 0's Unicode: Latin-1 with \uXXXX and \UXXXXXXXX for other characters.
  void push_escaped(std::string_view text) {
    std::string plain;
    const auto append = [&plain](unsigned code) {
      if (code < 0x80) {
        plain += char(code);
      } else if (code < 0x800) {
        plain += {char(0xc0 | code >> 6), char(0x80 | (code & 0x3f))};
      } else if (code < 0x10000) {
        plain += {char(0xe0 | code >> 12), char(0x80 | (code >> 6 & 0x3f)), char(0x80 | (code & 0x3f))};
      } else {
        plain += {char(0xf0 | (code >> 18 & 7)), char(0x80 | (code >> 12 & 0x3f)),
                  char(0x80 | (code >> 6 & 0x3f)), char(0x80 | (code & 0x3f))};
      }
    };
    for (std::size_t i = 0; i < text.size(); ++i) {
      const std::size_t digits = !text.substr(i).starts_with('\\') || i + 1 == text.size() ? 0
                                 : text[i + 1] == 'u'                                      ? 4
                                 : text[i + 1] == 'U'                                      ? 8
                                                                                           : 0;
      unsigned code = 0;
      const char* first = text.data() + i + 2;
      if (digits > 0 && i + 2 + digits <= text.size() &&
          std::from_chars(first, first + digits, code, 16).ptr == first + digits) {
        append(code);
        i += 1 + digits;
      } else {
        append(std::uint8_t(text[i]));
      }
    }
    document_.decoded.push_back(std::move(plain));
    push_text(Kind::text, document_.decoded.back());
  }
  void push_object(PickleRef callable, PickleRef arguments) {
    push_items(Kind::object, {callable, arguments});
  }
  void push_global(std::string_view module, std::string_view name) {
    if (module.size() > kMaxName || name.size() > kMaxName) return fail("a name is too long");
    document_.decoded.push_back(std::string(module) + ' ' + std::string(name));
    push_text(Kind::global, document_.decoded.back());
  }
  std::string_view popped_text() {
    const PickleRef ref = pop();
    if (error_) return {};
    const PickleNode& node = document_.nodes[ref];
    if ((node.kind != Kind::text && node.kind != Kind::bytes) || node.text.size() > kMaxName) {
      fail("a name is expected on the stack");
      return {};
    }
    return node.text;
  }

  void step(std::uint8_t code);
  bool step_values(std::uint8_t code);
  bool step_containers(std::uint8_t code);
  bool step_objects(std::uint8_t code);

  static constexpr PickleRef kNoRef = std::numeric_limits<PickleRef>::max();
  std::span<const std::byte> file_;
  PickleDocument& document_;
  std::size_t at_ = 0, instruction_ = 0;
  std::vector<PickleRef> stack_, memo_;
  std::vector<std::size_t> marks_;
  std::size_t memo_count_ = 0;
  std::optional<Error> error_;
};

bool Machine::step_values(std::uint8_t code) {
  switch (code) {
    case 'N':
      return push_new({}), true;
    case 0x88:
    case 0x89:
      return push_integer(code == 0x88, Kind::boolean), true;
    case 'I': {  // "00" and "01" are the booleans
      const std::string_view text = line();
      const bool boolean = text == "00" || text == "01";
      return push_integer(decimal(text), boolean ? Kind::boolean : Kind::integer), true;
    }
    case 'L':
      return push_integer(decimal(line())), true;
    case 'J':
      return push_integer(std::int32_t(unsigned_of(4))), true;
    case 'K':
      return push_integer(byte()), true;
    case 'M':
      return push_integer(std::int64_t(unsigned_of(2))), true;
    case 0x8a:
      return push_long(take(unsigned_of(1))), true;
    case 0x8b:
      return push_long(take(unsigned_of(4))), true;
    case 'F':
      return push_text_float(), true;
    case 'G':
      return push_binary_float(), true;
    case 'S':
      return push_quoted(), true;
    case 'V':
      return push_escaped(line()), true;
    case 'U':
    case 'C':
      return push_text(Kind::bytes, take(unsigned_of(1))), true;
    case 'T':
    case 'B':
      return push_text(Kind::bytes, take(unsigned_of(4))), true;
    case 0x8e:
    case 0x96:
      return push_text(Kind::bytes, take(unsigned_of(8))), true;
    case 0x8c:
      return push_text(Kind::text, take(unsigned_of(1))), true;
    case 'X':
      return push_text(Kind::text, take(unsigned_of(4))), true;
    case 0x8d:
      return push_text(Kind::text, take(unsigned_of(8))), true;
    default:
      return false;
  }
}

bool Machine::step_containers(std::uint8_t code) {
  switch (code) {
    case '(':
      if (marks_.size() >= kMaxMarks) fail(fmt::format("it nests deeper than {} levels", kMaxMarks));
      return marks_.push_back(stack_.size()), true;
    case ')':
      return push_items(Kind::tuple, {}), true;
    case ']':
      return push_items(Kind::list, {}), true;
    case '}':
      return push_items(Kind::dict, {}), true;
    case 0x8f:
      return push_items(Kind::set, {}), true;
    case 't':
      return push_items(Kind::tuple, pop_to_mark()), true;
    case 0x85:
    case 0x86:
    case 0x87:
      return push_items(Kind::tuple, pop_many(code - 0x84u)), true;
    case 'l':
      return push_items(Kind::list, pop_to_mark()), true;
    case 'd':
      push_items(Kind::dict, {});
      if (!error_) {
        const PickleRef dict = pop();
        const std::vector<PickleRef> items = pop_to_mark();
        push(dict);
        set_items(items);
      }
      return true;
    case 0x91:
      return push_items(Kind::set, pop_to_mark()), true;  // frozenset
    case 'a':
      return append(pop_many(1)), true;
    case 'e':
      return append(pop_to_mark()), true;
    case 's':
      return set_items(pop_many(2)), true;
    case 'u':
      return set_items(pop_to_mark()), true;
    case 0x90: {
      const std::vector<PickleRef> items = pop_to_mark();
      return add_items(top(Kind::set, Kind::set, "a set"), items), true;
    }
    default:
      return false;
  }
}

bool Machine::step_objects(std::uint8_t code) {
  switch (code) {
    case 'c': {
      const std::string_view module = line();
      return push_global(module, line()), true;
    }
    case 0x93: {
      const std::string_view name = popped_text(), module = popped_text();
      return push_global(module, name), true;
    }
    case 'R':     // callable, arguments
    case 0x81: {  // class, arguments
      const std::vector<PickleRef> pair = pop_many(2);
      if (!error_) push_object(pair[0], pair[1]);
      return true;
    }
    case 0x92: {  // class, arguments, keyword arguments
      const std::vector<PickleRef> three = pop_many(3);
      if (!error_) push_object(three[0], three[1]);
      return true;
    }
    case 'i': {  // old classes: module and name as lines, arguments down to the mark
      const std::string_view module = line(), name = line();
      push_global(module, name);
      const PickleRef callable = pop();
      const std::vector<PickleRef> arguments = pop_to_mark();
      push_items(Kind::tuple, arguments);
      const PickleRef tuple = pop();
      return push_object(callable, tuple), true;
    }
    case 'o': {
      std::vector<PickleRef> items = pop_to_mark();
      if (items.empty()) return fail("a class is missing"), true;
      const PickleRef callable = items.front();
      items.erase(items.begin());
      push_items(Kind::tuple, std::move(items));
      const PickleRef tuple = pop();
      return push_object(callable, tuple), true;
    }
    case 'b': {
      const PickleRef state = pop();
      PickleNode* object = top(Kind::object, Kind::object, "an object");
      if (object) object->items.resize(3), object->items[2] = state;
      return true;
    }
    case 'Q':
      return push_items(Kind::persistent, pop_many(1)), true;
    case 'P':
      push_text(Kind::bytes, line());
      return push_items(Kind::persistent, pop_many(1)), true;
    default:
      return false;
  }
}

void Machine::step(std::uint8_t code) {
  if (step_values(code) || step_containers(code) || step_objects(code)) return;
  switch (code) {
    case 0x80:  // protocol
      if (const std::uint8_t version = byte(); version > 5)
        fail(fmt::format("it has protocol {}, and Likeness reads 0 to 5", version));
      return;
    case 0x95:  // frame: only a hint of how much to read at once
      if (const std::uint64_t length = unsigned_of(8); length > file_.size() - at_)
        fail(fmt::format("a frame of {} bytes is promised and {} are left", length, file_.size() - at_));
      return;
    case '0':
      if (!marks_.empty() && stack_.size() == marks_.back())
        marks_.pop_back();
      else
        pop();
      return;
    case '1':
      pop_to_mark();
      return;
    case '2': {
      const PickleRef ref = pop();
      return push(ref), push(ref);
    }
    case 'p':
      return memoize(std::uint64_t(decimal(line())));
    case 'q':
      return memoize(unsigned_of(1));
    case 'r':
      return memoize(unsigned_of(4));
    case 0x94:
      return memoize(memo_count_);
    case 'g':
      return recall(std::uint64_t(decimal(line())));
    case 'h':
      return recall(unsigned_of(1));
    case 'j':
      return recall(unsigned_of(4));
    default:
      return fail(fmt::format("instruction {:#04x} is unknown or needs data that is not in the file", code));
  }
}

}  // namespace

Result<PickleDocument> read_pickle(std::span<const std::byte> file, const std::string& name) {
  if (file.size() >= std::numeric_limits<std::uint32_t>::max())
    return Error{ErrorCode::bad_input, "The pickle is larger than 4 GiB.",
                 "Choose the head model file itself.", name};
  PickleDocument document;
  document.file = file;
  document.name = name;
  Machine machine(file, document);
  if (!machine.run()) return machine.error();
  return document;
}

const PickleRef* find_key(const PickleDocument& document, PickleRef dict, std::string_view key) {
  const PickleNode& node = document.node(dict);
  if (node.kind != PickleKind::dict) return nullptr;
  const PickleRef* found = nullptr;  // the last of a repeated key counts, as in Python
  for (std::size_t i = 0; i + 1 < node.items.size(); i += 2) {
    const PickleNode& name = document.node(node.items[i]);
    if ((name.kind == PickleKind::text || name.kind == PickleKind::bytes) && name.text == key)
      found = &node.items[i + 1];
  }
  return found;
}

std::string_view object_type(const PickleDocument& document, PickleRef ref) {
  const PickleNode& node = document.node(ref);
  if (node.kind != PickleKind::object) return {};
  const PickleNode* callable = &document.node(node.items[0]);
  // Protocols 0 and 1 make plain objects by copy_reg._reconstructor(class, ...).
  if (callable->kind == PickleKind::global &&
      (callable->text == "copy_reg _reconstructor" || callable->text == "copyreg _reconstructor")) {
    const PickleNode& arguments = document.node(node.items[1]);
    if (arguments.kind == PickleKind::tuple && !arguments.items.empty())
      callable = &document.node(arguments.items[0]);
  }
  return callable->kind == PickleKind::global ? callable->text : std::string_view();
}

}  // namespace likeness
