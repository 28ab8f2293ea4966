#include "core/track/photo/photometric_mouth.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "core/base/quantile.h"
#include "core/scene/mesh_scene.h"

namespace likeness {
namespace {

constexpr double kJawStep = 0.035, kWidestJaw = 0.42;  // rad, of the states evaluated
constexpr double kOwnJaw = 0.05;         // rad: a face whose lips part below this is closed from there on
constexpr int kMinPixels = 150;          // in the picture that all states explain
constexpr double kMinSigma = 0.0008;     // m: the steps between the states, and errors of the surface
constexpr double kDoubtfulLips = 0.002;  // m that landmarks may be off before they lose weight
constexpr double kMaxDoubt = 8;          // times their sigma
constexpr double kWindow = 0.040;        // m, half side of the window of pixels
constexpr double kPixelsTogether = 12;   // neighbouring pixels err together
constexpr double kOutlierShare = 0.05;   // of skin pixels that may show anything
constexpr double kMinTones = 400;        // pixels seen inside open mouths before their tones are believed

struct MouthView {
  const MouthSurface& surface;
  PosedSurface posed;
  Raster raster;

  bool is_skin(int triangle) const { return static_cast<std::size_t>(triangle) < surface.skin_triangles; }
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

MouthView view_mouth(const FaceSurface& surface, const Intrinsics& window, const FaceState& state) {
  MouthView view{surface.mouth, posed_surface(surface.mouth, state.expression, state.jaw), {}};
  view.raster = rasterise(view.posed.points, surface.mouth.triangles, window, state.cam_from_head);
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

// Expected levels of the skin points around the mouth, encoded; -1 if not known.
std::vector<float> expected_levels(const MouthView& view, const Appearance& appearance, const Mat3d& turn) {
  const LitPoints& lit = appearance.level[0];
  std::vector<float> value(view.surface.skin.size(), -1);
  for (std::size_t p = 0; p < value.size(); ++p)
    if (const float albedo = lit.albedo[view.surface.skin[p]]; albedo > 0)
      value[p] = static_cast<float>(
          encoded_of_linear(albedo * shade(appearance.light, turn * view.posed.normals[p].cast<double>())));
  return value;
}

// Level and usual spread of the skin at pixel i; false if not known.
bool expect_skin(const MouthView& view, const std::vector<float>& value, const LitPoints& lit, std::size_t i,
                 double* level, double* spread) {
  *level = *spread = 0;
  for (int k = 0; k < 3; ++k) {
    const int p = view.surface.triangles[view.raster.triangle[i]][k];
    if (value[p] < 0) return false;
    *level += view.raster.barycentric[i][k] * value[p];
    *spread += view.raster.barycentric[i][k] * lit.spread[view.surface.skin[p]];
  }
  return true;
}

// The picture's brightness around the mouth over the expected one: a median, which the lips hardly affect.
double exposure_of(const MouthView& view, const Appearance& appearance, const FacePicture& picture,
                   const Intrinsics& window, const Mat3d& turn) {
  const std::vector<float> value = expected_levels(view, appearance, turn);
  std::vector<double> ratios;
  double level = 0, spread = 0;
  for (std::size_t i = 0; i < view.raster.triangle.size(); ++i) {
    const int t = view.raster.triangle[i];
    if (t < 0 || !view.is_skin(t)) continue;
    if (expect_skin(view, value, appearance.level[0], i, &level, &spread) && level > 10)
      ratios.push_back(picture_at(picture, window, i) / level);
  }
  if (ratios.empty()) return 1;
  return std::clamp(median(std::move(ratios)), 0.7, 1.4);
}

// Minus log probability of every pixel of the window; negative infinity never, NaN where nothing is known.
std::vector<double> pixel_costs(const MouthView& view, const Appearance& appearance,
                                const FacePicture& picture, const Intrinsics& window, const Mat3d& turn,
                                double exposure) {
  std::vector<double> costs(view.raster.triangle.size(), std::nan(""));
  const std::vector<float> value = expected_levels(view, appearance, turn);
  double expected = 0, spread = 0;
  for (std::size_t i = 0; i < costs.size(); ++i) {
    const int t = view.raster.triangle[i];
    if (t < 0) continue;
    const float level = picture_at(picture, window, i);
    if (!view.is_skin(t)) {
      costs[i] = appearance.cavity[tone_of(level)];
      continue;
    }
    if (!expect_skin(view, value, appearance.level[0], i, &expected, &spread)) continue;
    const double s = std::clamp(spread, 8.0, 30.0), r = (level - exposure * expected) / s;
    costs[i] = -std::log((1 - kOutlierShare) * 0.3989 / s * std::exp(-0.5 * r * r) + kOutlierShare / 256);
  }
  return costs;
}

}  // namespace

FaceState with_jaw(const HeadModel& model, const FaceState& state, double jaw) {
  FaceState other = state;
  const double own = std::max(state.jaw, kOwnJaw);
  other.jaw = jaw;
  if (jaw >= own) return other;
  for (std::size_t e = 0; e < model.expression_names.size(); ++e) {
    const std::string_view name = model.expression_names[e];
    for (std::string_view parting : {"mouthLowerDown", "mouthUpperUp", "mouthFunnel", "jawOpen"})
      if (name.starts_with(parting))
        other.expression[static_cast<Eigen::Index>(e)] *= std::max(0.0, jaw / own);
  }
  return other;
}

void count_cavity(const FaceSurface& surface, const FacePicture& picture, const FaceState& state,
                  std::array<double, Appearance::kTones>* counts) {
  const Intrinsics window = window_of(surface, picture, state);
  if (window.width == 0 || surface.mouth.skin_triangles == surface.mouth.triangles.size()) return;
  const MouthView view = view_mouth(surface, window, state);
  for (std::size_t i = 0; i < view.raster.triangle.size(); ++i)
    if (view.raster.triangle[i] >= 0 && !view.is_skin(view.raster.triangle[i]))
      (*counts)[tone_of(picture_at(picture, window, i))] += 1;
}

bool cavity_from_counts(const std::array<double, Appearance::kTones>& counts,
                        std::array<double, Appearance::kTones>* cost) {
  constexpr int n = Appearance::kTones;
  double total = 0;
  for (double c : counts) total += c;
  if (total < kMinTones) return false;
  for (int t = 0; t < n; ++t) {
    double smooth = 0, weight = 0;
    for (int k = -1; k <= 1; ++k)
      if (t + k >= 0 && t + k < n) smooth += (k == 0 ? 2 : 1) * counts[t + k], weight += k == 0 ? 2 : 1;
    // Probability of a tone, per level; a tenth is spread evenly, for lights and tongues not seen before.
    (*cost)[t] = -std::log(0.9 * smooth / weight / total * n / 256 + 0.1 / 256);
  }
  return true;
}

std::optional<MouthReading> read_mouth(const HeadModel& model, const ReducedHead& head,
                                       const ReducedPerson& person, const FaceSurface& surface,
                                       const Appearance& appearance, const FacePicture& picture,
                                       const Mat3d& world_from_cam, const FaceState& state) {
  const Intrinsics window = window_of(surface, picture, state);
  if (window.width == 0 || surface.mouth.skin_triangles == surface.mouth.triangles.size() ||
      !appearance.cavity_known)
    return std::nullopt;
  const Mat3d turn = world_from_cam * state.cam_from_head.linear();
  std::vector<FaceState> asked;
  std::vector<std::vector<double>> costs;
  double exposure = 0;
  for (double jaw = 0; jaw < kWidestJaw; jaw += kJawStep) {
    asked.push_back(with_jaw(model, state, jaw));
    const MouthView view = view_mouth(surface, window, asked.back());
    if (exposure == 0) exposure = exposure_of(view, appearance, picture, window, turn);
    costs.push_back(pixel_costs(view, appearance, picture, window, turn, exposure));
  }
  // Pixels that every state explains, so that none gains by hiding some.
  std::vector<double> cost(asked.size(), 0);
  int pixels = 0;
  for (std::size_t i = 0; i < costs[0].size(); ++i) {
    bool known = true;
    for (const auto& c : costs) known = known && !std::isnan(c[i]);
    if (!known) continue;
    ++pixels;
    for (std::size_t k = 0; k < cost.size(); ++k) cost[k] += costs[k][i] / kPixelsTogether;
  }
  if (pixels < kMinPixels) return std::nullopt;
  const std::size_t best =
      static_cast<std::size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
  MouthReading reading;
  reading.likeliest = asked[best];
  double sum = 0, first = 0, second = 0;
  for (std::size_t k = 0; k < asked.size(); ++k) {
    const double w = std::exp(cost[best] - cost[k]), gap = lip_gap(head, person, asked[k]);
    sum += w, first += w * gap, second += w * gap * gap;
  }
  reading.lips.known = true;
  reading.lips.gap_m = first / sum;
  const double spread = std::sqrt(std::max(0.0, second / sum - reading.lips.gap_m * reading.lips.gap_m));
  reading.lips.sigma_m = std::hypot(spread, kMinSigma);
  return reading;
}

void observe_mouth(const LipEvidence& lips, double fitted_gap_m, FaceObservation* out) {
  out->lips = lips;
  const double deviation = (fitted_gap_m - lips.gap_m) / std::hypot(kDoubtfulLips, lips.sigma_m);
  const double factor = std::min(kMaxDoubt, 1 + deviation * deviation);
  for (int k = 48; k < kLandmarkCount; ++k) out->sigma_px[k] *= factor;
  for (int k = 4; k <= 12; ++k) out->sigma_px[k] *= factor;  // the chin moves with the jaw
}

double mouth_gain(const FaceSurface& surface, const Appearance& appearance, const FacePicture& picture,
                  const Mat3d& world_from_cam, const FaceState& a, const FaceState& b) {
  const Intrinsics window = window_of(surface, picture, a);
  if (window.width == 0 || !appearance.cavity_known) return 0;
  const auto view = [&](const FaceState& s) { return view_mouth(surface, window, s); };
  const auto turn = [&](const FaceState& s) { return Mat3d(world_from_cam * s.cam_from_head.linear()); };
  const MouthView view_a = view(a), view_b = view(b);
  const double exposure = std::sqrt(exposure_of(view_a, appearance, picture, window, turn(a)) *
                                    exposure_of(view_b, appearance, picture, window, turn(b)));
  const std::vector<double> of_a = pixel_costs(view_a, appearance, picture, window, turn(a), exposure),
                            of_b = pixel_costs(view_b, appearance, picture, window, turn(b), exposure);
  double gain = 0;
  for (std::size_t i = 0; i < of_a.size(); ++i)
    if (!std::isnan(of_a[i]) && !std::isnan(of_b[i])) gain += of_a[i] - of_b[i];
  return gain / kPixelsTogether;
}

}  // namespace likeness
