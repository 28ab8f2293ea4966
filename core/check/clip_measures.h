// What a clip shows of a person, measured: the evidence of the capture check. About five looks a second, one
// pass over the clip for the face and one for the camera.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/camera/motion.h"
#include "core/capture/capture.h"
#include "core/face/landmarks.h"
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

struct CameraMeasures {
  bool rests = false;
  double motion = 0;  // length of the background's path, in 1/1000 of the width (core/camera/motion.h)
  double travel = 0;  // the same without small shaking
  Sway sway;          // what distinguishes shaking from deliberate movement
  double tracks = 0;  // background features this is based on
};

struct ClipMeasures {
  VideoInfo info;
  int frames = 0;         // decoded
  double duration_s = 0;  // of them
  std::vector<Look> looks;
  std::vector<ClipShot> shots;  // of a film that was cut, those that would serve and the others
  CameraMeasures camera;
};

// landmark_model: empty = the system's. Refuses what cannot be decoded; a clip without a face is still
// measured.
Result<ClipMeasures> measure_clip(const std::filesystem::path& video,
                                  const std::filesystem::path& landmark_model, const Progress& progress,
                                  std::stop_token stop);

}  // namespace likeness
