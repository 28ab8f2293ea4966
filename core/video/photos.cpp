// Photographs in order, upright: see photos.h.
#include "core/video/photos.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "core/base/hash.h"
#include "core/image/files.h"
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

}  // namespace

Result<std::vector<fs::path>> list_photos(const fs::path& folder) {
  std::vector<fs::path> photos;
  std::error_code fault;
  for (const auto& entry : fs::directory_iterator(folder, fault)) {
    // Archives contain ._IMG_1.jpg files that are not pictures.
    std::error_code unknown;
    if (!entry.is_regular_file(unknown) || entry.path().filename().string().starts_with(".")) continue;
    std::string extension = entry.path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    for (const char* known : {".jpg", ".jpeg", ".png", ".tif", ".tiff", ".webp"})
      if (extension == known) photos.push_back(entry.path());
  }
  if (fault)
    return Error{ErrorCode::not_found, fmt::format("The folder cannot be read: {}.", fault.message()),
                 "Give the folder that holds the photographs.", folder.string()};
  if (photos.size() < kMinPhotos)
    return Error{ErrorCode::bad_input,
                 fmt::format("\"{}\" is a folder with {} photographs; at least {} are needed.",
                             folder.string(), photos.size(), kMinPhotos),
                 "Give a folder of JPEG or PNG photographs of one scene from different places.",
                 folder.string()};
  std::sort(photos.begin(), photos.end());
  return photos;
}

Result<Image8> read_photo(const fs::path& path) {
  auto stored = read_image(path);
  if (!stored) return stored;
  return oriented(three_channels(*stored), orientation_of_tag(image_orientation(path)));
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

Error other_size_error(const fs::path& path, const Image8& photo, int width, int height) {
  return {ErrorCode::bad_input,
          fmt::format("This photograph has {} x {} px, the first one {} x {}.", photo.width, photo.height,
                      width, height),
          "Give photographs of one camera in one orientation; move the others out of the folder.",
          path.string()};
}

}  // namespace likeness
