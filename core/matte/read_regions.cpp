// See read_regions.h.
#include "core/matte/read_regions.h"

#include <fmt/format.h>

#include "core/image/files.h"

namespace likeness {
namespace {

Image8 channel_mask(const Image8& rgb, int channel) {
  Image8 mask(rgb.width, rgb.height, 1);
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    mask.data[i] = rgb.data[i * std::size_t(rgb.channels) + std::size_t(channel)] > 127 ? 255 : 0;
  }
  return mask;
}

}  // namespace

Result<Regions> read_regions(const std::filesystem::path& folder, const Capture& capture, int frame) {
  const auto picture = read_image(folder / fmt::format("{:06}.png", frame));
  if (!picture) return picture.error();
  if (picture->channels < 3 || picture->width != capture.width || picture->height != capture.height) {
    return Error{
        ErrorCode::bad_input,
        fmt::format("The region picture of frame {} is {} x {} with {} channels; the source is {} x {}.",
                    frame, picture->width, picture->height, picture->channels, capture.width, capture.height),
        "Give RGB pictures in source pixels: red person, green head, blue face.", folder.string()};
  }
  const SquareCrop& c = capture.crop;
  const Image8 cut =
      crop(resize(crop(*picture, c.x, c.y, c.side, c.side), capture.size, capture.size), capture.inside);
  return Regions{channel_mask(cut, 0), channel_mask(cut, 1), channel_mask(cut, 2)};
}

}  // namespace likeness
