// See further_views.h.
#include "core/project/further_views.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/parallel.h"
#include "core/matte/head_pixels.h"
#include "core/matte/plate_file.h"
#include "core/project/further_clips.h"
#include "core/project/project_views.h"
#include "core/project/staleness.h"

namespace likeness {
namespace {

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
    plate.camera = plate_info->camera;
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
      Image8 taught = head.taught(*find_tracked(track, frame), *find_camera(cameras, frame),
                                  view.camera.intrinsics, to_image(view.alpha));
      fill_outside(taught, view.inside, 0);
      view.teaches = TiledMask(taught);
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
