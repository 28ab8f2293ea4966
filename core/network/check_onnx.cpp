// The parts of ONNX's messages that matter here, by their numbers in onnx.proto (version 1.8): see
// check_onnx.h.
#include "core/network/check_onnx.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

namespace likeness {

namespace {

constexpr int kDeepest = 8;                         // graphs in attributes of graphs
constexpr std::int64_t kLargestNumber = 1'000'000;  // of strides, kernels and their like
constexpr std::uint64_t kMostUnstated = 1'000'000;  // numbers of a tensor whose values the file need not hold

struct OnnxFault {
  std::string what;
};

// One field of a Protocol Buffers message.
struct Field {
  std::uint64_t number = 0;
  unsigned wire = 0;        // 0 varint, 1 eight bytes, 2 bytes, 5 four bytes
  std::uint64_t value = 0;  // of a varint
  std::string_view bytes;   // of bytes
};

class Message {
 public:
  explicit Message(std::string_view bytes) : left_(bytes) {}
  bool next(Field& field) {
    if (left_.empty()) return false;
    const std::uint64_t key = varint();
    field = {key >> 3, unsigned(key & 7), 0, {}};
    switch (field.wire) {
      case 0:
        field.value = varint();
        return true;
      case 1:
        take(8);
        return true;
      case 2:
        field.bytes = take(varint());
        return true;
      case 5:
        take(4);
        return true;
      default:
        throw OnnxFault{"it is no ONNX file, or damaged"};
    }
  }

 private:
  std::string_view take(std::uint64_t count) {
    if (count > left_.size()) throw OnnxFault{"it is cut short or damaged"};
    const std::string_view bytes = left_.substr(0, std::size_t(count));
    left_.remove_prefix(std::size_t(count));
    return bytes;
  }
  std::uint64_t varint() {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      const auto byte = std::uint8_t(take(1)[0]);
      value |= std::uint64_t(byte & 0x7f) << shift;
      if ((byte & 0x80) == 0) return value;
    }
    throw OnnxFault{"it is no ONNX file, or damaged"};
  }
  std::string_view left_;
};

void for_each_field(std::string_view bytes, const std::function<void(const Field&)>& use) {
  Message message(bytes);
  for (Field field; message.next(field);) use(field);
}

// Repeated numbers are written one by one or packed.
void add_numbers(const Field& field, std::vector<std::int64_t>& numbers) {
  if (field.wire == 0) numbers.push_back(std::int64_t(field.value));
  if (field.wire != 2) return;
  std::string_view left = field.bytes;
  while (!left.empty()) {
    std::uint64_t value = 0;
    int shift = 0;
    for (bool more = true; more; shift += 7) {
      if (left.empty() || shift > 63) throw OnnxFault{"it is cut short or damaged"};
      const auto byte = std::uint8_t(left[0]);
      left.remove_prefix(1);
      value |= std::uint64_t(byte & 0x7f) << shift;
      more = (byte & 0x80) != 0;
    }
    numbers.push_back(std::int64_t(value));
  }
}

class Checker {
 public:
  explicit Checker(std::size_t file_bytes) : file_bytes_(file_bytes) {}

  void graph(std::string_view bytes, int depth) {
    if (depth > kDeepest) throw OnnxFault{"its graphs are nested too deeply"};
    std::vector<std::string_view> nodes;
    for_each_field(bytes, [&](const Field& field) {
      if (field.number == 1 && field.wire == 2) nodes.push_back(field.bytes);
      if (field.number == 5 && field.wire == 2) tensor(field.bytes);
    });
    for (const std::string_view each : nodes) node(each, depth);
  }

 private:
  void tensor(std::string_view bytes) {
    std::vector<std::int64_t> dims;
    std::string_view name;
    for_each_field(bytes, [&](const Field& field) {
      if (field.number == 1) add_numbers(field, dims);
      if (field.number == 8) name = field.bytes;
      if (field.number == 13 || (field.number == 14 && field.value != 0))
        throw OnnxFault{"its weights are in another file, and only one is opened"};
    });
    // A number takes at least a bit in the file, but for few that are all alike.
    const std::uint64_t most = std::max(kMostUnstated, 8 * std::uint64_t(file_bytes_));
    std::uint64_t count = 1;
    for (const std::int64_t length : dims) {
      if (length < 0 || (length > 0 && count > most / std::uint64_t(length)))
        throw OnnxFault{
            fmt::format("a tensor of it claims {} numbers in a direction, more than the file holds", length)};
      count *= std::uint64_t(length);
    }
    weights_[std::string(name)] = std::move(dims);
  }

  void node(std::string_view bytes, int depth) {
    std::string_view kind;
    std::vector<std::string_view> inputs;
    std::vector<std::pair<std::string_view, std::vector<std::int64_t>>> numbers;
    for_each_field(bytes, [&](const Field& field) {
      if (field.number == 1 && field.wire == 2) inputs.push_back(field.bytes);
      if (field.number == 4 && field.wire == 2) kind = field.bytes;
      if (field.number == 5 && field.wire == 2) numbers.push_back(attribute(field.bytes, depth));
    });
    for (const auto& [name, values] : numbers) check_numbers(kind, name, values);
    const bool convolves = kind == "Conv" || kind == "ConvTranspose";
    if (!convolves || inputs.size() < 2) return;
    std::int64_t groups = 1;
    for (const auto& [name, values] : numbers)
      if (name == "group" && !values.empty()) groups = values.front();
    const auto weights = weights_.find(std::string(inputs[1]));
    if (weights == weights_.end()) return;
    const std::vector<std::int64_t>& shape = weights->second;
    if (shape.size() < 3 || std::ranges::any_of(shape, [](std::int64_t length) { return length < 1; }) ||
        shape[0] % groups != 0)
      throw OnnxFault{fmt::format("the weights of a {} do not fit {} groups", kind, groups)};
  }

  // Its name and whole numbers.
  std::pair<std::string_view, std::vector<std::int64_t>> attribute(std::string_view bytes, int depth) {
    std::string_view name;
    std::vector<std::int64_t> numbers;
    for_each_field(bytes, [&](const Field& field) {
      if (field.number == 1 && field.wire == 2) name = field.bytes;
      if (field.number == 3 && field.wire == 0) numbers.push_back(std::int64_t(field.value));
      if (field.number == 8) add_numbers(field, numbers);
      if (field.number == 5 && field.wire == 2) tensor(field.bytes);
      if ((field.number == 6 || field.number == 11) && field.wire == 2) graph(field.bytes, depth + 1);
    });
    return {name, std::move(numbers)};
  }

  static void check_numbers(std::string_view kind, std::string_view name,
                            const std::vector<std::int64_t>& values) {
    constexpr std::string_view kPositive[] = {"group", "kernel_shape", "strides", "dilations", "blocksize"};
    constexpr std::string_view kCounts[] = {"pads", "output_padding", "output_shape", "hidden_size"};
    const bool positive = std::ranges::find(kPositive, name) != std::end(kPositive);
    const bool counts = std::ranges::find(kCounts, name) != std::end(kCounts);
    if (!positive && !counts) return;
    for (const std::int64_t value : values)
      if (value < (positive ? 1 : kind == "Pad" ? -kLargestNumber : 0) || value > kLargestNumber)
        throw OnnxFault{fmt::format("a {} of it has {} {}", kind, name, value)};
  }

  std::size_t file_bytes_;
  std::map<std::string, std::vector<std::int64_t>> weights_;  // shapes of the graph's own numbers
};

}  // namespace

std::string onnx_fault(std::span<const std::byte> file) {
  const std::string_view bytes(reinterpret_cast<const char*>(file.data()), file.size());
  try {
    Checker checker(bytes.size());
    bool graph = false;
    for_each_field(bytes, [&](const Field& field) {
      if (field.number != 7 || field.wire != 2) return;
      checker.graph(field.bytes, 0);
      graph = true;
    });
    return graph ? "" : "it holds no graph";
  } catch (const OnnxFault& fault) {
    return fault.what;
  }
}

}  // namespace likeness
