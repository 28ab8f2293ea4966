// Films the demo frame by frame into a folder of its own, which becomes visible only when complete.
#include "core/synth/demo_capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>

#include "core/base/files.h"
#include "core/base/json_text.h"
#include "core/base/unfinished.h"
#include "core/camera/camera.h"
#include "core/head/builtin_head.h"
#include "core/image/files.h"
#include "core/scene/mesh_scene.h"
#include "core/scene/track.h"
#include "core/synth/cast.h"
#include "core/synth/demo_camera.h"
#include "core/synth/demo_stage.h"
#include "core/synth/demo_truth.h"
#include "core/synth/drift.h"
#include "core/video/encode.h"
#include "core/video/lens_tag.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

// Removes its contents unless they are kept; also the target folder if that was made for this run alone.
class Unfinished {
 public:
  explicit Unfinished(const fs::path& folder) : folder_(folder), part_(folder / ".filming") {
    std::error_code ignored;
    made_ = !fs::exists(folder, ignored);
    fs::remove_all(part_, ignored);  // remains of a killed run would mix with this one's masks
    remember_unfinished(made_ ? folder_ : part_);
  }
  ~Unfinished() {
    std::error_code ignored;
    fs::remove_all(part_, ignored);
    if (made_ && !kept_) fs::remove(folder_, ignored);  // only when empty
    forget_unfinished(made_ ? folder_ : part_);
  }
  const fs::path& part() const { return part_; }

  Result<void> keep() {
    for (const char* name : {"demo.mp4", "cameras_truth.json", "track_truth.json", "masks_truth",
                             "habit_truth.json", "habit_truth", "wall_truth", "drift_truth.json"}) {
      std::error_code error;
      fs::remove_all(folder_ / name, error);
      if (!fs::exists(part_ / name)) continue;  // of an option that was not asked for
      fs::rename(part_ / name, folder_ / name, error);
      if (error) return file_error(folder_ / name, "put in place", error.value());
    }
    kept_ = true;
    return {};
  }

 private:
  fs::path folder_, part_;
  bool made_ = false, kept_ = false;
};

Error bad_option(std::string what, std::string fix) {
  return {ErrorCode::bad_input, std::move(what), std::move(fix), "demo"};
}

Result<void> check_cast(const DemoOptions& o) {
  const int people = int(demo_people().size()), lights = int(demo_lights().size());
  if (o.person < 0 || o.person >= people) {
    return bad_option(fmt::format("There is no demo person {}.", o.person),
                      fmt::format("Choose 0 to {}; `likeness demo --list` lists them.", people - 1));
  }
  if (o.light < 0 || o.light >= lights) {
    return bad_option(fmt::format("There is no demo light {}.", o.light),
                      fmt::format("Choose 0 to {}; `likeness demo --list` lists them.", lights - 1));
  }
  if (!(o.head_within_deg > 0)) {
    return bad_option(
        fmt::format("A head that turns by at most {} degrees cannot be played.", o.head_within_deg),
        "Choose more than 0 degrees.");
  }
  if (!(o.action_share > 0 && o.action_share <= 1)) {
    return bad_option(fmt::format("A face cannot perform {} of each action.", o.action_share),
                      "Choose a share up to 1.");
  }
  return {};
}

Result<void> check_camera(const DemoOptions& o) {
  if (!(o.hand_turn_deg >= 0 && o.hand_turn_deg <= kMostHandTurn_deg)) {
    return bad_option(
        fmt::format("A hand that turns the camera by {} degrees cannot be filmed.", o.hand_turn_deg),
        fmt::format("Choose 0 to {} degrees.", kMostHandTurn_deg));
  }
  if (!(o.hand_shift_m >= 0 && o.hand_shift_m <= kMostHandShift_m)) {
    return bad_option(
        fmt::format("A hand that displaces the camera by {} m cannot be filmed.", o.hand_shift_m),
        fmt::format("Choose 0 to {} m.", kMostHandShift_m));
  }
  if (o.cuts < 0 || o.cuts >= o.frames) {
    return bad_option(fmt::format("{} frames cannot be cut {} times.", o.frames, o.cuts),
                      "Choose fewer cuts than frames.");
  }
  return {};
}

Result<void> check_picture(const DemoOptions& o) {
  if (o.width < 32 || o.height < 32 || o.width > 4096 || o.height > 4096) {
    return bad_option(fmt::format("A demo of {} x {} pixels cannot be made.", o.width, o.height),
                      "Choose a size from 32 to 4096.");
  }
  if (o.frames < 1 || o.frames > 100000) {
    return bad_option(fmt::format("A demo of {} frames cannot be made.", o.frames),
                      "Choose 1 to 100000 frames.");
  }
  if (!(o.frames_per_second > 0 && o.frames_per_second <= 240)) {
    return bad_option(fmt::format("{} frames a second cannot be filmed.", o.frames_per_second),
                      "Choose up to 240 frames a second.");
  }
  if (o.samples_per_pixel < 1 || o.samples_per_pixel > 256) {
    return bad_option(fmt::format("{} samples a pixel cannot be taken.", o.samples_per_pixel),
                      "Choose 1 to 256 samples a pixel.");
  }
  return {};
}

Result<void> check_options(const DemoOptions& o) {
  for (const auto check : {check_picture, check_cast, check_camera})
    if (auto checked = check(o); !checked) return checked;
  return {};
}

// The truth of the whole clip. With a resting camera throughout, the world is the camera's frame.
struct Truth {
  CameraSet cameras;
  Track track;
};

// Whether one camera films all of it.
bool rests_throughout(const DemoStage& stage, const DemoOptions& options) {
  if (!camera_rests(uncut(options, stage.shots()), 0)) return false;
  return std::ranges::all_of(stage.shots(), [](const DemoShot& shot) { return shot.camera == 0; });
}

// A crop that changes from shot to shot is a zoom: a camera at rest that only crops goes nowhere.
CameraKind kind_of(const DemoStage& stage, const DemoOptions& options) {
  if (rests_throughout(stage, options)) return CameraKind::resting;
  switch (options.camera) {
    case DemoCamera::handheld:
    case DemoCamera::zoom:
    case DemoCamera::slide:
      return CameraKind::handheld;
    case DemoCamera::resting:
      return std::ranges::all_of(stage.shots(), [](const DemoShot& shot) { return shot.place == 0; })
                 ? CameraKind::handheld
                 : CameraKind::walking;
    default:
      return CameraKind::walking;
  }
}

Truth truth_of(const DemoStage& stage, const DemoOptions& options) {
  Truth truth;
  truth.cameras.kind = kind_of(stage, options);
  truth.cameras.scale = CameraScale::metric;
  truth.track.head_model_name = stage.model().name;
  truth.track.head_model_hash = stage.model().hash;
  truth.track.neutral = neutral_articulation(stage.model());
  truth.track.person = stage.person_shape();
  for (int frame = 0; frame < options.frames; ++frame) {
    const Shot shot = stage.shot(frame);
    const Pose world = truth.cameras.rests() ? shot.camera.cam_from_world : Pose::Identity();
    if (!truth.cameras.rests()) {
      truth.cameras.cameras.push_back(shot.camera);
    } else if (frame == 0) {
      Camera camera{-1, shot.camera.intrinsics, Pose::Identity()};
      truth.cameras.cameras.push_back(camera);
    }
    TrackedFrame tracked;
    tracked.frame = frame;
    tracked.time_s = frame / options.frames_per_second;
    tracked.pose.world_from_head = world * shot.world_from_head;
    tracked.pose.world_from_torso = world * shot.world_from_torso;
    tracked.pose.articulation = shot.articulation;
    const auto points = landmark_positions(stage.model(), stage.posed(shot));
    const Pose cam_from_head = shot.camera.cam_from_world * shot.world_from_head;
    for (std::size_t i = 0; i < points.size(); ++i) {
      tracked.landmarks[i] =
          project<double>(shot.camera.intrinsics, Vec3d(cam_from_head * points[i].cast<double>()));
    }
    truth.track.frames.push_back(std::move(tracked));
  }
  return truth;
}

// Every tenth frame, and the first of every shot.
bool shows_room(const DemoStage& stage, int frame) {
  return frame % 10 == 0 || shot_of(stage.shots(), frame).first == frame;
}

Result<void> film_all(DemoStage& stage, const fs::path& folder, const DemoOptions& options,
                      const Progress& progress, std::stop_token stop) {
  EncodeOptions encode;
  encode.frames_per_second = options.frames_per_second;
  encode.crf = 14;
  if (options.lens_tag) encode.tags.emplace_back(kFocalLengthTag, std::to_string(focal_35mm(options)));
  auto video = VideoWriter::create(folder / "demo.mp4", options.width, options.height, encode);
  if (!video) return video.error();
  for (int frame = 0; frame < options.frames; ++frame) {
    if (stop.stop_requested()) return cancelled_error();
    const DemoFrame picture = stage.film(frame, stop);
    if (!picture.complete) return cancelled_error();
    if (auto added = video->add(picture.rgb); !added) return added;
    const fs::path mask = folder / "masks_truth" / fmt::format("{:06d}.png", frame);
    if (auto written = write_image(mask, picture.mask); !written) return written;
    if (options.camera != DemoCamera::guided && shows_room(stage, frame)) {
      const auto room = stage.film_room(frame, stop);
      if (!room) return cancelled_error();
      const fs::path path = folder / "wall_truth" / fmt::format("{:06d}.png", frame);
      if (auto written = write_image(path, *room); !written) return written;
    }
    progress.report((frame + 1.0) / options.frames, fmt::format("frame {} of {}", frame + 1, options.frames));
  }
  return video->finish();
}

// Where the habit moves the skin by at least a third of its maximum, as seen in one frame.
Image8 habit_mask(const DemoStage& stage, const Shot& shot) {
  const std::vector<Vec3f>& field = stage.play().habit();
  float most = 0;
  for (const Vec3f& way : field) most = std::max(most, way.norm());
  const Intrinsics& k = shot.camera.intrinsics;
  const auto& triangles = stage.model().triangles;
  const Raster raster =
      rasterise(stage.posed(shot), triangles, k, shot.camera.cam_from_world * shot.world_from_head);
  Image8 mask(k.width, k.height, 1);
  for (std::size_t i = 0; i < raster.triangle.size(); ++i) {
    if (raster.triangle[i] < 0) continue;
    const Triangle& t = triangles[std::size_t(raster.triangle[i])];
    float way = 0;
    for (int corner = 0; corner < 3; ++corner)
      way += raster.barycentric[i][corner] * field[std::size_t(t[corner])].norm();
    mask.data[i] = way > most / 3 ? 255 : 0;
  }
  return mask;
}

Result<void> write_habit_truth(const DemoStage& stage, const fs::path& folder, const DemoOptions& options) {
  nlohmann::json strengths = nlohmann::json::array();
  for (int frame = 0; frame < options.frames; ++frame) {
    const Shot shot = stage.shot(frame);
    strengths.push_back(shot.habit);
    if (shot.habit > 0 && shot.habit < 0.95f) continue;
    const fs::path path = folder / "habit_truth" / fmt::format("{:06d}.png", frame);
    if (auto written = write_image(path, habit_mask(stage, shot)); !written) return written;
  }
  return write_text(folder / "habit_truth.json",
                    json_text(nlohmann::json{{"strengths", strengths}}, 1) + "\n");
}

Result<void> write_drift_truth(const fs::path& folder, const DemoOptions& options) {
  nlohmann::json gains = nlohmann::json::array(), face = gains, room = gains;
  for (int frame = 0; frame < options.frames; ++frame) {
    const Drift drift = drift_of(options, frame);
    gains.push_back({drift.gain.x(), drift.gain.y(), drift.gain.z()});
    face.push_back(drift.face_blur_px), room.push_back(drift.room_blur_px);
  }
  const nlohmann::json all = {{"gains", gains}, {"face_blur_px", face}, {"room_blur_px", room}};
  return write_text(folder / "drift_truth.json", json_text(all, 1) + "\n");
}

// What is known of the film beside its pictures.
Result<void> write_truth(const DemoStage& stage, const fs::path& folder, const DemoOptions& options) {
  const Truth truth = truth_of(stage, options);
  const fs::path cameras = folder / "cameras_truth.json";
  if (auto written = write_cameras(cameras, truth.cameras); !written) return written;
  if (auto added = add_demo_truth(cameras, options, stage.shots()); !added) return added;
  if (auto written = write_track(folder / "track_truth.json", truth.track); !written) return written;
  if (options.habit)
    if (auto written = write_habit_truth(stage, folder, options); !written) return written;
  if (options.drift)
    if (auto written = write_drift_truth(folder, options); !written) return written;
  return {};
}

}  // namespace

Result<void> write_demo_capture(const fs::path& folder, const DemoOptions& options, const Progress& progress,
                                std::stop_token stop) {
  if (auto checked = check_options(options); !checked) return checked;
  if (stop.stop_requested()) return cancelled_error();
  Unfinished unfinished(folder);
  if (auto made = make_writable_folder(unfinished.part() / "masks_truth"); !made) return made;
  progress.report(0, "Building the set");
  DemoStage stage(make_builtin_head(), options);
  const Progress filming = progress.stage(0.02, 0.99, "Filming");
  if (auto filmed = film_all(stage, unfinished.part(), options, filming, stop); !filmed) return filmed;
  if (auto written = write_truth(stage, unfinished.part(), options); !written) return written;
  if (stop.stop_requested()) return cancelled_error();
  if (auto kept = unfinished.keep(); !kept) return kept;
  progress.report(1, "Demo capture written");
  return {};
}

}  // namespace likeness
