// See job.h.
#include "ui/job.h"

#include <exception>
#include <utility>

namespace likeness::ui {

bool is_working(const JobStatus& status) {
  return status.state == JobState::running || status.state == JobState::stopping;
}

double estimate_left(double from, double now, double to, double seconds) {
  constexpr double kSettled_s = 3, kLeastShare = 0.03;
  if (seconds < kSettled_s || to <= from || now - from < kLeastShare * (to - from)) return -1;
  return seconds * (to - now) / (now - from);
}

Job::Job(Work work, std::function<void()> wake) {
  status_.state = JobState::running;
  thread_ = std::jthread([this, work = std::move(work), wake = std::move(wake)](std::stop_token stop) {
    const Progress progress([&](const ProgressReport& report) {
      const auto now = Clock::now();
      const std::lock_guard lock(mutex_);
      status_.fraction = report.fraction;
      status_.stage = report.stage;
      if (!report.text.empty()) status_.text = report.text;
      status_.seconds_left =
          estimate_left(0, report.fraction, 1, std::chrono::duration<double>(now - start_).count());
      if (now - last_wake_ < std::chrono::seconds(1)) return;
      last_wake_ = now;
      wake();
    });
    const Result<std::string> outcome = [&]() -> Result<std::string> {
      try {
        return work(progress, stop);
      } catch (const std::exception& e) {  // memory ran out, usually
        return Error{ErrorCode::failed, std::string("The work broke off: ") + e.what() + ".",
                     "Close other programs and try again; what was finished is kept.", ""};
      }
    }();
    {
      const std::lock_guard lock(mutex_);
      status_.seconds = std::chrono::duration<double>(Clock::now() - start_).count();
      status_.seconds_left = -1;
      if (outcome) {
        status_.state = JobState::done;
        status_.fraction = 1;
        status_.outcome = *outcome;
      } else {
        status_.state = outcome.error().code == ErrorCode::cancelled ? JobState::stopped : JobState::failed;
        status_.error = outcome.error();
      }
    }
    wake();
  });
}

Job::~Job() { thread_.request_stop(); }

JobStatus Job::status() const {
  const std::lock_guard lock(mutex_);
  JobStatus status = status_;
  if (is_working(status)) status.seconds = std::chrono::duration<double>(Clock::now() - start_).count();
  return status;
}

void Job::stop() {
  {
    const std::lock_guard lock(mutex_);
    if (status_.state == JobState::running) status_.state = JobState::stopping;
  }
  thread_.request_stop();
}

}  // namespace likeness::ui
