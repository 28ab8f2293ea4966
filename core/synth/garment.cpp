// Shape and stitches of the jumper.
#include "core/synth/garment.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/synth/noise.h"
#include "core/synth/shade.h"

namespace likeness {
namespace {

constexpr int kAroundBody = 160, kCollarRows = 10, kBodyRows = 44;

// Half-widths of the skin at the collar's height: across, to the front and to the back of centre z.
struct Neck {
  float centre_z = -0.018f, half_x = 0.062f, half_z = 0.062f;
};

Neck measure_neck(const std::vector<Vec3f>& skin, float y) {
  float left = 0, front = -1, back = 1;
  int found = 0;
  for (const Vec3f& p : skin) {
    if (std::abs(p.y() - y) > 0.008f) continue;
    ++found;
    left = std::max(left, std::abs(p.x()));
    front = std::max(front, p.z());
    back = std::min(back, p.z());
  }
  Neck neck;
  if (found < 12) return neck;
  neck.half_x = std::clamp(left, 0.045f, 0.075f);
  neck.half_z = std::clamp(0.5f * (front - back), 0.045f, 0.075f);
  neck.centre_z = std::clamp(0.5f * (front + back), -0.04f, 0.02f);
  return neck;
}

}  // namespace

Garment make_garment(const std::vector<Vec3f>& skin, const std::array<Vec3f, kLandmarkCount>& landmarks) {
  const float collar_y = landmarks[8].y() - 0.056f;
  const Neck neck = measure_neck(skin, collar_y + 0.006f);
  Garment garment;
  for (int row = 0; row < kCollarRows + kBodyRows; ++row) {
    for (int k = 0; k < kAroundBody; ++k) {
      const float angle =
          2 * std::numbers::pi_v<float> * float(k) / kAroundBody;  // 0 at the front, to the subject's left
      const float sine = std::sin(angle), cosine = std::cos(angle);
      float rx, rz, y, along;
      const float base_y = collar_y - 0.012f * cosine + 0.010f * sine * sine;
      if (row < kCollarRows) {  // a roll: up the inside, over the top, down the outside
        const float t = float(row) / (kCollarRows - 1), roll = std::numbers::pi_v<float> * t;
        const float thick = 0.0055f;
        rx = neck.half_x + 0.004f + thick * (1 - std::cos(roll));
        rz = neck.half_z + 0.004f + thick * (1 - std::cos(roll));
        y = base_y + 0.013f * std::sin(roll) - 0.010f * (1 - t) - 0.006f * t;
        along = -0.034f * (1 - t);
      } else {
        const float s = float(row - kCollarRows + 1) / kBodyRows, o = 1 - s;
        const float out = 1 - o * o * o, down = std::pow(s, 3.4f);
        rx = neck.half_x + 0.015f + (0.222f - neck.half_x) * out + 0.02f * down;
        rz = neck.half_z + 0.015f + (0.128f - neck.half_z) * (1 - std::pow(o, 2.2f));
        const float slope = 0.058f * sine * sine + 0.080f * cosine * cosine;
        y = base_y - 0.006f - slope * out - 0.36f * down;
        along = 0.30f * out * 0.55f + 0.42f * down;
      }
      // Shoulders are flatter than an ellipse; folds run over the cloth.
      const float square = row < kCollarRows ? 0 : std::min(1.0f, float(row - kCollarRows) / 18.0f);
      const float power = 1 - 0.16f * square;
      const float x = rx * std::copysign(std::pow(std::abs(sine), power), sine);
      const float z =
          neck.centre_z - 0.022f * square + rz * std::copysign(std::pow(std::abs(cosine), power), cosine);
      Vec3f p(x, y, z);
      const float fold = row < kCollarRows ? 0.0006f : 0.0045f * square;
      p += fold * noise(Vec3f(p.x() * 16, p.y() * 9, p.z() * 16), 301) * Vec3f(sine, 0.5f, cosine);
      garment.vertices.push_back(p);
      garment.cloth.push_back(Vec2f(angle * 0.115f, along));
    }
  }
  const int rows = kCollarRows + kBodyRows;
  for (int row = 0; row + 1 < rows; ++row) {
    for (int k = 0; k < kAroundBody; ++k) {
      const int a = row * kAroundBody + k, b = row * kAroundBody + (k + 1) % kAroundBody, c = a + kAroundBody,
                d = b + kAroundBody;
      garment.triangles.push_back(Triangle(a, c, b));
      garment.triangles.push_back(Triangle(b, c, d));
    }
  }
  return garment;
}

Surface knitted(const Vec2f& cloth, const ClothLook& look, float detail_m, std::uint32_t seed) {
  Surface s;
  s.roughness = 0.85f;
  s.f0 = 0.02f;
  const float width = 2 * std::numbers::pi_v<float> * 0.115f / 120, height = 0.0052f;  // of a stitch
  const bool collar = cloth.y() < 0;
  const float column = cloth.x() / width, row = cloth.y() / height;
  const int c = int(std::floor(column)), r = int(std::floor(row));
  const float u = column - float(c) - 0.5f;
  const Vec3f& ground = look.ground;
  Vec3f colour = ground;
  if (!collar && look.patterned) {
    // Bands of a Fair-Isle kind: a few stitch-wide motifs, mirrored, one colour per band.
    const int band = r / 9, line = r % 9, period = 6 + 2 * int(hash_u32(std::uint32_t(band) + seed) % 4);
    const int mirrored = std::abs((c % period + period) % period - period / 2);
    const bool motif = line > 0 && line < 8 && (hash_cell(mirrored, std::abs(line - 4), band, seed) & 1u);
    if (band % 3 != 2 && motif) colour = look.inks[hash_u32(std::uint32_t(band) * 7 + seed) % 3];
    if (band % 3 == 2) colour = (hash_cell(c, r, 5, seed) % 11 == 0) ? look.inks[0] : ground;
  }
  const float wool = 1 + 0.16f * noise(Vec3f(cloth.x() * 900, cloth.y() * 900, 0), seed) +
                     0.14f * noise(Vec3f(cloth.x() * 60, cloth.y() * 60, 2), seed + 1);
  // Relief: V-shaped stitches, or vertical ribs on the collar. Faded where a pixel cannot hold it.
  const float fade = std::clamp(1.6f - detail_m / 0.0022f, 0.15f, 1.0f);
  float dark;
  if (collar) {
    dark = 0.5f + 0.5f * std::cos(2 * std::numbers::pi_v<float> * column * 0.5f);
    dark = 1 - 0.55f * (1 - dark);
  } else {
    const float slanted = row + 1.1f * std::abs(u);
    const float yarn = std::abs(slanted - std::floor(slanted) - 0.5f);
    dark = 1 - 0.8f * std::max(smoothstep(0.28f, 0.5f, yarn), smoothstep(0.36f, 0.5f, std::abs(u)));
  }
  s.albedo = colour * wool * (1 - 0.62f * fade * (1 - dark));
  return s;
}

}  // namespace likeness
