// See training_preview.h.
#include "ui/studio/training_preview.h"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <numbers>
#include <utility>

#include "core/base/files.h"
#include "core/base/priority.h"
#include "core/direct/direct_avatar.h"
#include "core/direct/presets.h"
#include "core/direct/seen_limits.h"
#include "core/image/files.h"
#include "core/image/metrics.h"
#include "core/matte/plate_file.h"
#include "core/matte/read_regions.h"
#include "core/project/project_views.h"
#include "core/render/camera_path.h"
#include "core/render/room_picture.h"
#include "ui/studio/channel_words.h"
#include "ui/studio/project_contents.h"

namespace likeness::ui {

namespace {

using PreviewClock = std::chrono::steady_clock;

// What all previews of one training share.
struct Scene {
  std::shared_ptr<const ProjectContents> contents;
  FrameView view;
  Image8 truth;
  bool held_out = false;
  std::vector<Preset> presets;  // within what the clip showed; empty before the first avatar
  Image8 room;                  // what a walking camera sees behind the person there; empty: not known
  bool before_plate = false;    // the plate is what stands behind the person there
  Regions regions;              // of a frame that is not held out: the person alone
};

// What stands behind the person in the scene's frame, and where the person is.
void read_background(Scene& scene) {
  const Project& project = scene.contents->project;
  const Capture& capture = *scene.contents->capture;
  const int frame = scene.view.tracked->frame;
  if (const auto info = read_plate_info(plate_info_path(project)))
    scene.before_plate = std::ranges::binary_search(info->frames, frame);
  if (!scene.before_plate && path_exists(room_path(project)))
    if (const auto room = read_room(room_path(project)))
      scene.room = room_picture(make_room_scene(*room), scene.view.camera, RenderQuality::preview);
  if (auto regions = read_regions(regions_path(project), capture, frame)) {
    scene.regions = std::move(*regions);
  } else if (const auto mask = read_own_picture(project.folder / "masks",
                                                frame_name(frame).filename().string(), capture.size, 1)) {
    scene.regions.person = crop(*mask, capture.inside);
    for (std::uint8_t& alpha : scene.regions.person.data) alpha = alpha > 127 ? 255 : 0;
  }
}

// Empty: not known, a plain colour stands there.
Image8 background_of(const Scene& scene, const Avatar& avatar) {
  if (!scene.before_plate) return scene.room;
  return avatar.mosaic ? mosaic_seen_by(*avatar.mosaic, scene.view.camera) : avatar.plate;
}

bool same_size(const Image8& a, const Image8& b) { return a.width == b.width && a.height == b.height; }

// The figure of the whole picture counts only where the background does.
void score(const Scene& scene, bool background_counts, PreviewPictures& pictures) {
  if (!same_size(pictures.same, scene.truth)) return;
  const Image same = to_float(pictures.same), truth = to_float(scene.truth);
  const auto within = [&](const Image8& region) -> std::optional<double> {
    if (!same_size(region, scene.truth)) return std::nullopt;
    const double error = mse(same, truth, region);
    return std::isfinite(error) ? std::optional(psnr_from_mse(error)) : std::nullopt;
  };
  const auto person = within(scene.regions.person);
  pictures.of_person = !background_counts && person;
  pictures.psnr_db = pictures.of_person ? *person : psnr_from_mse(mse(same, truth));
  if (!pictures.of_person) return;
  pictures.head_db = within(scene.regions.head), pictures.face_db = within(scene.regions.face);
}

// The frames with a good track, or all frames if none has: a preview shows what is learnt, not how well the
// clip was tracked.
std::vector<int> well_tracked(const ProjectContents& contents, const std::vector<int>& frames) {
  std::vector<int> good;
  for (const int frame : frames)
    if (find_tracked(*contents.track, frame)->status == FrameStatus::good) good.push_back(frame);
  return good.empty() ? frames : good;
}

// A frame in the middle of the held-out ones, or of all if none is held out.
std::optional<Scene> open_scene(const Project& project) {
  auto contents = read_contents(project.folder, nullptr);
  if (!contents || !(*contents)->model) return std::nullopt;
  Scene scene{*contents, {}, {}, true, {}, {}, false, {}};
  std::vector<int> frames = shown_frames(**contents, true);
  if (frames.empty()) {
    frames = shown_frames(**contents, false);
    scene.held_out = false;
  }
  if (frames.empty()) return std::nullopt;
  frames = well_tracked(**contents, frames);
  scene.view = *frame_view(**contents, frames[frames.size() / 2]);
  const Capture& capture = *(*contents)->capture;
  const auto truth = read_own_picture(
      project.folder / "frames", frame_name(scene.view.tracked->frame).filename().string(), capture.size, 3);
  if (!truth) return std::nullopt;
  const PixelRect& inside = capture.inside;
  scene.truth = crop(*truth, inside);
  scene.view.camera = view_of_part(scene.view.camera, inside);
  read_background(scene);
  return scene;
}

Image8 over_background(const Image& rgba, const Image8& behind) {
  const bool fits = behind.width == rgba.width && behind.height == rgba.height;
  return to_bytes(composite(rgba, fits ? behind : Image8{}, Vec3f::Constant(0.88f)));
}

// The avatar at rest but for the performance's channels.
Image render_directed(const Scene& scene, const AvatarRig& rig, const std::shared_ptr<const Avatar>& avatar,
                      const Performance& performance, const RenderOptions& options,
                      PictureRenderer& renderer) {
  const DirectedMoment moment = direct_moment(direct_avatar(*avatar, *scene.contents->model), performance, 0);
  const RenderState state = pose_avatar(rig, moment.pose);
  return renderer.render(avatar, resized(moment.camera, avatar->size), state, options).rgba;
}

// Empty where the avatar does not fit the head model: the training's end tells it.
std::optional<PreviewPictures> render_preview(const Scene& scene, const std::shared_ptr<const Avatar>& shared,
                                              std::size_t number, PictureRenderer& renderer) {
  const Avatar& avatar = *shared;
  static constexpr double kTurns_deg[] = {-20, 20, 10, -10};
  static constexpr const char* kFaces[] = {"smile", "A", "surprise", "O"};
  const auto made = make_rig(avatar, *scene.contents->model);
  if (!made) return std::nullopt;
  const AvatarRig& rig = *made;
  RenderOptions options = render_options(RenderQuality::preview);
  PreviewPictures pictures;
  pictures.frame = scene.view.tracked->frame;
  pictures.held_out = scene.held_out;
  pictures.truth = scene.truth;
  pictures.step = avatar.steps;
  pictures.training_s = avatar.train_seconds;
  const AvatarPose pose = frame_pose(avatar, scene.contents->next_courses, *scene.view.tracked);
  const Image8 behind = background_of(scene, avatar);
  pictures.same = over_background(
      renderer.render(shared, scene.view.camera, pose_avatar(rig, pose), options).rgba, behind);
  score(scene, !behind.empty() && scene.contents->background_fault.empty(), pictures);
  const double turn = kTurns_deg[number % std::size(kTurns_deg)];
  Performance aside;
  set_value(aside, "camera yaw", float(turn), {});
  pictures.turned = over_background(render_directed(scene, rig, shared, aside, options, renderer), {});
  pictures.turned_words = fmt::format("From {:.0f}\u00b0 {}", std::abs(turn), turn < 0 ? "right" : "left");
  const std::string_view wanted = kFaces[number % std::size(kFaces)];
  const auto preset = std::ranges::find(scene.presets, wanted, &Preset::name);
  if (preset == scene.presets.end()) return pictures;
  Performance face;
  apply_preset(face, *preset, {});
  pictures.expression =
      over_background(render_directed(scene, rig, shared, face, options, renderer), avatar.plate);
  pictures.expression_words =
      wanted.size() == 1 ? fmt::format("Saying \"{}\"", wanted) : preset_words(*preset);
  return pictures;
}

}  // namespace

TrainingPreview::TrainingPreview(Project project, std::function<void()> wake, OpenBackend open)
    : project_(std::move(project)),
      wake_(std::move(wake)),
      open_(std::move(open)),
      thread_([this](std::stop_token stop) { loop(stop); }) {}

AvatarTap TrainingPreview::tap() {
  return {[this] {
            const std::lock_guard lock(mutex_);
            if (!training_since_) training_since_ = PreviewClock::now();
            return wanted_ &&
                   PreviewClock::now() - *training_since_ >= std::chrono::duration<double>(kFirst_s);
          },
          [this](const Avatar& avatar) {
            {
              const std::lock_guard lock(mutex_);
              avatar_ = std::make_shared<const Avatar>(avatar);
              wanted_ = false;
            }
            changed_.notify_one();
          }};
}

std::shared_ptr<const PreviewPictures> TrainingPreview::latest() const {
  const std::lock_guard lock(mutex_);
  return latest_;
}

std::vector<HeldOutScore> TrainingPreview::scores() const {
  const std::lock_guard lock(mutex_);
  return scores_;
}

void TrainingPreview::loop(std::stop_token stop) {
  lower_thread_priority();
  std::optional<Scene> scene;
  PictureRenderer renderer(open_, {});  // if its device fails, the training reports it
  for (std::size_t number = 0;; ++number) {
    std::shared_ptr<const Avatar> avatar;
    {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [&] { return avatar_ != nullptr; })) return;
      avatar = std::exchange(avatar_, nullptr);
    }
    const auto start = PreviewClock::now();
    std::shared_ptr<const PreviewPictures> pictures;
    try {
      if (!scene) scene = open_scene(project_);
      if (!scene) return;  // nothing to compare with; training goes on without previews
      const HeadModel& model = *scene->contents->model;
      if (scene->presets.empty()) scene->presets = presets(model, seen_from_rest(*avatar, model));
      auto rendered = render_preview(*scene, avatar, number, renderer);
      if (!rendered) return;
      pictures = std::make_shared<const PreviewPictures>(std::move(*rendered));
      renderer.let_go();  // the training needs the memory more
    } catch (const std::exception&) {
      return;  // memory ran out over a preview: the training needs it more
    }
    avatar.reset();
    const double took = std::chrono::duration<double>(PreviewClock::now() - start).count();
    {
      const std::lock_guard lock(mutex_);
      if (pictures->held_out && pictures->psnr_db > 0)
        scores_.push_back({pictures->training_s, pictures->psnr_db});
      latest_ = std::move(pictures);
    }
    wake_();
    std::unique_lock lock(mutex_);
    // Pauses in proportion to what the pictures cost, so that previews take kShare of the time.
    changed_.wait_for(lock, stop, std::chrono::duration<double>(took * (1 / kShare - 1)),
                      [] { return false; });
    if (stop.stop_requested()) return;
    wanted_ = true;
  }
}

}  // namespace likeness::ui
