// From which side the frames of a clip see the head, told by its landmarks: what Split::sides goes by.
#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/capture/capture.h"
#include "core/capture/scan_clip.h"
#include "core/face/landmarks.h"
#include "core/video/decode.h"

namespace likeness {

// Fed by a scan's lookout.
class HeadViewFinder {
 public:
  // info: of the pictures looked at. The detector must outlive it.
  HeadViewFinder(const VideoInfo& info, const FaceDetector& detector);
  ~HeadViewFinder();

  void look(const VideoFrame& frame, const FaceSample& sample);
  // Once all have been seen: fills in to_camera of the scan's samples.
  Result<void> put_into(std::vector<FaceSample>& samples, const Progress& progress, std::stop_token stop);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The views of the frames from those of the samples: straight lines between them, and none where the nearest
// that are known lie too far apart. Off their mean, the typical side. Samples of other frames do not count.
void fill_in_views(std::vector<CaptureFrame>& frames, const std::vector<FaceSample>& samples);

// How many frames the split has; inside: before some are refused.
struct SideCounts {
  int known = 0, inside = 0, apart = 0, beyond = 0;
  double widest_deg = 0;  // of the views that are known
};
SideCounts count_sides(const std::vector<CaptureFrame>& frames, const SideRange& sides);

// Whether there is enough to train on and to measure; the Error says what was found. where: of the Error.
Result<void> judge_sides(const std::vector<CaptureFrame>& frames, const SideRange& sides,
                         const std::string& where);

}  // namespace likeness
