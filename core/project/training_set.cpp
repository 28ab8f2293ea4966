// See training_set.h.
#include "core/project/training_set.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/parallel.h"
#include "core/matte/plate_file.h"
#include "core/project/further_views.h"
#include "core/project/project_detail.h"
#include "core/project/project_views.h"
#include "core/project/stage_inputs.h"

namespace likeness {

Result<TrainingSet> load_training_views(const Project& project, const HeadModel& model) {
  auto read = read_tracked_capture(project);
  if (!read) return read.error();
  read->capture =
      without_left_out(std::move(read->capture), stage_inputs(project.options).train.choices.left_out);
  const auto& [capture, cameras, track] = *read;
  if (const auto fits = check_track_fits(track, model); !fits) return fits.error();
  const auto plate_info = read_plate_info(plate_info_path(project));
  if (!plate_info) return plate_info.error();

  TrainingSet set;
  set.size = capture.size;
  set.model = model;
  set.person = track.person;
  set.neutral = track.neutral;
  set.has_torso = track.has_torso;
  set.torso_modes = track.torso_modes;
  if (const auto read_plate = read_project_plate(project, set.plate, set.plate_known); !read_plate)
    return read_plate.error();
  if (!set.plate.empty()) set.plate_camera = plate_info->camera;
  set.views = tracked_views(*read);
  for (TrainingView& view : set.views)
    view.has_plate = !set.plate.empty() && std::ranges::binary_search(plate_info->frames, view.camera.frame);
  if (set.views.size() < 20) {
    return Error{ErrorCode::bad_input,
                 fmt::format("Only {} frames are tracked well enough to train on.", set.views.size()),
                 "Film again facing the camera in even light, or use a longer clip.",
                 project.folder.string()};
  }
  if (const auto added = add_further_views(project, model, set); !added) return added.error();
  const auto detail = read_project_detail(project, model);
  if (!detail) return detail.error();
  if (*detail) take_detail(**detail, set);
  return set;
}

Result<void> load_training_pictures(const Project& project, TrainingSet& set) {
  const std::size_t own = own_views(set).size();
  std::vector<Result<void>> loaded(own);
  parallel_for(own, [&](std::size_t i) { loaded[i] = load_view_pictures(project, set.views[i]); });
  for (const auto& outcome : loaded) {
    if (!outcome) return outcome.error();
  }
  return load_further_pictures(project, set);
}

Result<TrainingSet> load_training_set(const Project& project, const HeadModel& model) {
  auto set = load_training_views(project, model);
  if (!set) return set.error();
  if (const auto loaded = load_training_pictures(project, *set); !loaded) return loaded.error();
  return set;
}

}  // namespace likeness
