// See job.h.
#include "ui/studio/job.h"

#include <exception>
#include <utility>

#include "core/base/fault_words.h"
#include "core/base/priority.h"

namespace likeness::ui {

bool is_working(const JobStatus& status) {
  return status.state == JobState::running || status.state == JobState::stopping;
}

double estimate_left(double from, double now, double to, double seconds) {
  constexpr double kSettled_s = 3, kMinShare = 0.03;
  if (seconds < kSettled_s || to <= from || now - from < kMinShare * (to - from)) return -1;
  return seconds * (to - now) / (now - from);
}

Job::Job(Work work, std::function<void()> wake) : wake_(std::move(wake)) {
  status_.state = JobState::running;
  thread_ = std::jthread([this, work = std::move(work)](std::stop_token stop) {
    lower_thread_priority();
    const Progress progress([&](const ProgressReport& report) {
      std::unique_lock lock(mutex_);
      wait_while_paused(lock, stop);
      const auto now = Clock::now();
      status_.fraction = report.fraction;
      status_.stage = report.stage;
      if (!report.text.empty()) status_.text = report.text;
      status_.seconds_left = estimate_left(0, report.fraction, 1, worked_s());
      if (now - last_wake_ < std::chrono::seconds(1)) return;
      last_wake_ = now;
      wake_();
    });
    const Result<std::string> outcome = [&]() -> Result<std::string> {
      try {
        return work(progress, stop);
      } catch (const std::exception& e) {  // usually for want of memory
        return Error{ErrorCode::failed, "The work was interrupted: " + fault_words(e) + ".",
                     "Close other programs and try again; what was finished is kept.", ""};
      }
    }();
    {
      const std::lock_guard lock(mutex_);
      status_.seconds = worked_s();
      status_.seconds_left = -1;
      status_.paused = status_.waiting = false;
      if (outcome) {
        status_.state = JobState::done;
        status_.fraction = 1;
        status_.outcome = *outcome;
      } else {
        status_.state = outcome.error().code == ErrorCode::cancelled ? JobState::stopped : JobState::failed;
        status_.error = outcome.error();
      }
    }
    wake_();
  });
}

Job::~Job() { thread_.request_stop(); }

JobStatus Job::status() const {
  const std::lock_guard lock(mutex_);
  JobStatus status = status_;
  if (is_working(status)) status.seconds = worked_s();
  return status;
}

void Job::stop() {
  {
    const std::lock_guard lock(mutex_);
    if (status_.state == JobState::running) status_.state = JobState::stopping;
  }
  thread_.request_stop();
}

void Job::pause() {
  const std::lock_guard lock(mutex_);
  if (status_.state == JobState::running) status_.paused = true;
}

void Job::go_on() {
  {
    const std::lock_guard lock(mutex_);
    status_.paused = false;
  }
  paused_changed_.notify_all();
}

double Job::worked_s() const {
  const auto now = Clock::now();
  const double waiting = waiting_since_ ? std::chrono::duration<double>(now - *waiting_since_).count() : 0;
  return std::chrono::duration<double>(now - start_).count() - waited_s_ - waiting;
}

void Job::wait_while_paused(std::unique_lock<std::mutex>& lock, const std::stop_token& stop) {
  if (!status_.paused || stop.stop_requested()) return;
  waiting_since_ = Clock::now();
  status_.waiting = true;
  wake_();
  paused_changed_.wait(lock, stop, [this] { return !status_.paused; });
  waited_s_ += std::chrono::duration<double>(Clock::now() - *waiting_since_).count();
  waiting_since_.reset();
  status_.waiting = false;
}

}  // namespace likeness::ui
