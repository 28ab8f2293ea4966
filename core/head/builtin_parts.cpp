// The separate pieces of the built-in head: eyeball, ear, teeth with gums, tongue. Millimetres, left half.
#include "core/head/builtin_parts.h"

#include <array>
#include <cmath>
#include <numbers>

#include "core/head/builtin_sculpt.h"

namespace likeness::builtin {
namespace {

// A patch of the uv square: the corners outside the skin's disc hold the pieces.
Vec2d uv_in(Vec2d corner, double size, double u, double v) { return corner + size * Vec2d(u, v); }

// A sheet of rows x columns vertices with its quads; `wrap` joins the last column to the first.
HalfMesh make_sheet(const std::vector<std::vector<HalfVertex>>& rows, bool wrap) {
  HalfMesh mesh;
  const int columns = int(rows.front().size());
  for (const auto& row : rows) mesh.vertices.insert(mesh.vertices.end(), row.begin(), row.end());
  for (int j = 0; j + 1 < int(rows.size()); ++j) {
    for (int i = 0; i + (wrap ? 0 : 1) < columns; ++i) {
      const int next = (i + 1) % columns;
      add_quad(mesh, j * columns + i, (j + 1) * columns + i, (j + 1) * columns + next, j * columns + next);
    }
  }
  return mesh;
}

// Closes the first or last row of a wrapped sheet with one vertex.
void close_row(HalfMesh& mesh, int row_start, int columns, const HalfVertex& pole, bool last) {
  const int index = int(mesh.vertices.size());
  mesh.vertices.push_back(pole);
  for (int i = 0; i < columns; ++i) {
    const int a = row_start + i, b = row_start + (i + 1) % columns;
    mesh.triangles.push_back(last ? Triangle(a, index, b) : Triangle(a, b, index));
  }
}

}  // namespace

HalfMesh make_eyeball() {
  constexpr int kRings = 16, kAround = 24;
  HalfVertex v;
  v.part = HeadPart::left_eyeball;
  v.tissue = Tissue::eyeball;
  const auto place = [&](double turn, double around) {
    const Vec3d direction(std::sin(turn) * std::cos(around), std::sin(turn) * std::sin(around),
                          std::cos(turn));
    v.position = kEyeCentre + kEyeballRadius * direction;
    const double r = 0.5 * turn / std::numbers::pi;
    v.uv = uv_in({0.86, 0.86}, 0.13, 0.5 + r * std::cos(around), 0.5 + r * std::sin(around));
    return v;
  };
  // Rows from the pupil to the optic nerve, closer together at the iris.
  std::vector<std::vector<HalfVertex>> rows;
  for (int j = 1; j < kRings; ++j) {
    const double t = double(j) / kRings, turn = std::numbers::pi * mix(t, t * t, 0.5);
    rows.emplace_back();
    for (int i = 0; i < kAround; ++i) rows.back().push_back(place(turn, 2 * std::numbers::pi * i / kAround));
  }
  HalfMesh mesh = make_sheet(rows, true);
  close_row(mesh, 0, kAround, place(0, 0), false);
  close_row(mesh, (kRings - 2) * kAround, kAround, place(std::numbers::pi, 0), true);
  return mesh;
}

Vec3d torso_at(const Vec3d& neck, const Vec3d& slope, double azimuth, double t) {
  // Rings of the bust: half width, front and back extent, and heights at the front, the side and the back,
  // mm.
  struct Ring {
    double width, front, back, y_front, y_side, y_back;
  };
  constexpr std::array<Ring, 5> kRings{{{66, 37, -84, -152, -142, -134},
                                        {112, 49, -98, -171, -160, -154},
                                        {178, 75, -108, -198, -188, -188},
                                        {206, 94, -112, -254, -250, -252},
                                        {192, 98, -106, -335, -335, -335}}};
  const double s = std::sin(azimuth), c = std::cos(azimuth), side = s * s;
  const auto place = [&](const Ring& ring) {
    const double power = 0.82;  // a little squarer than an ellipse
    const double middle = 0.5 * (ring.front + ring.back), deep = 0.5 * (ring.front - ring.back);
    const double end = c > 0 ? ring.y_front : ring.y_back;
    return Vec3d(ring.width * std::pow(std::abs(s), power), mix(end, ring.y_side, side),
                 middle + deep * std::copysign(std::pow(std::abs(c), power), c));
  };
  // A cubic through the knots, with chord length as its parameter and the neck's direction at its start.
  std::array<Vec3d, 6> knots{neck};
  std::array<double, 6> along{0};
  for (int i = 0; i < 5; ++i) {
    knots[i + 1] = place(kRings[i]);
    along[i + 1] = along[i] + (knots[i + 1] - knots[i]).norm();
  }
  const auto tangent = [&](int i) -> Vec3d {
    if (i == 0) return slope.normalized();
    if (i == 5) return (knots[5] - knots[4]) / (along[5] - along[4]);
    return (knots[i + 1] - knots[i - 1]) / (along[i + 1] - along[i - 1]);
  };
  const double at = t * along[5];
  int i = 0;
  while (i < 4 && at > along[i + 1]) ++i;
  const double h = along[i + 1] - along[i], u = std::clamp((at - along[i]) / h, 0.0, 1.0), u2 = u * u,
               u3 = u2 * u;
  return (2 * u3 - 3 * u2 + 1) * knots[i] + (u3 - 2 * u2 + u) * h * tangent(i) +
         (3 * u2 - 2 * u3) * knots[i + 1] + (u3 - u2) * h * tangent(i + 1);
}

HalfMesh make_ear() {
  // The ear's own plane: up leans back, out goes backwards and away from the head.
  const Vec3d root(70.8, 13, 13);
  const Vec3d up = Vec3d(0.10, 0.97, -0.22).normalized();
  const Vec3d back = (Vec3d(0.50, 0, -0.87) - Vec3d(0.50, 0, -0.87).dot(up) * up).normalized();
  const Vec3d face = up.cross(back).normalized() * -1.0;  // the side the concha opens to
  // Outline as polar radius (mm) from the concha's middle, counter-clockwise from straight back.
  constexpr std::array<double, 16> kOutline{17.5, 19.5, 23.5, 29.5, 32.5, 28.5, 19.5, 14.5,
                                            12.5, 13,   16,   24,   29.5, 25,   19,   17};
  const Vec2d middle(13, 1);
  struct Ring {
    double share, height;  // of the outline's radius; mm along `face`
  };
  constexpr std::array<Ring, 15> kRings{{{0.16, -5.2},
                                         {0.32, -5},
                                         {0.46, -3.4},
                                         {0.57, -0.3},
                                         {0.66, 1.2},
                                         {0.75, 0.4},
                                         {0.83, -0.2},
                                         {0.89, 1.4},
                                         {0.95, 2.8},
                                         {1.0, 2.0},
                                         {0.995, 0.0},
                                         {0.93, -2.0},
                                         {0.78, -3.4},
                                         {0.62, -6.5},
                                         {0.5, -11}}};
  constexpr int kAround = 40;
  HalfVertex v;
  v.part = HeadPart::scalp_neck;
  v.tissue = Tissue::ear;
  std::vector<std::vector<HalfVertex>> rows;
  for (const Ring& ring : kRings) {
    rows.emplace_back();
    for (int i = 0; i < kAround; ++i) {
      const double angle = 2 * std::numbers::pi * i / kAround, at = angle / (2 * std::numbers::pi) * 16;
      const int a = int(at) % 16;
      const double t = at - int(at), t2 = t * t, t3 = t2 * t;
      const double p0 = kOutline[(a + 15) % 16], p1 = kOutline[a], p2 = kOutline[(a + 1) % 16],
                   p3 = kOutline[(a + 2) % 16];
      const double radius = 0.5 * (2 * p1 + (p2 - p0) * t + (2 * p0 - 5 * p1 + 4 * p2 - p3) * t2 +
                                   (3 * p1 - p0 - 3 * p2 + p3) * t3);
      const Vec2d q = middle + ring.share * radius * Vec2d(std::cos(angle), std::sin(angle));
      // The rim's relief fades towards the lobe; the front edge sinks into the head.
      const double lobe = smoothstep(-8, -20, q.y()), front = smoothstep(7, -1, q.x());
      double height = ring.height * (1 - 0.75 * lobe * (ring.height > -3 ? 1 : 0.8));
      height = mix(height, ring.height > 0 ? 0.2 : height - 1.5, front);
      height += 3.0 * std::exp(-(q - Vec2d(2.5, -2)).squaredNorm() / 18) * (rows.size() <= 10);  // tragus
      v.position = root + q.x() * back + q.y() * up + height * face;
      if (rows.size() <= 10) {  // the front of the ear lies on the head where it would dip into it
        const double clear = sculpt_distance(v.position),
                     wanted = 0.5 * (clear + 0.9 + std::hypot(clear - 0.9, 1.5));
        v.position += (wanted - clear) * Vec3d(0.95, 0, 0.3);
      }
      v.uv = uv_in({0.86, 0.01}, 0.13, 0.5 + q.x() / 70 - 0.2, 0.5 + q.y() / 70);
      rows.back().push_back(v);
    }
  }
  HalfMesh mesh = make_sheet(rows, true);
  v.position = root + middle.x() * back + middle.y() * up - 5 * face;
  close_row(mesh, 0, kAround, v, false);
  v.position = root + middle.x() * back + middle.y() * up - 14 * face;
  close_row(mesh, (int(kRings.size()) - 1) * kAround, kAround, v, true);
  return mesh;
}

HalfMesh make_teeth(bool upper) {
  // One half of the arch, from the midline: crown widths, mm. Lower front teeth are narrower.
  constexpr std::array<double, 7> kUpper{8.4, 6.6, 7.4, 6.8, 6.6, 9.6, 9.0};
  constexpr std::array<double, 7> kLower{5.4, 5.8, 6.6, 6.9, 7.0, 10.2, 9.6};
  constexpr int kPerTooth = 4;
  const auto& widths = upper ? kUpper : kLower;
  const double front_z = upper ? 103.5 : 100.8, half_width = upper ? 28.5 : 26.6, depth = 40,
               sign = upper ? 1 : -1;
  const double edge_y = upper ? -36.0 : -36.4;
  double total = 0;
  for (double w : widths) total += w;
  const auto arch = [&](double s) {  // s: mm along the arch; ellipse traversed nearly by its length
    const double t = s / total, angle = (0.80 * t + 0.20 * t * t) * 84 * std::numbers::pi / 180;
    return Vec2d(half_width * std::sin(angle), front_z - depth * (1 - std::cos(angle)));
  };
  struct Profile {
    double up, out;  // mm from the edge towards the gum, mm out of the arch's centre line
    bool gum;
  };
  // Front face from the gum's fold down the crown, round the edge and up the back.
  constexpr std::array<Profile, 14> kProfile{{{17, -1.2, true},
                                              {14, 0.6, true},
                                              {11.6, 1.1, true},
                                              {9.8, 0.9, true},
                                              {9.3, 0.2, false},
                                              {7.0, 0.9, false},
                                              {4.0, 0.9, false},
                                              {1.4, 0.4, false},
                                              {0.2, -0.3, false},
                                              {0.0, -1.1, false},
                                              {0.8, -2.0, false},
                                              {4.5, -3.4, false},
                                              {9.3, -4.6, false},
                                              {14, -6.5, true}}};
  std::vector<std::vector<HalfVertex>> rows(kProfile.size());
  double start = 0;
  for (int tooth = 0; tooth < 7; ++tooth) {
    const bool molar = tooth >= 3;
    for (int i = tooth == 0 ? 0 : 1; i <= kPerTooth; ++i) {
      const double w = 2.0 * i / kPerTooth - 1, s = start + widths[tooth] * i / kPerTooth;
      const Vec2d centre = arch(s), ahead = arch(s + 0.1) - arch(s - 0.1);
      const Vec2d normal = Vec2d(-ahead.y(), ahead.x()).normalized();  // (x, z) out of the arch
      const double gap = std::pow(std::abs(w), 6), height = molar        ? 0.82
                                                            : tooth == 2 ? 1.04
                                                            : tooth == 1 ? 0.93
                                                                         : 1;
      for (std::size_t j = 0; j < kProfile.size(); ++j) {
        const Profile& p = kProfile[j];
        const double rounded = p.gum ? 0 : gap * 0.9 * smoothstep(3.5, 0.0, p.up);  // corners of the edge
        const double scallop = p.gum && p.up < 12 ? -0.8 * gap : 0;  // gum runs down between teeth
        const double inward = p.gum ? 0.2 * gap : 0.75 * gap * (p.out > -1.5 ? 1 : -1);
        const double thick = molar && !p.gum && p.out < -0.8 ? 1.7 : 1;
        const double out = p.out * thick - inward;
        HalfVertex v;
        v.position = Vec3d(centre.x() + normal.x() * out, edge_y + sign * (p.up * height + rounded + scallop),
                           centre.y() + normal.y() * out);
        v.midline = tooth == 0 && i == 0;
        if (v.midline) v.position.x() = 0;
        v.part = p.gum ? HeadPart::gums_tongue : HeadPart::teeth;
        v.tissue = upper ? Tissue::upper_teeth : Tissue::lower_teeth;
        v.uv = uv_in(upper ? Vec2d(0.93, 0.15) : Vec2d(0.80, 0.935), 0.045, s / total,
                     double(j) / kProfile.size());
        rows[j].push_back(v);
      }
    }
    start += widths[tooth];
  }
  if (!upper) std::reverse(rows.begin(), rows.end());
  return make_sheet(rows, false);
}

HalfMesh make_tongue() {
  constexpr int kLength = 16, kAround = 12;
  HalfVertex v;
  v.part = HeadPart::gums_tongue;
  v.tissue = Tissue::tongue;
  std::vector<std::vector<HalfVertex>> rows;
  for (int j = 0; j < kLength; ++j) {
    const double t = (j + 0.4) / kLength;  // tip to root
    const double swell = std::sqrt(std::max(0.0, 1 - std::pow(1 - std::min(1.0, t * 2.2), 2)));
    const Vec3d centre(
        0, -44 + 6 * std::sin(std::numbers::pi * std::min(1.0, t * 0.8)) - 6 * smoothstep(0.7, 1, t),
        95 - 52 * t);
    rows.emplace_back();
    for (int i = 0; i <= kAround; ++i) {
      const double angle = std::numbers::pi * i / kAround;  // top midline round the side to the bottom
      const double groove = 1.2 * std::exp(-std::pow(angle / 0.35, 2)) * swell;
      v.position = centre + Vec3d(swell * 20 * std::sin(angle), swell * 7 * std::cos(angle) - groove, 0);
      v.midline = i == 0 || i == kAround;
      if (v.midline) v.position.x() = 0;
      v.uv = uv_in({0.93, 0.80}, 0.045, angle / std::numbers::pi, t);
      rows.back().push_back(v);
    }
  }
  HalfMesh mesh = make_sheet(rows, false);
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);  // columns run the other way round
  const auto fan = [&](int row, Vec3d tip, bool last) {
    HalfVertex pole = rows[row][0];
    pole.position = tip;
    const int index = int(mesh.vertices.size());
    mesh.vertices.push_back(pole);
    for (int i = 0; i < kAround; ++i) {
      const int a = row * (kAround + 1) + i;
      mesh.triangles.push_back(last ? Triangle(a, a + 1, index) : Triangle(a, index, a + 1));
    }
  };
  fan(0, Vec3d(0, -44, 95.5), false);
  fan(kLength - 1, rows.back()[0].position - Vec3d(0, 7, 4), true);
  return mesh;
}

}  // namespace likeness::builtin
