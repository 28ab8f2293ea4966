// Reading a project's pictures back for training: see project_views.h.
#include "core/project/project_views.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "core/image/files.h"
#include "core/matte/matte_report.h"
#include "core/render/pose_avatar.h"

namespace likeness {

namespace fs = std::filesystem;

std::optional<Camera> picture_camera(const Capture& capture, const CameraSet& cameras, const Track& track,
                                     int frame) {
  const Camera* source = find_camera(cameras, frame);
  if (source == nullptr) return std::nullopt;
  Camera camera = *source;
  camera.frame = frame;
  camera.intrinsics =
      crop_intrinsics(source->intrinsics, capture.crop.x, capture.crop.y, capture.crop.side, capture.size);
  camera.cam_from_world.translation() *= track.metres_per_unit;
  return camera;
}

std::optional<Camera> filmed_camera(const Capture& capture, const CameraSet& cameras, const Track& track,
                                    int frame) {
  const auto camera = picture_camera(capture, cameras, track, frame);
  if (!camera) return std::nullopt;
  return view_of_part(*camera, capture.inside);
}

Capture without_left_out(Capture capture, const std::vector<int>& left_out) {
  for (CaptureFrame& frame : capture.frames) {
    if (!frame.used || std::ranges::find(left_out, frame.frame) == left_out.end()) continue;
    frame.used = false;
    frame.refused = "Left out by hand.";
  }
  return capture;
}

Result<TrackedCapture> read_tracked_capture(const Project& project) {
  auto capture = read_capture(capture_path(project));
  if (!capture) return capture.error();
  auto cameras = read_cameras(cameras_path(project));
  if (!cameras) return cameras.error();
  auto track = read_track(track_path(project));
  if (!track) return track.error();
  return TrackedCapture{std::move(*capture), std::move(*cameras), std::move(*track)};
}

Result<void> check_avatar_fits(const Avatar& avatar, const HeadModel& model, const std::string& where) {
  if (model.hash == avatar.head_model_hash) {
    auto fits = check_numbers_fit(avatar, model);
    if (fits) return {};
    Error error = fits.error();
    error.where = where;
    return error;
  }
  return Error{ErrorCode::bad_input,
               fmt::format("The avatar was made with the {} head model, the project now names the {} one.",
                           avatar.head_model_name, model.name),
               "Build the project again, so that both agree.", where};
}

Result<void> check_track_fits(const Track& track, const HeadModel& model) {
  const bool fits =
      track.head_model_hash == model.hash && track.person.identity.size() == model.identity_count() &&
      track.neutral.expression.size() == model.expression_count() &&
      (track.person.offsets.empty() || int(track.person.offsets.size()) == model.vertex_count()) &&
      std::ranges::all_of(track.frames, [&](const TrackedFrame& frame) {
        return frame.pose.articulation.expression.size() == model.expression_count();
      });
  const auto refused = [](std::string what) {
    return Error{ErrorCode::bad_input, std::move(what), "Run likeness fit, so that the track is made again.",
                 "track.json"};
  };
  if (!fits)
    return refused(fmt::format("The track was made with the {} head model and does not fit the {} one.",
                               track.head_model_name, model.name));
  if (const std::string wrong = misplaced_rest(model, track.person, track.neutral); !wrong.empty())
    return refused(fmt::format("The track does not fit its head model: {}.", wrong));
  return {};
}

Result<Image8> read_own_picture(const std::filesystem::path& folder, const std::string& name, int size,
                                int channels) {
  auto picture = read_image(folder / name);
  const bool fits =
      picture && picture->width == size && picture->height == size && picture->channels == channels;
  if (fits) return picture;
  return Error{ErrorCode::bad_input,
               picture ? fmt::format("{} does not have the project's {} x {} px.", (folder / name).string(),
                                     size, size)
                       : fmt::format("{} is missing or damaged.", (folder / name).string()),
               fmt::format("Delete {} and run the build again: it is then made again.", folder.string()),
               (folder / name).string()};
}

Result<void> load_view_pictures(const Project& project, TrainingView& view) {
  const std::string name = fmt::format("{:06}.png", view.camera.frame);
  const int width = view.camera.intrinsics.width;
  auto rgb = read_own_picture(project.folder / "frames", name, width, 3);
  if (!rgb) return rgb.error();
  view.rgb = std::move(*rgb);
  auto alpha = read_own_picture(project.folder / "masks", name, width, 1);
  if (!alpha) return alpha.error();
  view.alpha = TiledMask(*alpha);
  return {};
}

std::vector<TrainingView> tracked_views(const TrackedCapture& tracked) {
  const auto& [capture, cameras, track] = tracked;
  TiledMask teaches;
  if (!capture.inside.empty()) {
    Image8 filmed(capture.size, capture.size, 1, 255);
    fill_outside(filmed, capture.inside, 0);
    teaches = TiledMask(filmed);
  }
  std::vector<TrainingView> views;
  for (const CaptureFrame& frame : capture.frames) {
    if (!frame.used) continue;
    const TrackedFrame* found = find_tracked(track, frame.frame);
    const auto camera = picture_camera(capture, cameras, track, frame.frame);
    if (found == nullptr || found->status == FrameStatus::lost || !camera) continue;
    TrainingView& view = views.emplace_back();
    view.camera = *camera;
    view.pose = found->pose;
    view.teaches = teaches;
    view.inside = capture.inside;
  }
  return views;
}

std::string project_background_fault(const Project& project) {
  const auto report = read_matte_report(matte_report_path(project));
  return report && *report ? background_fault(**report) : std::string();
}

Result<void> read_project_plate(const Project& project, Image8& plate, Image8& known) {
  std::error_code ignored;
  if (!fs::exists(plate_path(project), ignored)) return {};
  const auto unusable = [&](const fs::path& path, std::string_view what) {
    return Error{ErrorCode::bad_input, fmt::format("{} {}.", path.string(), what),
                 "Delete it and run the build again: it is then made again.", path.string()};
  };
  auto rgb = read_image(plate_path(project));
  if (!rgb) return rgb.error();
  if (rgb->channels != 3) return unusable(plate_path(project), "is no picture in colours");
  plate = std::move(*rgb);
  // Projects from before this file treat the whole plate as seen.
  if (!fs::exists(plate_known_path(project), ignored)) return {};
  auto seen = read_image(plate_known_path(project));
  if (!seen) return seen.error();
  if (seen->channels != 1 || seen->width != plate.width || seen->height != plate.height)
    return unusable(plate_known_path(project), "is no mask of the plate's size");
  known = std::move(*seen);
  return {};
}

}  // namespace likeness
