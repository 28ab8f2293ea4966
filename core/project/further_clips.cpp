// See further_clips.h.
#include "core/project/further_clips.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/base/hash.h"
#include "core/base/parallel.h"
#include "core/matte/head_pixels.h"
#include "core/matte/matte.h"
#include "core/project/care.h"
#include "core/project/project_views.h"
#include "core/project/run_stages.h"
#include "core/video/decode.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

// The choices of a further clip: the first one's, but for what is of one clip alone.
ProjectOptions further_options(const Project& project, ProjectOptions own) {
  const ProjectOptions& first = project.options;
  own.head_model = first.head_model;
  own.landmark_model = first.landmark_model;
  own.matting_network = first.matting_network;
  own.size = first.size;
  own.seed = first.seed;
  return own;
}

// Whose clip has this content: its name for a message, or empty.
std::string holder_of(const Project& project, const std::string& hash) {
  const auto of = [](const Project& any) {
    if (const auto capture = read_capture(capture_path(any))) return capture->video_hash;
    const auto content = hash_video(any.options.video);
    return content ? *content : std::string();
  };
  if (of(project) == hash) return "the project's first clip";
  for (const int number : project.further_clips)
    if (const auto further = open_further_clip(project, number); further && of(*further) == hash)
      return fmt::format("clip {}", number);
  return "";
}

std::vector<TrainingView> further_views(const TrackedCapture& tracked, int number) {
  std::vector<TrainingView> views = tracked_views(tracked);
  for (TrainingView& view : views) {
    view.has_plate = false;
    view.further_clip = number;
    view.pose.world_from_torso = view.pose.world_from_head;
    view.pose.torso_shape = {};
  }
  return views;
}

}  // namespace

fs::path further_clip_folder(const Project& project, int number) {
  return project.folder / "clips" / std::to_string(number);
}

Result<Project> open_further_clip(const Project& project, int number) {
  auto further = open_project(further_clip_folder(project, number));
  if (!further) {
    Error error = further.error();
    error.what = fmt::format("Clip {} of this project cannot be read. {}", number, error.what);
    error.fix = fmt::format("Take it out, and add it again: likeness clips {} --remove {}",
                            project.folder.string(), number);
    return error;
  }
  further->options = further_options(project, std::move(further->options));
  further->first_clip = project.folder;
  return further;
}

Result<int> add_further_clip(Project& project, const fs::path& video, bool resting_camera) {
  const auto probed = probe_video(video);
  if (!probed) return probed.error();
  const auto hash = hash_video(video);
  if (!hash) return hash.error();
  // The lock first, then the newest project.json.
  const auto lock = ProjectLock::acquire(project);
  if (!lock) return lock.error();
  auto newest = open_project(project.folder);
  if (!newest) return newest.error();
  if (const std::string holder = holder_of(*newest, *hash); !holder.empty())
    return Error{ErrorCode::bad_input, fmt::format("{} is {} already.", video.string(), holder),
                 "Add another clip of the same person: one that shows what the first one did not.",
                 video.string()};
  int number = kFirstFurtherClip;
  for (const int taken : newest->further_clips) number = std::max(number, taken + 1);
  std::error_code ignored;
  while (fs::exists(further_clip_folder(*newest, number), ignored)) ++number;  // left by hand or by a failure
  ProjectOptions options;
  options.video = video;
  options.resting_camera = resting_camera;
  const auto further =
      open_or_create_project(further_clip_folder(*newest, number), further_options(*newest, options));
  if (!further) return further.error();
  newest->further_clips.push_back(number);
  if (const auto saved = save_project(*newest); !saved) return saved.error();
  project = std::move(*newest);
  return number;
}

Result<void> remove_further_clip(Project& project, int number) {
  const auto lock = ProjectLock::acquire(project);
  if (!lock) return lock.error();
  auto newest = open_project(project.folder);
  if (!newest) return newest.error();
  if (std::erase(newest->further_clips, number) == 0)
    return Error{ErrorCode::not_found, fmt::format("This project has no clip {}.", number),
                 fmt::format("See its clips: likeness clips {}", project.folder.string()),
                 project.folder.string()};
  if (const auto saved = save_project(*newest); !saved) return saved.error();
  project = std::move(*newest);
  // Forgotten in any case; what is left of a folder that cannot be removed belongs to no clip.
  const fs::path folder = further_clip_folder(project, number);
  if (std::error_code ignored; fs::exists(folder, ignored))
    if (const auto deleted = delete_person(folder, false); !deleted) return deleted.error();
  std::error_code ignored;
  fs::remove(project.folder / "clips", ignored);  // where it is empty
  return {};
}

std::string further_clip_name(const Project& further, int number) {
  return fmt::format("Clip {} ({})", number, further.options.video.filename().string());
}

Result<void> add_further_views(const Project& project, const HeadModel& model, TrainingSet& set) {
  for (const int number : project.further_clips) {
    const auto further = open_further_clip(project, number);
    if (!further) return further.error();
    const auto tracked = read_tracked_capture(*further);
    if (!tracked) return tracked.error();
    if (const auto fits = check_track_fits(tracked->track, model); !fits) return fits.error();
    if (tracked->track.person.identity != set.person.identity || tracked->capture.size != set.size)
      return Error{
          ErrorCode::bad_input,
          fmt::format("{} was tracked with another person's shape.", further_clip_name(*further, number)),
          fmt::format("Fit it again: likeness fit {}", project.folder.string()), further->folder.string()};
    const auto plate_info = read_plate_info(plate_info_path(*further));
    if (!plate_info) return plate_info.error();
    FurtherPlate plate;
    if (const auto read = read_project_plate(*further, plate.rgb, plate.known); !read) return read.error();
    std::vector<TrainingView> views = further_views(*tracked, number);
    for (TrainingView& view : views)
      view.has_plate =
          !plate.rgb.empty() && std::ranges::binary_search(plate_info->frames, view.camera.frame);
    if (!plate.rgb.empty()) set.further_plates[number] = std::move(plate);
    std::ranges::move(views, std::back_inserter(set.views));
  }
  return {};
}

Result<void> load_further_pictures(const Project& project, TrainingSet& set) {
  std::size_t begin = own_views(set).size();
  for (const int number : project.further_clips) {
    const auto further = open_further_clip(project, number);
    if (!further) return further.error();
    const auto tracked = read_tracked_capture(*further);
    if (!tracked) return tracked.error();
    const CameraSet& cameras = tracked->cameras;
    const Track& track = tracked->track;
    const HeadPixels head(set.model, track);
    const std::size_t count = further_views(*tracked, number).size();
    std::vector<Result<void>> loaded(count);
    parallel_for(count, [&](std::size_t i) {
      TrainingView& view = set.views[begin + i];
      loaded[i] = load_view_pictures(*further, view);
      if (!loaded[i]) return;
      const int frame = view.camera.frame;
      view.teaches = TiledMask(head.taught(*find_tracked(track, frame), *find_camera(cameras, frame),
                                           view.camera.intrinsics, to_image(view.alpha)));
    });
    for (const auto& outcome : loaded)
      if (!outcome) return outcome.error();
    begin += count;
  }
  return {};
}

SeenViews learnt_further_views(const Project& project) {
  SeenViews seen;
  if (project.further_clips.empty() || !is_current(project, Stage::train)) return seen;
  for (const int number : project.further_clips) {
    const auto further = open_further_clip(project, number);
    if (!further) continue;
    if (const auto read = read_tracked_capture(*further))
      seen = joined(seen, seen_views(read->capture, read->cameras, read->track));
  }
  return seen;
}

}  // namespace likeness
