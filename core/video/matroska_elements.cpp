// Walk over the elements of a segment: see matroska_elements.h.
#include "core/video/matroska_elements.h"

#include <bit>
#include <cstdint>
#include <fstream>
#include <optional>

namespace likeness {
namespace {

constexpr std::uint32_t kHeader = 0x1A45DFA3, kSegment = 0x18538067, kCluster = 0x1F43B675, kVoid = 0xEC,
                        kCrc = 0xBF;

struct Element {
  std::uint32_t id = 0;
  std::uint64_t begin = 0;            // of its contents, as an offset in the file
  std::optional<std::uint64_t> size;  // nullopt: not stated
};

// A number whose first byte's leading zeros say how many bytes follow; nullopt at the file's end.
std::optional<std::uint64_t> read_number(std::ifstream& file, int most, bool with_marker, bool& all_ones) {
  const int first = file.get();
  if (first == std::ifstream::traits_type::eof() || first == 0) return std::nullopt;
  const int more = std::countl_zero(std::uint8_t(first));
  if (more >= most) return std::nullopt;
  const std::uint64_t ones = 0x7fu >> more;
  std::uint64_t value = with_marker ? std::uint64_t(first) : std::uint64_t(first) & ones;
  all_ones = (std::uint64_t(first) & ones) == ones;
  for (int i = 0; i < more; ++i) {
    const int byte = file.get();
    if (byte == std::ifstream::traits_type::eof()) return std::nullopt;
    all_ones = all_ones && byte == 0xff;
    value = value << 8 | std::uint64_t(byte);
  }
  return value;
}

std::optional<Element> read_element(std::ifstream& file, std::uint64_t at) {
  file.clear();
  file.seekg(std::streamoff(at));
  bool unknown = false;
  const auto id = read_number(file, 4, true, unknown);
  if (!id) return std::nullopt;
  const auto size = read_number(file, 8, false, unknown);
  if (!size) return std::nullopt;
  return Element{std::uint32_t(*id), std::uint64_t(file.tellg()), unknown ? std::nullopt : size};
}

}  // namespace

bool is_cut_matroska(const std::filesystem::path& path) {
  std::error_code failure;
  const std::uint64_t file_size = std::filesystem::file_size(path, failure);
  std::ifstream file(path, std::ios::binary);
  if (failure || !file) return false;
  const auto header = read_element(file, 0);
  if (!header || header->id != kHeader || !header->size || *header->size > file_size) return false;
  const auto segment = read_element(file, header->begin + *header->size);
  if (!segment || segment->id != kSegment || !segment->size) return false;
  if (*segment->size <= file_size - segment->begin) return false;
  bool pictures = false;
  for (std::uint64_t at = segment->begin; at < file_size;) {
    const auto element = read_element(file, at);
    if (!element) return true;
    if (pictures && element->id != kCluster && element->id != kVoid && element->id != kCrc) return false;
    pictures = pictures || element->id == kCluster;
    if (!element->size || *element->size > file_size - element->begin) return true;
    at = element->begin + *element->size;
  }
  return true;
}

}  // namespace likeness
