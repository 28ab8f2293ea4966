// The clock of the measurements. One thread is timed by its own processor time, which the load of others does
// not stretch; several threads can only be timed by the wall.
#pragma once

#include <ctime>

namespace likeness {

class Stopwatch {
 public:
  explicit Stopwatch(int threads) : clock_(threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC) {
    start_ = now();
  }
  double seconds() const { return now() - start_; }

 private:
  double now() const {
    timespec t{};
    ::clock_gettime(clock_, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
  }
  clockid_t clock_;
  double start_ = 0;
};

}  // namespace likeness
