// How far the mattes and what was learnt of the background can be trusted, measured by the matte stage itself
// once both are there. Kept in a project as matte_report.json.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/camera/camera.h"

namespace likeness {

// What says where the person is, beside the tracked head and colours.
enum class MaskPrior { none, person_network, matting_network, clip };  // clip: it brought its own
const char* mask_prior_name(MaskPrior prior);                          // as written above

// How well a picture of the background alone - plate, mosaic or room - shows what frames show of it. Only
// pixels beside the person, with a margin, count.
struct BackgroundFit {
  int frames = 0;          // compared; 0: none shows any background
  bool held_out = true;    // nothing was learnt from them; false: no such frames, these trained
  double psnr_db = 0;      // mean over the frames
  double constant_db = 0;  // the same for one colour a frame, the mean of its own background
};
// What psnr_db must reach. One colour a frame knows nothing of what is there: a background that was learnt
// leaves at most half of the squared error that it leaves, 3 dB. At 16 dB the error is a sixth of the range,
// another picture to anybody, however much contrast there is; at 26, a twentieth, which an exposure that
// drifts before a plain wall makes of a true picture, and one colour a frame would follow it.
inline constexpr double kBeyondOneColour_dB = 3, kNeverLearnt_dB = 16, kSurelyLearnt_dB = 26;
double needed_db(const BackgroundFit& fit);
bool is_learnt(const BackgroundFit& fit);  // true where there was nothing to compare

// The plate beside all frames that were filmed before it: one that differs from many of them is of a camera
// that did not do what it was taken for.
struct PlateLookBack {
  int frames = 0;        // compared
  double differing = 0;  // share of them in which too much of the background, far from the person, differs
};
inline constexpr double kMaxDiffering = 0.25;  // passers-by and a door take fewer
bool holds(const PlateLookBack& look);

struct MatteReport {
  MaskPrior prior = MaskPrior::none;
  int frames = 0;        // with a matte
  int prior_frames = 0;  // in which the prior was used: it saw the tracked head there
  PlateLookBack plate_look_back{};
  std::optional<BackgroundFit> plate{}, room{};  // nullopt: there is none
  bool has_mosaic = false;                       // the plate is one
};

// What a plate that does not hold means before a camera of this kind, and what the user can do; empty where
// it holds.
std::string look_back_warning(const MatteReport& report, CameraKind kind);

// Why plate or room do not show the background, in a sentence or two; empty where they do, or there is none.
// A room that fails is not shown, a plate that fails still is.
std::string plate_fault(const MatteReport& report);
std::string room_fault(const MatteReport& report);
// Why the avatar's background counts as not learnt: of the plate where there is one, otherwise of the room.
std::string background_fault(const MatteReport& report);

Result<void> write_matte_report(const std::filesystem::path& path, const MatteReport& report);
// A missing file: of mattes from before there was one, nullopt.
Result<std::optional<MatteReport>> read_matte_report(const std::filesystem::path& path);

}  // namespace likeness
