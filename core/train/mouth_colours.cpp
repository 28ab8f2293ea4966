// Read off lips and eyeballs.
#include "core/train/mouth_colours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/image/srgb.h"
#include "core/scene/head_regions.h"

namespace likeness {
namespace {

constexpr int kFirstLip = 48, kFirstInnerLip = 60, kLastLip = 67;
constexpr float kTeeth = 0.7f, kTongue = 0.7f, kWalls = 0.3f;  // of the eyes' white and of the lips, linear
const Vec3f kEnamel(1.f, 0.96f, 0.86f);                        // beside an eye's white
constexpr float kLit = 0.006f, kFading = 0.02f, kDarkest = 0.12f;  // m behind the lips; of the light there
constexpr float kWhites = 0.85f;                                   // quantile of the eyeballs' brightness
constexpr float kWhiteOfSkin = 1.6f;  // where no eye is seen, of the lips', linear

Vec3f to_linear(const Vec3f& c) { return {linear_of_srgb(c[0]), linear_of_srgb(c[1]), linear_of_srgb(c[2])}; }
Vec3f to_encoded(const Vec3f& c) {
  return {srgb_of_linear(c[0]), srgb_of_linear(c[1]), srgb_of_linear(c[2])};
}

std::optional<Vec3f> colour_of_lips(const HeadModel& model, const std::vector<float>& known,
                                    const std::vector<Vec3f>& colours) {
  Vec3f sum = Vec3f::Zero();
  float weight = 0;
  for (int k = kFirstLip; k < kFirstInnerLip; ++k)
    for (const int v : model.triangles[std::size_t(model.landmark_triangle[std::size_t(k)])])
      sum += known[std::size_t(v)] * to_linear(colours[std::size_t(v)]), weight += known[std::size_t(v)];
  if (weight == 0) return std::nullopt;
  return sum / weight;
}

std::optional<Vec3f> white_of_eyes(const HeadModel& model, const std::vector<float>& known,
                                   const std::vector<Vec3f>& colours) {
  std::vector<std::pair<float, std::size_t>> brightness;
  for (std::size_t v = 0; v < model.parts.size(); ++v)
    if ((model.parts[v] == HeadPart::left_eyeball || model.parts[v] == HeadPart::right_eyeball) &&
        known[v] > 0)
      brightness.emplace_back(colours[v].sum(), v);
  if (brightness.empty()) return std::nullopt;
  std::ranges::sort(brightness);
  const std::size_t at = std::size_t(kWhites * float(brightness.size() - 1));
  return to_linear(colours[brightness[at].second]);
}

}  // namespace

std::vector<std::uint8_t> inside_mouth(const HeadModel& model) {
  std::vector<std::uint8_t> inside(model.vertices.size(), 0);
  if (model.parts.empty()) return inside;
  for (std::size_t v = 0; v < inside.size(); ++v)
    inside[v] = model.parts[v] == HeadPart::mouth_socket || model.parts[v] == HeadPart::gums_tongue ||
                model.parts[v] == HeadPart::teeth;
  return inside;
}

void colour_mouth(const HeadModel& model, const std::vector<Vec3f>& rest, std::vector<float>& known,
                  std::vector<Vec3f>& colours) {
  const std::vector<std::uint8_t> inside = inside_mouth(model);
  const std::optional<Vec3f> lips = colour_of_lips(model, known, colours);
  if (!lips) return;
  const Vec3f white =
      white_of_eyes(model, known, colours).value_or(Vec3f::Constant(kWhiteOfSkin * lips->mean()));
  const auto landmarks = landmark_positions(model, rest);
  float front = 0;
  for (int k = kFirstInnerLip; k <= kLastLip; ++k)
    front += landmarks[std::size_t(k)].z() / float(kLastLip - kFirstInnerLip + 1);
  for (std::size_t v = 0; v < inside.size(); ++v) {
    if (!inside[v] || known[v] >= 1) continue;
    const float depth = std::max(0.f, front - rest[v].z() - kLit),
                light = std::max(kDarkest, std::exp(-depth / kFading));
    const float wall = std::min(1.f, depth / kLit);  // lips go on inwards
    const HeadPart part = model.parts[v];
    const Vec3f own = part == HeadPart::teeth         ? Vec3f(kTeeth * white.cwiseProduct(kEnamel))
                      : part == HeadPart::gums_tongue ? Vec3f(kTongue * *lips)
                                                      : Vec3f((1 + wall * (kWalls - 1)) * *lips);
    const Vec3f guessed = to_encoded((light * own).cwiseMin(1.f));
    colours[v] = known[v] * colours[v] + (1 - known[v]) * guessed;
    known[v] = 1;
  }
}

}  // namespace likeness
