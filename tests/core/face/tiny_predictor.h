// A shape predictor of two small forests as the bytes of dlib's file. The landmarks lie on a circle in the
// box.
#pragma once

#include <dlib/image_processing/shape_predictor.h>

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "core/head/head_model.h"

namespace likeness {

// depth: of the trees, >= 1. With another number of parts, or comparing a pixel from 3 on, the model is
// invalid.
inline std::string tiny_predictor(int depth, int parts = kLandmarkCount, std::size_t pixel = 0) {
  dlib::matrix<float, 0, 1> shape(2 * parts), step(2 * parts);
  for (int p = 0; p < parts; ++p) {
    shape(2 * p) = 0.5f + 0.4f * std::cos(0.1f * float(p));
    shape(2 * p + 1) = 0.5f + 0.4f * std::sin(0.1f * float(p));
    step(2 * p) = 0.0078125f, step(2 * p + 1) = -0.015625f;
  }
  const int leaves = 1 << depth;
  dlib::impl::regression_tree tree;
  for (int s = 0; s < leaves - 1; ++s) tree.splits.push_back({pixel, std::size_t(s % 3), 8});
  for (int l = 0; l < leaves; ++l) tree.leaf_values.push_back(l % 2 == 0 ? step : -step);
  const std::vector<dlib::vector<float, 2>> pixels{{0.25f, 0.25f}, {0.5f, 0.75f}, {0.75f, 0.5f}};
  const dlib::shape_predictor predictor(shape, {{tree}, {tree, tree}}, {pixels, pixels});
  std::ostringstream out;
  serialize(predictor, out);
  return out.str();
}

}  // namespace likeness
