// Frame choice: see choose_frames.h.
#include "core/capture/choose_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/quantile.h"

namespace likeness {
namespace {

constexpr double kFaceReach = 1.5;  // s; for a while HOG misses turned heads that a tracker follows
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

bool is_silent(const CaptureFrame& frame) { return frame.held_out || frame.apart; }

// Median sharpness of the training frames around `index`, itself included; frames without a known face do not
// count.
double neighbour_median(const std::vector<CaptureFrame>& frames, std::size_t index) {
  std::vector<double> around;
  const std::size_t begin = index - std::min<std::size_t>(index, kNeighbours);
  const std::size_t end = std::min(frames.size(), index + kNeighbours + 1);
  for (std::size_t i = begin; i < end; ++i) {
    if (frames[i].sharpness > 0 && !is_silent(frames[i])) around.push_back(frames[i].sharpness);
  }
  return median(std::move(around));
}

// A path length through the clip to which time and change contribute equally, both as shares of the whole:
// frames at rest are near-duplicates, but a long rest should still keep more than a blink. For training
// frames only: what held-out ones show decides nothing.
std::vector<double> way_through(const std::vector<CaptureFrame>& frames, const std::vector<float>& change) {
  double all = 0;
  std::vector<float> calm(change), trained;
  for (std::size_t i = 0; i < std::min(calm.size(), frames.size()); ++i) {
    if (is_silent(frames[i])) calm[i] = 0;
    if (!is_silent(frames[i])) trained.push_back(calm[i]);
  }
  // A cut, or a face found again, is not movement.
  const float most = trained.empty() ? 0 : 8 * std::max(0.1f, median(std::move(trained)));
  for (float& value : calm) all += value = std::min(value, most);
  std::vector<double> way;
  double moved = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i < calm.size()) moved += calm[i];
    const double time = double(i + 1) / double(frames.size());
    way.push_back(all > 0 ? 0.5 * (time + moved / all) : time);
  }
  return way;
}

// Cuts the path into `limit` equal slots and keeps the sharpest frame of each; slots that hold none leave
// their share to the others in another round.
void thin(const std::vector<CaptureFrame*>& kept, const std::vector<double>& way, int limit) {
  const std::size_t count = kept.size();
  if (count <= std::size_t(limit)) return;
  std::vector<char> stays(count, 0);
  for (int left = limit; left > 0;) {
    const double from = way.front(), length = std::max(1e-12, way.back() - from);
    std::vector<std::size_t> best(std::size_t(left), count);
    for (std::size_t i = 0; i < count; ++i) {
      if (stays[i]) continue;
      const auto slot = std::min(std::size_t(left) - 1, std::size_t((way[i] - from) / length * left));
      if (best[slot] == count || kept[i]->sharpness > kept[best[slot]]->sharpness) best[slot] = i;
    }
    for (const std::size_t i : best)
      if (i < count) stays[i] = 1, --left;
  }
  for (std::size_t i = 0; i < count; ++i)
    if (!stays[i]) kept[i]->refused = fmt::format("Left out to keep {} of {} good frames.", limit, count);
}

}  // namespace

void choose_training_frames(std::vector<CaptureFrame>& frames, const std::vector<FaceSample>& samples,
                            const std::vector<float>& change, const std::vector<char>& repeats,
                            const ImportOptions& options) {
  const std::vector<double> distance = face_distance(frames, samples);
  const std::vector<double> way = way_through(frames, change);
  std::vector<CaptureFrame*> kept;
  std::vector<double> kept_way;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    CaptureFrame& frame = frames[i];
    frame.used = false;
    if (frame.apart) continue;
    frame.refused.clear();
    if (frame.held_out) continue;
    const double median = neighbour_median(frames, i);
    if (i < repeats.size() && repeats[i]) {
      frame.refused = "Repeats the frame before it.";
    } else if (distance[i] > kFaceReach || frame.sharpness <= 0) {
      frame.refused = "No face was found near this frame.";
    } else if (frame.sharpness < options.blur_ratio * median) {
      frame.refused = fmt::format("Blurred: sharpness {:.0f}, its neighbours' median is {:.0f}.",
                                  frame.sharpness, median);
    } else {
      kept.push_back(&frame);
      kept_way.push_back(way[i]);
    }
  }
  thin(kept, kept_way, options.max_frames);
  for (CaptureFrame* frame : kept) frame->used = frame->refused.empty();
}

}  // namespace likeness
