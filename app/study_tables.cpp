// See study_tables.h.
#include "app/study_tables.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/lab/study/cull_study.h"
#include "core/lab/study/landmark_study.h"
#include "core/train/landmark_patches.h"

namespace likeness::app {
namespace {

constexpr int kCulledFrames = 12, kLandmarkFrames = 24;

void add_rows(Table& table, const std::string& rays, const CullTable& sums) {
  for (std::size_t i = 0; i < sums.size(); ++i)
    table.rows.push_back({rays, kCullLookups[i], sums[i].kept_per_ray(), 100 * sums[i].share_dense_lost(),
                          100 * sums[i].share_density_lost(), 100 * sums[i].share_light_lost()});
}

// Landmarks of one part of the face together.
struct FacePart {
  const char* name;
  int first, last;
};
constexpr FacePart kFaceParts[] = {{"brows", 17, 26},
                                   {"nose", 27, 35},
                                   {"eyes", 36, 47},
                                   {"mouth", 48, 67},
                                   {"all", kFirstPatchLandmark, 67}};

std::vector<TableCell> cells_of(const LandmarkStudy& study, const FacePart& part) {
  OffsetAgreement truth, truth_map, truth_dlib, shifted, shifted_map, render;
  int accepted = 0, all = 0, hold = 0;
  double learnt = 0;
  for (const LandmarkRow& row : study.rows) {
    if (row.landmark < part.first || row.landmark > part.last) continue;
    ++all;
    if (!row.accepted) continue;
    ++accepted;
    learnt += row.learnt_correlation;
    hold += row.shifted.correlation() >= kMinCorrelation;
    truth.add(row.truth), truth_map.add(row.truth_map), truth_dlib.add(row.truth_dlib);
    shifted.add(row.shifted), shifted_map.add(row.shifted_map), render.add(row.render);
  }
  return {part.name,
          accepted,
          all,
          learnt / std::max(1, accepted),
          truth_map.correlation(),
          truth_dlib.correlation(),
          truth.correlation(),
          shifted_map.correlation(),
          shifted.correlation(),
          render.correlation(),
          hold};
}

Table each_landmark(const LandmarkStudy& study) {
  Table table{.name = "landmarks_each", .printed = false};
  for (const char* key :
       {"landmark", "learnt_correlation", "spread", "accepted", "shifted_truth", "shifted_truth_map",
        "shifted_truth_dlib", "shifted_render", "shifted_render_map", "render"})
    table.columns.push_back({key, "", 3});
  for (const LandmarkRow& row : study.rows)
    table.rows.push_back({row.landmark, row.learnt_correlation, row.spread, int(row.accepted),
                          row.truth.correlation(), row.truth_map.correlation(), row.truth_dlib.correlation(),
                          row.shifted.correlation(), row.shifted_map.correlation(),
                          row.render.correlation()});
  return table;
}

}  // namespace

Result<std::vector<Table>> occupancy_tables(const Project& project, const std::optional<int>& frames,
                                            const Progress& progress, std::stop_token stop) {
  const auto study = study_culling(project, frames.value_or(kCulledFrames), progress, stop);
  if (!study) return study.error();
  Table table{.name = "occupancy", .title = "What the look-up of empty cells saves and loses"};
  table.columns = {{"rays", "rays of"},
                   {"lookup", "look-up"},
                   {"samples_per_ray", "samples per ray"},
                   {"dense_lost_percent", "dense lost, %", 3},
                   {"density_lost_percent", "density lost, %", 3},
                   {"light_lost_percent", "light lost, %", 3}};
  add_rows(table, fmt::format("{} held-out frames", study->frames), study->held_out);
  add_rows(table, fmt::format("{} actions, each at full", study->actions), study->acted);
  table.notes = {fmt::format(
      "The head's samples every {:.1f} mm; dense: over {:g} per cube side. none: no look-up; trained: the "
      "avatar's\ncells of the posed head; posed, canonical: learnt from the same samples, of the posed head "
      "and of the canonical\nface by the head model's deformation alone; resting: of the canonical face at "
      "rest.",
      1000 * study->spacing, study->threshold)};
  return std::vector<Table>{std::move(table)};
}

Result<std::vector<Table>> landmark_tables(const Project& project, const std::optional<int>& frames,
                                           const Progress& progress, std::stop_token stop) {
  const auto study = study_landmarks(project, frames.value_or(kLandmarkFrames), progress, stop);
  if (!study) return study.error();
  Table table{.name = "landmarks", .title = "What the landmark loss measures: correlations of offsets"};
  table.columns = {{"part", "part"},
                   {"accepted", "accepted", 0},
                   {"landmarks", "of", 0},
                   {"made_up", "synthetic", 3},
                   {"shifted_truth_map", "truth: map", 3},
                   {"shifted_truth_dlib", "truth: dlib", 3},
                   {"shifted_truth", "truth: both", 3},
                   {"shifted_render_map", "shifted render: map", 3},
                   {"shifted_render", "shifted render: both", 3},
                   {"render", "render: both", 3},
                   {"reach_the_limit", fmt::format(">= {}", kMinCorrelation), 0}};
  for (const FacePart& part : kFaceParts) table.rows.push_back(cells_of(*study, part));
  table.notes = {fmt::format(
      "On {} held-out frames: by map or dlib with a known shift, and (both) with each other; last, how many\n"
      "accepted landmarks reach the limit on shifted renders. Synthetic: of the maps on training views kept "
      "out.\n"
      "Patches of {} x {} pixels, {} apart; the eyes' outer corners are {:.0f} px apart.",
      study->frames, kPatchSide, kPatchSide, study->stride, study->interocular_px)};
  return std::vector<Table>{std::move(table), each_landmark(*study)};
}

}  // namespace likeness::app
