#include "core/head/drawn_landmarks.h"

#include <set>
#include <vector>

#include "core/head/nearest_barycentric.h"

namespace likeness {
namespace {

// Twice the largest shift: triangles farther from the old place than this, along the surface, are not tried.
constexpr double kReach = 0.12;  // distances between the outer corners of the eyes

Vec3d landmark_place(const HeadModel& model, int landmark) {
  const Triangle& t = model.triangles[std::size_t(model.landmark_triangle[std::size_t(landmark)])];
  const Vec3f& w = model.landmark_barycentric[std::size_t(landmark)];
  Vec3d place = Vec3d::Zero();
  for (int k = 0; k < 3; ++k) place += double(w[k]) * model.vertices[std::size_t(t[k])].cast<double>();
  return place;
}

// Against ICT-FaceKit's list, of one-hot vertices: medians over five people's clips of the offset between
// newly detected landmarks and the fitted model's (core/lab/truth/track_checks.h), mirrored halves averaged.
// From one person to the next they differ by 0.003 to 0.01; smaller shifts are left out.
constexpr std::array kIctShifts = std::to_array<DrawnLandmark>({
    {17, {0.006f, -0.015f}},  {18, {-0.008f, -0.003f}}, {20, {-0.007f, -0.007f}}, {21, {-0.009f, -0.023f}},
    {27, {0, 0.009f}},        {29, {0, -0.013f}},       {31, {0.004f, 0.008f}},   {33, {0, -0.014f}},
    {36, {-0.002f, -0.008f}}, {37, {0.023f, -0.002f}},  {38, {0.008f, -0.008f}},  {39, {-0.006f, -0.004f}},
    {40, {-0.008f, -0.002f}}, {41, {0.014f, -0.005f}},  {48, {-0.012f, -0.003f}}, {49, {-0.008f, -0.004f}},
    {51, {0, -0.015f}},       {55, {0.014f, -0.003f}},  {56, {-0.010f, -0.008f}}, {61, {0.016f, 0}},
    {65, {-0.022f, 0.002f}},  {66, {0, 0.007f}},
});

// Against the built-in head's: medians of the same offsets over landmark fits of clips of five people on whom
// no figures are measured, with the identity held fifty times as firmly as in a normal fit: left free,
// identity and head pitch absorb most of an offset. Shifts below 0.004 are left out, and the inner lips stay:
// the mouth's pocket is cut along them.
constexpr std::array kBuiltinShifts = std::to_array<DrawnLandmark>({
    {17, {-0.021f, -0.016f}}, {18, {-0.010f, 0.003f}},  {19, {0.005f, 0.004f}},  {20, {-0.005f, 0.001f}},
    {21, {-0.010f, -0.015f}}, {27, {0, 0.011f}},        {29, {0, -0.011f}},      {30, {0, -0.015f}},
    {31, {-0.008f, 0.008f}},  {32, {-0.010f, 0.010f}},  {33, {0, -0.015f}},      {36, {0.002f, -0.011f}},
    {37, {0.008f, -0.001f}},  {39, {-0.003f, -0.005f}}, {40, {-0.003f, 0.010f}}, {41, {0.002f, 0.009f}},
    {48, {-0.020f, 0.005f}},  {49, {-0.007f, -0.016f}}, {51, {0, -0.005f}},      {55, {0.005f, -0.001f}},
    {56, {-0.020f, -0.007f}},
});

// Triangles connected with `start` over common vertices no farther than `reach` from `centre`.
std::set<int> triangles_around(const HeadModel& model, const std::vector<std::vector<int>>& of_vertex,
                               int start, const Vec3d& centre, double reach) {
  std::set<int> found{start};
  std::vector<int> open{start};
  while (!open.empty()) {
    const Triangle t = model.triangles[std::size_t(open.back())];
    open.pop_back();
    for (int k = 0; k < 3; ++k) {
      if ((model.vertices[std::size_t(t[k])].cast<double>() - centre).norm() > reach) continue;
      for (const int next : of_vertex[std::size_t(t[k])])
        if (found.insert(next).second) open.push_back(next);
    }
  }
  return found;
}

}  // namespace

std::span<const DrawnLandmark> ict_shifts() { return kIctShifts; }
std::span<const DrawnLandmark> builtin_shifts() { return kBuiltinShifts; }

int mirrored_landmark(int landmark) {
  constexpr std::array<int, kLandmarkCount> kOther{
      16, 15, 14, 13, 12, 11, 10, 9,  8,  7,  6,  5,  4,  3,  2,  1,  0,  26, 25, 24, 23, 22, 21,
      20, 19, 18, 17, 27, 28, 29, 30, 35, 34, 33, 32, 31, 45, 44, 43, 42, 47, 46, 39, 38, 37, 36,
      41, 40, 54, 53, 52, 51, 50, 49, 48, 59, 58, 57, 56, 55, 64, 63, 62, 61, 60, 67, 66, 65};
  return kOther[std::size_t(landmark)];
}

void draw_landmarks(HeadModel& model, std::span<const DrawnLandmark> shifts) {
  const double eyes = (landmark_place(model, 36) - landmark_place(model, 45)).norm();
  std::vector<std::vector<int>> of_vertex(model.vertices.size());
  for (std::size_t t = 0; t < model.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) of_vertex[std::size_t(model.triangles[t][k])].push_back(int(t));
  // Only the place seen from the front counts; depth merely separates overlapping surfaces.
  const auto seen = [](const Vec3d& p) { return Vec3d(p.x(), p.y(), 0.2 * p.z()); };
  const auto move = [&](int landmark, const Vec3d& shift) {
    const Vec3d from = landmark_place(model, landmark), to = seen(from + eyes * shift);
    int& triangle = model.landmark_triangle[std::size_t(landmark)];
    double nearest = 1e30;
    for (const int t : triangles_around(model, of_vertex, triangle, from, kReach * eyes)) {
      std::array<Vec3d, 3> p;
      for (int k = 0; k < 3; ++k)
        p[std::size_t(k)] =
            seen(model.vertices[std::size_t(model.triangles[std::size_t(t)][k])].cast<double>());
      const Vec3d weights = nearest_barycentric(to, p[0], p[1], p[2]);
      const double apart = (weights[0] * p[0] + weights[1] * p[1] + weights[2] * p[2] - to).squaredNorm();
      if (apart >= nearest) continue;
      nearest = apart;
      triangle = t;
      model.landmark_barycentric[std::size_t(landmark)] = weights.cast<float>();
    }
  };
  for (const auto& [landmark, shift] : shifts) {
    const int other = mirrored_landmark(landmark);
    move(landmark, {other == landmark ? 0.0 : double(shift.x), double(shift.y), 0});
    if (other != landmark) move(other, {-double(shift.x), double(shift.y), 0});
  }
}

}  // namespace likeness
