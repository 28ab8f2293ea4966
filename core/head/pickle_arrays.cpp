// Arrays from pickle records: see pickle_arrays.h.
#include "core/head/pickle_arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>

namespace likeness {
namespace {

using Kind = PickleKind;
using Shape = std::vector<std::size_t>;

constexpr int kMaxDepth = 8;               // of arrays wrapped in chumpy objects
constexpr std::size_t kMaxRank = 32;       // numpy's own limit
constexpr std::size_t kFreeBytes = 65536;  // a small array is never too large for its file

// One array being read; keeps the fault's place.
class Rebuilder {
 public:
  explicit Rebuilder(const PickleDocument& document) : document_(document) {}

  Result<NpyArray> array(PickleRef ref, int depth);
  Result<std::vector<PickleRef>> elements(PickleRef ref);

 private:
  Error fault(PickleRef ref, const std::string& what) const {
    return {ErrorCode::bad_input,
            fmt::format("The pickled value at byte {} is not an array that Likeness reads: {}.",
                        node(ref).offset, what),
            "Choose the file as it was downloaded; if it is damaged, download it again.", document_.name};
  }
  const PickleNode& node(PickleRef ref) const { return document_.node(ref); }
  bool is_tuple(PickleRef ref, std::size_t least) const {
    return node(ref).kind == Kind::tuple && node(ref).items.size() >= least;
  }
  bool is_integer(PickleRef ref) const {
    return node(ref).kind == Kind::integer || node(ref).kind == Kind::boolean;
  }
  bool is_text(PickleRef ref) const { return node(ref).kind == Kind::text || node(ref).kind == Kind::bytes; }
  // Names vary over a library's versions: only the last component and the package's name are compared.
  static bool is_named(std::string_view type, std::string_view package, std::string_view name) {
    return type.starts_with(package) && type.ends_with(name) && type.size() > name.size() &&
           type[type.size() - name.size() - 1] == ' ' &&
           (type[package.size()] == '.' || type[package.size()] == ' ');
  }

  std::optional<Shape> shape(PickleRef ref) const;
  struct Type {
    char kind = 0;
    int bytes = 0;
    bool big_endian = false;
  };
  std::optional<Type> type(PickleRef ref) const;
  // Bytes as they stand, or the text a newer Python wraps them in; `store` keeps what had to be decoded.
  std::optional<std::string_view> raw_bytes(PickleRef ref, std::string& store) const;
  Result<NpyArray> from_raw(PickleRef ref, const Shape& shape, const Type& type, bool fortran,
                            std::string_view raw) const;

  Result<NpyArray> dense(PickleRef ref);
  Result<NpyArray> from_buffer(PickleRef ref);
  Result<NpyArray> scalar(PickleRef ref);
  Result<NpyArray> numbers(PickleRef ref) const;
  Result<NpyArray> sparse(PickleRef ref, bool by_column, int depth);
  Result<NpyArray> chumpy(PickleRef ref, int depth);
  Result<NpyArray> tensor(PickleRef ref) const;

  const PickleDocument& document_;
};

std::optional<Shape> Rebuilder::shape(PickleRef ref) const {
  if (is_integer(ref))
    return node(ref).integer >= 0 ? std::optional(Shape{std::size_t(node(ref).integer)}) : std::nullopt;
  if (node(ref).kind != Kind::tuple && node(ref).kind != Kind::list) return std::nullopt;
  if (node(ref).items.size() > kMaxRank) return std::nullopt;
  Shape shape;
  for (const PickleRef item : node(ref).items) {
    if (!is_integer(item) || node(item).integer < 0) return std::nullopt;
    shape.push_back(std::size_t(node(item).integer));
  }
  return shape;
}

// numpy.dtype('f8', ...) with state (version, byte order, ...).
std::optional<Rebuilder::Type> Rebuilder::type(PickleRef ref) const {
  if (!is_named(object_type(document_, ref), "numpy", "dtype")) return std::nullopt;
  const PickleNode& record = node(ref);
  if (!is_tuple(record.items[1], 1) || !is_text(node(record.items[1]).items[0])) return std::nullopt;
  std::string_view code = node(node(record.items[1]).items[0]).text;
  Type type;
  if (code.starts_with('<') || code.starts_with('|') || code.starts_with('>')) {
    type.big_endian = code.front() == '>';
    code.remove_prefix(1);
  }
  if (code == "O" || code == "O8" || code == "O4") return Type{'O', 8, false};
  if (code.size() != 2) return std::nullopt;
  type.kind = code[0], type.bytes = code[1] - '0';
  const bool known = (type.kind == 'f' && (type.bytes == 2 || type.bytes == 4 || type.bytes == 8)) ||
                     ((type.kind == 'i' || type.kind == 'u') &&
                      (type.bytes == 1 || type.bytes == 2 || type.bytes == 4 || type.bytes == 8)) ||
                     (type.kind == 'b' && type.bytes == 1);
  if (!known) return std::nullopt;
  if (record.items.size() > 2 && is_tuple(record.items[2], 2)) {
    const PickleRef order = node(record.items[2]).items[1];
    if (is_text(order) && node(order).text == ">") type.big_endian = true;
  }
  return type;
}

std::optional<std::string_view> Rebuilder::raw_bytes(PickleRef ref, std::string& store) const {
  if (node(ref).kind == Kind::bytes) return node(ref).text;
  const std::string_view type = object_type(document_, ref);
  const bool is_bytes = type == "__builtin__ bytes" || type == "builtins bytes" ||
                        type == "__builtin__ bytearray" || type == "builtins bytearray";
  if (is_bytes && is_tuple(node(ref).items[1], 0) && node(node(ref).items[1]).items.empty())
    return std::string_view();
  PickleRef text = ref;
  if (type == "_codecs encode" && is_tuple(node(ref).items[1], 1)) text = node(node(ref).items[1]).items[0];
  if (node(text).kind != Kind::text) return std::nullopt;
  // Python 3 writes bytes in protocol 2 as text, one character a byte.
  const std::string_view utf8 = node(text).text;
  store.reserve(utf8.size());
  for (std::size_t i = 0; i < utf8.size(); ++i) {
    const auto c = std::uint8_t(utf8[i]);
    if (c < 0x80) {
      store += char(c);
    } else if ((c == 0xc2 || c == 0xc3) && i + 1 < utf8.size()) {
      store += char((c & 3) << 6 | (std::uint8_t(utf8[++i]) & 0x3f));
    } else {
      return std::nullopt;
    }
  }
  return std::string_view(store);
}

Result<NpyArray> Rebuilder::from_raw(PickleRef ref, const Shape& shape, const Type& type, bool fortran,
                                     std::string_view raw) const {
  std::size_t expected = std::size_t(type.bytes);
  for (const std::size_t n : shape) {
    if (n != 0 && expected > raw.size() / n)
      return fault(ref, fmt::format("its shape needs more than its {} bytes", raw.size()));
    expected *= n;
  }
  if (raw.size() != expected)
    return fault(ref, fmt::format("{} bytes where {} are needed", raw.size(), expected));
  NpyArray array;
  array.shape = shape;
  array.kind = type.kind;
  array.item_bytes = type.bytes;
  const std::span<const std::byte> bytes = std::as_bytes(std::span(raw.data(), raw.size()));
  array.data = fortran ? c_order(array, bytes) : std::vector<std::byte>(bytes.begin(), bytes.end());
  if (type.big_endian)
    for (std::size_t at = 0; at + std::size_t(type.bytes) <= array.data.size(); at += std::size_t(type.bytes))
      std::reverse(array.data.begin() + std::ptrdiff_t(at),
                   array.data.begin() + std::ptrdiff_t(at) + type.bytes);
  return array;
}

// numpy's _reconstruct(...) with state (version, shape, dtype, fortran order, data).
Result<NpyArray> Rebuilder::dense(PickleRef ref) {
  const PickleNode& record = node(ref);
  if (record.items.size() < 3 || !is_tuple(record.items[2], 4)) return fault(ref, "its state is missing");
  const std::vector<PickleRef>& state = node(record.items[2]).items;
  const std::size_t first = state.size() >= 5 ? 1 : 0;  // the version number is optional
  const auto extent = shape(state[first]);
  const auto element = type(state[first + 1]);
  std::string store;
  const auto raw = raw_bytes(state[first + 3], store);
  if (!extent) return fault(ref, "it has no shape");
  if (!element || element->kind == 'O') return fault(ref, "its elements are not plain numbers");
  if (!raw) return fault(ref, "its data are not bytes");
  return from_raw(ref, *extent, *element, node(state[first + 2]).integer != 0, *raw);
}

// numpy's _frombuffer(buffer, dtype, shape, order) of protocol 5.
Result<NpyArray> Rebuilder::from_buffer(PickleRef ref) {
  const PickleRef arguments = node(ref).items[1];
  if (!is_tuple(arguments, 4)) return fault(ref, "its description is incomplete");
  const std::vector<PickleRef>& part = node(arguments).items;
  const auto extent = shape(part[2]);
  const auto element = type(part[1]);
  std::string store;
  const auto raw = raw_bytes(part[0], store);
  if (!extent || !element || element->kind == 'O' || !raw || !is_text(part[3]))
    return fault(ref, "its description is incomplete");
  return from_raw(ref, *extent, *element, node(part[3]).text == "F", *raw);
}

Result<NpyArray> Rebuilder::scalar(PickleRef ref) {
  const PickleRef arguments = node(ref).items[1];
  if (!is_tuple(arguments, 2)) return fault(ref, "its description is incomplete");
  const auto element = type(node(arguments).items[0]);
  std::string store;
  const auto raw = raw_bytes(node(arguments).items[1], store);
  if (!element || element->kind == 'O' || !raw) return fault(ref, "its description is incomplete");
  return from_raw(ref, {}, *element, false, *raw);
}

// A number, or a list or tuple of numbers.
Result<NpyArray> Rebuilder::numbers(PickleRef ref) const {
  const bool single = is_integer(ref) || node(ref).kind == Kind::real;
  const std::vector<PickleRef> one{ref};
  const std::vector<PickleRef>& items = single ? one : node(ref).items;
  bool integers = true;
  for (const PickleRef item : items) {
    if (!is_integer(item) && node(item).kind != Kind::real) return fault(ref, "it holds more than numbers");
    integers = integers && is_integer(item);
  }
  NpyArray array;
  if (!single) array.shape = {items.size()};
  array.kind = integers ? 'i' : 'f';
  array.item_bytes = 8;
  array.data.resize(8 * items.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    const PickleNode& item = node(items[i]);
    const double real = item.kind == Kind::real ? item.real : double(item.integer);
    std::memcpy(array.data.data() + 8 * i, integers ? static_cast<const void*>(&item.integer) : &real, 8);
  }
  return array;
}

// scipy's compressed columns (or rows): state {data, indices, indptr, _shape}.
Result<NpyArray> Rebuilder::sparse(PickleRef ref, bool by_column, int depth) {
  if (node(ref).items.size() < 3) return fault(ref, "its state is missing");
  const PickleRef state = node(ref).items[2];
  const auto part = [&](std::string_view key) -> Result<NpyArray> {
    const PickleRef* found = find_key(document_, state, key);
    if (!found) return fault(ref, fmt::format("the sparse matrix has no {}", key));
    return array(*found, depth + 1);
  };
  const PickleRef* extent_ref = find_key(document_, state, "_shape");
  if (!extent_ref) extent_ref = find_key(document_, state, "shape");
  const auto extent = extent_ref ? shape(*extent_ref) : std::nullopt;
  if (!extent || extent->size() != 2) return fault(ref, "the sparse matrix has no shape");
  const auto data = part("data"), indices = part("indices"), starts = part("indptr");
  for (const auto* array : {&data, &indices, &starts})
    if (!*array) return array->error();
  const std::size_t rows = (*extent)[0], columns = (*extent)[1], outer = by_column ? columns : rows;
  const std::size_t inner = by_column ? rows : columns;
  // A file with the matrix has a start for each of its columns; its dense form is bounded as well.
  const std::size_t most = std::max(kFreeBytes, document_.file.size());
  if (rows == 0 || columns == 0 || rows > most / columns / sizeof(double))
    return fault(ref, fmt::format("the sparse matrix of {} x {} is too large for its file", rows, columns));
  const std::vector<std::int32_t> first = starts->as_int(), index = indices->as_int();
  const std::vector<float> value = data->as_float();
  if (first.size() != outer + 1 || index.size() != value.size())
    return fault(ref, "the parts of the sparse matrix have different sizes");
  std::vector<float> full(rows * columns, 0.0f);
  for (std::size_t o = 0; o < outer; ++o) {
    if (first[o] < 0 || first[o + 1] < first[o] || std::size_t(first[o + 1]) > index.size())
      return fault(ref, fmt::format("the sparse matrix ends inside column {}", o));
    for (std::int32_t k = first[o]; k < first[o + 1]; ++k) {
      if (index[std::size_t(k)] < 0 || std::size_t(index[std::size_t(k)]) >= inner)
        return fault(ref,
                     fmt::format("the sparse matrix refers to row {} of {}", index[std::size_t(k)], inner));
      const std::size_t i = std::size_t(index[std::size_t(k)]);
      full[by_column ? i * columns + o : o * columns + i] += value[std::size_t(k)];
    }
  }
  return npy_from_floats({rows, columns}, full);
}

// chumpy: Ch holds its array as x; Select picks elements of a flattened array, Reshape gives it a new shape.
Result<NpyArray> Rebuilder::chumpy(PickleRef ref, int depth) {
  const std::string_view name = object_type(document_, ref);
  if (node(ref).items.size() < 3) return fault(ref, "its state is missing");
  const PickleRef state = node(ref).items[2];
  const PickleRef* inner = find_key(document_, state, name.ends_with(" Ch") ? "x" : "a");
  if (!inner) return fault(ref, "the chumpy object holds no array");
  auto values = array(*inner, depth + 1);
  if (!values || name.ends_with(" Ch")) return values;
  const bool select = name.ends_with(" Select");
  if (!select && !name.ends_with(" Reshape"))
    return fault(ref, fmt::format("the chumpy operation {} is not known", name));
  if (select) {
    const PickleRef* chosen = find_key(document_, state, "idxs");
    if (!chosen) return fault(ref, "the chumpy selection has no indices");
    const auto indices = array(*chosen, depth + 1);
    if (!indices) return indices.error();
    const std::vector<std::int32_t> index = indices->as_int();
    const std::size_t count = values->count(), bytes = std::size_t(values->item_bytes);
    NpyArray picked;
    picked.kind = values->kind, picked.item_bytes = values->item_bytes;
    picked.shape = {index.size()};
    picked.data.resize(index.size() * bytes);
    for (std::size_t i = 0; i < index.size(); ++i) {
      if (index[i] < 0 || std::size_t(index[i]) >= count)
        return fault(ref, fmt::format("the chumpy selection refers to element {} of {}", index[i], count));
      std::memcpy(picked.data.data() + i * bytes, values->data.data() + std::size_t(index[i]) * bytes, bytes);
    }
    *values = std::move(picked);
  }
  const PickleRef* wanted = find_key(document_, state, select ? "preferred_shape" : "newshape");
  if (!wanted) return values;
  const auto extent = shape(*wanted);
  std::size_t count = 1;
  for (const std::size_t n : extent.value_or(Shape{0}))
    count = n != 0 && count > values->count() / n ? 0 : count * n;
  if (!extent || count != values->count())
    return fault(ref, "the chumpy array does not have the shape asked for");
  values->shape = *extent;
  return values;
}

// torch's _rebuild_tensor(_v2)(storage, offset, size, stride, ...) over a storage that was saved in the older
// form: four pickles (a magic number, a version, the system, the storage's identity), a pickled list of
// names, the element count as 64 bits, the elements.
Result<NpyArray> Rebuilder::tensor(PickleRef ref) const {
  const PickleRef arguments = node(ref).items[1];
  if (!is_tuple(arguments, 4)) return fault(ref, "its description is incomplete");
  const std::vector<PickleRef>& part = node(arguments).items;
  const PickleRef storage = part[0];
  if (!object_type(document_, storage).ends_with(" _load_from_bytes") || !is_tuple(node(storage).items[1], 1))
    return fault(ref, "its torch storage is of an unknown form");
  std::string store;
  const auto saved = raw_bytes(node(node(storage).items[1]).items[0], store);
  if (!saved) return fault(ref, "its torch storage is of an unknown form");
  std::span<const std::byte> rest = std::as_bytes(std::span(saved->data(), saved->size()));
  Type element;
  for (int section = 0; section < 5; ++section) {
    const auto inner = read_pickle(rest, document_.name);
    if (!inner) return fault(ref, "its torch storage is damaged");
    const PickleNode& root = inner->node(inner->root);
    if (section == 3 && root.kind == Kind::persistent && inner->node(root.items[0]).items.size() >= 2) {
      const std::string_view name = inner->node(inner->node(root.items[0]).items[1]).text;
      element = name == "torch LongStorage"     ? Type{'i', 8, false}
                : name == "torch IntStorage"    ? Type{'i', 4, false}
                : name == "torch DoubleStorage" ? Type{'f', 8, false}
                : name == "torch FloatStorage"  ? Type{'f', 4, false}
                                                : Type{};
    }
    rest = rest.subspan(inner->end);
  }
  if (element.kind == 0 || rest.size() < 8) return fault(ref, "its torch storage is of an unknown kind");
  rest = rest.subspan(8);
  const auto extent = shape(part[2]), stride = shape(part[3]);
  if (!extent || !stride || extent->size() != stride->size() || !is_integer(part[1]))
    return fault(ref, "its description is incomplete");
  std::size_t count = 1;
  for (std::size_t axis = extent->size(); axis-- > 0;) {
    if ((*extent)[axis] > 1 && (*stride)[axis] != count)
      return fault(ref, "the torch tensor is not contiguous");
    if ((*extent)[axis] != 0 && count > rest.size() / (*extent)[axis])
      return fault(ref, "the torch tensor is larger than its storage");
    count *= (*extent)[axis];
  }
  const std::size_t bytes = std::size_t(element.bytes), total = rest.size() / bytes;
  const std::int64_t offset = node(part[1]).integer;
  if (offset < 0 || std::size_t(offset) > total || count > total - std::size_t(offset))
    return fault(ref, "the torch tensor is larger than its storage");
  const auto wanted = rest.subspan(std::size_t(offset) * bytes, count * bytes);
  return from_raw(ref, *extent, element, false,
                  {reinterpret_cast<const char*>(wanted.data()), wanted.size()});
}

Result<NpyArray> Rebuilder::array(PickleRef ref, int depth) {
  if (depth > kMaxDepth) return fault(ref, "it is wrapped too deeply");
  const Kind kind = node(ref).kind;
  if (kind == Kind::list || kind == Kind::tuple || kind == Kind::integer || kind == Kind::boolean ||
      kind == Kind::real)
    return numbers(ref);
  const std::string_view type = object_type(document_, ref);
  if (type.empty()) return fault(ref, "it is text or another kind of value");
  if (is_named(type, "numpy", "_reconstruct")) return dense(ref);
  if (is_named(type, "numpy", "_frombuffer")) return from_buffer(ref);
  if (is_named(type, "numpy", "scalar")) return scalar(ref);
  if (is_named(type, "scipy", "csc_matrix") || is_named(type, "scipy", "csc_array"))
    return sparse(ref, true, depth);
  if (is_named(type, "scipy", "csr_matrix") || is_named(type, "scipy", "csr_array"))
    return sparse(ref, false, depth);
  if (type.starts_with("chumpy.") || type.starts_with("chumpy ")) return chumpy(ref, depth);
  if (is_named(type, "torch", "_rebuild_tensor") || is_named(type, "torch", "_rebuild_tensor_v2"))
    return tensor(ref);
  return fault(ref, fmt::format("it is an object of {}", type));
}

Result<std::vector<PickleRef>> Rebuilder::elements(PickleRef ref) {
  if (node(ref).kind == Kind::list || node(ref).kind == Kind::tuple) return node(ref).items;
  if (!is_named(object_type(document_, ref), "numpy", "_reconstruct") || node(ref).items.size() < 3 ||
      !is_tuple(node(ref).items[2], 4))
    return fault(ref, "an array of objects is expected");
  const PickleRef data = node(node(ref).items[2]).items.back();
  if (node(data).kind != Kind::list) return fault(ref, "an array of objects is expected");
  return node(data).items;
}

}  // namespace

Result<NpyArray> pickle_array(const PickleDocument& document, PickleRef ref) {
  return Rebuilder(document).array(ref, 0);
}

Result<std::vector<PickleRef>> pickle_elements(const PickleDocument& document, PickleRef ref) {
  return Rebuilder(document).elements(ref);
}

}  // namespace likeness
