// The least work a field can be had for, counted from its configuration, and the time it takes at the
// ceilings: the floor. Only arithmetic, table reads and table updates are counted; everything else a kernel
// does is its overhead.
#pragma once

#include <cstddef>
#include <vector>

#include "core/field/field.h"
#include "core/field/precision.h"
#include "core/lab/bench/ceilings.h"

namespace likeness {

// A level's table: accesses a sample.
struct TableWork {
  std::size_t bytes = 0;
  double forward_reads = 0;   // the corners of a cell
  double training_reads = 0;  // and once more where the gradient of the point is needed
  double updates = 0;         // in training
  bool halved = false;        // features are read from copies in bfloat16 where that is asked for
};

struct FieldWork {
  double forward_flops = 0;   // a sample, two operations a multiply-add
  double training_flops = 0;  // forward, gradients of weights, gradients of those inputs that need one
  std::vector<TableWork> tables;
  // Of those operations, in the density and colour networks: dot products of bfloat16 where that is asked
  // for.
  double forward_dots = 0, training_dots = 0;
};
FieldWork field_work(const FieldConfig& config);

// Seconds a sample of all threads together: operations / peak + reads / rate + updates / rate. In bfloat16
// the two networks have the peak of dot products, and features of all levels that H does not see are read
// from half the bytes.
double forward_floor_seconds(const FieldWork& work, const Ceilings& ceilings,
                             FieldPrecision precision = FieldPrecision::exact);
double training_floor_seconds(const FieldWork& work, const Ceilings& ceilings,
                              FieldPrecision precision = FieldPrecision::exact);

}  // namespace likeness
