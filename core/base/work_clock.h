// What the seconds of long work are measured by.
#pragma once

#include <chrono>
#include <ctime>

namespace likeness {

enum class WorkClock {
  wall,
  processor  // CPU time of all threads of this process together: the same when others use the machine too
};

// Seconds since a fixed moment.
inline double clock_seconds(WorkClock clock) {
  if (clock == WorkClock::processor) return double(std::clock()) / CLOCKS_PER_SEC;
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace likeness
