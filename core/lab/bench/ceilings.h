// What a number of threads of this machine can do at most, all busy with the same thing: the denominators of
// every "fraction of its floor".
#pragma once

#include <cstddef>
#include <vector>

namespace likeness {

// Random accesses to 8-byte entries (two floats) of a table; 1e6 a second, of all threads together.
struct TableRate {
  std::size_t bytes = 0;
  double gather_mps = 0, read_modify_write_mps = 0;
};

struct Ceilings {
  int threads = 0;
  double fma_gflops = 0;          // single precision, 2 operations a multiply-add
  double bandwidth_gbs = 0;       // reading memory in order, 1e9 bytes a second
  std::vector<TableRate> tables;  // by rising size: 32 KB, 128 KB, 512 KB, 2 MB
  double bf16_gflops = 0;  // dot products of bfloat16 pairs, 4 operations each; 0 without the instruction
};

// `seconds`: for each figure; 0.01 is enough where nothing else runs.
Ceilings measure_ceilings(int threads, double seconds);
// The better of each figure: repeated measurements of a machine that others use, too.
Ceilings best_of(const Ceilings& a, const Ceilings& b);

// Seconds an access takes in a table of `bytes`, by size interpolated between the measured ones.
double gather_seconds(const Ceilings& ceilings, std::size_t bytes);
double read_modify_write_seconds(const Ceilings& ceilings, std::size_t bytes);

}  // namespace likeness
