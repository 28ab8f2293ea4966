// Exports one after the other: each with its progress, stopped and tried again by itself; one that fails does
// not keep the next from its turn.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "ui/studio/job.h"

namespace likeness::ui {

// As the panel shows it. JobState::none: it waits for its turn.
struct ExportItem {
  int number = 0;  // of the item, ascending
  std::filesystem::path out;
  JobStatus status;
};

class ExportQueue {
 public:
  explicit ExportQueue(std::function<void()> wake) : wake_(std::move(wake)) {}

  void add(std::filesystem::path out, Job::Work work);
  // Of a waiting or running one; it stays in the list, stopped.
  void stop(int number);
  void stop_all();
  void retry(int number);   // of a stopped or failed one: at the end of the queue
  void forget(int number);  // takes it off the list where it is not at work; files stay
  // Begins the next one. Call when woken.
  void tick();
  // Empties the list; the job at work is handed over, to be ended where waiting does no harm.
  std::unique_ptr<Job> clear();

  std::vector<ExportItem> items() const;
  // Of the running one, otherwise of the one that ended last.
  JobStatus status() const;
  std::filesystem::path last_written() const { return last_written_; }
  bool is_working() const;  // something runs or waits
  bool holds(const std::filesystem::path& out) const;

 private:
  struct Entry {
    int number = 0;
    std::filesystem::path out;
    Job::Work work;
    JobStatus status;
  };
  Entry* find(int number);

  std::function<void()> wake_;
  std::vector<Entry> entries_;
  int running_ = -1, next_number_ = 1;  // number of the entry at work
  std::unique_ptr<Job> job_;
  JobStatus last_;  // of the one that ended last, until it is forgotten
  int last_number_ = -1;
  std::filesystem::path last_written_;
};

}  // namespace likeness::ui
