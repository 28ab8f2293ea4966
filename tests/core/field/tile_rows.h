// Rows of a tile's samples, as the kernels read and write them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/field/field_kernels.h"

namespace likeness {

// (count, kTile) floats, zero at first.
struct TileRows {
  AlignedFloats memory;
  float* data;
  explicit TileRows(std::size_t count) : data(memory.reserve(count * kTile)) {
    std::fill(data, data + count * kTile, 0.0f);
  }
  // As pairs of bfloat16.
  std::uint32_t* words() const { return reinterpret_cast<std::uint32_t*>(data); }
};

}  // namespace likeness
