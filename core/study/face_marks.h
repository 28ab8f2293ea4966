// What a person who looked at frames of a clip saw of mouth and eyes, and whether a track says the same.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "core/head/head_model.h"
#include "core/track/track.h"

namespace likeness {

enum class Marked { unsure, no, yes };

struct FaceMark {
  int frame = 0;  // number in the source
  Marked mouth_open = Marked::unsure, eyes_shut = Marked::unsure;
};

// {"version": 1, "frames": [0, 4, ...], "mouth": "oc?...", "eyes": "os?..."}: a letter a frame, o = open, c
// (the mouth) and s (the eyes) = shut, ? = not judged.
Result<std::vector<FaceMark>> read_face_marks(const std::filesystem::path& path);

struct MarkScore {
  int mouths = 0, eyes = 0;                   // judged, in frames the track has
  std::vector<int> wrong_mouths, wrong_eyes;  // frames
};

// By fixed rules, the same for everybody: the mouth is open where the fitted inner lips are more than
// kOpenLips_m apart, eyes are shut where both pairs of lids are less than kShutLids of their median distance
// apart. Frames the track lost count as wrong.
inline constexpr double kOpenLips_m = 0.0025, kShutLids = 0.5;
MarkScore score_marks(const Track& track, const HeadModel& model, const std::vector<FaceMark>& marks);

}  // namespace likeness
