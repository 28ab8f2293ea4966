// Trilinear blend of random slopes at lattice points (gradient noise), with a quintic fade.
#include "core/synth/noise.h"

namespace likeness {
namespace {

// Dot product of the offset with one of twelve edge directions chosen by the cell's hash.
inline float slope(std::uint32_t h, float x, float y, float z) {
  const std::uint32_t k = h & 15;
  const float u = k < 8 ? x : y, v = k < 4 ? y : (k == 12 || k == 14 ? x : z);
  return ((k & 1) ? -u : u) + ((k & 2) ? -v : v);
}

inline float fade(float t) { return t * t * t * (t * (t * 6 - 15) + 10); }

}  // namespace

float noise(const Vec3f& p, std::uint32_t seed) {
  const float fx = std::floor(p.x()), fy = std::floor(p.y()), fz = std::floor(p.z());
  const int ix = int(fx), iy = int(fy), iz = int(fz);
  const float x = p.x() - fx, y = p.y() - fy, z = p.z() - fz;
  const float u = fade(x), v = fade(y), w = fade(z);
  float planes[2];
  for (int dz = 0; dz < 2; ++dz) {
    float rows[2];
    for (int dy = 0; dy < 2; ++dy) {
      const float a = slope(hash_cell(ix, iy + dy, iz + dz, seed), x, y - float(dy), z - float(dz));
      const float b = slope(hash_cell(ix + 1, iy + dy, iz + dz, seed), x - 1, y - float(dy), z - float(dz));
      rows[dy] = a + u * (b - a);
    }
    planes[dz] = rows[0] + v * (rows[1] - rows[0]);
  }
  return planes[0] + w * (planes[1] - planes[0]);
}

float fractal_noise(const Vec3f& p, int octaves, std::uint32_t seed, float gain) {
  float sum = 0, height = 1, total = 0;
  Vec3f q = p;
  for (int i = 0; i < octaves; ++i) {
    sum += height * noise(q, seed + std::uint32_t(i));
    total += height;
    height *= gain;
    q = q * 2.0f + Vec3f(17.3f, 9.1f, 4.7f);
  }
  return sum / total;
}

}  // namespace likeness
