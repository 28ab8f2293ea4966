// What a person who looked at frames of a clip saw of mouth and eyes, and whether a track says the same.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "core/head/head_model.h"
#include "core/scene/track.h"

namespace likeness {

enum class Marked { unsure, no, yes };

struct FaceMark {
  int frame = 0;  // number in the source
  Marked mouth_open = Marked::unsure, eyes_shut = Marked::unsure;
  // That landmarks and head model, drawn over the picture, lay beside the face's features. Mouth and eyes are
  // of the picture and stay true; this is of the track that was looked at, and holds for another one only as
  // far as that one is alike.
  Marked misplaced = Marked::unsure;
};

// {"version": 1, "frames": [0, 4, ...], "mouth": "oc?...", "eyes": "os?...", "placed": "rw?..."}: a letter a
// frame, o = open, c (the mouth) and s (the eyes) = shut, r = right, w = wrong, ? = not judged. "placed" may
// be absent, and "why" ({"12": "the jaw lies on the collar"}) is for people.
Result<std::vector<FaceMark>> read_face_marks(const std::filesystem::path& path);

struct MarkScore {
  int mouths = 0, eyes = 0;                   // judged, in frames the track has
  std::vector<int> wrong_mouths, wrong_eyes;  // frames
  int placed = 0;                             // judged, in frames the track calls good
  std::vector<int> misplaced;                 // of those
};

// By fixed rules, the same for everybody: the mouth is open where the fitted inner lips are more than
// kOpenLips_m apart, eyes are shut where both pairs of lids are less than kShutLids of their median distance
// apart. Frames the track lost count as wrong.
inline constexpr double kOpenLips_m = 0.0025, kShutLids = 0.5;
MarkScore score_marks(const Track& track, const HeadModel& model, const std::vector<FaceMark>& marks);

}  // namespace likeness
