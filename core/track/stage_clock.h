// Seconds per stage of long work: wall time, and CPU time over all threads, which a busy computer hardly
// changes.
#pragma once

#include <chrono>
#include <ctime>
#include <string>
#include <vector>

namespace likeness {

struct StageSeconds {
  std::string stage;
  double wall_s = 0, cpu_s = 0;
};

class StageClock {
 public:
  // seconds: where finished stages go, or null.
  explicit StageClock(std::vector<StageSeconds>* seconds) : seconds_(seconds) {}

  // The time since the last call, or since the beginning, belongs to this stage.
  void lap(const std::string& stage) {
    const double wall = wall_now(), cpu = cpu_now();
    if (seconds_) seconds_->push_back({stage, wall - wall_, cpu - cpu_});
    wall_ = wall, cpu_ = cpu;
  }

 private:
  static double wall_now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }
  static double cpu_now() {
    timespec t{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }

  std::vector<StageSeconds>* seconds_;
  double wall_ = wall_now(), cpu_ = cpu_now();
};

}  // namespace likeness
