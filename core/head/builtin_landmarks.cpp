// Places the landmarks on the built-in head's own curves (lids, lips, jaw) and embeds them in its triangles.
#include "core/head/builtin_landmarks.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "core/head/builtin_sculpt.h"
#include "core/head/nearest_barycentric.h"

namespace likeness::builtin {
namespace {

// The skin at a height and an azimuth about the vertical axis through the middle of the head.
Vec3d skin_around(double azimuth_deg, double y) {
  const double a = azimuth_deg * std::numbers::pi / 180;
  return outermost_hit({0, y, 10}, {std::sin(a), 0, std::cos(a)}, 150);
}

Vec3d on_ring(const WholeHead& head, const std::vector<int>& ring, double at) {
  const int n = int(ring.size()), k = int(at);
  const Vec3d a = head.vertices[ring[k % n]].position, b = head.vertices[ring[(k + 1) % n]].position;
  return a + (at - k) * (b - a);
}

Vec3d flipped(const Vec3d& p) { return {-p.x(), p.y(), p.z()}; }

// The vertex ring index of the lip's border (the last ring before lip > 1) and of the seam's front.
std::size_t ring_where(const WholeHead& head, double lip) {
  for (std::size_t r = 1; r < head.skin.mouth_rings.size(); ++r)
    if (head.vertices[head.skin.mouth_rings[r][0]].lip >= lip - 1e-9) return r;
  return head.skin.mouth_rings.size() - 1;
}

}  // namespace

std::array<Vec3d, kLandmarkCount> landmark_targets(const WholeHead& head) {
  std::array<Vec3d, kLandmarkCount> at{};
  // Subject's left points, with the number of their mirror image.
  const auto pair = [&](int left, int right, const Vec3d& p) { at[left] = p, at[right] = flipped(p); };

  // -- Jaw line: (azimuth, height) from the chin to the ear
  constexpr std::array<Vec2d::Scalar, 9> kAzimuth{0, 11, 24.5, 37.5, 49.5, 57.5, 63, 67.5, 70.5};
  constexpr std::array<Vec2d::Scalar, 9> kHeight{-76, -74, -69, -59.5, -43.5, -24, -5, 15, 36};
  for (int i = 0; i <= 8; ++i) pair(8 + i, 8 - i, skin_around(kAzimuth[i], kHeight[i]));

  // -- Brows, nose
  constexpr double kBrow[5][2] = {{11.5, 58}, {23.5, 61.5}, {37, 62}, {48.5, 59}, {57.5, 52}};
  for (int i = 0; i < 5; ++i) pair(22 + i, 21 - i, frontal_hit(kBrow[i][0], kBrow[i][1]));
  constexpr double kRidge[4] = {37.4, 26.5, 15.5, 4};
  for (int i = 0; i < 4; ++i) at[27 + i] = frontal_hit(0, kRidge[i]);
  at[33] = frontal_hit(0, -12);
  pair(34, 32, frontal_hit(6.2, -12.8));
  pair(35, 31, frontal_hit(13.2, -10.2));

  // -- Lid margins; the ring runs from the inner corner over the upper lid
  const auto margin = [&](double along, bool upper) {
    const Vec2d q = lid_margin(kEyeOpen, along, upper);
    return frontal_hit(q.x(), q.y());
  };
  pair(42, 39, margin(0, true));
  pair(43, 38, margin(0.34, true));
  pair(44, 37, margin(0.70, true));
  pair(45, 36, margin(1, true));
  pair(46, 41, margin(0.70, false));
  pair(47, 40, margin(0.34, false));

  // -- Lips: the ring runs from the midline above, round the left corner, to the midline below
  const auto lip = [&](double along, bool upper, double ring_lip) {
    const auto& ring = head.skin.mouth_rings[ring_where(head, ring_lip)];
    const double half = 0.5 * (ring.size() - 1);
    return on_ring(head, ring, upper ? along * half : (2 - along) * half);
  };
  at[51] = lip(0, true, 1);
  at[57] = lip(0, false, 1);
  at[62] = lip(0, true, 1.98);
  at[66] = lip(0, false, 1.98);
  pair(52, 50, lip(0.25, true, 1));
  pair(53, 49, lip(0.58, true, 1));
  pair(54, 48, lip(1, true, 1));
  pair(55, 59, lip(0.62, false, 1));
  pair(56, 58, lip(0.33, false, 1));
  pair(63, 61, lip(0.36, true, 1.98));
  pair(64, 60, lip(1, true, 1.98));
  pair(65, 67, lip(0.36, false, 1.98));
  return at;
}

void embed_landmarks(const WholeHead& head, HeadModel& model) {
  const auto targets = landmark_targets(head);
  for (int l = 0; l < kLandmarkCount; ++l) {
    double best = std::numeric_limits<double>::infinity();
    // Lip landmarks stay on their own lip.
    const int side = l < 48 || l == 48 || l == 54 || l == 60 || l == 64 ? 0
                     : (l <= 53 || (l >= 61 && l <= 63))                ? 1
                                                                        : -1;
    for (int f = 0; f < int(head.triangles.size()); ++f) {
      const Triangle& t = head.triangles[f];
      const HalfVertex &a = head.vertices[t[0]], &b = head.vertices[t[1]], &c = head.vertices[t[2]];
      if (a.tissue != Tissue::skin || b.tissue != Tissue::skin || c.tissue != Tissue::skin) continue;
      if (side != 0 && (a.mouth_side != side || b.mouth_side != side || c.mouth_side != side)) continue;
      if ((a.position - targets[l]).squaredNorm() > 400) continue;
      const Vec3d w = nearest_barycentric(targets[l], a.position, b.position, c.position);
      const double d =
          (w.x() * a.position + w.y() * b.position + w.z() * c.position - targets[l]).squaredNorm();
      if (d < best) {
        best = d;
        model.landmark_triangle[l] = f;
        model.landmark_barycentric[l] = w.cast<float>();
      }
    }
  }
}

}  // namespace likeness::builtin
