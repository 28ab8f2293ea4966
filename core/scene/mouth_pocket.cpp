// Lips as two curves over x, jaw and skull as two half-spaces about the jaw's joint.
#include "core/scene/mouth_pocket.h"

#include <algorithm>
#include <cmath>

#include "core/scene/warp_math.h"

namespace likeness {
namespace {

constexpr float kMargin = 0.001f;     // m off a lip's inner edge
constexpr float kPocketAngle = 0.2f;  // rad, opening of the jaw in the pocket
constexpr float kUnderSeam = 0.002f;  // m, of the teeth's edges under the lips' seam
constexpr int kCurvePieces = 8;       // of the contour between two landmarks
constexpr int kFirstInner = 60, kFirstChin = 7;

Vec3f place(const MouthFrame::Mark& mark, std::span<const Vec3f> posed) {
  return mark.weights[0] * posed[std::size_t(mark.vertices[0])] +
         mark.weights[1] * posed[std::size_t(mark.vertices[1])] +
         mark.weights[2] * posed[std::size_t(mark.vertices[2])];
}

template <std::size_t N>
Vec3f mean_place(const std::array<MouthFrame::Mark, N>& marks, std::span<const Vec3f> posed) {
  Vec3f sum = Vec3f::Zero();
  for (const auto& mark : marks) sum += place(mark, posed);
  return sum / float(N);
}

// Catmull-Rom tangent, but in height no steeper than either neighbour allows: an open mouth is boxy, and the
// curve must not overshoot its landmarks into the lips.
Vec3f tangent(const Vec3f& before, const Vec3f& at, const Vec3f& after) {
  Vec3f t = 0.5f * (after - before);
  const float up = at.y() - before.y(), on = after.y() - at.y();
  t.y() = up * on > 0 ? 2 * up * on / (up + on) : 0.f;
  return t;
}

// From the right corner over the upper lip to the left, and back over the lower.
std::vector<Vec3f> lip_curve(const MouthFrame& frame, std::span<const Vec3f> posed) {
  std::array<Vec3f, 8> p;
  for (std::size_t i = 0; i < 8; ++i) p[i] = place(frame.lips[i], posed);
  std::vector<Vec3f> curve;
  for (std::size_t i = 0; i < 8; ++i) {
    const Vec3f &a = p[i], &b = p[(i + 1) % 8];
    // Corners are sharp: no tangent runs through them.
    const Vec3f from = i % 4 == 0 ? Vec3f(b - a) : tangent(p[(i + 7) % 8], a, b);
    const Vec3f to = i % 4 == 3 ? Vec3f(b - a) : tangent(a, b, p[(i + 2) % 8]);
    for (int k = 0; k < kCurvePieces; ++k) {
      const float t = float(k) / kCurvePieces, t2 = t * t, t3 = t2 * t;
      curve.push_back((2 * t3 - 3 * t2 + 1) * a + (t3 - 2 * t2 + t) * from + (3 * t2 - 2 * t3) * b +
                      (t3 - t2) * to);
    }
  }
  curve.push_back(curve.front());
  return curve;
}

LipEdges lip_edges(const MouthFrame& frame, std::span<const Vec3f> posed) {
  const std::vector<Vec3f> curve = lip_curve(frame, posed);
  LipEdges edges;
  edges.right = edges.left = curve.front().x();
  for (const Vec3f& p : curve)
    edges.right = std::min(edges.right, p.x()), edges.left = std::max(edges.left, p.x());
  constexpr std::size_t kHalf = 4 * kCurvePieces;
  const float step = std::max(1e-6f, (edges.left - edges.right) / (kLipColumns - 1));
  for (int side = 0; side < 2; ++side) {
    auto& y = side == 0 ? edges.upper_y : edges.lower_y;
    auto& z = side == 0 ? edges.upper_z : edges.lower_z;
    const std::size_t first = side == 0 ? 0 : kHalf;
    for (int column = 0; column < kLipColumns; ++column) {
      // The piece of this lip's curve at the column; the outermost end where a corner bulges past it.
      const float x = edges.right + step * float(column);
      float nearest = 1e9f;
      for (std::size_t k = first; k < first + kHalf; ++k) {
        const Vec3f &a = curve[k], &b = curve[k + 1];
        const float span = b.x() - a.x();
        const float t = std::abs(span) < 1e-9f ? 0.f : std::clamp((x - a.x()) / span, 0.f, 1.f);
        const Vec3f p = a + t * (b - a);
        const float off = std::abs(p.x() - x);
        if (off >= nearest) continue;
        nearest = off;
        y[std::size_t(column)] = p.y(), z[std::size_t(column)] = p.z();
      }
    }
  }
  return edges;
}

// Turn about x that takes a to b within the plane of symmetry.
float turn_between(const Vec3f& a, const Vec3f& b) {
  return std::atan2(a.y() * b.z() - a.z() * b.y(), a.y() * b.y() + a.z() * b.z());
}

Eigen::Matrix3f about_x(float angle) { return Eigen::AngleAxisf(angle, Vec3f::UnitX()).toRotationMatrix(); }

// Height of the middle between the rows' edges among the teeth with z in [from, to]; `none` without both
// rows.
float bite_height(std::span<const Vec3f> upper, std::span<const Vec3f> lower, float from, float to,
                  float none) {
  float above = 1e9f, below = -1e9f;
  for (const Vec3f& v : upper)
    if (v.z() >= from && v.z() <= to) above = std::min(above, v.y());
  for (const Vec3f& v : lower)
    if (v.z() >= from && v.z() <= to) below = std::max(below, v.y());
  return above > 1e8f || below < -1e8f ? none : 0.5f * (above + below);
}

// The plane from the model's teeth, front and back; without teeth, level and a little below the lips' seam.
void place_bite(const HeadModel& model, const HeadShape& shape, std::span<const Vec3f> rest,
                const Vec3f& seam, MouthFrame& frame) {
  Articulation open = neutral_articulation(model);
  open.jaw.x() = 0.1f;
  const std::vector<Vec3f> opened = pose_head(model, shape, open);
  const float moved = 0.5f * (mean_place(frame.chin, opened) - mean_place(frame.chin, shape.vertices)).norm();
  std::vector<Vec3f> upper, lower;
  float front = -1e9f, back = 1e9f;
  for (std::size_t v = 0; v < model.parts.size(); ++v) {
    if (model.parts[v] != HeadPart::teeth) continue;
    ((opened[v] - shape.vertices[v]).norm() > moved ? lower : upper).push_back(rest[v]);
    front = std::max(front, rest[v].z()), back = std::min(back, rest[v].z());
  }
  const float level = seam.y() - kUnderSeam, quarter = 0.25f * (front - back);
  const float ahead = bite_height(upper, lower, front - quarter, front, level);
  const float behind = bite_height(upper, lower, back, back + quarter, ahead);
  const float length = std::max(0.01f, 3 * quarter);
  const float slope = std::clamp((ahead - behind) / length, -0.3f, 0.3f);
  frame.bite = Vec3f(0, ahead, front > back ? front : seam.z());
  frame.up = Vec3f(0, 1, -slope).normalized();
}

}  // namespace

MouthFrame make_mouth_frame(const HeadModel& model, const HeadShape& shape, std::span<const Vec3f> rest) {
  MouthFrame frame;
  const auto mark = [&](int landmark) {
    return MouthFrame::Mark{model.triangles[std::size_t(model.landmark_triangle[std::size_t(landmark)])],
                            model.landmark_barycentric[std::size_t(landmark)]};
  };
  for (int i = 0; i < 8; ++i) frame.lips[std::size_t(i)] = mark(kFirstInner + i);
  for (int i = 0; i < 3; ++i) frame.chin[std::size_t(i)] = mark(kFirstChin + i);
  frame.chin_rest = mean_place(frame.chin, rest);
  frame.jaw = shape.joints[kJaw];
  const Vec3f seam = mean_place(frame.lips, rest);
  place_bite(model, shape, rest, seam, frame);
  const LipEdges edges = lip_edges(frame, rest);
  for (std::size_t i = 0; i < kLipColumns; ++i)
    frame.margin[i] = kMargin + 0.5f * std::max(0.f, edges.upper_y[i] - edges.lower_y[i]);
  // -- The pocket: its middle between the ears, above the brows.
  const Vec3f middle = frame.jaw + about_x(0.5f * kPocketAngle) *
                                       (seam - Vec3f(0, 0, 0.5f * (kGapDepth - kGapFront)) - frame.jaw);
  const Vec3f ears = 0.5f * (place(mark(0), rest) + place(mark(16), rest));
  const Vec3f brows = 0.5f * (place(mark(19), rest) + place(mark(24), rest));
  frame.pocket = Vec3f(0, brows.y() + 0.02f, ears.z()) - Vec3f(0, middle.y(), middle.z());
  return frame;
}

MouthGap make_mouth_gap(const MouthFrame& frame, std::span<const Vec3f> posed) {
  MouthGap gap;
  gap.edges = lip_edges(frame, posed);
  gap.margin = frame.margin;
  const LipEdges& e = gap.edges;
  float low_y = 1e9f, high_y = -1e9f, low_z = 1e9f, high_z = -1e9f;
  for (std::size_t i = 0; i < kLipColumns; ++i) {
    gap.open = std::max(gap.open, 0.5f * (e.upper_y[i] - e.lower_y[i]) - gap.margin[i]);
    low_y = std::min(low_y, e.lower_y[i]), high_y = std::max(high_y, e.upper_y[i]);
    low_z = std::min({low_z, e.lower_z[i], e.upper_z[i]}),
    high_z = std::max({high_z, e.lower_z[i], e.upper_z[i]});
  }
  if (!(gap.open > 0)) return gap;
  const float widened = std::min(kGapWidest, 2 * gap.open);
  gap.low = {e.right - widened, low_y - widened, low_z - kGapDepth};
  gap.high = {e.left + widened, high_y + widened, high_z + kGapFront};
  if (!gap.low.allFinite() || !gap.high.allFinite()) {  // a face that no head model makes
    gap.open = 0;
    return gap;
  }

  // -- How the jaw hangs now, and how in the pocket.
  const Vec3f chin = mean_place(frame.chin, posed);
  const float angle = turn_between(frame.chin_rest - frame.jaw, chin - frame.jaw);
  const Eigen::Matrix3f closes = about_x(-angle), opens = about_x(kPocketAngle);
  gap.jaw = frame.jaw;
  // A point on the jaw's row is on its plane once the jaw is closed again.
  const Vec3f at_rest = (frame.chin_rest - frame.jaw) - closes * (chin - frame.jaw);
  gap.upper_normal = frame.up, gap.upper_height = frame.up.dot(frame.bite - frame.jaw);
  gap.lower_normal = closes.transpose() * frame.up;
  gap.lower_height = gap.upper_height - frame.up.dot(at_rest);
  gap.turn = opens * closes;
  gap.shift = opens * at_rest;
  gap.pocket = frame.pocket;
  return gap;
}

bool in_gap(const MouthGap& gap, const Vec3f& point) {
  // Also false of a place that is no number.
  if (gap.open <= 0 || !(point.array() >= gap.low.array()).all() ||
      !(point.array() <= gap.high.array()).all())
    return false;
  const LipEdges& e = gap.edges;
  const float along = (point.x() - e.right) / std::max(1e-6f, e.left - e.right);
  const float beyond = std::max({0.f, e.right - point.x(), point.x() - e.left});
  const float at = std::clamp(along, 0.f, 1.f) * (kLipColumns - 1);
  const auto i = std::size_t(std::min(int(at), kLipColumns - 2));
  const float t = at - float(i);
  const auto look = [&](const std::array<float, kLipColumns>& row) {
    return row[i] + t * (row[i + 1] - row[i]);
  };
  const Vec3f upper(point.x(), look(e.upper_y), look(e.upper_z)),
      lower(point.x(), look(e.lower_y), look(e.lower_z));
  const float share = std::clamp((point.y() - lower.y()) / std::max(1e-6f, upper.y() - lower.y()), 0.f, 1.f);
  const float depth = lower.z() + share * (upper.z() - lower.z()) - point.z();
  if (depth < -kGapFront || depth > kGapDepth) return false;
  const float widens = std::min({kGapSlope * std::max(0.f, depth - kGapLip), kGapWidest, 2 * gap.open});
  // Lips are thick: their edges run into the mouth along the rows of teeth, the lower with the jaw.
  const float inside = std::min((upper - point).dot(gap.upper_normal), (point - lower).dot(gap.lower_normal));
  return inside - beyond - look(gap.margin) + widens > 0;
}

Vec3f way_to_pocket(const MouthGap& gap, const Vec3f& point) {
  const Vec3f arm = point - gap.jaw;
  const float below_upper = gap.upper_height - arm.dot(gap.upper_normal);
  const float above_lower = arm.dot(gap.lower_normal) - gap.lower_height;
  const float apart = std::max(kGapBite, below_upper + above_lower);
  const float skull = std::clamp(0.5f + 0.5f * (above_lower - below_upper) / apart, 0.f, 1.f);
  return gap.pocket + (1 - skull) * (gap.turn * arm + gap.shift - arm);
}

}  // namespace likeness
