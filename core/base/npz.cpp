// .npz reading and writing: see npz.h. Zip structure after PKWARE's APPNOTE, .npy after NumPy's format
// description.
#include "core/base/npz.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>
#include <optional>
#include <type_traits>
#include <utility>

#include <fmt/format.h>
#include <zlib.h>

#include <Eigen/Core>

#include "core/base/files.h"

namespace likeness {

namespace {

using Bytes = std::span<const std::byte>;

Error bad_npz(const std::string& where, const std::string& what) {
  return {ErrorCode::bad_input, what, "The file is damaged or of another kind; get a fresh copy of it.",
          where};
}

template <class T>
T little_endian(Bytes bytes, std::size_t offset) {
  T value{};
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

// What a file may unpack to, over all its entries: arrays compress a few times, bombs a thousand times.
constexpr std::size_t kUnpackFree = std::size_t(16) << 20, kUnpackTimes = 64;
constexpr std::size_t kMaxRank = 32;  // NumPy's own limit

struct ZipEntry {
  std::string name;
  std::uint16_t method = 0;  // 0 stored, 8 deflated
  std::uint32_t checksum = 0;
  std::uint64_t compressed = 0, size = 0, header = 0;
};

// Offset of the end-of-central-directory record, searched backwards over a possible comment.
std::optional<std::size_t> find_directory_end(Bytes file) {
  constexpr std::size_t kRecord = 22, kComment = 65535;
  if (file.size() < kRecord) return std::nullopt;
  const std::size_t last = file.size() - kRecord, first = last > kComment ? last - kComment : 0;
  for (std::size_t at = last + 1; at-- > first;) {
    if (little_endian<std::uint32_t>(file, at) == 0x06054b50) return at;
  }
  return std::nullopt;
}

// Zip64 sizes replace 0xffffffff fields, in this order, when present in the extra field.
void apply_zip64(Bytes extra, ZipEntry& entry) {
  std::size_t at = 0;
  while (at + 4 <= extra.size()) {
    const auto id = little_endian<std::uint16_t>(extra, at);
    const auto length = little_endian<std::uint16_t>(extra, at + 2);
    at += 4;
    if (at + length > extra.size()) return;
    if (id == 1) {
      std::size_t field = at;
      for (std::uint64_t* value : {&entry.size, &entry.compressed, &entry.header}) {
        if (*value != 0xffffffffu || field + 8 > at + length) continue;
        *value = little_endian<std::uint64_t>(extra, field);
        field += 8;
      }
    }
    at += length;
  }
}

Result<std::vector<ZipEntry>> read_directory(Bytes file, const std::string& where) {
  const auto end = find_directory_end(file);
  if (!end)
    return bad_npz(where, "It is not a zip archive, which an .npz file must be, or its end is missing.");
  const auto count = little_endian<std::uint16_t>(file, *end + 10);
  std::size_t at = little_endian<std::uint32_t>(file, *end + 16);
  std::vector<ZipEntry> entries;
  for (int i = 0; i < count; ++i) {
    if (at + 46 > file.size() || little_endian<std::uint32_t>(file, at) != 0x02014b50) {
      return bad_npz(where, fmt::format("The zip directory is damaged at byte {}.", at));
    }
    ZipEntry entry;
    entry.method = little_endian<std::uint16_t>(file, at + 10);
    entry.checksum = little_endian<std::uint32_t>(file, at + 16);
    entry.compressed = little_endian<std::uint32_t>(file, at + 20);
    entry.size = little_endian<std::uint32_t>(file, at + 24);
    const std::size_t name = little_endian<std::uint16_t>(file, at + 28);
    const std::size_t extra = little_endian<std::uint16_t>(file, at + 30);
    const std::size_t comment = little_endian<std::uint16_t>(file, at + 32);
    entry.header = little_endian<std::uint32_t>(file, at + 42);
    if (at + 46 + name + extra + comment > file.size()) {
      return bad_npz(where, fmt::format("The zip directory is damaged at byte {}.", at));
    }
    entry.name.assign(reinterpret_cast<const char*>(file.data()) + at + 46, name);
    apply_zip64(file.subspan(at + 46 + name, extra), entry);
    entries.push_back(std::move(entry));
    at += 46 + name + extra + comment;
  }
  return entries;
}

std::uint32_t zip_checksum(Bytes plain) {
  return std::uint32_t(crc32_z(0, reinterpret_cast<const Bytef*>(plain.data()), plain.size()));
}

// `budget`: bytes that may still be unpacked; reduced by what is unpacked here.
Result<std::vector<std::byte>> unpack(Bytes file, const ZipEntry& entry, const std::string& where,
                                      std::size_t& budget) {
  const Error damaged =
      bad_npz(where, fmt::format("The entry {} is damaged at byte {}.", entry.name, entry.header));
  if (entry.header > file.size() || file.size() - entry.header < 30 ||
      little_endian<std::uint32_t>(file, entry.header) != 0x04034b50) {
    return damaged;
  }
  const std::size_t begin = std::size_t(entry.header) + 30 +
                            little_endian<std::uint16_t>(file, entry.header + 26) +
                            little_endian<std::uint16_t>(file, entry.header + 28);
  if (begin > file.size() || entry.compressed > file.size() - begin) return damaged;
  if (entry.size > budget)
    return bad_npz(where, fmt::format("The entry {} unpacks to {} bytes, too many for a file of {}.",
                                      entry.name, entry.size, file.size()));
  budget -= std::size_t(entry.size);
  const Bytes packed = file.subspan(begin, entry.compressed);
  if (entry.method == 0) {
    if (entry.size != entry.compressed || zip_checksum(packed) != entry.checksum) return damaged;
    return std::vector<std::byte>(packed.begin(), packed.end());
  }
  // Deflate cannot expand more than about 1032 times: a larger claim is false, and no reason to take memory.
  if (entry.method != 8 || entry.size / 1040 > entry.compressed + 64) return damaged;
  // Memory is taken as data arrives: what is claimed but missing costs nothing.
  std::vector<std::byte> plain(std::size_t(std::min<std::uint64_t>(entry.size, 4 * entry.compressed + 4096)));
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return damaged;
  std::size_t in = 0, out = 0;
  int status = Z_OK;
  while (status == Z_OK) {
    if (out == plain.size())
      plain.resize(std::size_t(std::min<std::uint64_t>(entry.size, 4 * plain.size() + 64)));
    constexpr std::size_t kPiece = std::numeric_limits<uInt>::max() / 2;
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed.data() + in));
    stream.avail_in = uInt(std::min(packed.size() - in, kPiece));
    stream.next_out = reinterpret_cast<Bytef*>(plain.data() + out);
    stream.avail_out = uInt(std::min(plain.size() - out, kPiece));
    const uInt in_before = stream.avail_in, out_before = stream.avail_out;
    status = inflate(&stream, Z_NO_FLUSH);
    in += in_before - stream.avail_in;
    out += out_before - stream.avail_out;
    if (status == Z_OK && in_before == stream.avail_in && out_before == stream.avail_out) break;
  }
  inflateEnd(&stream);
  if (status != Z_STREAM_END || out != entry.size) return damaged;
  plain.resize(out);
  if (zip_checksum(plain) != entry.checksum) return damaged;
  return plain;
}

// The text after 'key': in the .npy header's Python dictionary.
std::string_view header_value(std::string_view header, std::string_view key) {
  const std::size_t at = header.find(fmt::format("'{}':", key));
  if (at == std::string_view::npos) return {};
  std::string_view rest = header.substr(at + key.size() + 3);
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  return rest;
}

std::optional<std::vector<std::size_t>> parse_shape(std::string_view text) {
  if (text.empty() || text.front() != '(') return std::nullopt;
  std::vector<std::size_t> shape;
  std::size_t number = 0;
  bool digits = false;
  for (const char c : text.substr(1)) {
    if (c >= '0' && c <= '9') {
      if (number > (std::size_t(1) << 48)) return std::nullopt;
      number = number * 10 + std::size_t(c - '0');
      digits = true;
    } else if (c == ',' || c == ')') {
      if (digits) shape.push_back(number);
      if (shape.size() > kMaxRank) return std::nullopt;
      number = 0;
      digits = false;
      if (c == ')') return shape;
    } else if (c != ' ' && c != 'L') {
      return std::nullopt;
    }
  }
  return std::nullopt;
}

// An index that no 32 bits hold must not become one that they do. NumPy's own unsigned -1 is known.
template <class To, class From>
To converted(From value) {
  if constexpr (std::is_same_v<To, std::int32_t> && std::is_integral_v<From>) {
    if (std::in_range<To>(value)) return To(value);
    if (std::cmp_equal(value, std::numeric_limits<std::uint32_t>::max())) return -1;
    return std::cmp_less(value, 0) ? std::numeric_limits<To>::min() : std::numeric_limits<To>::max();
  } else {
    return static_cast<To>(value);
  }
}

template <class To, class From>
std::vector<To> convert(const NpyArray& array) {
  std::vector<To> values(array.count());
  for (std::size_t i = 0; i < values.size(); ++i) {
    From value;
    std::memcpy(&value, array.data.data() + i * sizeof(From), sizeof(From));
    values[i] = converted<To>(value);
  }
  return values;
}

// The numeric kinds, dispatched once. Unsupported kinds give an empty vector.
template <class To>
std::vector<To> convert_any(const NpyArray& array) {
  switch (array.kind * 16 + array.item_bytes) {
    case 'f' * 16 + 2:
      return convert<To, Eigen::half>(array);
    case 'f' * 16 + 4:
      return convert<To, float>(array);
    case 'f' * 16 + 8:
      return convert<To, double>(array);
    case 'i' * 16 + 1:
      return convert<To, std::int8_t>(array);
    case 'i' * 16 + 2:
      return convert<To, std::int16_t>(array);
    case 'i' * 16 + 4:
      return convert<To, std::int32_t>(array);
    case 'i' * 16 + 8:
      return convert<To, std::int64_t>(array);
    case 'b' * 16 + 1:
    case 'u' * 16 + 1:
      return convert<To, std::uint8_t>(array);
    case 'u' * 16 + 2:
      return convert<To, std::uint16_t>(array);
    case 'u' * 16 + 4:
      return convert<To, std::uint32_t>(array);
    case 'u' * 16 + 8:
      return convert<To, std::uint64_t>(array);
    default:
      return {};
  }
}

void append(std::vector<std::byte>& out, const void* data, std::size_t size) {
  const std::size_t old_size = out.size();
  out.resize(old_size + size);
  if (size > 0) std::memcpy(out.data() + old_size, data, size);
}

template <class T>
void append_value(std::vector<std::byte>& out, T value) {
  append(out, &value, sizeof value);
}

std::vector<std::byte> npy_bytes(const NpyArray& array) {
  std::string shape;
  for (const std::size_t n : array.shape) shape += fmt::format("{},", n);
  std::string header = fmt::format("{{'descr': '{}{}{}', 'fortran_order': False, 'shape': ({}), }}",
                                   array.item_bytes == 1 ? '|' : '<', array.kind,
                                   array.kind == 'U' ? array.item_bytes / 4 : array.item_bytes, shape);
  header.append(63 - (10 + header.size()) % 64, ' ');
  header.push_back('\n');
  std::vector<std::byte> out;
  append(out, "\x93NUMPY\x01\x00", 8);
  append_value(out, std::uint16_t(header.size()));
  append(out, header.data(), header.size());
  append(out, array.data.data(), array.data.size());
  return out;
}

}  // namespace

std::vector<std::byte> c_order(const NpyArray& array, Bytes fortran) {
  if (array.shape.size() < 2) return {fortran.begin(), fortran.end()};
  std::vector<std::byte> data(fortran.size());
  const std::size_t rank = array.shape.size(), item = std::size_t(array.item_bytes);
  std::vector<std::size_t> index(rank, 0);
  for (std::size_t c = 0; c < array.count(); ++c) {
    std::size_t offset = 0, stride = 1;
    for (std::size_t axis = 0; axis < rank; ++axis) {
      offset += index[axis] * stride;
      stride *= array.shape[axis];
    }
    std::memcpy(data.data() + c * item, fortran.data() + offset * item, item);
    for (std::size_t axis = rank; axis-- > 0 && ++index[axis] == array.shape[axis];) index[axis] = 0;
  }
  return data;
}

std::size_t NpyArray::count() const {
  return std::accumulate(shape.begin(), shape.end(), std::size_t(1), std::multiplies<>());
}

std::vector<float> NpyArray::as_float() const { return convert_any<float>(*this); }

std::vector<std::int32_t> NpyArray::as_int() const {
  if (kind == 'f') return {};
  return convert_any<std::int32_t>(*this);
}

std::vector<std::string> NpyArray::as_strings() const {
  if (kind != 'U') return {};
  std::vector<std::string> strings(count());
  for (std::size_t i = 0; i < strings.size(); ++i) {
    for (int c = 0; c < item_bytes / 4; ++c) {
      const auto code = little_endian<std::uint32_t>(data, i * std::size_t(item_bytes) + std::size_t(c) * 4);
      if (code == 0) break;
      strings[i] += code < 128 ? char(code) : '?';  // names of shapes are ASCII
    }
  }
  return strings;
}

Result<NpyArray> parse_npy(Bytes bytes, const std::string& name) {
  if (bytes.size() < 10 || std::memcmp(bytes.data(), "\x93NUMPY", 6) != 0) {
    return bad_npz(name, fmt::format("{} is not a NumPy array.", name));
  }
  const bool long_header = std::to_integer<int>(bytes[6]) >= 2;
  if (bytes.size() < 12) return bad_npz(name, fmt::format("{} ends inside its header.", name));
  const std::size_t header_size =
      long_header ? little_endian<std::uint32_t>(bytes, 8) : little_endian<std::uint16_t>(bytes, 8);
  const std::size_t header_begin = long_header ? 12 : 10;
  if (header_size > bytes.size() - header_begin)
    return bad_npz(name, fmt::format("{} ends inside its header.", name));
  const std::string_view header(reinterpret_cast<const char*>(bytes.data()) + header_begin, header_size);

  const std::string_view descr = header_value(header, "descr");
  const auto shape = parse_shape(header_value(header, "shape"));
  if (descr.size() < 4 || !shape || (descr[1] != '<' && descr[1] != '|')) {
    return bad_npz(name, fmt::format("{} has an array header that Likeness cannot read: {}", name,
                                     header.substr(0, 80)));
  }
  NpyArray array;
  array.shape = *shape;
  array.kind = descr[2];
  if (array.kind == 'O') {
    array.item_bytes = 8;
    const Bytes pickle = bytes.subspan(header_begin + header_size);
    array.data.assign(pickle.begin(), pickle.end());
    return array;
  }
  array.item_bytes = 0;
  for (const char c : descr.substr(3)) {
    if (c < '0' || c > '9' || array.item_bytes > 100000) break;
    array.item_bytes = array.item_bytes * 10 + (c - '0');
  }
  if (array.kind == 'U') array.item_bytes *= 4;
  const bool known =
      (array.kind == 'f' && (array.item_bytes == 2 || array.item_bytes == 4 || array.item_bytes == 8)) ||
      ((array.kind == 'i' || array.kind == 'u') &&
       (array.item_bytes == 1 || array.item_bytes == 2 || array.item_bytes == 4 || array.item_bytes == 8)) ||
      (array.kind == 'b' && array.item_bytes == 1) ||
      ((array.kind == 'U' || array.kind == 'S') && array.item_bytes > 0);
  if (!known)
    return bad_npz(name, fmt::format("{} holds elements of a type that Likeness cannot read: {}", name,
                                     descr.substr(0, 12)));
  std::size_t expected = std::size_t(array.item_bytes);
  const Bytes body = bytes.subspan(header_begin + header_size);
  for (const std::size_t n : array.shape) {
    if (n != 0 && expected > body.size() / n) {
      return bad_npz(
          name, fmt::format("{} ends early: its header promises more than its {} bytes.", name, body.size()));
    }
    expected *= n;
  }
  if (body.size() < expected) {
    return bad_npz(name, fmt::format("{} ends early: {} of {} bytes.", name, body.size(), expected));
  }
  const bool fortran = header_value(header, "fortran_order").starts_with("True");
  const Bytes data = body.first(expected);
  array.data = fortran ? c_order(array, data) : std::vector<std::byte>(data.begin(), data.end());
  return array;
}

Result<NpzArchive> read_npz(const std::filesystem::path& path) {
  const auto file = read_file(path);
  if (!file) return file.error();
  return parse_npz(*file, path.string());
}

Result<NpzArchive> parse_npz(Bytes file, const std::string& where) {
  const auto entries = read_directory(file, where);
  if (!entries) return entries.error();
  std::size_t budget = std::max(kUnpackFree, kUnpackTimes * file.size());
  NpzArchive archive;
  for (const ZipEntry& entry : *entries) {
    if (!entry.name.ends_with(".npy")) continue;
    const auto plain = unpack(file, entry, where, budget);
    if (!plain) return plain.error();
    const std::string key = entry.name.substr(0, entry.name.size() - 4);
    auto array = parse_npy(*plain, key);
    if (!array) return Error{array.error().code, array.error().what, array.error().fix, where};
    archive.emplace(key, std::move(*array));
  }
  return archive;
}

Result<void> write_npz(const std::filesystem::path& path, const NpzArchive& archive) {
  std::vector<std::byte> file, directory;
  for (const auto& [key, array] : archive) {
    const std::string name = key + ".npy";
    const std::vector<std::byte> body = npy_bytes(array);
    if (file.size() + body.size() > 0xfffffff0u) {
      return Error{ErrorCode::bad_input, "The arrays are larger than a plain .npz file can hold (4 GiB).",
                   "Write fewer or smaller arrays.", path.string()};
    }
    const std::uint32_t checksum = zip_checksum(body);
    const auto offset = std::uint32_t(file.size());
    // Fields shared by the local header and the directory entry: version, flags, method, time, date, crc,
    // sizes, names.
    std::vector<std::byte> fields;
    for (const std::uint16_t v :
         {std::uint16_t(20), std::uint16_t(0), std::uint16_t(0), std::uint16_t(0), std::uint16_t(0x21)}) {
      append_value(fields, v);
    }
    append_value(fields, checksum);
    append_value(fields, std::uint32_t(body.size()));
    append_value(fields, std::uint32_t(body.size()));
    append_value(fields, std::uint16_t(name.size()));
    append_value(fields, std::uint16_t(0));

    append_value(file, std::uint32_t(0x04034b50));
    append(file, fields.data(), fields.size());
    append(file, name.data(), name.size());
    append(file, body.data(), body.size());

    append_value(directory, std::uint32_t(0x02014b50));
    append_value(directory, std::uint16_t(20));
    append(directory, fields.data(), fields.size());
    for (int i = 0; i < 3; ++i)
      append_value(directory, std::uint16_t(0));  // comment, disk, internal attributes
    append_value(directory, std::uint32_t(0));    // external attributes
    append_value(directory, offset);
    append(directory, name.data(), name.size());
  }
  const auto directory_offset = std::uint32_t(file.size());
  append(file, directory.data(), directory.size());
  append_value(file, std::uint32_t(0x06054b50));
  append_value(file, std::uint32_t(0));
  append_value(file, std::uint16_t(archive.size()));
  append_value(file, std::uint16_t(archive.size()));
  append_value(file, std::uint32_t(directory.size()));
  append_value(file, directory_offset);
  append_value(file, std::uint16_t(0));
  return write_file(path, file);
}

NpyArray npy_from_floats(std::vector<std::size_t> shape, std::span<const float> values) {
  const Bytes bytes = std::as_bytes(values);
  return {std::move(shape), 'f', 4, {bytes.begin(), bytes.end()}};
}

NpyArray npy_from_ints(std::vector<std::size_t> shape, std::span<const std::int32_t> values) {
  const Bytes bytes = std::as_bytes(values);
  return {std::move(shape), 'i', 4, {bytes.begin(), bytes.end()}};
}

}  // namespace likeness
