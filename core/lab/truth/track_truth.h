// A track measured against the ground truth of a demo capture.
//
// One picture knows no metre, and two head models put their origins at different places. So one scale s and
// one rigid offset X = truth_head_from_head are taken out first, for all frames together, from training
// frames: cam_from_truth_head * X and cam_from_head differ by s about the camera. What is left is the track's
// error.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/head/head_model.h"
#include "core/scene/track.h"

namespace likeness {

struct TrackTruth {
  Track track;
  CameraSet cameras;  // metric
  HeadModel model;    // of the truth's coefficients
};
// folder: as `likeness demo` writes it.
Result<TrackTruth> read_track_truth(const std::filesystem::path& folder);

struct TruthAlignment {
  double scale = 1;                              // true distance / tracked distance
  Pose truth_head_from_head = Pose::Identity();  // m, after scaling
};

struct PoseErrors {
  double turn_median_deg = 0, turn_p95_deg = 0;
  // Of the point midway between the eyes, seen from the camera.
  double along_median_percent = 0, along_p95_percent = 0;  // of the distance
  double across_median_mm = 0, across_p95_mm = 0;
};

struct TruthCorrelation {
  std::string name;  // a named action, or gazeYaw, gazePitch
  std::optional<double>
      value;  // Pearson's; absent where the truth hardly moves or one model lacks the action
};

struct TruthScore {
  int frames = 0, good = 0, weak = 0, lost = 0;
  PoseErrors pose;  // of frames that are not lost
  std::vector<TruthCorrelation> correlations;
};

// The resting face that a track found, beside the true person's with expression zero; the fitted head is
// brought there by the alignment.
struct RestError {
  double mouth_rms_mm = 0;  // distance of the mouth's skin to the true surface, rms over the fitted vertices
  double mouth_width_mm = 0;  // between the corners of the mouth, minus the true one
};

struct TruthComparison {
  TruthAlignment alignment;
  TruthScore training, held_out;
  double shape_rms_mm = 0;  // of the face with expression zero, see shape_error
  RestError rest;           // of the resting face that was found
};

// Pearson's; absent with fewer than 5 frames or where the truth hardly moves.
std::optional<double> course_correlation(const std::vector<double>& truth, const std::vector<double>& found);

// The actions whose course is compared.
const std::vector<std::string>& compared_actions();

// Distance of the fitted face at rest (expression zero, the skin of the face region) to the true surface,
// rms over the fitted vertices, m. The fitted head is brought there by the alignment.
double shape_error(const HeadModel& model, const PersonShape& fitted, const HeadModel& truth_model,
                   const PersonShape& truth, const TruthAlignment& alignment);

// neutral: as the track has it. The mouth is the face's skin within 10 mm of the lips' landmarks.
RestError rest_error(const HeadModel& model, const PersonShape& fitted, const Articulation& neutral,
                     const HeadModel& truth_model, const PersonShape& truth, const TruthAlignment& alignment);

// estimate: tracked with the truth's cameras. model: the estimate's.
Result<TruthComparison> compare_with_truth(const Track& estimate, const HeadModel& model,
                                           const TrackTruth& truth, const std::set<int>& held_out);

}  // namespace likeness
