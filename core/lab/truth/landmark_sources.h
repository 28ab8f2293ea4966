// The sources of landmarks (core/face/landmarks.h) beside each other on the same pictures: how still they
// hold, how near to the truth they lie, whether they see a mouth that is open and eyes that are shut, and
// what they cost. Landmarks alone, before any fit, and the live tracker on them.
//
// Lengths are shares of the distance between the outer corners of the eyes.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/head/head_model.h"
#include "core/lab/truth/face_marks.h"

namespace likeness {

enum class FacePart { brows, nose, lids, lips };
inline constexpr std::size_t kFaceParts = 4;
const char* face_part_name(FacePart part);

// The 68 points of a frame, px; nullopt: no face was found.
using FoundPoints = std::vector<std::optional<std::array<Vec2d, kLandmarkCount>>>;

// Frames in which the head is still: over the 9 around, the middle of the inner points moves less than 0.004
// a frame in the mean of all sources, so that none of them chooses.
std::vector<bool> still_frames(const std::vector<FoundPoints>& of_sources);

// RMS second difference of each part's points over still frames with both neighbours, divided by sqrt(6): the
// standard deviation of independent noise. nullopt: fewer than 10 such frames.
std::array<std::optional<double>, kFaceParts> tremble(const FoundPoints& found,
                                                      const std::vector<bool>& still);

// Mean distance to the true points; and without each point's usual (median) offset, in the face's own axes,
// since a source and a head model each draw a point of their own.
struct PointErrors {
  std::array<double, kFaceParts> whole{}, moving{};
};
PointErrors point_errors(const FoundPoints& found, const FoundPoints& truth);

// Mouth and eyes beside the marks, by the rules of face_marks.h for landmarks: open lips are 0.028 apart.
MarkScore score_points(const FoundPoints& found, const std::vector<int>& frames,
                       const std::vector<FaceMark>& marks);

struct SourceRow {
  std::string clip, source;
  int frames = 0, lost = 0;
  std::array<std::optional<double>, kFaceParts> tremble;
  std::optional<PointErrors> errors;       // where the truth is known
  std::optional<MarkScore> marks;          // where there are marks
  double detect_ms = 0, landmarks_ms = 0;  // medians of a frame, of processor time
  double live_fps = 0;                     // of the live tracker, a second of processor time
  int live_lost = 0;
};

// clip: a film, or a folder of `likeness demo`, whose truth is read. sources: as landmark_source takes them.
// At most `max_frames` frames from the clip's start.
Result<std::vector<SourceRow>> study_landmark_sources(const std::filesystem::path& clip,
                                                      const std::vector<std::string>& sources,
                                                      const std::vector<FaceMark>& marks, int max_frames,
                                                      const Progress& progress, std::stop_token stop);

}  // namespace likeness
