// See picture_kind.h.
#include "core/image/picture_kind.h"

#include <cstdint>
#include <string_view>

namespace likeness {

namespace {

using namespace std::string_view_literals;

struct FirstBytes {
  std::string_view bytes;
  const char* name;
  std::size_t from = 0;
};

constexpr FirstBytes kOthers[] = {{"GIF8"sv, "a GIF"},
                                  {"BM"sv, "a BMP"},
                                  {"SDPX"sv, "a DPX"},
                                  {"XPDS"sv, "a DPX"},
                                  {"8BPS"sv, "a Photoshop file"},
                                  {"#?RADIANCE"sv, "a Radiance HDR"},
                                  {"#?RGBE"sv, "a Radiance HDR"},
                                  {"\0\0\x01\0"sv, "an icon"},
                                  {"\0\0\0\x0CjP  "sv, "a JPEG 2000"},
                                  {"\xFF\x4F\xFF\x51"sv, "a JPEG 2000"},
                                  {"\xFF\x0A"sv, "a JPEG XL"},
                                  {"\0\0\0\x0CJXL "sv, "a JPEG XL"},
                                  {"FUJIFILMCCD-RAW"sv, "a camera's raw picture (RAF)"},
                                  {"crx "sv, "a camera's raw picture (CR3)", 8},
                                  {"DDS "sv, "a DDS"},
                                  {"qoif"sv, "a QOI"},
                                  {"FLIF"sv, "a FLIF"},
                                  {"%PDF"sv, "a PDF"},
                                  {"<svg"sv, "an SVG"},
                                  {"<?xml"sv, "an XML file"}};

constexpr std::string_view kHeifBrands[] = {"heic", "heix", "heim", "heis", "hevc",
                                            "hevx", "mif1", "msf1", "avif", "avis"};

// A TIFF's first directory; numbers as the file orders them.
class TiffTags {
 public:
  explicit TiffTags(std::string_view bytes) : bytes_(bytes), little_(bytes.starts_with("II")) {}
  bool has(unsigned wanted) const {
    return each([&](unsigned tag, std::size_t) { return tag == wanted; });
  }
  // The first value of a tag of short numbers.
  bool has(unsigned wanted, unsigned value) const {
    return each([&](unsigned tag, std::size_t at) { return tag == wanted && number(at + 8, 2) == value; });
  }

 private:
  template <class Test>
  bool each(const Test& test) const {
    const std::size_t directory = number(4, 4);
    const std::size_t count = number(directory, 2);
    for (std::size_t i = 0; i < count; ++i)
      if (const std::size_t at = directory + 2 + 12 * i; test(unsigned(number(at, 2)), at)) return true;
    return false;
  }
  // 0 beyond the end.
  std::size_t number(std::size_t at, std::size_t size) const {
    if (at > bytes_.size() || bytes_.size() - at < size) return 0;
    std::size_t value = 0;
    for (std::size_t i = 0; i < size; ++i)
      value = value << 8 | std::uint8_t(bytes_[at + (little_ ? size - 1 - i : i)]);
    return value;
  }

  std::string_view bytes_;
  bool little_;
};

// Shorter, or empty, where the file ends before.
std::string_view part(std::string_view bytes, std::size_t at, std::size_t size) {
  return at < bytes.size() ? bytes.substr(at, size) : std::string_view();
}

FoundKind kind_of_tiff(std::string_view bytes) {
  constexpr unsigned kDngVersion = 50706, kPhotometric = 262, kColourFilterArray = 32803, kNewSubfile = 254;
  const TiffTags tags(bytes);
  if (tags.has(kDngVersion)) return {PictureKind::other, "a camera's raw picture (DNG)"};
  if (part(bytes, 8, 2) == "CR") return {PictureKind::other, "a camera's raw picture (CR2)"};
  // A thumbnail first, or sensor values: NEF, ARW, ORF and their like.
  constexpr unsigned kSubDirectories = 330, kReduced = 1;
  if (tags.has(kPhotometric, kColourFilterArray) ||
      (tags.has(kNewSubfile, kReduced) && tags.has(kSubDirectories)))
    return {PictureKind::other, "a camera's raw picture"};
  return {PictureKind::tiff, {}};
}

}  // namespace

FoundKind picture_kind(std::span<const std::byte> file) {
  const std::string_view bytes(reinterpret_cast<const char*>(file.data()), file.size());
  if (bytes.starts_with("\x89PNG\r\n\x1A\n"sv)) return {PictureKind::png, {}};
  if (bytes.starts_with("\xFF\xD8"sv)) return {PictureKind::jpeg, {}};
  if (bytes.starts_with("\x76\x2F\x31\x01"sv)) return {PictureKind::exr, {}};
  if (bytes.starts_with("RIFF"sv) && part(bytes, 8, 4) == "WEBP") return {PictureKind::webp, {}};
  if (bytes.starts_with("II*\0"sv) || bytes.starts_with("MM\0*"sv)) return kind_of_tiff(bytes);
  if (bytes.starts_with("II+\0"sv) || bytes.starts_with("MM\0+"sv)) return {PictureKind::tiff, {}};
  if (bytes.substr(0, 12).size() == 12 && bytes.substr(4, 4) == "ftyp")
    for (const std::string_view brand : kHeifBrands)
      if (bytes.substr(8, 4) == brand) return {PictureKind::heif, {}};
  for (const FirstBytes& other : kOthers)
    if (bytes.size() >= other.from && bytes.substr(other.from).starts_with(other.bytes))
      return {PictureKind::other, other.name};
  const bool netpbm = bytes.size() > 2 && bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '7' &&
                      (bytes[2] == '\n' || bytes[2] == ' ' || bytes[2] == '\r' || bytes[2] == '\t');
  return {PictureKind::other, netpbm ? "a Netpbm picture" : ""};
}

const char* reader_of(PictureKind kind) {
  switch (kind) {
    case PictureKind::png:
      return "png";
    case PictureKind::jpeg:
      return "jpeg";
    case PictureKind::tiff:
      return "tiff";
    case PictureKind::webp:
      return "webp";
    case PictureKind::exr:
      return "openexr";
    case PictureKind::heif:
      return "heif";
    case PictureKind::other:
      break;
  }
  return "";
}

}  // namespace likeness
