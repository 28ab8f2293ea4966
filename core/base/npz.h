// NumPy .npz archives (zip of .npy, stored or deflated), read defensively: every size is checked against the
// file before memory is taken, and no file unpacks to more than 64 times its size (or 16 MiB); the archive's
// checksums are compared. Little-endian arrays; Fortran order is converted to C order. Arrays of Python
// objects keep their pickle unread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace likeness {

struct NpyArray {
  std::vector<std::size_t> shape;
  char kind = 'f';     // f float, i signed, u unsigned, b bool, as in NumPy's dtype codes; U = UTF-32 text,
                       // S = bytes, O = Python objects
  int item_bytes = 4;  // of one element
  std::vector<std::byte> data;  // C order, little-endian; of kind O: the pickle of the whole array

  std::size_t count() const;
  std::vector<float> as_float() const;          // from f2, f4, f8 and the integer kinds
  std::vector<std::int32_t> as_int() const;     // from integer kinds; 4294967295 becomes -1, others beyond
                                                // 32 bits the largest or smallest there is
  std::vector<std::string> as_strings() const;  // from kind U
};

using NpzArchive = std::map<std::string, NpyArray>;

Result<NpzArchive> read_npz(const std::filesystem::path& path);
Result<NpzArchive> parse_npz(std::span<const std::byte> file, const std::string& where);
Result<NpyArray> parse_npy(std::span<const std::byte> bytes, const std::string& name);
Result<void> write_npz(const std::filesystem::path& path, const NpzArchive& archive);

// `fortran`, the bytes of an array of this shape in Fortran order, put into C order.
std::vector<std::byte> c_order(const NpyArray& array, std::span<const std::byte> fortran);

NpyArray npy_from_floats(std::vector<std::size_t> shape, std::span<const float> values);
NpyArray npy_from_ints(std::vector<std::size_t> shape, std::span<const std::int32_t> values);

}  // namespace likeness
