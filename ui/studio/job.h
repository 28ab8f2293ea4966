// Long work on a thread of its own: progress, an honest time left, a pause, a stop, and how it ended.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "core/base/progress.h"
#include "core/base/result.h"

namespace likeness::ui {

enum class JobState { none, running, stopping, done, failed, stopped };

struct JobStatus {
  JobState state = JobState::none;
  double fraction = 0;
  std::string stage, text;   // of the progress
  double seconds = 0;        // since the start, without pauses
  bool paused = false;       // asked to wait
  bool waiting = false;      // and it does
  double seconds_left = -1;  // of the innermost stage's rate; negative: not known yet
  std::string outcome;       // of finished work, in words
  std::optional<Error> error;
};
bool is_working(const JobStatus& status);

// Time left of work whose fraction rose from `from` at its start to `now` in `seconds`; negative while the
// rate has not settled (less than three seconds, or hardly any progress).
double estimate_left(double from, double now, double to, double seconds);

class Job {
 public:
  using Work = std::function<Result<std::string>(const Progress&, std::stop_token)>;

  // wake: called from the job's thread, once a second and at the end: a frame of the window costs what it
  // shows.
  Job(Work work, std::function<void()> wake);
  ~Job();  // stops and waits

  JobStatus status() const;
  void stop();
  // The work waits where it next reports, with all it has in memory, until it goes on or is stopped.
  void pause();
  void go_on();

 private:
  using Clock = std::chrono::steady_clock;
  double worked_s() const;  // under the lock
  void wait_while_paused(std::unique_lock<std::mutex>& lock, const std::stop_token& stop);

  const std::function<void()> wake_;
  mutable std::mutex mutex_;
  std::condition_variable_any paused_changed_;
  JobStatus status_;
  Clock::time_point start_ = Clock::now(), last_wake_ = start_;
  std::optional<Clock::time_point> waiting_since_;
  double waited_s_ = 0;
  std::jthread thread_;
};

}  // namespace likeness::ui
