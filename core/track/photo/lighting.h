// Albedo of surface points and one light for a whole clip, from grey pictures.
//
// Pictures are display-referred sRGB, grey; only here are they linearised (the luma of encoded colours is
// taken for encoded luminance). A point shows albedo * (light . basis(normal)), the light as spherical
// harmonics of second order in the world frame (Ramamoorthi and Hanrahan, SIGGRAPH 2001): it is fixed while
// heads and cameras turn. Only the product is observable; the light's mean over everything seen is 1.
#pragma once

#include <vector>

#include "core/base/linalg.h"

namespace likeness {

using ShVector = Eigen::Matrix<double, 9, 1>;

// The nine basis functions, up to constants that the light absorbs. Unit normal.
ShVector sh_basis(const Vec3d& normal);
// Light on a normal, never below a twentieth: anything darker is a shadow.
double shade(const ShVector& light, const Vec3d& normal);

double linear_of_encoded(double level);  // 0..255 -> [0, 1]
double encoded_of_linear(double value);  // [0, 1], above 1 continued -> 0..255 and more

struct LightSample {
  int point = 0;
  Vec3f normal = Vec3f::Zero();  // unit, world frame
  float linear = 0;              // [0, 1]
  float weight = 1;              // of the view: slanted ones count less
};

struct LitPoints {
  std::vector<float> albedo;  // (N) linear; 0 where the point was seen in fewer than three pictures
  std::vector<float> spread;  // (N) usual error of the prediction, encoded levels 0..255
  ShVector light = ShVector::Zero();
};

// fixed_light: null, or the light to keep (then only albedo and spread are estimated). Robust against glints,
// shadows and occlusions in some pictures; repeats bit for bit.
LitPoints light_points(const std::vector<std::vector<LightSample>>& pictures, int points,
                       const ShVector* fixed_light = nullptr);

}  // namespace likeness
