// First pass over a clip: where the face is, in sampled frames, and how sharp it is, in every frame.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/base/linalg.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/capture/capture.h"
#include "core/capture/sketch_film.h"
#include "core/face/landmarks.h"
#include "core/image/pixel_rect.h"
#include "core/video/decode_for.h"

namespace likeness {

struct FaceSample {
  int frame = 0;
  std::optional<FaceBox> face;  // of the main person, source px
  bool second_face = false;     // another of comparable size is in view
  // From the head to the camera, of length 1 in the head's frame, where it was asked for and could be told
  // (core/capture/head_views.h).
  std::optional<Vec3d> to_camera{};
};

// Of the samples: where fewer show a face, no avatar can be made of the clip.
inline constexpr double kLeastFaceShare = 0.1;

struct ClipScan {
  VideoInfo info;
  // Every frame read (core/video/decode.h: sampled): number, time and sharpness (0 before the first face).
  std::vector<CaptureFrame> frames;
  std::vector<float>
      change;  // of the face since the frame before, mean of a small picture of it, 8-bit units
  std::vector<float> difference;    // of the whole picture (repeated_frames.h)
  std::vector<FaceSample> samples;  // about five a second
  std::vector<FrameSketch> film;    // one a frame: what cuts are found by
  std::optional<Error> fault{};     // why the film ends early (VideoReader::fault())
};

// Called with every sampled picture (luma only) when its face has been sought; may be empty.
using FaceLookout = std::function<void(const VideoFrame&, const FaceSample&)>;

// film: what is looked at, source px; empty: the whole picture. The lookout sees that part, and faces in its
// pixels.
Result<ClipScan> scan_clip(const std::filesystem::path& video, const FaceDetector& detector,
                           const FaceLookout& look, const PixelRect& film, const Progress& progress,
                           std::stop_token stop);

// The same, fed by another's decoding. The detector must outlive it.
class ClipScanner {
 public:
  ClipScanner(const VideoInfo& info, const FaceDetector& detector, FaceLookout look,
              const Progress& progress);
  ~ClipScanner();

  FrameListener listener();  // of every frame, sampled
  // Once all have been seen. corner: of the frames' pictures in the source's.
  ClipScan take(const PixelRect& corner = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Variance of the Laplacian of the face's luma, the box reduced or enlarged to a fixed size so that a face
// further away is not called blurred. 8-bit units squared.
double face_sharpness(const Image8& picture, const FaceBox& face);

}  // namespace likeness
