// A list of states with a current one: see performance_history.h.
#include "core/direct/performance_history.h"

#include <utility>

#include "core/base/check.h"

namespace likeness {
namespace {

std::size_t memory_of(const Performance& performance) {
  std::size_t bytes = sizeof(Performance);
  for (const auto& [channel, keys] : performance.channels)
    bytes += 64 + channel.capacity() + sizeof(keys) + keys.capacity() * sizeof(Key);
  return bytes;
}

}  // namespace

PerformanceHistory::PerformanceHistory(Performance start, std::size_t budget_bytes)
    : budget_bytes_(budget_bytes) {
  append({std::move(start), "", 0, 0});
}

void PerformanceHistory::append(State state) {
  state.bytes = memory_of(state.performance);
  bytes_ += state.bytes;
  states_.push_back(std::move(state));
  at_ = states_.size() - 1;
  while (bytes_ > budget_bytes_ && states_.size() > 1) {
    bytes_ -= states_.front().bytes;
    states_.pop_front();
    --at_;
  }
}

void PerformanceHistory::record(Performance performance, std::string what, std::size_t gesture) {
  const bool continues =
      at_ > 0 && gesture != 0 && states_[at_].gesture == gesture && states_[at_].what == what;
  const std::size_t kept = continues ? at_ : at_ + 1;
  while (states_.size() > kept) {
    bytes_ -= states_.back().bytes;
    states_.pop_back();
  }
  append({std::move(performance), std::move(what), gesture, 0});
}

const std::string& PerformanceHistory::undo_name() const {
  LIKENESS_CHECK(can_undo(), "nothing to undo");
  return states_[at_].what;
}

const std::string& PerformanceHistory::redo_name() const {
  LIKENESS_CHECK(can_redo(), "nothing to redo");
  return states_[at_ + 1].what;
}

void PerformanceHistory::undo() {
  if (can_undo()) --at_;
}

void PerformanceHistory::redo() {
  if (can_redo()) ++at_;
}

}  // namespace likeness
