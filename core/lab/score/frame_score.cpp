// Scoring pictures.
#include "core/lab/score/frame_score.h"

#include <cmath>

#include "core/image/metrics.h"

namespace likeness {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace

LandmarkErrors landmark_errors(const FaceDetector& detector, const Image8& truth, const Image8& rendered) {
  const int scale = truth.width < 512 ? 512 / truth.width : 1;  // the detector needs faces of 80 px or more
  const Image8 a = resize(truth, truth.width * scale, truth.height * scale);
  const Image8 b = resize(rendered, rendered.width * scale, rendered.height * scale);
  const auto faces = detector.detect(a);
  if (faces.empty()) return {};
  const Landmarks in_truth = detector.landmarks(a, faces.front()),
                  in_render = detector.landmarks(b, faces.front());
  const auto mean_distance = [&](int first, int last) {
    double sum = 0;
    for (int i = first; i <= last; ++i)
      sum += (in_truth.points[std::size_t(i)] - in_render.points[std::size_t(i)]).norm();
    return sum / (last + 1 - first) / scale;
  };
  return {mean_distance(17, 67), mean_distance(48, 67), mean_distance(36, 47)};
}

double mean_finite(std::span<const FrameScore> frames, double (*value)(const FrameScore&)) {
  double sum = 0;
  int count = 0;
  for (const FrameScore& frame : frames) {
    const double own = value(frame);
    if (!std::isfinite(own)) continue;
    sum += own;
    ++count;
  }
  return count > 0 ? sum / count : kNaN;
}

FrameScore score_picture(const Image& truth, const Image& rendered, const Regions& regions, int frame) {
  FrameScore score;
  score.frame = frame;
  score.mse = mse(truth, rendered);
  score.person_mse = mse(truth, rendered, regions.person);
  score.head_mse = mse(truth, rendered, regions.head);
  score.face_mse = mse(truth, rendered, regions.face);
  return score;
}

}  // namespace likeness
