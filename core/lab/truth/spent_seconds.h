// What a stage cost: by the clock, and in processor time of this process, its threads and the programs it has
// waited for, which says the same on a machine that is busy besides.
#pragma once

#include <sys/resource.h>

#include "core/base/work_clock.h"

namespace likeness {

struct SpentSeconds {
  double wall = 0, processor = 0;
};

// Since a fixed moment.
inline SpentSeconds spent_seconds() {
  SpentSeconds spent{clock_seconds(WorkClock::wall), 0};
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    ::getrusage(who, &usage);
    for (const timeval& t : {usage.ru_utime, usage.ru_stime})
      spent.processor += double(t.tv_sec) + 1e-6 * double(t.tv_usec);
  }
  return spent;
}
inline SpentSeconds spent_since(const SpentSeconds& start) {
  const SpentSeconds now = spent_seconds();
  return {now.wall - start.wall, now.processor - start.processor};
}

}  // namespace likeness
