// What a clip shows of a person, measured: the evidence of the capture check. About five looks a second, one
// pass over the clip for the face and one for the camera.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/capture/capture.h"
#include "core/check/clip_words.h"
#include "core/check/measure_camera.h"
#include "core/face/landmarks.h"
#include "core/image/pixel_rect.h"
#include "core/video/decode.h"

namespace likeness {

// Expressions an avatar must have seen to be able to show them, each measured by one or two named actions.
enum class KeyExpression { open_mouth, smile, pucker, raise_brows, shut_eyes };
inline constexpr std::array kKeyExpressions{KeyExpression::open_mouth, KeyExpression::smile,
                                            KeyExpression::pucker, KeyExpression::raise_brows,
                                            KeyExpression::shut_eyes};

// The measures of one sampled picture.
struct Look {
  int frame = 0;
  double time_s = 0;
  bool serves = true;           // in a shot that would serve
  std::optional<FaceBox> face;  // of the main person, source px
  bool second_face = false;     // another of comparable size is in view
  // Of pictures with a face:
  double sharpness = 0;                     // core/capture/scan_clip.h
  double level = 0;                         // mean luma of the face, 0..255
  double dark_share = 0, bright_share = 0;  // of the face's pixels: nearly black, burnt out
  double cut_share = 0;                     // of the head's surroundings, outside the picture
  bool posed = false;                       // the landmarks agreed; what follows holds
  double yaw_deg = 0, pitch_deg = 0;  // of the head against the line of sight: to the subject's left, up
  std::array<double, kKeyExpressions.size()> expressions{};  // amounts, 0 none .. 1 full
};

struct ClipMeasures {
  VideoInfo info;
  int frames = 0;                // decoded
  std::optional<Error> fault{};  // why they are not all (VideoReader::fault())
  double duration_s = 0;         // of them
  std::vector<Look> looks;
  std::vector<ClipShot> shots;  // of a film that was cut, those that would serve and the others
  CameraMeasures camera;
  // What was filmed of the pictures: without the bars that an editor added (core/capture/find_film.h), px of
  // the clip; empty: all of them. All else is about it, and in its pixels: `info`, too.
  PixelRect film{};
  int whole_width = 0, whole_height = 0;  // px of the clip's pictures
  int repeated = 0;                       // frames that show the one before them once more
  bool has_person_network = false;
  int faces = 0, persons_seen = 0;  // looks at a face with it; those in which it saw the person
};

// For sentences about the clip (clip_words.h).
ClipFacts clip_facts(const ClipMeasures& measures);

// landmark_model: as landmark_source takes it. person_network: as chosen_person_network takes it
// (core/matte/person_network.h). Refuses what cannot be decoded; a clip without a face is still
// measured.
Result<ClipMeasures> measure_clip(const std::filesystem::path& video,
                                  const std::filesystem::path& landmark_model,
                                  const std::filesystem::path& person_network, const Progress& progress,
                                  std::stop_token stop);

}  // namespace likeness
