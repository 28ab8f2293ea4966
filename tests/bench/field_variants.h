// Kernels of the field beside the arrangements they replaced, each over the same data, so that one run shows
// what an arrangement brings as a ratio.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/field/field.h"
#include "core/field/field_layout.h"

namespace likeness {

struct TableCase {
  const FieldConfig& config;
  const FieldLayout& layout;
  const float* parameters;
  const float* point[3];  // (count) each, count a multiple of 64
  std::size_t count;
};

// Features of one level of two features an entry, of all samples.
enum class Read { scalar, pairs, neighbours };  // neighbours: dense levels only
void read_level(const TableCase& c, int level, Read how, float* rows);

// Features of every level, all levels for `chunk` samples at a time; rows (tiles, rows a tile, 64).
void read_levels(const TableCase& c, std::size_t chunk, float* rows);

// Gradients of one level; `mark`: touched lines with every update, or once at the end.
enum class Mark { every_update, once };
void update_level(const TableCase& c, int level, Mark mark, const float* rows, float* gradients,
                  std::uint8_t* touched);

}  // namespace likeness
