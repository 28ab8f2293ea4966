// The camera stage measured against known cameras: those of a demo, or a published solution that lies beside
// its photographs.
//
// A solve from pictures knows neither metre nor origin. So one similarity, the one that brings the found
// centres nearest to the true ones, is taken out first; what is left is the solve's error. Of a camera that
// goes nowhere only its views can be compared (core/lab/truth/view_truth.h).
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/align.h"
#include "core/camera/camera.h"
#include "core/lab/truth/view_truth.h"

namespace likeness {

struct CameraTruth {
  std::filesystem::path input;  // the clip, or the folder of photographs
  bool photographs = false;
  // Those of the moving part of a guided film, all of others. frame: in the clip, or the photograph's place
  // in the order of names.
  CameraSet cameras;
  CameraKind kind = CameraKind::walking;  // what a perfect solve would show
  std::vector<TrueShot> shots;            // of a demo with cuts
};
// folder: as `likeness demo` writes it, or with a transforms.json (NeRF's layout: world from camera, camera
// axes x right, y up, z backwards) that names the photographs. Refuses a guided film in which no camera
// moves.
Result<CameraTruth> read_camera_truth(const std::filesystem::path& folder);

struct CameraErrors {
  int wanted = 0, found = 0;  // true cameras; those among them that the solve placed
  // Of the found ones. Positions in percent of the path's extent, the diagonal of the box of true centres.
  double position_median_percent = 0, position_max_percent = 0;
  double turn_median_deg = 0, turn_max_deg = 0;
  // What of the turn is the same for every camera, as a misplaced principal point makes it; and the median
  // without it.
  double shared_turn_deg = 0, own_turn_median_deg = 0;
  double focal_percent = 0;  // median, found over true - 1
};
// nullopt where fewer than 3 true cameras were found: no similarity follows from them.
std::optional<CameraErrors> compare_cameras(const CameraSet& found, const CameraSet& truth);

struct CameraRow {
  std::string masks;                   // by name
  std::optional<CameraKind> kind;      // of the cameras found; nullopt: none were
  std::optional<CameraErrors> errors;  // of the path, if there is one
  std::optional<ViewErrors> views;
  std::string outcome;  // what the stage said: its evidence, or its failure with the remedy
  double seconds = 0, processor_seconds = 0;  // of the stage, programs it ran included
};
struct NamedMask {
  std::string name;
  PersonMask person;  // may be empty: nothing is masked
};
// One row for each mask. work: an empty folder, or seconds are those of what was left to do.
Result<std::vector<CameraRow>> study_cameras(const CameraTruth& truth, const std::vector<NamedMask>& masks,
                                             const std::filesystem::path& work, const AlignOptions& options,
                                             const Progress& progress, std::stop_token stop);

}  // namespace likeness
