// See place_picture.h.
#include "core/capture/place_picture.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

#include "core/image/bilinear.h"

namespace likeness {

Image8 placed_picture(const Image8& from, const Placed& at) {
  Image8 out(from.width, from.height, 1);
  const double cx = 0.5 * (from.width - 1), cy = 0.5 * (from.height - 1);
  for (int y = 0; y < from.height; ++y)
    for (int x = 0; x < from.width; ++x) {
      const double u = std::clamp(cx + (x - cx - at.x) / (1 + at.scale), 0.0, double(from.width - 1)),
                   v = std::clamp(cy + (y - cy - at.y) / (1 + at.scale), 0.0, double(from.height - 1));
      *out.at(x, y) = std::uint8_t(std::lround(bilinear(from, u + 0.5, v + 0.5)));
    }
  return out;
}

Placed place_in(const Image8& a, const Image8& b, const std::vector<std::uint8_t>& free) {
  Placed at;
  const int w = a.width, h = a.height;
  const double cx = 0.5 * (w - 1), cy = 0.5 * (h - 1);
  for (int iteration = 0; iteration < 15; ++iteration) {
    const Image8 now = placed_picture(a, at);
    double sa = 0, sb = 0, saa = 0, sbb = 0, n = 1e-9;
    for (std::size_t p = 0; p < free.size(); ++p) {
      if (!free[p]) continue;
      sa += now.data[p], sb += b.data[p], saa += double(now.data[p]) * now.data[p],
          sbb += double(b.data[p]) * b.data[p], ++n;
    }
    const double gain = std::clamp(
        std::sqrt((sbb / n - sb / n * (sb / n) + 4) / (saa / n - sa / n * (sa / n) + 4)), 0.5, 2.0);
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (int y = 1; y + 1 < h; ++y)
      for (int x = 1; x + 1 < w; ++x) {
        if (!free[std::size_t(y) * w + x]) continue;
        const double gx = 0.5 * gain * (*now.at(x + 1, y) - *now.at(x - 1, y)),
                     gy = 0.5 * gain * (*now.at(x, y + 1) - *now.at(x, y - 1));
        const Eigen::Vector3d row(gx, gy, gx * (x - cx) + gy * (y - cy));
        const double off = (*b.at(x, y) - sb / n) - gain * (*now.at(x, y) - sa / n);
        const double trust = 1 / (1 + off * off / 144);  // what has moved counts little
        right -= trust * off * row;
        normal += trust * row * row.transpose();
      }
    normal.diagonal() += 1e-6 * normal.diagonal() + Eigen::Vector3d::Constant(1e-3);
    const Eigen::Vector3d step = normal.ldlt().solve(right);
    at.x += std::clamp(step[0], -1.0, 1.0), at.y += std::clamp(step[1], -1.0, 1.0);
    at.scale = std::clamp(at.scale + std::clamp(step[2], -0.02, 0.02), -0.3, 0.3);
  }
  return at;
}

}  // namespace likeness
