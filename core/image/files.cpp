// Pictures in and out of files through OpenImageIO: see files.h.
#include "core/image/files.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <webp/decode.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <new>
#include <optional>
#include <string>

#include "core/base/check.h"
#include "core/base/files.h"
#include "core/image/picture_kind.h"
#include "core/image/read_numbers.h"

namespace likeness {
namespace {

// Bytes decoded, in numbers as wide as the file's; a larger claim is a broken header. So is a claim beyond
// what any picture's bytes can decode to, unless it is small: memory would be taken for nothing.
constexpr std::int64_t kLargestPicture = std::int64_t(1) << 30, kSmallPicture = std::int64_t(64) << 20;
constexpr std::size_t kKindBytes = std::size_t(1) << 16;  // that tell a picture's kind
constexpr std::int64_t kMaxUnfolded = 4000;               // decoded bytes of a file's; deflate reaches 1032

Error unreadable(const std::filesystem::path& path, std::string what) {
  return {ErrorCode::bad_input, std::move(what), "Copy or export the picture again, as PNG or JPEG.",
          path.string()};
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

// libjpeg fills the rest of a cut-off picture with grey and only warns, so the end mark is looked for here.
// Walks the segments of the main picture: lengths up to each scan, then scan data, in which FF is followed by
// 00 or a restart mark. True when FF D9 is reached.
bool jpeg_is_whole(std::span<const std::byte> bytes) {
  const auto at = [&](std::size_t i) { return std::to_integer<unsigned>(bytes[i]); };
  std::size_t i = 2;
  while (i + 1 < bytes.size()) {
    if (at(i) != 0xFF) {  // scan data
      ++i;
      continue;
    }
    const unsigned mark = at(i + 1);
    if (mark == 0xD9) return true;
    if (mark == 0xFF) {  // fill byte
      ++i;
    } else if (mark == 0x00 || mark == 0x01 || (mark >= 0xD0 && mark <= 0xD8)) {
      i += 2;
    } else {
      if (i + 3 >= bytes.size()) return false;
      i += 2 + std::max(2u, (at(i + 2) << 8) + at(i + 3));
    }
  }
  return false;
}

// Walks the chunks: length, type, that many bytes, checksum. True when IEND lies within the file. Beyond the
// end OpenImageIO's reader exits by a long jump and leaks its message.
bool png_is_whole(std::span<const std::byte> bytes) {
  const auto at = [&](std::size_t i) { return std::to_integer<std::size_t>(bytes[i]); };
  for (std::size_t i = 8; bytes.size() - i >= 12;) {
    const std::size_t length = at(i) << 24 | at(i + 1) << 16 | at(i + 2) << 8 | at(i + 3);
    if (length > bytes.size() - i - 12) return false;
    if (at(i + 4) == 'I' && at(i + 5) == 'E' && at(i + 6) == 'N' && at(i + 7) == 'D') return true;
    i += 12 + length;
  }
  return false;
}

// The most bytes that a picture may claim to decode to.
std::int64_t largest_claim(std::size_t file_bytes) {
  return std::min(kLargestPicture, std::max(kSmallPicture, kMaxUnfolded * std::int64_t(file_bytes)));
}

Error too_large_a_claim(const std::filesystem::path& path, int width, int height, int channels) {
  return unreadable(path, fmt::format("\"{}\" claims a size of {} x {} x {}, which no ordinary picture has.",
                                      path.filename().string(), width, height, channels));
}

// OpenImageIO takes the memory of a whole WebP when it opens the file, up to 1 GiB for a few hundred bytes,
// so its claim is read first.
std::optional<Error> webp_claims_too_much(const std::filesystem::path& path,
                                          std::span<const std::byte> bytes) {
  WebPBitstreamFeatures claim;
  if (WebPGetFeatures(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), &claim) !=
      VP8_STATUS_OK)
    return std::nullopt;  // not a WebP, or one whose error the reader reports better
  const int channels = claim.has_alpha ? 4 : 3;
  if (std::int64_t(claim.width) * claim.height <= largest_claim(bytes.size()) / channels) return std::nullopt;
  return too_large_a_claim(path, claim.width, claim.height, channels);
}

Image8 grey_alpha_to_rgba(const Image8& image) {
  Image8 result(image.width, image.height, 4);
  for (std::size_t i = 0; i < image.pixels(); ++i) {
    std::fill_n(result.data.begin() + std::ptrdiff_t(4 * i), 3, image.data[2 * i]);
    result.data[4 * i + 3] = image.data[2 * i + 1];
  }
  return result;
}

// A picture of a kind that may be opened.
struct OpenedPicture {
  PictureKind kind = PictureKind::other;
  std::size_t file_bytes = 0;
};

// By the reader of its kind alone: asked by name, OpenImageIO tries all it has.
Result<std::unique_ptr<OIIO::ImageInput>> open_picture(const std::filesystem::path& path, PictureKind kind,
                                                       const OIIO::ImageSpec& config) {
  const std::string name = path.filename().string();
  auto input = OIIO::ImageInput::create(reader_of(kind));
  OIIO::ImageSpec spec;
  if (input && input->open(path.string(), spec, config)) return input;
  const std::string why = first_line(input ? input->geterror() : OIIO::geterror());
  return unreadable(path, fmt::format("\"{}\" is not a picture that can be read: {}.", name, why));
}

Result<Image8> decode(const std::filesystem::path& path, const OpenedPicture& picture) {
  const std::string name = path.filename().string();
  const std::size_t file_bytes = picture.file_bytes;
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);  // alpha stays straight, as on disk
  const auto opened = open_picture(path, picture.kind, config);
  if (!opened) return opened.error();
  OIIO::ImageInput* input = opened->get();
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.width <= 0 || spec.height <= 0 || spec.nchannels < 1 || spec.nchannels > 4 || spec.depth > 1 ||
      std::int64_t(spec.width) * spec.height >
          largest_claim(file_bytes) / (spec.nchannels * std::int64_t(spec.format.size()))) {
    return too_large_a_claim(path, spec.width, spec.height, spec.nchannels);
  }
  Image8 image(spec.width, spec.height, spec.nchannels);
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, image.data.data())) {
    return unreadable(path, fmt::format("\"{}\" ({} x {}) is cut short or damaged: {}.", name, spec.width,
                                        spec.height, first_line(input->geterror())));
  }
  return image.channels == 2 ? grey_alpha_to_rgba(image) : std::move(image);
}

void append_number(std::vector<unsigned char>& bytes, std::uint32_t number) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back((unsigned char)(number >> shift));
}

// An iTXt chunk: keyword, not compressed, no language.
std::vector<unsigned char> text_chunk(const std::string& keyword, const std::string& text) {
  LIKENESS_CHECK(!keyword.empty() && keyword.size() < 80, "a PNG text's keyword of %d letters",
                 int(keyword.size()));
  std::vector<unsigned char> body{'i', 'T', 'X', 't'};
  body.insert(body.end(), keyword.begin(), keyword.end());
  body.insert(body.end(), 5, 0);
  body.insert(body.end(), text.begin(), text.end());
  std::vector<unsigned char> chunk;
  append_number(chunk, std::uint32_t(body.size() - 4));
  chunk.insert(chunk.end(), body.begin(), body.end());
  append_number(chunk, std::uint32_t(crc32(0, body.data(), uInt(body.size()))));
  return chunk;
}

// OpenImageIO writes only the XMP terms it knows, so the chunks are inserted here, after the header.
void add_texts(std::vector<unsigned char>& png,
               const std::vector<std::pair<std::string, std::string>>& texts) {
  constexpr std::size_t kHeader = 8 + 25;  // signature and IHDR
  std::vector<unsigned char> chunks;
  for (const auto& [keyword, text] : texts) {
    const auto chunk = text_chunk(keyword, text);
    chunks.insert(chunks.end(), chunk.begin(), chunk.end());
  }
  png.insert(png.begin() + kHeader, chunks.begin(), chunks.end());
}

}  // namespace

bool reads_heif() { return OIIO::get_string_attribute("extension_list").find("heif:") != std::string::npos; }

int image_orientation(const std::filesystem::path& path) {
  try {
    const auto head = read_head(path, kKindBytes);
    const auto opened = head ? open_picture(path, picture_kind(*head).kind, {})
                             : Result<std::unique_ptr<OIIO::ImageInput>>(head.error());
    const OIIO::ImageInput* input = opened ? opened->get() : nullptr;
    const int tag = input ? input->spec().get_int_attribute("Orientation", 1) : 1;
    return tag >= 1 && tag <= 8 ? tag : 1;
  } catch (const std::exception&) {
    return 1;
  }
}

namespace {

Result<OpenedPicture> whole_picture(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {
    return Error{ErrorCode::not_found, fmt::format("There is no picture \"{}\".", path.string()),
                 "Check the name and the folder.", path.string()};
  }
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  if (bytes->empty()) return unreadable(path, fmt::format("\"{}\" is empty (0 bytes).", name));
  const FoundKind found = picture_kind(*bytes);
  if (found.kind == PictureKind::other)
    return unreadable(path,
                      fmt::format("\"{}\" is not a picture that can be read: it is {}.", name,
                                  found.name.empty() ? "no PNG, JPEG, TIFF, WebP, EXR or HEIF" : found.name));
  if (found.kind == PictureKind::jpeg && !jpeg_is_whole(*bytes)) {
    return unreadable(path, fmt::format("\"{}\" is cut short: the end of the JPEG data is missing.", name));
  }
  if (found.kind == PictureKind::png && !png_is_whole(*bytes)) {
    return unreadable(path, fmt::format("\"{}\" is cut short: the end of the PNG data is missing.", name));
  }
  if (auto refused = webp_claims_too_much(path, *bytes)) return *refused;
  return OpenedPicture{found.kind, bytes->size()};
}

Result<NumberPicture> decode_numbers(const std::filesystem::path& path, const OpenedPicture& picture) {
  const std::string name = path.filename().string();
  const std::size_t file_bytes = picture.file_bytes;
  const auto opened = open_picture(path, picture.kind, {});
  if (!opened) return opened.error();
  OIIO::ImageInput* input = opened->get();
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.width <= 0 || spec.height <= 0 || spec.nchannels < 1 || spec.nchannels > 4 || spec.depth > 1 ||
      std::int64_t(spec.width) * spec.height > largest_claim(file_bytes) / 16)
    return too_large_a_claim(path, spec.width, spec.height, spec.nchannels);
  NumberPicture numbers{
      spec.width, spec.height, int(8 * spec.format.size()), !spec.format.is_floating_point(), {}};
  numbers.values.resize(std::size_t(spec.width) * std::size_t(spec.height));
  if (!input->read_image(0, 0, 0, 1, OIIO::TypeDesc::FLOAT, numbers.values.data()))
    return unreadable(path, fmt::format("\"{}\" ({} x {}) is cut short or damaged: {}.", name, spec.width,
                                        spec.height, first_line(input->geterror())));
  // Whole numbers were read as shares of the largest.
  if (numbers.whole && numbers.bits <= 16)
    for (float& value : numbers.values) value = std::round(value * float((1 << numbers.bits) - 1));
  return numbers;
}

}  // namespace

Result<Image8> read_image(const std::filesystem::path& path) {
  const auto picture = whole_picture(path);
  if (!picture) return picture.error();
  try {
    return decode(path, *picture);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    return unreadable(path, fmt::format("\"{}\" cannot be decoded: {}.", path.filename().string(), e.what()));
  }
}

Result<NumberPicture> read_numbers(const std::filesystem::path& path) {
  const auto picture = whole_picture(path);
  if (!picture) return picture.error();
  try {
    return decode_numbers(path, *picture);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    return unreadable(path, fmt::format("\"{}\" cannot be decoded: {}.", path.filename().string(), e.what()));
  }
}

Result<void> write_image(const std::filesystem::path& path, const Image8& image,
                         const ImageWriteOptions& options) {
  LIKENESS_CHECK(!image.empty() && image.data.size() == image.pixels() * image.channels,
                 "picture %d x %d x %d", image.width, image.height, image.channels);
  const auto refused = [&](std::string_view reason) {
    return Error{ErrorCode::bad_input,
                 fmt::format("A picture cannot be written as \"{}\": {}.", path.filename().string(), reason),
                 "Use a name that ends in .png or .jpg.", path.string()};
  };
  // Encoded in memory and written by write_file(), which alone knows about full disks and half-written files.
  std::vector<unsigned char> encoded;
  try {
    const auto output = OIIO::ImageOutput::create(path.filename().string());
    if (!output) return refused("the format is unknown");
    if (!output->supports("ioproxy")) return refused("the format cannot be written safely");
    OIIO::ImageSpec spec(image.width, image.height, image.channels, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:UnassociatedAlpha", 1);
    spec.attribute("png:compressionLevel", options.png_level);
    spec.attribute("Compression", "jpeg:" + std::to_string(options.jpeg_quality));
    OIIO::Filesystem::IOVecOutput memory(encoded);
    OIIO::Filesystem::IOProxy* proxy = &memory;
    spec.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    if (!output->open(path.string(), spec) ||
        !output->write_image(OIIO::TypeDesc::UINT8, image.data.data()) || !output->close()) {
      return refused(first_line(output->geterror()));
    }
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    return refused(e.what());
  }
  if (!options.texts.empty()) {
    if (path.extension() != ".png") return refused("only a PNG can carry texts");
    add_texts(encoded, options.texts);
  }
  return write_file(path, std::as_bytes(std::span(encoded)));
}

}  // namespace likeness
