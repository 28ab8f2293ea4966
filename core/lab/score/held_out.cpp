// Reading what an evaluation needs: see held_out.h.
#include "core/lab/score/held_out.h"

#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/image/files.h"
#include "core/matte/plate_file.h"
#include "core/project/project_views.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

Image8 channel_mask(const Image8& rgb, int channel) {
  Image8 mask(rgb.width, rgb.height, 1);
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    mask.data[i] = rgb.data[i * std::size_t(rgb.channels) + std::size_t(channel)] > 127 ? 255 : 0;
  }
  return mask;
}

}  // namespace

Result<Image8> read_truth(const Project& project, const Capture& capture, int frame) {
  auto picture = read_image(project.folder / frame_name(frame));
  if (!picture) return picture.error();
  return crop(*picture, capture.inside);
}

Result<Regions> read_regions(const fs::path& folder, const Capture& capture, int frame) {
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

Image8 plate_behind(const HeldOutSet& set, int frame, const Camera& camera) {
  const Avatar& avatar = set.avatar;
  if (avatar.plate.empty() || !std::ranges::binary_search(set.plate_info.frames, frame)) return {};
  return avatar.mosaic ? mosaic_seen_by(*avatar.mosaic, camera) : avatar.plate;
}

Result<HeldOutSet> read_held_out(const Project& project) {
  if (std::error_code ignored; !fs::exists(avatar_path(project), ignored)) {
    return Error{ErrorCode::not_found, fmt::format("{} holds no trained avatar.", project.folder.string()),
                 "Run: likeness build VIDEO --project DIR", project.folder.string()};
  }
  auto read = read_tracked_capture(project);
  if (!read) return read.error();
  auto& [capture, cameras, track] = *read;
  if (track.frames.empty()) {
    return Error{ErrorCode::bad_input, "The track holds no frames.",
                 "Delete track.json and run the build again.", track_path(project).string()};
  }
  auto avatar = read_avatar(avatar_path(project));
  if (!avatar) return avatar.error();
  // A later import or fit leaves the old avatar in place until the next training.
  const int width = capture.inside.empty() ? capture.size : capture.inside.width;
  if (avatar->intrinsics.width != width || avatar->head_model_hash != track.head_model_hash) {
    return Error{
        ErrorCode::bad_input,
        fmt::format("The avatar was trained at {} px on the {} head; the project now holds {} px and "
                    "the {} head.",
                    avatar->intrinsics.width, avatar->head_model_name, width, track.head_model_name),
        fmt::format("Run: likeness train {}", project.folder.string()), project.folder.string()};
  }
  auto plate_info = read_plate_info(plate_info_path(project));
  if (!plate_info) return plate_info.error();
  return HeldOutSet{std::move(capture), std::move(cameras), std::move(track), std::move(*avatar),
                    std::move(*plate_info)};
}

}  // namespace likeness
