// What the seconds of a long work are counted of.
#pragma once

#include <chrono>
#include <ctime>

namespace likeness {

enum class WorkClock {
  wall,
  processor  // worked by all threads of this process together: says the same where others use the machine too
};

// Seconds since a moment that is the same for every call.
inline double clock_seconds(WorkClock clock) {
  if (clock == WorkClock::processor) return double(std::clock()) / CLOCKS_PER_SEC;
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace likeness
