// Reading what an evaluation needs: see held_out.h.
#include "core/lab/score/held_out.h"

#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/image/files.h"
#include "core/matte/plate_file.h"
#include "core/project/project_views.h"
#include "core/train/choose_parts.h"
#include "core/train/exposure.h"

namespace likeness {

namespace fs = std::filesystem;

Result<Image8> read_truth(const Project& project, const Capture& capture, int frame) {
  auto picture =
      read_own_picture(project.folder / "frames", fmt::format("{:06}.png", frame), capture.size, 3);
  if (!picture) return picture.error();
  return crop(*picture, capture.inside);
}

Image8 plate_behind(const HeldOutSet& set, int frame, const Camera& camera) {
  const Avatar& avatar = set.avatar;
  if (avatar.plate.empty() || !std::ranges::binary_search(set.plate_info.frames, frame)) return {};
  return avatar.mosaic ? mosaic_seen_by(*avatar.mosaic, camera) : avatar.plate;
}

Result<Vec3f> held_out_exposure(const Project& project, const HeldOutSet& set, int frame,
                                const Camera& camera, const Image8& truth) {
  if (!is_evenly_lit(set.avatar)) return Vec3f(Vec3f::Ones());
  PlatePicture behind{plate_behind(set, frame, camera), {}};
  if (behind.rgb.empty()) return Vec3f(Vec3f::Ones());
  if (set.avatar.mosaic) {
    behind.rgb = mosaic_seen_by(*set.avatar.mosaic, camera, &behind.known);
  } else {
    Image8 plate;
    if (const auto read = read_project_plate(project, plate, behind.known); !read) return read.error();
    if (!behind.known.empty()) behind.known = crop(behind.known, set.capture.inside);
    if (!behind.known.empty() &&
        (behind.known.width != behind.rgb.width || behind.known.height != behind.rgb.height))
      return Error{
          ErrorCode::bad_input,
          fmt::format("{} has another size than the avatar's plate.", plate_known_path(project).string()),
          fmt::format("Run: likeness build {}", project.folder.string()), plate_known_path(project).string()};
  }
  const auto alpha =
      read_own_picture(project.folder / "masks", fmt::format("{:06}.png", frame), set.capture.size, 1);
  if (!alpha) return alpha.error();
  return exposure_beside(truth, TiledMask(crop(*alpha, set.capture.inside)), behind).value_or(Vec3f::Ones());
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
  const int width = capture.inside.empty() ? capture.size : capture.inside.width,
            height = capture.inside.empty() ? capture.size : capture.inside.height;
  if (avatar->intrinsics.width != width || avatar->intrinsics.height != height ||
      avatar->head_model_hash != track.head_model_hash) {
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
