#include "core/track/photo/face_look.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace likeness {
namespace {

constexpr int kSide = 24, kSamples = 3;         // values a side; samples a value and side
constexpr double kHalfWidth = 0.95;             // of the distance from eyes to mouth
constexpr double kAbove = 0.75, kBelow = 1.35;  // from the eyes, of the same distance
constexpr int kApart = 12;                      // frames; nearer ones agree whatever they show

Vec2d centre_of(const std::array<Vec2d, kLandmarkCount>& points, int from, int to) {
  Vec2d sum = Vec2d::Zero();
  for (int i = from; i < to; ++i) sum += points[i];
  return sum / (to - from);
}

double grey_at(const Image8& picture, const Vec2d& p) {
  const int x = std::clamp(static_cast<int>(std::floor(p.x())), 0, picture.width - 1),
            y = std::clamp(static_cast<int>(std::floor(p.y())), 0, picture.height - 1);
  const std::uint8_t* c = picture.at(x, y);
  return picture.channels >= 3 ? 0.30 * c[0] + 0.59 * c[1] + 0.11 * c[2] : c[0];
}

}  // namespace

FaceLook face_look(const Image8& picture, const std::array<Vec2d, kLandmarkCount>& points) {
  const Vec2d eyes = centre_of(points, 36, 48), mouth = centre_of(points, 48, 60), down = mouth - eyes;
  if (picture.empty() || down.norm() < 6) return {};
  const Vec2d across(down.y(), -down.x());
  FaceLook look;
  look.values.reserve(kSide * kSide);
  double sum = 0;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      double value = 0;
      for (int k = 0; k < kSamples * kSamples; ++k) {
        const double u = (x + (k % kSamples + 0.5) / kSamples) / kSide,
                     v = (y + (k / kSamples + 0.5) / kSamples) / kSide;
        value += grey_at(picture,
                         eyes + kHalfWidth * (2 * u - 1) * across + (v * (kAbove + kBelow) - kAbove) * down);
      }
      look.values.push_back(static_cast<float>(value));
      sum += value;
    }
  const float mean = static_cast<float>(sum / (kSide * kSide));
  double norm = 0;
  for (float& v : look.values) v -= mean, norm += static_cast<double>(v) * v;
  if (norm < 1e-6) return {};
  for (float& v : look.values) v /= static_cast<float>(std::sqrt(norm));
  return look;
}

double alike(const FaceLook& a, const FaceLook& b) {
  if (a.values.empty() || a.values.size() != b.values.size()) return 0;
  double sum = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) sum += static_cast<double>(a.values[i]) * b.values[i];
  return sum;
}

std::vector<double> agreement_of_looks(const std::vector<FaceLook>& looks,
                                       const std::vector<int>& references) {
  std::vector<double> agreement(looks.size(), 1.0);
  std::vector<double> found;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    if (looks[i].values.empty()) continue;
    found.clear();
    for (int r : references)
      if (std::abs(r - static_cast<int>(i)) > kApart && !looks[r].values.empty())
        found.push_back(alike(looks[i], looks[r]));
    if (found.size() < 4) continue;
    const std::size_t best = (found.size() + 3) / 4;
    std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(best), found.end(),
                      std::greater<>());
    double sum = 0;
    for (std::size_t k = 0; k < best; ++k) sum += found[k];
    agreement[i] = sum / static_cast<double>(best);
  }
  return agreement;
}

}  // namespace likeness
