// Procedural paints of the room. Lengths in metres, so that the texture of a large patch is not coarser than
// that of a small one; features of 5 to 60 mm, which at the demo's distances suit a feature detector.
#include <algorithm>
#include <array>
#include <cmath>

#include "core/synth/noise.h"
#include "core/synth/room.h"

namespace likeness {
namespace {

Vec3f palette(std::uint32_t h) {
  static const std::array<Vec3f, 10> colours = {
      linear_colour(0.72f, 0.24f, 0.18f), linear_colour(0.16f, 0.30f, 0.46f),
      linear_colour(0.86f, 0.68f, 0.30f), linear_colour(0.20f, 0.42f, 0.34f),
      linear_colour(0.88f, 0.84f, 0.76f), linear_colour(0.14f, 0.14f, 0.17f),
      linear_colour(0.55f, 0.32f, 0.44f), linear_colour(0.36f, 0.55f, 0.62f),
      linear_colour(0.78f, 0.46f, 0.26f), linear_colour(0.45f, 0.50f, 0.30f)};
  return colours[hash_u32(h) % colours.size()];
}

Vec3f paint_plaster(const RoomPatch& p, const Vec3f& m) {
  const float broad = fractal_noise(m * 2.2f, 3, p.seed), fine = fractal_noise(m * 38.0f, 3, p.seed + 9);
  const float blots = smoothstep(0.22f, 0.5f, noise(m * 14.0f, p.seed + 21));
  Vec3f c = p.colour * (1 + 0.10f * broad + 0.12f * fine - 0.10f * blots);
  // Hand-stamped leaves, no two alike.
  const float cell = 0.085f;
  const int x = int(std::floor(m.x() / cell)), y = int(std::floor(m.y() / cell));
  if (hash_unit(x, y, 1, p.seed) < 0.7f) {
    const float dx = m.x() / cell - float(x) - 0.3f - 0.4f * hash_unit(x, y, 2, p.seed);
    const float dy = m.y() / cell - float(y) - 0.3f - 0.4f * hash_unit(x, y, 3, p.seed);
    const float angle = 6.2831853f * hash_unit(x, y, 4, p.seed),
                size = 0.14f + 0.12f * hash_unit(x, y, 5, p.seed);
    const float a = std::cos(angle) * dx + std::sin(angle) * dy,
                b = -std::sin(angle) * dx + std::cos(angle) * dy;
    const float leaf = a * a / (size * size) + b * b / (0.16f * size * size);
    if (leaf < 1 && std::abs(b) > 0.008f) c *= hash_unit(x, y, 6, p.seed) < 0.5f ? 0.55f : 1.45f;
  }
  return c;
}

Vec3f paint_brick(const RoomPatch& p, const Vec3f& m) {
  const float height = 0.078f, length = 0.23f, joint = 0.006f;
  const float wobble = 0.0025f * noise(m * 40.0f, p.seed);
  const int row = int(std::floor(m.y() / height));
  const float x = m.x() + (row & 1 ? 0.5f : 0) * length + 0.03f * hash_unit(row, 3, 0, p.seed);
  const int column = int(std::floor(x / length));
  const float dx = std::min(x - length * float(column), length * float(column + 1) - x) + wobble;
  const float dy = std::min(m.y() - height * float(row), height * float(row + 1) - m.y()) + wobble;
  const float grain = fractal_noise(m * 90.0f, 3, p.seed + 5), stain = noise(m * 17.0f, p.seed + 6);
  if (std::min(dx, dy) < joint) return p.other * (1 + 0.15f * grain);
  const float tone = hash_unit(column, row, 1, p.seed), hue = hash_unit(column, row, 2, p.seed);
  Vec3f c = mix(p.colour, Vec3f(p.colour.cwiseProduct(Vec3f(0.75f, 0.8f, 0.95f))), hue);
  return c * (0.6f + 0.7f * tone + 0.22f * grain + 0.2f * stain);
}

Vec3f paint_wood(const RoomPatch& p, const Vec3f& m, float plank) {
  float x = m.x(), shade = 1;
  Vec3f q = m;
  if (plank > 0) {
    const int row = int(std::floor(m.y() / plank));
    const float length = 0.7f, along = x + 0.37f * hash_unit(row, 0, 0, p.seed);
    const int board = int(std::floor(along / length));
    shade = 0.72f + 0.5f * hash_unit(row, board, 1, p.seed);
    const float gap = std::min(m.y() - plank * float(row), along - length * float(board));
    if (gap < 0.003f) shade *= 0.35f;
    q += Vec3f(3.1f * float(row), 0, float(board));
  }
  const float rings = noise(Vec3f(q.x() * 2.5f, q.y() * 42.0f, q.z()), p.seed);
  const float fibre = noise(Vec3f(q.x() * 18.0f, q.y() * 260.0f, q.z()), p.seed + 1);
  const float knots = smoothstep(0.45f, 0.62f, noise(Vec3f(q.x() * 7.0f, q.y() * 13.0f, q.z()), p.seed + 2));
  return p.colour * (shade * (1 + 0.28f * rings + 0.14f * fibre - 0.45f * knots));
}

Vec3f paint_spine(const RoomPatch& p, float s, float t, const Vec3f& m) {
  const float wear = fractal_noise(m * 60.0f, 2, p.seed);
  Vec3f c = p.colour * (1 + 0.18f * wear);
  const float band = 0.08f + 0.1f * hash_unit(p.seed + 1), title = 0.3f + 0.2f * hash_unit(p.seed + 2);
  if (std::abs(t - band) < 0.016f || std::abs(t - (1 - band)) < 0.016f) c = p.other;
  if (hash_unit(p.seed + 3) < 0.5f && std::abs(t - 0.5f * band) < 0.008f) c = p.other;
  // Letters of the title run up the spine.
  if (t > title && t < title + 0.42f && std::abs(s - 0.5f) < 0.24f) {
    const int letter = int((t - title) / 0.035f);
    const float in_letter = (t - title) / 0.035f - float(letter);
    if (hash_unit(letter, 5, 0, p.seed) < 0.84f && in_letter < 0.72f &&
        hash_unit(letter, int(s * 9), int(in_letter * 3), p.seed) < 0.72f) {
      c = p.other;
    }
  }
  const float round = 1 - 0.55f * std::pow(std::abs(2 * s - 1), 3.0f);
  return c * round;
}

Vec3f paint_poster(const RoomPatch& p, float s, float t) {
  const float aspect = p.v.norm() / p.u.norm();
  const float border = 0.05f;
  if (s < border || s > 1 - border || t < border / aspect || t > 1 - border / aspect) return p.other;
  Vec3f c = palette(p.seed);
  RandomStream random{p.seed * 7919u + 5};
  for (int i = 0; i < 16; ++i) {
    const int kind = random.below(4);
    const float x = random.unit(), y = random.unit() * aspect, size = random.between(0.04f, 0.26f);
    const float angle = random.between(0, 3.14f);
    const Vec3f colour = palette(p.seed + 100 + std::uint32_t(random.below(1000)));
    const float dx = s - x, dy = t * aspect - y;
    const float a = std::cos(angle) * dx + std::sin(angle) * dy,
                b = -std::sin(angle) * dx + std::cos(angle) * dy;
    bool inside = false;
    if (kind == 0) inside = dx * dx + dy * dy < size * size;
    if (kind == 1) inside = std::abs(a) < size && std::abs(b) < 0.5f * size;
    if (kind == 2) inside = std::abs(std::sqrt(dx * dx + dy * dy) - size) < 0.22f * size;
    if (kind == 3) inside = b > 0 && b < size && std::abs(a) < 0.6f * (size - b);
    if (inside) c = colour;
  }
  // A few lines of text at the foot.
  if (t < 0.22f) {
    const int line = int(t / 0.036f), word = int(s / 0.06f);
    const float in_line = t / 0.036f - float(line);
    if (in_line > 0.35f && in_line < 0.8f && hash_unit(line, word, 0, p.seed) < 0.75f &&
        hash_unit(line, int(s / 0.011f), 1, p.seed) < 0.7f) {
      c = 0.15f * c + 0.85f * p.other;
    }
  }
  return c * (1 + 0.08f * noise(Vec3f(s * 40, t * 40, 0), p.seed));
}

Vec3f paint_landscape(const RoomPatch& p, float s, float t) {
  const float aspect = p.v.norm() / p.u.norm(), border = 0.06f;
  if (s < border || s > 1 - border || t < border / aspect || t > 1 - border / aspect) {
    return p.other * (1 + 0.3f * noise(Vec3f(s * 60, t * 60, 1), p.seed));
  }
  Vec3f c = mix(Vec3f(0.75f, 0.55f, 0.38f), Vec3f(0.16f, 0.28f, 0.5f), t);
  c *= 1 + 0.25f * fractal_noise(Vec3f(s * 5, t * 14, 0), 4, p.seed);
  for (int ridge = 0; ridge < 4; ++ridge) {
    const float f = float(ridge);
    const float top =
        0.72f - 0.17f * f + 0.13f * fractal_noise(Vec3f(s * (3 + 2 * f), f * 7, 0), 4, p.seed + 40);
    if (t < top) {
      const float detail = fractal_noise(Vec3f(s * 26, t * 32, f), 4, p.seed + 50);
      c = mix(Vec3f(0.28f, 0.34f, 0.42f), Vec3f(0.07f, 0.11f, 0.04f), f / 3) * (1 + 0.8f * detail);
    }
  }
  return c;
}

Vec3f paint_outdoors(const RoomPatch& p, float s, float t) {
  const Vec3f sky = mix(Vec3f(0.95f, 0.95f, 0.92f), Vec3f(0.55f, 0.72f, 0.95f), t);
  Vec3f c = sky * (1 + 0.10f * fractal_noise(Vec3f(s * 4, t * 7, 0), 4, p.seed));
  const float crown = 0.55f + 0.25f * fractal_noise(Vec3f(s * 4, 0, 3), 4, p.seed + 1);
  if (t < crown) {
    const float leaves = fractal_noise(Vec3f(s * 22, t * 22, 0), 4, p.seed + 2);
    c = Vec3f(0.20f, 0.33f, 0.10f) * (1 + 1.1f * leaves);
  }
  return c;
}

Vec3f paint_cloth(const RoomPatch& p, const Vec3f& m) {
  const float stripe = std::sin(m.x() * 90.0f + 1.5f * noise(m * 6.0f, p.seed));
  const float weave = noise(Vec3f(m.x() * 300, m.y() * 300, 0), p.seed + 1);
  const int cx = int(std::floor(m.x() / 0.075f)), cy = int(std::floor(m.y() / 0.075f));
  const float ox = m.x() / 0.075f - float(cx) - 0.5f, oy = m.y() / 0.075f - float(cy) - 0.5f;
  const float motif = std::abs(ox) + std::abs(oy);
  Vec3f c = p.colour;
  if (motif < 0.34f && ((cx + cy) & 1)) c = p.other;
  if (motif < 0.16f) c = 0.5f * (p.colour + p.other);
  return c * (1 + 0.12f * stripe + 0.12f * weave + 0.2f * noise(m * 11.0f, p.seed + 2));
}

Vec3f paint_leaf(const RoomPatch& p, float s, float t) {
  const float rib = std::abs(s - 0.5f), veins = std::sin(60 * (t + 0.8f * rib));
  const float edge = smoothstep(0.3f, 0.5f, rib);
  Vec3f c = p.colour * (1 + 0.22f * veins - 0.3f * edge + 0.25f * noise(Vec3f(s * 8, t * 20, 0), p.seed));
  if (rib < 0.03f) c = p.other;
  return c;
}

}  // namespace

Vec3f paint_patch(const RoomPatch& patch, float s, float t) {
  const Vec3f m(s * patch.u.norm(), t * patch.v.norm(), 0.37f * float(patch.seed % 97));
  switch (patch.paint) {
    case RoomPaint::plaster:
      return paint_plaster(patch, m);
    case RoomPaint::brick:
      return paint_brick(patch, m);
    case RoomPaint::wood:
      return paint_wood(patch, m, 0);
    case RoomPaint::floor:
      return paint_wood(patch, m, 0.11f);
    case RoomPaint::spine:
      return paint_spine(patch, s, t, m);
    case RoomPaint::cover:
      return patch.colour * (1 + 0.15f * fractal_noise(m * 50.0f, 2, patch.seed));
    case RoomPaint::poster:
      return paint_poster(patch, s, t);
    case RoomPaint::landscape:
      return paint_landscape(patch, s, t);
    case RoomPaint::outdoors:
      return paint_outdoors(patch, s, t);
    case RoomPaint::cloth:
      return paint_cloth(patch, m);
    case RoomPaint::leaf:
      return paint_leaf(patch, s, t);
    case RoomPaint::blank:
      return patch.colour;
    case RoomPaint::plain:
      break;
  }
  return patch.colour * (1 + 0.06f * noise(m * 70.0f, patch.seed));
}

}  // namespace likeness
