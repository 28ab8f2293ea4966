// Layers of the skin, from broad to fine: complexion, blood, freckles, stubble, brows, lips, pores.
#include "core/synth/skin.h"

#include <algorithm>
#include <cmath>

#include "core/synth/noise.h"
#include "core/synth/shade.h"

namespace likeness {
namespace {

// A Catmull-Rom curve through the points, `fine` segments between neighbours.
std::vector<Vec3f> curve_through(const std::vector<Vec3f>& points, bool closed, int fine) {
  std::vector<Vec3f> curve;
  const int n = int(points.size());
  const auto at = [&](int i) {
    return closed ? points[std::size_t((i + n) % n)] : points[std::size_t(std::clamp(i, 0, n - 1))];
  };
  for (int i = 0; i < (closed ? n : n - 1); ++i) {
    for (int k = 0; k < fine; ++k) {
      const float t = float(k) / float(fine);
      const Vec3f a = at(i - 1), b = at(i), c = at(i + 1), d = at(i + 2);
      curve.push_back(0.5f * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t * t +
                              (3 * b - a - 3 * c + d) * t * t * t));
    }
  }
  if (!closed) curve.push_back(points.back());
  return curve;
}

struct OnCurve {
  float distance = 1e9f;  // in the frontal plane, m
  float along = 0;        // 0..1
  float above = 0;        // signed, m: positive on the upper side
};

OnCurve nearest_on(const std::vector<Vec3f>& curve, const Vec3f& p) {
  OnCurve best;
  for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
    const Vec2f a = curve[i].head<2>(), ab = curve[i + 1].head<2>() - a, ap = p.head<2>() - a;
    const float t = std::clamp(ap.dot(ab) / std::max(1e-12f, ab.squaredNorm()), 0.0f, 1.0f);
    const Vec2f off = ap - t * ab;
    const float d = off.norm();
    if (d < best.distance) best = {d, (float(i) + t) / float(curve.size() - 1), off.y() >= 0 ? d : -d};
  }
  return best;
}

bool inside_outline(const std::vector<Vec3f>& outline, const Vec3f& p) {
  bool inside = false;
  for (std::size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
    const Vec3f &a = outline[i], &b = outline[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x())
      inside = !inside;
  }
  return inside;
}

float bell(const Vec3f& p, const Vec3f& centre, float radius) {
  return std::exp(-(p - centre).squaredNorm() / (radius * radius));
}

// Round spots of random size on a jittered lattice of `cell`; the depth of the spot at p, 0..1.
float spots(const Vec3f& p, float cell, float share, std::uint32_t seed) {
  const Vec3f q = p / cell;
  const int x = int(std::floor(q.x())), y = int(std::floor(q.y())), z = int(std::floor(q.z()));
  const std::uint32_t h = hash_cell(x, y, z, seed);
  if (hash_unit(h) > share) return 0;
  const Vec3f centre(float(x) + 0.3f + 0.4f * hash_unit(h + 1), float(y) + 0.3f + 0.4f * hash_unit(h + 2),
                     float(z) + 0.3f + 0.4f * hash_unit(h + 3));
  const float radius = 0.12f + 0.18f * hash_unit(h + 4);
  return 1 - smoothstep(0.5f * radius, radius * 1.3f, (q - centre).norm());
}

std::vector<Vec3f> pick(const std::array<Vec3f, kLandmarkCount>& l, std::initializer_list<int> indices) {
  std::vector<Vec3f> points;
  for (const int i : indices) points.push_back(l[std::size_t(i)]);
  return points;
}

}  // namespace

Skin::Skin(const std::array<Vec3f, kLandmarkCount>& landmarks, const std::array<Vec3f, 2>& eyes,
           float eye_radius, const SkinLook& look, float detail_m, std::uint32_t seed)
    : landmarks_(landmarks),
      eyes_(eyes),
      look_(look),
      eye_radius_(eye_radius),
      detail_(detail_m),
      seed_(seed) {
  unit_ = (eyes[0] - eyes[1]).norm() / 0.062f;
  brows_[0] = curve_through(pick(landmarks, {17, 18, 19, 20, 21}), false, 4);
  brows_[1] = curve_through(pick(landmarks, {26, 25, 24, 23, 22}), false, 4);
  upper_lids_[0] = curve_through(pick(landmarks, {36, 37, 38, 39}), false, 5);
  upper_lids_[1] = curve_through(pick(landmarks, {45, 44, 43, 42}), false, 5);
  lower_lids_[0] = curve_through(pick(landmarks, {36, 41, 40, 39}), false, 5);
  lower_lids_[1] = curve_through(pick(landmarks, {45, 46, 47, 42}), false, 5);
  lips_ = curve_through(pick(landmarks, {48, 49, 50, 51, 52, 53, 54, 55, 56, 57, 58, 59}), true, 4);
}

float Skin::brow(const Vec3f& p) const {
  const int side = p.x() < 0 ? 0 : 1;
  const Vec3f& middle = landmarks_[side == 0 ? 19 : 24];
  if ((p - middle).norm() > 0.045f * unit_ || p.z() < middle.z() - 0.05f) return 0;
  const OnCurve on = nearest_on(brows_[side], p);  // along: 0 at the temple
  const float t = on.along;
  const float below = (0.0026f + 0.0036f * smoothstep(0.1f, 0.8f, t)) * unit_ * look_.brow_width,
              above = 0.0015f * unit_;
  const float ragged = 0.0012f * noise(p * 420.0f, seed_ + 61);
  const float across = on.above + ragged;
  const float body = smoothstep(-below - 0.0022f, -below + 0.0026f, across) *
                     (1 - smoothstep(above - 0.0014f, above + 0.0024f, across));
  const float ends =
      smoothstep(0.0f, 0.22f, t) * (1 - smoothstep(0.86f, 1.0f, t + 0.05f * noise(p * 700.0f, seed_ + 64)));
  // Hairs: streaks that lean towards the temple, steeper near the nose.
  const float lean = 0.35f + 1.1f * t, sign = side == 0 ? 1.0f : -1.0f;
  const float u = p.x() * sign * std::cos(lean) - p.y() * std::sin(lean),
              v = p.x() * sign * std::sin(lean) + p.y() * std::cos(lean);
  const float streak =
      noise(Vec3f(u * 1300, v * 190, 0), seed_ + 62) + 0.6f * noise(Vec3f(u * 2300, v * 300, 3), seed_ + 63);
  return body * ends * (0.98f + 0.22f * streak) * smoothstep(1.3f, 0.55f, std::abs(t - 0.5f));
}

float Skin::lip(const Vec3f& p) const {
  const Vec3f centre = 0.5f * (landmarks_[48] + landmarks_[54]);
  if (std::abs(p.x() - centre.x()) > 0.034f * unit_ || std::abs(p.y() - centre.y()) > 0.03f * unit_ ||
      p.z() < centre.z() - 0.012f) {
    return 0;
  }
  std::vector<Vec3f>::const_iterator first = lips_.begin();
  float nearest = 1e9f;
  for (std::size_t i = 0; i < lips_.size(); ++i) {
    const Vec2f a = first[long(i)].head<2>(), ab = first[long((i + 1) % lips_.size())].head<2>() - a,
                ap = p.head<2>() - a;
    const float t = std::clamp(ap.dot(ab) / std::max(1e-12f, ab.squaredNorm()), 0.0f, 1.0f);
    nearest = std::min(nearest, (ap - t * ab).norm());
  }
  const float signed_distance = inside_outline(lips_, p) ? nearest : -nearest;
  return smoothstep(-0.0009f, 0.0013f, signed_distance + 0.0004f * noise(p * 500.0f, seed_ + 71));
}

float Skin::lash_line(const Vec3f& p) const {
  const int side = p.x() < 0 ? 0 : 1;
  if ((p - eyes_[side == 0 ? 1 : 0]).norm() > 0.026f * unit_) return 0;
  float upper = 1e9f, lower = 1e9f;
  for (const Vec3f& q : upper_lids_[side]) upper = std::min(upper, (p - q).squaredNorm());
  for (const Vec3f& q : lower_lids_[side]) lower = std::min(lower, (p - q).squaredNorm());
  upper = std::sqrt(upper);
  lower = std::sqrt(lower);
  return std::max(1 - smoothstep(0.0009f, 0.0021f, upper), 0.45f * (1 - smoothstep(0.0006f, 0.0014f, lower)));
}

float Skin::stubble(const Vec3f& p) const {
  const Vec3f &chin = landmarks_[8], &corner_r = landmarks_[48], &corner_l = landmarks_[54],
              &nose = landmarks_[33];
  const float lip_y = 0.5f * (corner_r.y() + corner_l.y());
  const float side = std::abs(p.x()) / (0.07f * unit_);
  const float top = lip_y + 0.010f * unit_ + 0.034f * unit_ * side * side;
  float beard = 1 - smoothstep(top - 0.010f, top + 0.010f, p.y() + 0.005f * noise(p * 60.0f, seed_ + 81));
  beard *= smoothstep(chin.y() - 0.055f * unit_, chin.y() - 0.015f * unit_, p.y());
  const float moustache = bell(Vec3f(0.62f * p.x(), p.y(), 0),
                               Vec3f(0, 0.5f * (nose.y() + landmarks_[51].y()), 0), 0.0105f * unit_);
  return std::clamp(beard + (p.z() > corner_r.z() - 0.01f ? moustache : 0.0f), 0.0f, 1.0f) *
         smoothstep(-0.01f, 0.03f, p.z());
}

// Depth of the lines of age at a point, about [0, 1]: across the forehead, at the temples beside the eyes,
// under them, and beside the mouth.
float Skin::lines(const Vec3f& p) const {
  const float wave = 0.0022f * noise(p * 55.0f, seed_ + 101);
  const float brow = 0.5f * (landmarks_[19].y() + landmarks_[24].y()), height = p.y() - brow + wave;
  const auto crease = [](float x, float width) { return std::exp(-x * x / (width * width)); };
  const auto ridge = [&](float x, float period, float width) {
    return crease(period * (x / period - std::round(x / period)), width);
  };
  float depth = smoothstep(0.010f, 0.016f, height) * (1 - smoothstep(0.036f, 0.052f, height)) *
                (1 - smoothstep(0.030f, 0.048f, std::abs(p.x()))) * ridge(height, 0.0088f, 0.0011f) *
                smoothstep(0.04f, 0.06f, p.z());
  const float sign = p.x() < 0 ? -1.0f : 1.0f;
  const Vec3f outer = landmarks_[p.x() < 0 ? 36 : 45], inner = landmarks_[p.x() < 0 ? 39 : 42];
  const Vec2f d = (p - outer).head<2>();
  const float aside = sign * d.x(), fan = std::atan2(d.y() + 0.6f * wave, std::max(1e-4f, aside));
  depth += 0.8f * smoothstep(0.005f, 0.010f, aside) * (1 - smoothstep(0.018f, 0.030f, aside)) *
           (1 - smoothstep(0.5f, 0.8f, std::abs(fan))) * ridge(fan * 0.016f, 0.0046f, 0.0009f) *
           smoothstep(0.03f, 0.045f, p.z());
  const Vec2f lid = (p - 0.5f * (outer + inner)).head<2>();
  const float bag = std::hypot(0.62f * lid.x(), lid.y()) - 0.0165f * unit_;
  if (lid.y() < -0.004f && p.z() > 0.05f)
    depth += 0.7f * crease(bag + 0.5f * wave, 0.0014f) * (1 - smoothstep(0.016f, 0.024f, std::abs(lid.x())));
  const Vec3f corner = landmarks_[p.x() < 0 ? 48 : 54], wing = landmarks_[p.x() < 0 ? 31 : 35];
  const float t = (wing.y() + 0.003f - p.y()) / std::max(0.01f, wing.y() - corner.y() + 0.012f);
  if (t > -0.1f && t < 1.2f && p.z() > 0.05f) {
    const float x =
        sign * p.x() - (sign * wing.x() + 0.006f +
                        (sign * corner.x() + 0.010f - sign * wing.x() - 0.006f) * t + 0.012f * t * (1 - t));
    depth += 1.0f * crease(x + 0.5f * wave, 0.0017f) * smoothstep(-0.1f, 0.15f, t) *
             (1 - smoothstep(0.8f, 1.2f, t));
  }
  return std::min(depth, 1.2f);
}

Surface Skin::face(const Vec3f& p) const {
  Surface s;
  const Vec3f m = p / unit_;
  // -- Complexion
  Vec3f albedo = look_.complexion;
  const float broad = fractal_noise(m * 32.0f, 3, seed_), blotch = fractal_noise(m * 130.0f, 3, seed_ + 5);
  albedo *= 1 + 0.07f * broad;
  // -- Blood: cheeks, nose, ears, chin; less around the eyes
  const Vec3f cheek_r = mix(mix(landmarks_[2], landmarks_[31], 0.5f), landmarks_[40], 0.3f);
  const Vec3f cheek_l = mix(mix(landmarks_[14], landmarks_[35], 0.5f), landmarks_[47], 0.3f);
  float blood = 0.9f * (bell(p, cheek_r, 0.03f * unit_) + bell(p, cheek_l, 0.03f * unit_)) +
                0.8f * bell(p, landmarks_[30], 0.018f * unit_) +
                0.35f * bell(p, landmarks_[8], 0.022f * unit_);
  blood += 0.9f * smoothstep(0.073f * unit_, 0.082f * unit_, std::abs(p.x()));
  blood += 0.35f * blotch + 0.2f * broad;
  blood *= look_.blood;
  albedo = albedo.cwiseProduct(Vec3f(1.0f + 0.02f * blood, 1 - 0.17f * blood, 1 - 0.15f * blood));
  for (const Vec3f& eye : eyes_) {
    const float shade = bell(p, eye + Vec3f(0, -0.010f, 0.012f) * unit_, 0.019f * unit_);
    albedo = albedo.cwiseProduct(Vec3f(1 - 0.11f * shade, 1 - 0.15f * shade, 1 - 0.10f * shade));
  }
  // -- Freckles and a few moles
  const float freckled =
      std::clamp(0.25f + bell(p, cheek_r, 0.045f) + bell(p, cheek_l, 0.045f) + bell(p, landmarks_[29], 0.04f),
                 0.0f, 1.0f);
  const float freckle = std::min(1.0f, look_.freckles) *
                        std::min(1.0f, freckled * std::max(1.0f, look_.freckles)) *
                        std::max(0.55f * spots(m, 0.0062f, 0.45f, seed_ + 11),
                                 0.5f * spots(m + Vec3f(3, 1, 2), 0.0044f, 0.35f, seed_ + 12));
  const float mole = 0.85f * spots(m, 0.0085f, 0.02f, seed_ + 13) * (freckle > 0 ? 1.0f : 0.8f);
  albedo = albedo.cwiseProduct(mix(Vec3f(1, 1, 1), Vec3f(0.62f, 0.47f, 0.40f), std::max(freckle, mole)));
  albedo *= 1 + 0.05f * blotch;
  s.roughness = 0.44f - 0.06f * bell(p, landmarks_[29], 0.03f) -
                0.05f * bell(p, landmarks_[27] + Vec3f(0, 0.04f, 0), 0.03f);
  s.f0 = 0.028f + 0.006f * look_.gloss;
  s.roughness -= 0.06f * look_.gloss;
  // -- Stubble
  const float beard = stubble(p);
  const float lips = lip(p);
  if (beard > 0) {
    const float dots = 0.5f + 0.5f * noise(m * 620.0f, seed_ + 21);
    const float dark = look_.stubble * beard * (1 - lips) * (0.12f + 0.26f * dots);
    albedo = mix(albedo, Vec3f(albedo.cwiseMin(Vec3f(0.085f, 0.068f, 0.060f))), dark);
  }
  // -- Lips
  if (lips > 0) {
    const float lines = noise(Vec3f(m.x() * 900, m.y() * 160, m.z() * 160), seed_ + 31);
    const Vec3f lip_colour = look_.lips * (1 + 0.10f * lines + 0.12f * blotch);
    albedo = mix(albedo, lip_colour, 0.92f * lips);
    s.roughness = mix(s.roughness, 0.33f, lips);
    s.slope += Vec3f(0.10f * lines * lips, 0, 0);
  }
  // -- Brows and lid margins
  const float hairs = std::clamp(brow(p), 0.0f, 1.0f), lashes = lash_line(p);
  albedo = mix(albedo, look_.brows, 0.92f * hairs);
  const Vec3f lash_colour = mix(Vec3f(0.035f, 0.020f, 0.015f), Vec3f(0.012f, 0.008f, 0.007f),
                                std::clamp(look_.lash - 1, 0.0f, 1.0f));
  albedo = mix(albedo, lash_colour, std::min(1.0f, 0.9f * look_.lash * lashes));
  s.roughness = mix(s.roughness, 0.6f, std::max(hairs, lashes));
  // -- Pores and fine relief
  const float pore_size = std::max(0.0009f, 1.3f * detail_), wave = 1 / pore_size;
  const float pores = noise(m * wave, seed_ + 41), step = 0.35f * pore_size;
  const Vec3f slope(noise((m + Vec3f(step, 0, 0)) * wave, seed_ + 41) - pores,
                    noise((m + Vec3f(0, step, 0)) * wave, seed_ + 41) - pores,
                    noise((m + Vec3f(0, 0, step)) * wave, seed_ + 41) - pores);
  s.slope += 0.16f * slope;
  // -- Lines of age
  if (look_.wrinkles > 0) {
    const float depth = lines(p);
    if (depth > 0.01f) {
      constexpr float e = 0.0004f;
      const Vec3f fall(lines(p + Vec3f(e, 0, 0)) - depth, lines(p + Vec3f(0, e, 0)) - depth, 0);
      s.slope -= look_.wrinkles * 0.0009f / e * fall;
      albedo = albedo.cwiseProduct(
          mix(Vec3f(1, 1, 1), Vec3f(0.70f, 0.58f, 0.55f), 0.75f * look_.wrinkles * std::min(1.0f, depth)));
    }
  }
  albedo *= 1 + 0.07f * pores;
  s.albedo = albedo.cwiseMax(0.01f);
  return s;
}

Surface Skin::eyeball(const Vec3f& p, const Vec3f& centre) const {
  Surface s;
  const Vec3f d = (p - centre).normalized();
  const float angle = std::acos(std::clamp(d.z(), -1.0f, 1.0f)), round = std::atan2(d.y(), d.x());
  const float iris = std::asin(std::min(0.9f, 0.0059f * unit_ / eye_radius_)), pupil = 0.42f * iris;
  const float veins = fractal_noise(Vec3f(d.x() * 26, d.y() * 40, d.z() * 8), 3, seed_ + 91);
  Vec3f white(0.60f, 0.56f, 0.525f);
  const float corner = smoothstep(0.55f, 1.0f, angle);
  white = white.cwiseProduct(Vec3f(1, 1 - 0.22f * corner, 1 - 0.22f * corner));
  white = white.cwiseProduct(
      mix(Vec3f(1, 1, 1), Vec3f(1, 0.72f, 0.68f), corner * smoothstep(0.1f, 0.35f, veins)));
  const float streak = noise(Vec3f(std::cos(round) * 9, std::sin(round) * 9, angle * 5), seed_ + 92) +
                       0.6f * noise(Vec3f(std::cos(round) * 20, std::sin(round) * 20, angle * 9), seed_ + 93);
  const float t = (angle - pupil) / (iris - pupil);
  Vec3f colour = mix(look_.iris_inner, look_.iris_outer, smoothstep(0.15f, 0.6f, t + 0.12f * streak));
  colour *= 1 + 0.45f * streak;
  colour *= 1 - 0.75f * smoothstep(0.72f, 1.0f, t);  // limbus
  const Vec3f inner =
      mix(Vec3f(0.006f, 0.006f, 0.007f), Vec3f(colour.cwiseMax(0.004f)), smoothstep(-0.05f, 0.06f, t));
  s.albedo = mix(inner, white, smoothstep(0.95f, 1.12f, angle / iris));
  s.roughness = 0.10f;
  s.f0 = 0.03f;
  s.coat = 1;
  return s;
}

Surface Skin::at(const Vec3f& p, HeadPart part) const {
  Surface s;
  switch (part) {
    case HeadPart::left_eyeball:
      return eyeball(p, eyes_[0]);
    case HeadPart::right_eyeball:
      return eyeball(p, eyes_[1]);
    case HeadPart::teeth: {
      const float stain = noise(p * 300.0f, seed_ + 95);
      s.albedo = Vec3f(0.78f, 0.72f, 0.61f) * (1 + 0.06f * stain);
      s.roughness = 0.22f;
      s.f0 = 0.045f;
      return s;
    }
    case HeadPart::gums_tongue:
      s.albedo = Vec3f(0.40f, 0.12f, 0.11f) * (1 + 0.15f * noise(p * 400.0f, seed_ + 96));
      s.roughness = 0.30f;
      s.f0 = 0.03f;
      return s;
    case HeadPart::mouth_socket:
      if (const float lips = lip(p); lips > 0.5f && p.z() > landmarks_[60].z() - 0.002f) return face(p);
      s.albedo = Vec3f(0.22f, 0.06f, 0.055f);
      s.roughness = 0.4f;
      return s;
    case HeadPart::left_eye_socket:
    case HeadPart::right_eye_socket:
      s.albedo = Vec3f(0.42f, 0.20f, 0.16f);
      s.roughness = 0.3f;
      return s;
    default:
      return face(p);
  }
}

}  // namespace likeness
