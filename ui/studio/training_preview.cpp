// See training_preview.h.
#include "ui/studio/training_preview.h"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <exception>
#include <numbers>
#include <utility>

#include "core/base/priority.h"
#include "core/direct/direct_avatar.h"
#include "core/direct/presets.h"
#include "core/direct/seen_limits.h"
#include "core/image/files.h"
#include "core/image/metrics.h"
#include "core/render/camera_path.h"
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
};

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
  Scene scene{*contents, {}, {}, true};
  std::vector<int> frames = shown_frames(**contents, true);
  if (frames.empty()) {
    frames = shown_frames(**contents, false);
    scene.held_out = false;
  }
  if (frames.empty()) return std::nullopt;
  frames = well_tracked(**contents, frames);
  scene.view = *frame_view(**contents, frames[frames.size() / 2]);
  auto truth = read_image(project.folder / frame_name(scene.view.tracked->frame));
  if (!truth || truth->channels != 3) return std::nullopt;
  const PixelRect& inside = (*contents)->capture->inside;
  scene.truth = crop(*truth, inside);
  scene.view.camera = view_of_part(scene.view.camera, inside);
  return scene;
}

Image8 over_plate(const Avatar& avatar, const Image& rgba, bool camera_rests) {
  const bool plate = camera_rests && avatar.plate.width == rgba.width && avatar.plate.height == rgba.height;
  return to_bytes(composite(rgba, plate ? avatar.plate : Image8{}, Vec3f::Constant(0.88f)));
}

// The avatar at rest but for the performance's channels.
Image render_directed(const Scene& scene, const AvatarRig& rig, const std::shared_ptr<const Avatar>& avatar,
                      const Performance& performance, const RenderOptions& options,
                      PictureRenderer& renderer) {
  const DirectedMoment moment = direct_moment(direct_avatar(*avatar, *scene.contents->model), performance, 0);
  const RenderState state = pose_avatar(rig, moment.pose);
  return renderer.render(avatar, resized(moment.camera, avatar->size), state, options).rgba;
}

PreviewPictures render_preview(const Scene& scene, const std::shared_ptr<const Avatar>& shared,
                               std::size_t number, PictureRenderer& renderer) {
  const Avatar& avatar = *shared;
  static constexpr double kTurns_deg[] = {-20, 20, 10, -10};
  static constexpr const char* kFaces[] = {"smile", "A", "surprise", "O"};
  const AvatarRig rig = make_rig(avatar, *scene.contents->model);
  RenderOptions options = render_options(RenderQuality::preview);
  PreviewPictures pictures;
  pictures.frame = scene.view.tracked->frame;
  pictures.held_out = scene.held_out;
  pictures.truth = scene.truth;
  pictures.step = avatar.steps;
  pictures.training_s = avatar.train_seconds;
  const AvatarPose pose = frame_pose(avatar, scene.contents->next_courses, *scene.view.tracked);
  pictures.same = over_plate(
      avatar, renderer.render(shared, scene.view.camera, pose_avatar(rig, pose), options).rgba, true);
  if (pictures.same.width == scene.truth.width && pictures.same.height == scene.truth.height)
    pictures.psnr_db = psnr_from_mse(mse(to_float(pictures.same), to_float(scene.truth)));
  const double turn = kTurns_deg[number % std::size(kTurns_deg)];
  Performance aside;
  set_value(aside, "camera yaw", float(turn), {});
  pictures.turned = over_plate(avatar, render_directed(scene, rig, shared, aside, options, renderer), false);
  pictures.turned_words = fmt::format("From {:.0f}\u00b0 {}", std::abs(turn), turn < 0 ? "right" : "left");
  const std::string_view wanted = kFaces[number % std::size(kFaces)];
  const auto preset = std::ranges::find(scene.presets, wanted, &Preset::name);
  if (preset == scene.presets.end()) return pictures;
  Performance face;
  apply_preset(face, *preset, {});
  pictures.expression =
      over_plate(avatar, render_directed(scene, rig, shared, face, options, renderer), true);
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
      pictures = std::make_shared<const PreviewPictures>(render_preview(*scene, avatar, number, renderer));
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
