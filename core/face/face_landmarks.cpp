// See face_landmarks.h.
#include "core/face/face_landmarks.h"

#include <algorithm>

namespace likeness {
namespace {

constexpr int kFirstInner = 17;  // landmarks before it are the jaw line

}  // namespace

double overlap(const FaceBox& a, const FaceBox& b) {
  const double w = std::min(a.x + a.width, b.x + b.width) - std::max(a.x, b.x);
  const double h = std::min(a.y + a.height, b.y + b.height) - std::max(a.y, b.y);
  if (w <= 0 || h <= 0) return 0;
  return w * h / (a.width * a.height + b.width * b.height - w * h);
}

double inner_spread(const Landmarks& landmarks) {
  double sum = 0;
  for (int i = kFirstInner; i < kLandmarkCount; ++i) sum += landmarks.spread[i];
  return sum / (kLandmarkCount - kFirstInner);
}

}  // namespace likeness
