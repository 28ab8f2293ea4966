// Frame choice: see choose_frames.h.
#include "core/capture/choose_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/quantile.h"

namespace likeness {
namespace {

constexpr double kFaceReach = 1.5;  // s; HOG misses turned heads for a while that a tracker follows
constexpr int kNeighbours = 12;     // frames to either side

// Gap between each frame and the nearest sample with a face, in seconds.
std::vector<double> face_distance(const std::vector<CaptureFrame>& frames,
                                  const std::vector<FaceSample>& samples) {
  std::vector<double> times;
  for (const FaceSample& sample : samples) {
    if (!sample.face) continue;
    const auto at = std::ranges::lower_bound(frames, sample.frame, {}, &CaptureFrame::frame);
    if (at != frames.end()) times.push_back(at->time_s);
  }
  std::vector<double> distance;
  for (const CaptureFrame& frame : frames) {
    const auto after = std::lower_bound(times.begin(), times.end(), frame.time_s);
    double nearest = std::numeric_limits<double>::infinity();
    if (after != times.end()) nearest = *after - frame.time_s;
    if (after != times.begin()) nearest = std::min(nearest, frame.time_s - *(after - 1));
    distance.push_back(nearest);
  }
  return distance;
}

// Median sharpness of the frames around `index`, itself included; frames without a known face do not count.
double neighbour_median(const std::vector<CaptureFrame>& frames, std::size_t index) {
  std::vector<double> around;
  const std::size_t begin = index - std::min<std::size_t>(index, kNeighbours);
  const std::size_t end = std::min(frames.size(), index + kNeighbours + 1);
  for (std::size_t i = begin; i < end; ++i) {
    if (frames[i].sharpness > 0) around.push_back(frames[i].sharpness);
  }
  return median(std::move(around));
}

void thin_evenly(std::vector<CaptureFrame*> kept, int limit) {
  const std::size_t count = kept.size();
  if (count <= std::size_t(limit)) return;
  for (std::size_t i = 0; i < count; ++i) {
    // Frame i stays when the running quota limit * i / count reaches a new whole number there.
    if ((i + 1) * limit / count > i * limit / count) continue;
    kept[i]->refused = fmt::format("Left out to keep {} of {} good frames.", limit, count);
  }
}

}  // namespace

void hold_out_tail(std::vector<CaptureFrame>& frames, double share) {
  std::size_t count = std::min(frames.size(), std::size_t(std::lround(share * double(frames.size()))));
  if (count == 0 && share > 0 && !frames.empty()) count = 1;
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].held_out = i + count >= frames.size();
}

void choose_training_frames(std::vector<CaptureFrame>& frames, const std::vector<FaceSample>& samples,
                            const ImportOptions& options) {
  const std::vector<double> distance = face_distance(frames, samples);
  std::vector<CaptureFrame*> kept;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    CaptureFrame& frame = frames[i];
    frame.used = false;
    frame.refused.clear();
    if (frame.held_out) continue;
    const double median = neighbour_median(frames, i);
    if (distance[i] > kFaceReach || frame.sharpness <= 0) {
      frame.refused = "No face was found near this frame.";
    } else if (frame.sharpness < options.blur_ratio * median) {
      frame.refused = fmt::format("Blurred: sharpness {:.0f}, its neighbours' median is {:.0f}.",
                                  frame.sharpness, median);
    } else {
      kept.push_back(&frame);
    }
  }
  thin_evenly(kept, options.max_frames);
  for (CaptureFrame* frame : kept) frame->used = frame->refused.empty();
}

}  // namespace likeness
