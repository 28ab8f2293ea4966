// How the background moves: feature tracks outside the person through a whole clip, from which follow whether
// the camera moves, where it rests, and which frames show it from usefully different places.
#pragma once

#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/base/frame_span.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/image/image.h"
#include "core/image/pixel_rect.h"

namespace likeness {

// Frames first..last (numbers in the source) during which the camera did not move.
struct RestStretch {
  int first = 0, last = 0;
};

struct FrameMotion {
  int frame = 0;
  double path = 0;       // length of the background's way so far, in 1/1000 of the picture's width
  double travel = 0;     // the same without the shaking of a hand: only ways of 2 % of the width count
  double sharpness = 0;  // variance of the Laplacian outside the person
  double x = 0, y = 0;   // where the background is, against its start, 1/1000 of the width
  double time_s = 0;
};

struct BackgroundMotion {
  int width = 0, height = 0;  // px of the source
  double motion = 0;          // 95th percentile of the path: 0 for a camera at rest, in 1/1000 of the width
  double seconds = 0;         // from the first frame to the last
  double tracks = 0;          // feature tracks that carried the decision, mean over the frames
  int stride = 1;             // of the frames looked at (core/video/decode.h: sampled)
  std::vector<FrameMotion> frames;  // every frame looked at
  std::vector<RestStretch> rests;   // at least a second long each
};

// The same frames, one for one, small and grey, and where the person is in them: what a hand-held camera is
// solved on.
struct BackgroundPictures {
  std::vector<int> frames;
  std::vector<Image8> grey;  // one for each of the frames, all of one size
  std::vector<Image8>
      person;  // of every kMaskEvery-th frame, from the first on: 255 = not background; or none
  const Image8* person_at(std::size_t i) const {
    return person.empty() ? nullptr : &person[std::min(i / kMaskEvery, person.size() - 1)];
  }
  static constexpr std::size_t kMaskEvery = 5;  // frames between two askings for the person
};

// What distinguishes a shaking hand from a camera that is moved somewhere: the one stays near its middle, or
// returns to it again and again; the other goes far, and slowly.
struct Sway {
  double reach = 0;  // across the places where the background is for nearly all of the time, 1/1000 of the
                     // width
  double crossings = 0;  // times a second that it passes the middle of them, from one quarter to the other
};
Sway measure_sway(const BackgroundMotion& motion);

// Of a moving camera: it is not going anywhere.
bool is_shaking(const Sway& sway);

// The longest stretch between rests, or nullopt where there is none.
struct MovingStretch {
  int first = 0, last = 0;  // frames
};
std::optional<MovingStretch> moving_stretch(const BackgroundMotion& motion);

// Fewer tracks than this say nothing about the camera.
inline constexpr double kLeastTracks = 8;

// person(frame, rgb): 255 = ignore; asked for every fifth frame, at the source's size. May be empty.
// rest_px_per_1000: how far the background may stray, in 1/1000 of the width, for the camera to be at rest.
// pictures: receives what was looked at; null: not kept.
// film: the part of the pictures that is looked at, and that `person` and the result are about; empty: all.
// stretches: as AlignOptions has them; of one place, so that points are looked for beyond a cut where they
// were before it.
Result<BackgroundMotion> measure_background_motion(const std::filesystem::path& video,
                                                   const std::function<Image8(int, const Image8&)>& person,
                                                   double rest_px_per_1000, const Progress& progress,
                                                   std::stop_token stop,
                                                   BackgroundPictures* pictures = nullptr,
                                                   const PixelRect& film = {},
                                                   const std::vector<FrameSpan>& stretches = {});

struct VideoInfo;
struct VideoFrame;

// The same, fed by another's decoding: of every frame sampled (core/video/decode.h), RGB, in order.
class MotionMeter {
 public:
  MotionMeter(const VideoInfo& info, const std::filesystem::path& video,
              std::function<Image8(int, const Image8&)> person, double rest_px_per_1000);
  ~MotionMeter();

  Result<void> add(const VideoFrame& frame);
  Result<BackgroundMotion> finish();
  // After finish(), once.
  BackgroundPictures take_pictures();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// At most `count` frames: evenly spaced along the background's travel, each the sharpest of its
// neighbourhood. A long sweep gets one for every 9 % of the width, a short one more, but none nearer than
// 3.5 %: closer pictures bring no parallax, only cost.
std::vector<int> choose_keyframes(const BackgroundMotion& motion, int count);

}  // namespace likeness
