// How a clip's light falls on skin, told by how bright skin is that faces one way or another: what shades the
// places that no picture shows.
#pragma once

#include <vector>

#include "core/base/linalg.h"

namespace likeness {

// Spherical harmonics up to the second order per channel, of linear colours; a Lambertian surface under
// distant light has hardly more (Ramamoorthi & Hanrahan 2001).
struct SkinLight {
  Eigen::Matrix<float, 9, 3> coefficients = Eigen::Matrix<float, 9, 3>::Zero();
  Vec3f front = Vec3f::UnitZ();  // unit: about what normals are known
  Vec3f usual = Vec3f::Ones();   // mean linear colour, which bounds what is guessed
};

// normals: (V) unit; colours: (V) linear; weights: (V) 0 = unknown, or no skin. Brows, lips and stubble are
// outliers. With too few places, the same light from everywhere.
SkinLight fit_light(const std::vector<Vec3f>& normals, const std::vector<Vec3f>& colours,
                    const std::vector<float>& weights);

// Linear colour of average skin with this normal; normals that face away from `front` are shaded as the
// nearest ones that do not, as nothing tells what light there is behind.
Vec3f shade(const SkinLight& light, const Vec3f& normal);

}  // namespace likeness
