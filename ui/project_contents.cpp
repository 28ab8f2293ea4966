// See project_contents.h.
#include "ui/project_contents.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/hash.h"
#include "core/direct/seen_limits.h"
#include "core/project/project_views.h"
#include "core/project/run_stages.h"

namespace likeness::ui {

namespace {

template <class T>
std::shared_ptr<const T> shared_or_none(Result<T> result) {
  return result ? std::make_shared<const T>(std::move(*result)) : nullptr;
}

bool avatar_fits(const Avatar& avatar, const HeadModel& model) {
  return avatar.head_model_hash == model.hash && avatar.neutral.expression.size() == model.expression_count();
}

std::shared_ptr<const DirectedAvatar> read_directed(const Project& project,
                                                    std::shared_ptr<const HeadModel> model) {
  auto avatar = read_avatar(avatar_path(project));
  if (!avatar || !model || !avatar_fits(*avatar, *model)) return nullptr;
  auto directed = std::make_shared<DirectedAvatar>();
  directed->model = std::move(model);
  directed->avatar = std::move(*avatar);
  directed->rig = make_rig(directed->avatar, *directed->model);
  directed->seen = seen_from_rest(directed->avatar, *directed->model);
  if (auto hash = hash_file(avatar_path(project))) directed->hash = std::move(*hash);
  return directed;
}

SeenTurn read_seen_turn(const ProjectContents& contents) {
  SeenTurn seen;
  std::array<std::vector<double>, 3> angles;
  if (!contents.avatar || !contents.capture) return seen;
  for (const CaptureFrame& frame : contents.capture->frames) {
    const auto view = frame.used ? frame_view(contents, frame.frame) : std::nullopt;
    if (!view) continue;
    const auto turn =
        relative_turn(contents.avatar->avatar, view->camera.cam_from_world, view->pose.world_from_head);
    for (std::size_t axis = 0; axis < 3; ++axis) angles[axis].push_back(turn[axis]);
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (angles[axis].empty()) continue;
    std::ranges::sort(angles[axis]);
    seen.low_deg[axis] = angles[axis][(angles[axis].size() - 1) * 2 / 100];
    seen.high_deg[axis] = angles[axis][(angles[axis].size() - 1) * 98 / 100];
  }
  return seen;
}

}  // namespace

Result<std::shared_ptr<const ProjectContents>> read_contents(const std::filesystem::path& folder,
                                                             const ProjectContents* earlier) {
  auto project = open_project(folder);
  if (!project) return project.error();
  auto contents = std::make_shared<ProjectContents>();
  contents->project = std::move(*project);
  const Project& p = contents->project;
  for (const Stage stage : kStages) contents->current[std::size_t(stage)] = is_current(p, stage);
  if (auto info = probe_video(p.options.video)) contents->clip = std::move(*info);
  const auto same_stage = [&](Stage stage) {
    return earlier && contents->is_current(stage) && earlier->is_current(stage) &&
           earlier->project.record(stage).input_hash == p.record(stage).input_hash;
  };
  if (earlier && earlier->model && earlier->project.options.head_model == p.options.head_model) {
    contents->model = earlier->model;
  } else {
    contents->model = shared_or_none(project_head_model(p.options));
  }
  contents->capture = shared_or_none(read_capture(capture_path(p)));
  contents->cameras = shared_or_none(read_cameras(cameras_path(p)));
  contents->track = same_stage(Stage::fit) ? earlier->track : shared_or_none(read_track(track_path(p)));
  contents->avatar =
      same_stage(Stage::train) && earlier->avatar ? earlier->avatar : read_directed(p, contents->model);
  contents->seen_turn = read_seen_turn(*contents);
  return std::shared_ptr<const ProjectContents>(std::move(contents));
}

std::optional<FrameView> frame_view(const ProjectContents& contents, int frame) {
  if (!contents.capture || !contents.cameras || !contents.track) return std::nullopt;
  const TrackedFrame* tracked = find_tracked(*contents.track, frame);
  const auto camera = picture_camera(*contents.capture, *contents.cameras, *contents.track, frame);
  if (!tracked || tracked->status == FrameStatus::lost || !camera) return std::nullopt;
  return FrameView{
      frame,
      *camera,
      {tracked->world_from_head, tracked->world_from_torso, tracked->articulation, tracked->torso_shape}};
}

std::vector<int> shown_frames(const ProjectContents& contents, bool held_out) {
  std::vector<int> frames;
  if (!contents.capture) return frames;
  for (const CaptureFrame& frame : contents.capture->frames)
    if ((frame.held_out || (!held_out && frame.used)) && frame_view(contents, frame.frame))
      frames.push_back(frame.frame);
  return frames;
}

}  // namespace likeness::ui
