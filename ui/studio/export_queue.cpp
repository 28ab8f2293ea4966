// See export_queue.h.
#include "ui/studio/export_queue.h"

#include <algorithm>
#include <utility>

namespace likeness::ui {

void ExportQueue::add(std::filesystem::path out, Job::Work work) {
  entries_.push_back({next_number_++, std::move(out), std::move(work), {}});
  tick();
}

ExportQueue::Entry* ExportQueue::find(int number) {
  const auto found = std::ranges::find(entries_, number, &Entry::number);
  return found == entries_.end() ? nullptr : &*found;
}

void ExportQueue::stop(int number) {
  Entry* entry = find(number);
  if (!entry) return;
  if (number == running_) {
    job_->stop();
  } else if (entry->status.state == JobState::none) {
    entry->status.state = JobState::stopped;
  }
}

void ExportQueue::stop_all() {
  for (Entry& entry : entries_) stop(entry.number);
}

void ExportQueue::retry(int number) {
  Entry* entry = find(number);
  if (!entry || number == running_) return;
  if (entry->status.state != JobState::failed && entry->status.state != JobState::stopped) return;
  entry->status = {};
  std::rotate(entries_.begin() + (entry - entries_.data()), entries_.begin() + (entry - entries_.data()) + 1,
              entries_.end());
  tick();
}

void ExportQueue::forget(int number) {
  if (number == running_) return;
  std::erase_if(entries_, [&](const Entry& e) { return e.number == number; });
  if (number != last_number_) return;
  last_ = {};
  last_number_ = -1;
}

void ExportQueue::tick() {
  if (job_) {
    Entry* entry = find(running_);
    entry->status = job_->status();
    if (ui::is_working(entry->status)) return;
    last_ = entry->status;
    last_number_ = entry->number;
    if (last_.state == JobState::done) last_written_ = entry->out;
    job_.reset();
    running_ = -1;
  }
  const auto waiting =
      std::ranges::find_if(entries_, [](const Entry& e) { return e.status.state == JobState::none; });
  if (waiting == entries_.end()) return;
  running_ = waiting->number;
  job_ = std::make_unique<Job>(waiting->work, wake_);
  waiting->status = job_->status();
}

std::unique_ptr<Job> ExportQueue::clear() {
  entries_.clear();
  running_ = -1;
  last_ = {};
  last_number_ = -1;
  last_written_.clear();
  return std::exchange(job_, nullptr);
}

std::vector<ExportItem> ExportQueue::items() const {
  std::vector<ExportItem> items;
  for (const Entry& entry : entries_)
    items.push_back({entry.number, entry.out, entry.number == running_ ? job_->status() : entry.status});
  return items;
}

JobStatus ExportQueue::status() const { return job_ ? job_->status() : last_; }

bool ExportQueue::is_working() const {
  return std::ranges::any_of(items(), [](const ExportItem& item) {
    return item.status.state == JobState::none || ui::is_working(item.status);
  });
}

bool ExportQueue::holds(const std::filesystem::path& out) const {
  return std::ranges::any_of(entries_, [&](const Entry& entry) { return entry.out == out; });
}

}  // namespace likeness::ui
