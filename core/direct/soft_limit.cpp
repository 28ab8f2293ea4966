// Two comparisons a side.
#include "core/direct/soft_limit.h"

#include <algorithm>

namespace likeness {

float softly_limited(float began, float wanted, const ValueRange& limits, bool insists) {
  if (insists || !(limits.low < limits.high)) return wanted;
  const float near = 0.01f * (limits.high - limits.low);  // of a limit: a drag that begins there was stopped
  if (began < limits.high - near) wanted = std::min(wanted, limits.high);
  if (began > limits.low + near) wanted = std::max(wanted, limits.low);
  return wanted;
}

}  // namespace likeness
