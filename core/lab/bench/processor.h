// Which processor this is, and what its cores were once measured to do.
#pragma once

#include <optional>
#include <string>

#include "core/lab/bench/ceilings.h"

namespace likeness {

struct Processor {
  std::string name;             // as it calls itself
  std::string instruction_set;  // that the kernels use here
};
Processor this_processor();

// Ceilings of one core measured before on a machine with nothing else to do.
struct KnownCeilings {
  const char* processor = "";
  double fma_gflops = 0, gather_mps = 0, read_modify_write_mps = 0;  // in a table of 512 KB
};
// Of this processor's kind, where it is one of those.
std::optional<KnownCeilings> known_ceilings();

// The lowest ratio of one core's measured to its known ceilings: under 0.9 the machine is throttled, shared
// or emulated, and fractions of its floor say nothing about the kernels.
inline constexpr double kUsualShare = 0.9;
double share_of_known(const Ceilings& one_thread, const KnownCeilings& known);

}  // namespace likeness
