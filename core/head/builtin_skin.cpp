// The skin of the built-in head: the chart's grid with two rectangles taken out and filled by closed loops
// that run round the eye (down to the lid margin, under the lid and round the back of the eyeball) and the
// mouth (over the rolled lips, through the seam and round the mouth's cavity).
#include <array>
#include <cmath>
#include <numbers>

#include "core/head/builtin_parts.h"
#include "core/head/builtin_sculpt.h"

namespace likeness::builtin {
namespace {

// -- Curves

// Catmull-Rom through (x[i], y[i]) at non-uniform x, flat beyond the ends' slopes.
template <std::size_t N>
double curve_at(const std::array<double, N>& x, const std::array<double, N>& y, double at) {
  std::size_t i = 0;
  while (i + 2 < N && at > x[i + 1]) ++i;
  const auto slope = [&](std::size_t k) {
    if (k == 0) return (y[1] - y[0]) / (x[1] - x[0]);
    if (k == N - 1) return (y[N - 1] - y[N - 2]) / (x[N - 1] - x[N - 2]);
    return (y[k + 1] - y[k - 1]) / (x[k + 1] - x[k - 1]);
  };
  const double h = x[i + 1] - x[i], t = std::clamp((at - x[i]) / h, 0.0, 1.0);
  const double t2 = t * t, t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * y[i] + (t3 - 2 * t2 + t) * h * slope(i) + (3 * t2 - 2 * t3) * y[i + 1] +
         (t3 - t2) * h * slope(i + 1);
}

const Vec2d kInnerCanthus(17.9, 33.2), kOuterCanthus(45.4, 35.0);  // front view, mm
constexpr double kMouthCornerY = -35.0, kBorderCornerX = 25.6, kSeamCornerX = 23.4;

// Rings from the grid's rectangle to the lid margin, as fractions of the way; behind it follow four more and
// a pole.
constexpr std::array<double, 8> kLidSteps{0.18, 0.35, 0.5, 0.63, 0.75, 0.86, 0.94, 1.0};
constexpr std::array<double, 8> kLidFold{0.2, 0.5, 0.8, 0.6, -0.5, -0.35, -0.1, 0};  // mm outwards
constexpr int kLidOuterRings = int(kLidSteps.size()), kLidInnerRings = 5;

// Rings from the rectangle to the vermilion border, then the rolled lip: share of the way from border to
// seam, and how far it stands out of the face at the upper and lower lip, mm.
constexpr std::array<double, 5> kMouthSteps{0.24, 0.47, 0.68, 0.85, 1.0};
struct LipRing {
  double share, upper_mm, lower_mm;
};
constexpr std::array<LipRing, 7> kLipRings{{{0.14, 1.1, 0.8},
                                            {0.33, 1.9, 1.9},
                                            {0.55, 2.2, 2.7},
                                            {0.76, 1.8, 2.5},
                                            {0.91, -0.3, 0.4},
                                            {0.98, -2.6, -2.2},
                                            {1.0, -5.0, -5.0}}};
// The cavity: half width and half height of the ring and its depth behind the seam's z (or, with absolute,
// its z).
struct CavityRing {
  double share, half_width, half_height, z;
  bool absolute;
};
constexpr std::array<CavityRing, 6> kCavityRings{{{0.12, 24, 2, -4.0, false},
                                                  {0.55, 26, 9, -6.0, false},
                                                  {1.0, 30, 16, -9.5, false},
                                                  {1.0, 34, 18, 76, true},
                                                  {1.0, 29, 16, 54, true},
                                                  {1.0, 15, 9, 38, true}}};

constexpr int kTorsoRows = 14;

struct Rectangle {
  int left, right, top, bottom;  // columns and rows, on the boundary
};

Rectangle rectangle_between(const Chart& chart, Vec2d low, Vec2d high) {
  const Vec2d middle = 0.5 * (low + high);
  const auto column = [&](double x) { return chart_of(chart, frontal_hit(x, middle.y())).x(); };
  const auto row = [&](double y) { return chart_of(chart, frontal_hit(middle.x(), y)).y(); };
  Rectangle r{int(std::lround(column(low.x()))), int(std::lround(column(high.x()))),
              int(std::lround(row(high.y()))), int(std::lround(row(low.y())))};
  if ((r.bottom - r.top) % 2 != 0) ++r.bottom;  // the corners sit in the middle of the rectangle's sides
  return r;
}

// Grid points of the boundary, clockwise seen from the front. Eye: closed, from the middle of the left side.
std::vector<Eigen::Vector2i> eye_boundary(const Rectangle& r) {
  std::vector<Eigen::Vector2i> points;
  const int middle = (r.top + r.bottom) / 2;
  for (int j = middle; j > r.top; --j) points.emplace_back(r.left, j);
  for (int i = r.left; i < r.right; ++i) points.emplace_back(i, r.top);
  for (int j = r.top; j < r.bottom; ++j) points.emplace_back(r.right, j);
  for (int i = r.right; i > r.left; --i) points.emplace_back(i, r.bottom);
  for (int j = r.bottom; j > middle; --j) points.emplace_back(r.left, j);
  return points;
}

// Mouth: open, from the midline above the lip round the corner to the midline below.
std::vector<Eigen::Vector2i> mouth_boundary(const Rectangle& r) {
  std::vector<Eigen::Vector2i> points;
  for (int i = 0; i < r.right; ++i) points.emplace_back(i, r.top);
  for (int j = r.top; j < r.bottom; ++j) points.emplace_back(r.right, j);
  for (int i = r.right; i >= 0; --i) points.emplace_back(i, r.bottom);
  return points;
}

// The disc on which the skin is laid out: the crown at its centre, the torso's edge on its rim, the face
// downwards and given most of the angle. No seam, so no vertex is doubled.
Vec2d skin_uv(const Chart& chart, const Vec2d& at) {
  const double angle = std::numbers::pi * at.x() / (chart.columns() - 1);
  const double radius = 0.49 * at.y() / (chart.rows() - 1 + kTorsoRows);
  return {0.5 + radius * std::sin(angle), 0.5 - radius * std::cos(angle)};
}

// -- Eye rings

// Behind the margin the lid turns in to the eyeball and lines it round to the optic nerve.
Vec3d lid_lining(const Vec3d& margin, int ring) {
  const Vec3d out = margin - kEyeCentre;
  const double distance = out.norm();
  const double angle = std::acos(std::clamp(out.z() / distance, -1.0, 1.0));  // from the gaze
  const double around = std::atan2(out.y(), out.x());
  constexpr std::array<double, 5> kTurn{0.0, 0.18, 0.45, 0.66,
                                        0.88};  // share of the way from the margin to the back
  constexpr std::array<double, 5> kGap{0.45, 0.55, 1.0, 1.2, 1.2};  // mm off the eyeball
  const double far = std::max(distance - 1.3 - 2.0 * ring, 0.0);    // corners lie off the eyeball
  const double radius = std::max(kEyeballRadius + kGap[ring], far);
  const double turned = mix(angle, 0.97 * std::numbers::pi, kTurn[ring]);
  return kEyeCentre + radius * Vec3d(std::sin(turned) * std::cos(around), std::sin(turned) * std::sin(around),
                                     std::cos(turned));
}

std::vector<std::vector<Vec3d>> eye_points(const Chart& chart, const std::vector<Vec2d>& boundary,
                                           const EyeOpening& opening) {
  const int n = int(boundary.size());
  std::vector<std::vector<Vec3d>> rings(kLidOuterRings + kLidInnerRings, std::vector<Vec3d>(n));
  for (int k = 0; k < n; ++k) {
    const bool upper = k <= n / 2;
    const double even = upper ? 2.0 * k / n : 2.0 * (n - k) / n;
    const double eased = 0.5 - 0.5 * std::cos(std::numbers::pi * even);
    const Vec2d margin = lid_margin(opening, mix(even, eased, 0.6), upper);
    const Vec2d inner = chart_of(chart, frontal_hit(margin.x(), margin.y()));
    // The upper lid's fold, which unrolls as the lid comes down.
    const double open = upper ? std::max(opening.upper, 0.0) / kEyeOpen.upper : 0;
    const Vec3d fold = Vec3d(0, -0.25, 1) * (open * std::pow(std::max(0.0, 4 * even * (1 - even)), 0.7));
    for (int r = 0; r < kLidOuterRings; ++r)
      rings[r][k] = skin_at(chart, boundary[k] + kLidSteps[r] * (inner - boundary[k])) + fold * kLidFold[r];
    for (int r = 0; r < kLidInnerRings; ++r)
      rings[kLidOuterRings + r][k] = lid_lining(rings[kLidOuterRings - 1][k], r);
  }
  return rings;
}

// -- Mouth rings

struct MouthPoint {
  Vec3d position;
  Vec2d chart;
  double lip;
};

std::vector<MouthPoint> mouth_spoke(const Chart& chart, const Vec2d& boundary, double along, bool upper) {
  std::vector<MouthPoint> spoke;
  const Vec2d border = lip_point(upper ? LipCurve::upper_border : LipCurve::lower_border, along);
  const Vec2d seam = lip_point(upper ? LipCurve::upper_seam : LipCurve::lower_seam, along);
  const Vec2d border_chart = chart_of(chart, frontal_hit(border.x(), border.y()));
  const double fullness = std::pow(std::max(0.0, 1 - along * along), 0.6);
  const auto on_midline = [&](Vec3d p) { return along == 0 ? Vec3d(0, p.y(), p.z()) : p; };
  for (double step : kMouthSteps) {
    const Vec2d at = boundary + step * (border_chart - boundary);
    // The lip begins to rise a little before its border.
    const double rise = 0.5 * fullness * smoothstep(0.6, 1.0, step);
    spoke.push_back({on_midline(skin_at(chart, at) + Vec3d(0, 0, rise)), at, step});
  }
  Vec3d last = Vec3d::Zero();
  for (const LipRing& ring : kLipRings) {
    const Vec2d xy = border + ring.share * (seam - border);
    Vec3d p = frontal_hit(xy.x(), xy.y());
    const double tuck = -2.0 * (1 - fullness) * ring.share;  // the corner is drawn in
    p.z() += fullness * (upper ? ring.upper_mm : ring.lower_mm) + tuck;
    last = p;
    spoke.push_back({on_midline(p), chart_of(chart, frontal_hit(xy.x(), xy.y())), 1 + ring.share});
  }
  const double angle = along * std::numbers::pi / 2, sign = upper ? 1 : -1;
  for (std::size_t r = 0; r < kCavityRings.size(); ++r) {
    const CavityRing& ring = kCavityRings[r];
    const Vec3d wide(ring.half_width * std::sin(angle),
                     kMouthCornerY + 1 + sign * ring.half_height * std::cos(angle),
                     ring.absolute ? ring.z : last.z() + ring.z);
    const Vec3d narrow(last.x(), last.y() + sign * 0.2, last.z() + ring.z);
    const Vec3d p = ring.absolute ? wide : Vec3d(narrow + ring.share * (wide - narrow));
    spoke.push_back({on_midline(p), spoke.back().chart, 2 + (r + 1.0) / (kCavityRings.size() + 1)});
  }
  return spoke;
}

// -- Assembly

struct Grid {
  int columns, rows;
  std::vector<int> index;  // (rows, columns) vertex, -1 inside the rectangles
  int& at(int i, int j) { return index[std::size_t(j) * columns + i]; }
  int at(int i, int j) const { return index[std::size_t(j) * columns + i]; }
};

// Quads between successive rings, and a fan from the last ring to `pole`.
void join_rings(HalfMesh& mesh, const std::vector<std::vector<int>>& rings, const HalfVertex& pole,
                bool closed) {
  const int n = int(rings[0].size()), spans = closed ? n : n - 1;
  for (std::size_t r = 0; r + 1 < rings.size(); ++r)
    for (int k = 0; k < spans; ++k)
      add_quad(mesh, rings[r][k], rings[r + 1][k], rings[r + 1][(k + 1) % n], rings[r][(k + 1) % n]);
  const int pole_index = int(mesh.vertices.size());
  mesh.vertices.push_back(pole);
  for (int k = 0; k < spans; ++k)
    mesh.triangles.emplace_back(rings.back()[k], pole_index, rings.back()[(k + 1) % n]);
}

Grid add_grid(Skin& skin, const Rectangle& eye, const Rectangle& lips) {
  const Chart& chart = skin.chart;
  HalfMesh& mesh = skin.mesh;
  const auto inside = [](const Rectangle& r, int i, int j, bool to_midline) {
    return j > r.top && j < r.bottom && i < r.right && (to_midline || i > r.left);
  };
  const int columns = chart.columns(), neck_rows = chart.rows(), rows = neck_rows + kTorsoRows;
  Grid grid{columns, rows, std::vector<int>(std::size_t(columns) * rows, -1)};
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      if (inside(eye, i, j, false) || inside(lips, i, j, true)) continue;
      if (j == 0 && i > 0) {
        grid.at(i, j) = grid.at(0, 0);  // the crown is one vertex
        continue;
      }
      HalfVertex v;
      if (j < neck_rows) {
        v.position = skin_at(chart, Vec2d(i, j));
      } else {
        const Vec3d neck = mesh.vertices[grid.at(i, neck_rows - 1)].position;
        const Vec3d slope = neck - mesh.vertices[grid.at(i, neck_rows - 2)].position;
        v.position = torso_at(neck, slope, chart.azimuth[i], double(j - neck_rows + 1) / kTorsoRows);
      }
      v.midline = i == 0 || i == columns - 1 || j == 0;
      if (v.midline) v.position.x() = 0;
      const bool face = v.position.y() < 95 && chart.azimuth[i] < 1.35 && v.position.y() > -84;
      v.part = j >= neck_rows ? HeadPart::torso : face ? HeadPart::face : HeadPart::scalp_neck;
      v.uv = skin_uv(chart, Vec2d(i, j));
      grid.at(i, j) = int(mesh.vertices.size());
      mesh.vertices.push_back(v);
    }
  }
  for (int j = 0; j + 1 < rows; ++j) {
    for (int i = 0; i + 1 < columns; ++i) {
      const auto cell_in = [&](const Rectangle& r, bool to_midline) {
        return j >= r.top && j < r.bottom && i < r.right && (to_midline || i >= r.left);
      };
      if (cell_in(eye, false) || cell_in(lips, true)) continue;
      add_quad(mesh, grid.at(i, j), grid.at(i, j + 1), grid.at(i + 1, j + 1), grid.at(i + 1, j));
    }
  }
  return grid;
}

void add_eye(Skin& skin, const Grid& grid, const Rectangle& eye) {
  const Chart& chart = skin.chart;
  HalfMesh& mesh = skin.mesh;
  const auto boundary = eye_boundary(eye);
  const int n = int(boundary.size());
  std::vector<Vec2d> boundary_chart;
  skin.eye_rings.emplace_back();
  for (const auto& b : boundary) {
    boundary_chart.emplace_back(b.cast<double>());
    skin.eye_rings[0].push_back(grid.at(b.x(), b.y()));
  }
  const auto eye_rings = eye_points(chart, boundary_chart, kEyeOpen);
  for (std::size_t r = 0; r < eye_rings.size(); ++r) {
    skin.eye_rings.emplace_back();
    const bool lining = int(r) >= kLidOuterRings;
    for (int k = 0; k < n; ++k) {
      HalfVertex v;
      v.position = eye_rings[r][k];
      v.part = lining && int(r) > kLidOuterRings ? HeadPart::left_eye_socket : HeadPart::face;
      v.tissue = lining ? Tissue::lid_inner : Tissue::skin;
      v.lid = lining ? 1 : kLidSteps[r];
      const double deeper = lining ? 1 + 0.06 * (r - kLidOuterRings + 1) : kLidSteps[r];
      const Vec2d centre = chart_of(chart, frontal_hit(31.4, 35));
      const Vec2d margin = chart_of(chart, eye_rings[kLidOuterRings - 1][k]);
      v.uv = skin_uv(chart, lining ? Vec2d(margin + 1.5 * (deeper - 1) * (centre - margin))
                                   : Vec2d(boundary_chart[k] + kLidSteps[r] * (margin - boundary_chart[k])));
      skin.eye_rings.back().push_back(int(mesh.vertices.size()));
      mesh.vertices.push_back(v);
    }
  }
  HalfVertex nerve = mesh.vertices[skin.eye_rings.back()[0]];
  nerve.position = kEyeCentre - Vec3d(0, 0, kEyeballRadius + 1.2);
  join_rings(mesh, skin.eye_rings, nerve, true);
}

void add_mouth(Skin& skin, const Grid& grid, const Rectangle& lips) {
  const Chart& chart = skin.chart;
  HalfMesh& mesh = skin.mesh;
  const auto mouth = mouth_boundary(lips);
  const int last = int(mouth.size()) - 1;
  skin.mouth_rings.assign(1 + kMouthSteps.size() + kLipRings.size() + kCavityRings.size(), {});
  for (int k = 0; k <= last; ++k) {
    const bool upper = 2 * k <= last;
    const double along = upper ? 2.0 * k / last : 2.0 * (last - k) / last;
    skin.mouth_rings[0].push_back(grid.at(mouth[k].x(), mouth[k].y()));
    const auto spoke = mouth_spoke(chart, mouth[k].cast<double>(), along, upper);
    for (std::size_t r = 0; r < spoke.size(); ++r) {
      HalfVertex v;
      v.position = spoke[r].position;
      v.lip = spoke[r].lip;
      v.mouth_side = upper ? 1 : -1;
      v.along_lip = along;
      v.midline = k == 0 || k == last;
      const bool cavity = r >= kMouthSteps.size() + kLipRings.size();
      v.part = cavity ? HeadPart::mouth_socket : HeadPart::face;
      v.tissue = cavity ? Tissue::lip_inner : Tissue::skin;
      v.uv = skin_uv(chart, spoke[r].chart);
      skin.mouth_rings[r + 1].push_back(int(mesh.vertices.size()));
      mesh.vertices.push_back(v);
    }
  }
  HalfVertex throat = mesh.vertices[skin.mouth_rings.back()[last / 2]];
  throat.position = Vec3d(0, kMouthCornerY + 1, 30);
  throat.midline = true;
  throat.lip = 3;
  join_rings(mesh, skin.mouth_rings, throat, false);
}

}  // namespace

Vec2d lid_margin(const EyeOpening& opening, double along, bool upper) {
  const Vec2d inner = kInnerCanthus + opening.inner, outer = kOuterCanthus + opening.outer;
  const Vec2d line = inner + along * (outer - inner);
  const double round = std::pow(std::max(0.0, 4 * along * (1 - along)), 0.72);
  const double height = upper ? opening.upper : -opening.lower;
  // Highest towards the nose, lowest towards the temple; a closed upper lid lies along the lower one.
  const double skew =
      height > 0 ? 1 + (opening.lean - 0.22) * (along - 0.5) : 1 + (opening.lean + 0.25) * (along - 0.5);
  return line + Vec2d(0, height * round * skew);
}

Vec2d lip_point(LipCurve curve, double along) {
  constexpr std::array<double, 7> kAt{0, 0.15, 0.3, 0.5, 0.7, 0.87, 1};
  constexpr std::array<double, 7> kUpper{9.7, 10.3, 10.6, 9.3, 6.9, 3.7, 0};
  constexpr std::array<double, 7> kLower{-9.2, -9.1, -8.8, -7.8, -5.9, -3.2, 0};
  constexpr std::array<double, 7> kSeam{1.0, 1.3, 1.6, 1.5, 1.0, 0.4, 0};
  const double reach = std::sin(0.5 * std::numbers::pi * along) * 0.35 + along * 0.65;
  const bool seam = curve == LipCurve::upper_seam || curve == LipCurve::lower_seam;
  const double gap = curve == LipCurve::upper_seam ? 0.04 : curve == LipCurve::lower_seam ? -0.04 : 0;
  const auto& table = seam ? kSeam : curve == LipCurve::upper_border ? kUpper : kLower;
  return {(seam ? kSeamCornerX : kBorderCornerX) * reach,
          kMouthCornerY + curve_at(kAt, table, reach) + gap * (1 - along)};
}

std::vector<std::vector<Vec3d>> eye_ring_positions(const Skin& skin, const EyeOpening& opening) {
  std::vector<Vec2d> boundary;
  std::vector<Vec3d> outer;
  for (int v : skin.eye_rings[0]) {
    outer.push_back(skin.mesh.vertices[v].position);
    boundary.push_back(chart_of(skin.chart, outer.back()));
  }
  auto rings = eye_points(skin.chart, boundary, opening);
  rings.insert(rings.begin(), outer);
  return rings;
}

Skin make_skin() {
  Skin skin;
  skin.chart = make_chart();
  const Rectangle eye = rectangle_between(skin.chart, {10.5, 21}, {54, 49});
  const Rectangle lips = rectangle_between(skin.chart, {0, -50.5}, {35, -19.5});
  const Grid grid = add_grid(skin, eye, lips);
  add_eye(skin, grid, eye);
  add_mouth(skin, grid, lips);
  return skin;
}

void add_quad(HalfMesh& mesh, int a, int b, int c, int d) {
  if (a != b && b != c && c != a) mesh.triangles.emplace_back(a, b, c);
  if (a != c && c != d && d != a) mesh.triangles.emplace_back(a, c, d);
}

void append(HalfMesh& mesh, const HalfMesh& piece) {
  const int base = int(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), piece.vertices.begin(), piece.vertices.end());
  for (const Triangle& t : piece.triangles) mesh.triangles.push_back(t + Triangle::Constant(base));
}

}  // namespace likeness::builtin
