// What each step of the tracker brings: one clip tracked with more and more steps, each measured against the
// truth of a demo or, on a real clip, against measurements it has not seen.
#pragma once

#include <filesystem>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/head/head_model.h"
#include "core/lab/truth/face_marks.h"
#include "core/lab/truth/track_checks.h"
#include "core/lab/truth/track_truth.h"
#include "core/track/clip/track_clip.h"
#include "core/track/points/withheld_points.h"

namespace likeness {

struct TrackStep {
  std::string name;
  TrackOptions options;
};
const std::vector<std::string>& track_step_names();  // in the order in which they build on each other
// names: empty = all of them.
Result<std::vector<TrackStep>> track_steps(const std::vector<std::string>& names, const TrackOptions& base);

// A clip to track, and with what.
struct StudyClip {
  std::filesystem::path video;
  TrackRegion region;  // empty = the whole picture
  CameraSet cameras;
  std::set<int> held_out;
  HeadModel model;
  std::vector<FaceMark> marks;  // or empty
};

struct TruthRow {
  std::string step;
  TruthComparison comparison;
  double seconds = 0, frames_per_second = 0;
};
// The last tenth of the frames is held out, as in a project. tracks: where each step's track.json goes, or
// empty.
Result<std::vector<TruthRow>> study_against_truth(const std::filesystem::path& demo, const HeadModel& model,
                                                  const std::vector<TrackStep>& steps,
                                                  const std::filesystem::path& tracks,
                                                  const Progress& progress, std::stop_token stop);

struct CheckRow {
  std::string step;
  int frames = 0, good = 0, weak = 0, lost = 0;
  double inner_error_px = 0;  // source px, as `likeness track` says it
  WithheldScore withheld;     // working px
  FreshLandmarks fresh;
  Stillness stillness;
  MarkScore marks;
  double seconds = 0, frames_per_second = 0;
};
// 15 % of the point tracks are held back from the dense step; every row is judged by the same ones.
Result<std::vector<CheckRow>> study_real_clip(const StudyClip& clip, const std::vector<TrackStep>& steps,
                                              const std::filesystem::path& tracks, const Progress& progress,
                                              std::stop_token stop);

}  // namespace likeness
