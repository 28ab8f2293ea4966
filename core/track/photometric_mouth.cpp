#include "core/track/photometric_mouth.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "core/scene/mesh_scene.h"

namespace likeness {
namespace {

constexpr double kClosedGap = 0.0016;   // m between inner lip landmarks, thickness of the line included
constexpr double kPartedJaw = 0.13;     // rad
constexpr double kWindow = 0.040;       // m, half side of the pixels asked
constexpr double kPixelsTogether = 12;  // neighbouring pixels err together
constexpr double kOutlierShare = 0.05;  // of skin pixels: anything may be there
constexpr double kLeastTones = 400;     // pixels seen inside open mouths before their tones are believed

struct MouthView {
  Raster raster;
  std::vector<Triangle> triangles;  // skin's around the mouth, then the interior's, offset by the skin points
  std::size_t skin_triangles = 0;
  PosedSurface posed;
};

Intrinsics window_of(const FaceSurface& surface, const FacePicture& picture, const FaceState& state) {
  Vec3d mouth = Vec3d::Zero();
  int count = 0;
  for (std::size_t p = 0; p < surface.zone.size(); ++p)
    if (surface.zone[p] == FaceZone::lip)
      mouth += surface.person.base.segment<3>(3 * static_cast<Eigen::Index>(p)), ++count;
  const Intrinsics& k = picture.intrinsics[0];
  Intrinsics window = k;
  window.width = window.height = 0;
  if (count == 0) return window;
  const Vec3d in_cam = state.cam_from_head * Vec3d(mouth / count);
  if (in_cam.z() < 0.05) return window;
  const Vec2d px = project<double>(k, in_cam);
  const double reach = kWindow * k.fx / in_cam.z();
  const int x0 = std::max(0, static_cast<int>(px.x() - reach)),
            y0 = std::max(0, static_cast<int>(px.y() - reach)),
            x1 = std::min(k.width, static_cast<int>(px.x() + reach)),
            y1 = std::min(k.height, static_cast<int>(px.y() + reach));
  if (x1 <= x0 || y1 <= y0) return window;
  window.width = x1 - x0, window.height = y1 - y0;
  window.cx -= x0, window.cy -= y0;
  return window;
}

MouthView view_mouth(const HeadModel& model, const HeadShape& shape, const FaceSurface& surface,
                     const Intrinsics& window, const FaceState& state) {
  MouthView view;
  view.posed = posed_surface(surface, state.expression, state.jaw);
  Articulation articulation = neutral_articulation(model);
  articulation.expression = state.expression.cast<float>();
  articulation.jaw.x() = static_cast<float>(state.jaw);
  std::vector<Vec3f> vertices = view.posed.points;
  const std::vector<Vec3f> inside = pose_head(model, shape, articulation);
  vertices.insert(vertices.end(), inside.begin(), inside.end());
  for (int t : surface.mouth) view.triangles.push_back(surface.triangles[t]);
  view.skin_triangles = view.triangles.size();
  const Triangle offset = Triangle::Constant(surface.points.points);
  for (const Triangle& t : surface.interior) view.triangles.push_back(t + offset);
  view.raster = rasterise(vertices, view.triangles, window, state.cam_from_head);
  return view;
}

float picture_at(const FacePicture& picture, const Intrinsics& window, std::size_t pixel) {
  const int x0 = static_cast<int>(std::lround(picture.intrinsics[0].cx - window.cx)),
            y0 = static_cast<int>(std::lround(picture.intrinsics[0].cy - window.cy));
  const int x = static_cast<int>(pixel % static_cast<std::size_t>(window.width)),
            y = static_cast<int>(pixel / static_cast<std::size_t>(window.width));
  return *picture.picture[0].at(x + x0, y + y0);
}

int tone_of(float level) {
  return std::clamp(static_cast<int>(level / 256 * Appearance::kTones), 0, Appearance::kTones - 1);
}

// Minus log probability of every pixel of the window; negative infinity never, NaN where nothing is known.
std::vector<double> pixel_costs(const MouthView& view, const FaceSurface& surface,
                                const Appearance& appearance, const FacePicture& picture,
                                const Intrinsics& window, const Mat3d& turn) {
  const LitPoints& lit = appearance.level[0];
  std::vector<double> costs(view.raster.triangle.size(), std::nan(""));
  std::vector<float> value(surface.zone.size(), -1);
  for (int t : surface.mouth)
    for (int k = 0; k < 3; ++k) {
      const int p = surface.triangles[t][k];
      if (value[p] < 0 && lit.albedo[p] > 0)
        value[p] = static_cast<float>(encoded_of_linear(
            lit.albedo[p] * shade(appearance.light, turn * view.posed.normals[p].cast<double>())));
    }
  for (std::size_t i = 0; i < costs.size(); ++i) {
    const int t = view.raster.triangle[i];
    if (t < 0) continue;
    const float level = picture_at(picture, window, i);
    if (static_cast<std::size_t>(t) >= view.skin_triangles) {
      costs[i] = appearance.cavity[tone_of(level)];
      continue;
    }
    double expected = 0, spread = 0;
    bool known = true;
    for (int k = 0; k < 3; ++k) {
      const int p = view.triangles[t][k];
      known = known && value[p] >= 0;
      expected += view.raster.barycentric[i][k] * value[p];
      spread += view.raster.barycentric[i][k] * lit.spread[p];
    }
    if (!known) continue;
    const double s = std::clamp(spread, 8.0, 30.0), r = (level - expected) / s;
    costs[i] = -std::log((1 - kOutlierShare) * 0.3989 / s * std::exp(-0.5 * r * r) + kOutlierShare / 256);
  }
  return costs;
}

}  // namespace

double lip_gap(const ReducedHead& head, const ReducedPerson& person, const FaceState& state) {
  double sum = 0;
  for (int k = 0; k < 3; ++k)  // 61 over 67, 62 over 66, 63 over 65
    sum += (reduced_point(head, person, 61 + k, state.expression, state.jaw) -
            reduced_point(head, person, 67 - k, state.expression, state.jaw))
               .norm();
  return sum / 3;
}

std::optional<FaceState> other_mouth(const HeadModel& model, const ReducedHead& head,
                                     const ReducedPerson& person, const FaceState& state) {
  FaceState other = state;
  if (lip_gap(head, person, state) < kClosedGap) {
    other.jaw = std::max(state.jaw, 0.0) + kPartedJaw;
    return other;
  }
  other.jaw = 0;
  for (std::size_t e = 0; e < model.expression_names.size(); ++e) {
    const std::string_view name = model.expression_names[e];
    for (std::string_view parting : {"mouthLowerDown", "mouthUpperUp", "mouthFunnel", "jawOpen"})
      if (name.starts_with(parting)) other.expression[static_cast<Eigen::Index>(e)] = 0;
  }
  return other;
}

void count_cavity(const HeadModel& model, const HeadShape& shape, const FaceSurface& surface,
                  const FacePicture& picture, const FaceState& state,
                  std::array<double, Appearance::kTones>* counts) {
  const Intrinsics window = window_of(surface, picture, state);
  if (window.width == 0 || surface.interior.empty()) return;
  const MouthView view = view_mouth(model, shape, surface, window, state);
  for (std::size_t i = 0; i < view.raster.triangle.size(); ++i)
    if (view.raster.triangle[i] >= static_cast<int>(view.skin_triangles))
      (*counts)[tone_of(picture_at(picture, window, i))] += 1;
}

bool cavity_from_counts(const std::array<double, Appearance::kTones>& counts,
                        std::array<double, Appearance::kTones>* cost) {
  constexpr int n = Appearance::kTones;
  double total = 0;
  for (double c : counts) total += c;
  if (total < kLeastTones) return false;
  for (int t = 0; t < n; ++t) {
    double smooth = 0, weight = 0;
    for (int k = -1; k <= 1; ++k)
      if (t + k >= 0 && t + k < n) smooth += (k == 0 ? 2 : 1) * counts[t + k], weight += k == 0 ? 2 : 1;
    // Probability of a tone, per level; a tenth is spread evenly: lights and tongues not seen before.
    (*cost)[t] = -std::log(0.9 * smooth / weight / total * n / 256 + 0.1 / 256);
  }
  return true;
}

double mouth_gain(const HeadModel& model, const HeadShape& shape, const FaceSurface& surface,
                  const Appearance& appearance, const FacePicture& picture, const Mat3d& world_from_cam,
                  const FaceState& a, const FaceState& b) {
  const Intrinsics window = window_of(surface, picture, a);
  if (window.width == 0 || !appearance.cavity_known) return 0;
  const auto costs = [&](const FaceState& s) {
    return pixel_costs(view_mouth(model, shape, surface, window, s), surface, appearance, picture, window,
                       world_from_cam * s.cam_from_head.linear());
  };
  const std::vector<double> of_a = costs(a), of_b = costs(b);
  double gain = 0;
  for (std::size_t i = 0; i < of_a.size(); ++i)
    if (!std::isnan(of_a[i]) && !std::isnan(of_b[i])) gain += of_a[i] - of_b[i];
  return gain / kPixelsTogether;
}

}  // namespace likeness
