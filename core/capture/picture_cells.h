// How two small grey pictures differ, cell by cell. Every cell is compared apart from its own brightness and
// contrast, so that a step of the exposure, a lamp or a cloud leaves it alone.
#pragma once

#include <vector>

#include "core/image/image.h"

namespace likeness {

// One entry a cell, row by row. The motion of a cell is what its gradients make of its difference; it grows
// with the true one up to about the size of what the cell shows, and no further.
struct CellChange {
  std::vector<float> moved;     // px
  std::vector<float> gradient;  // levels per px, at most 12: how much the motion is worth
  std::vector<float> alike;     // correlation, -1..1; about 0 where one of the two shows nothing
  std::vector<float> contrast;  // levels, at most 24; of the one that shows more
};

// Pictures of one size, one channel, whose sides are multiples of `cell` px.
CellChange compare_cells(const Image8& before, const Image8& after, int cell);

// Mean motion, px, each cell's up to `most` and weighted by its gradient.
double mean_motion(const CellChange& change, double most);

}  // namespace likeness
