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

// Gradients of one level from rows (tiles, rows a tile, 64), all levels' of a tile together. Touched lines
// are marked once at the end, or with every update.
enum class Update {
  marking,   // sample by sample, marking
  in_order,  // sample by sample
  apart,     // samples of a ray apart, neighbours in x at once
  ahead      // the same, a tile's rows asked for four tiles before
};
void update_level(const TableCase& c, int level, Update how, const float* rows, float* gradients,
                  std::uint8_t* touched);

}  // namespace likeness
