// Photographs in order, upright: see photos.h.
#include "core/video/photos.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <set>
#include <string_view>

#include "core/base/hash.h"
#include "core/base/natural_order.h"
#include "core/image/files.h"
#include "core/video/alpha.h"
#include "core/video/frame_to_rgb.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMinPhotos = 3;

// Of the tag's eight values: how the stored picture lies (Exif 2.3, 4.6.4 A).
Orientation orientation_of_tag(int tag) {
  Orientation o;
  o.transposed = tag >= 5 && tag <= 8;
  o.flip_x = tag == 2 || tag == 3 || tag == 7 || tag == 8;
  o.flip_y = tag == 3 || tag == 4 || tag == 6 || tag == 7;
  return o;
}

Image8 three_channels(const Image8& image) {
  if (image.channels == 3) return image;
  Image8 rgb(image.width, image.height, 3);
  for (std::size_t i = 0; i < image.pixels(); ++i)
    for (int c = 0; c < 3; ++c)
      rgb.data[3 * i + std::size_t(c)] =
          image.data[i * std::size_t(image.channels) + (image.channels == 1 ? 0 : std::size_t(c))];
  return rgb;
}

// Of a folder, in any order.
struct FolderPictures {
  std::vector<fs::path> read;
  std::map<std::string, int> unread;  // by their names' ends, in small letters
  int twice = 0;                      // left out of `read`: there in another kind
  bool twice_heif = false;            // they are the HEIF ones
};

constexpr std::array<std::string_view, 3> kHeif{".heic", ".heif", ".avif"};

std::string kind_of(const fs::path& path) {
  std::string kind = path.extension().string();
  std::ranges::transform(kind, kind.begin(), [](unsigned char c) { return std::tolower(c); });
  return kind;
}

bool is_heif(const fs::path& path) { return std::ranges::find(kHeif, kind_of(path)) != kHeif.end(); }

// Phones and those who copy from them write one photograph as HEIC and as JPEG.
void leave_out_twice(FolderPictures& pictures) {
  std::set<fs::path> heif, other;
  for (const fs::path& path : pictures.read) (is_heif(path) ? heif : other).insert(path.stem());
  pictures.twice_heif = heif.size() <= other.size();
  const std::set<fs::path>& kept = pictures.twice_heif ? other : heif;
  pictures.twice = int(std::erase_if(pictures.read, [&](const fs::path& path) {
    return is_heif(path) == pictures.twice_heif && kept.contains(path.stem());
  }));
}

FolderPictures list_pictures(const fs::path& folder, std::error_code& fault) {
  constexpr std::array<std::string_view, 6> kRead{".jpg", ".jpeg", ".png", ".tif", ".tiff", ".webp"};
  constexpr std::array<std::string_view, 24> kUnread{
      ".3fr", ".arw", ".bmp", ".cr2", ".cr3", ".dng", ".exr", ".gif", ".hif", ".iiq", ".j2k", ".jp2",
      ".jxl", ".nef", ".nrw", ".orf", ".pef", ".psd", ".raf", ".raw", ".rw2", ".rwl", ".srw", ".tga"};
  const auto among = [](const auto& kinds, const std::string& kind) {
    return std::ranges::find(kinds, kind) != kinds.end();
  };
  FolderPictures pictures;
  for (const auto& entry : fs::directory_iterator(folder, fault)) {
    // Archives contain ._IMG_1.jpg files that are not pictures.
    std::error_code unknown;
    if (!entry.is_regular_file(unknown) || entry.path().filename().string().starts_with(".")) continue;
    const std::string kind = kind_of(entry.path());
    if (among(kRead, kind) || (among(kHeif, kind) && reads_heif()))
      pictures.read.push_back(entry.path());
    else if (among(kHeif, kind) || among(kUnread, kind))
      ++pictures.unread[kind];
  }
  leave_out_twice(pictures);
  return pictures;
}

std::string space_before(const std::string& sentence) { return sentence.empty() ? "" : " " + sentence; }

}  // namespace

Result<std::vector<fs::path>> list_photos(const fs::path& folder) {
  std::error_code fault;
  std::vector<fs::path> photos = list_pictures(folder, fault).read;
  if (fault)
    return Error{ErrorCode::not_found, fmt::format("The folder cannot be read: {}.", fault.message()),
                 "Give the folder that holds the photographs.", folder.string()};
  if (photos.size() < kMinPhotos)
    return Error{
        ErrorCode::bad_input,
        fmt::format("\"{}\" is a folder with {} photographs that can be read; at least {} are needed.",
                    folder.string(), photos.size(), kMinPhotos) +
            space_before(unread_pictures(folder)),
        "Give a folder of JPEG or PNG photographs of one scene from different places.", folder.string()};
  std::ranges::sort(photos, [](const fs::path& a, const fs::path& b) {
    return naturally_before(a.filename().string(), b.filename().string());
  });
  return photos;
}

std::string unread_pictures(const fs::path& folder) {
  std::error_code fault;
  const FolderPictures pictures = list_pictures(folder, fault);
  std::string twice;
  if (pictures.twice > 0)
    twice = fmt::format(
        "{} photographs are in the folder twice, as HEIC or AVIF and in another kind: the {} are left out.",
        pictures.twice, pictures.twice_heif ? "HEIC or AVIF ones" : "others");
  if (pictures.unread.empty()) return twice;
  std::string counted;
  for (const auto& [extension, count] : pictures.unread)
    counted += fmt::format("{}{} {}", counted.empty() ? "" : ", ", count, extension);
  return fmt::format(
             "Pictures of these kinds in the folder cannot be read here and are left out: {}. Export them as "
             "JPEG or PNG to use them.",
             counted) +
         space_before(twice);
}

Result<Image8> read_photo(const fs::path& path, Image8* alpha) {
  auto stored = read_image(path);
  if (!stored) return stored;
  const Orientation orientation = orientation_of_tag(image_orientation(path));
  if (alpha) *alpha = {};
  if (stored->channels != 4) return oriented(three_channels(*stored), orientation);
  const ShownPicture shown = over_backdrop(*stored);
  if (alpha && !shown.alpha.empty()) *alpha = oriented(shown.alpha, orientation);
  return oriented(shown.rgb, orientation);
}

Result<std::string> hash_photos(const fs::path& folder) {
  const auto photos = list_photos(folder);
  if (!photos) return photos.error();
  std::string list;
  for (const fs::path& photo : *photos) {
    const auto hash = hash_file(photo);
    if (!hash) return hash.error();
    list += photo.filename().string() + " " + *hash + "\n";
  }
  return hash_text(list);
}

Image8 luma_of_photo(const Image8& rgb) {
  Image8 luma(rgb.width, rgb.height, 1);
  for (std::size_t i = 0; i < luma.data.size(); ++i) {
    const std::uint8_t* p = rgb.data.data() + 3 * i;
    luma.data[i] = std::uint8_t((77 * p[0] + 150 * p[1] + 29 * p[2] + 128) >> 8);
  }
  return luma;
}

bool may_leave_out(const Error& error, std::size_t count, std::size_t all) {
  return error.code == ErrorCode::bad_input && 2 * count <= all;
}

Error left_out_error(const std::vector<Error>& left_out, std::size_t all) {
  const Error& first = left_out.front();
  return {ErrorCode::bad_input,
          fmt::format("{} of {} photographs are left out, {} first: {}", left_out.size(), all,
                      fs::path(first.where).filename().string(), first.what),
          first.fix, first.where};
}

Error other_size_error(const fs::path& path, const Image8& photo, int width, int height) {
  return {ErrorCode::bad_input,
          fmt::format("This photograph has {} x {} px, the first one {} x {}.", photo.width, photo.height,
                      width, height),
          "Give photographs of one camera in one orientation; move the others out of the folder.",
          path.string()};
}

}  // namespace likeness
