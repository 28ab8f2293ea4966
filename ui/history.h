// Undo and redo of a value: every committed change is one step. Dragging a slider is one change, committed
// when the slider is let go.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace likeness::ui {

template <class T>
class History {
 public:
  explicit History(T value = {}) : now_(value), committed_(std::move(value)) {}

  const T& value() const { return now_; }
  bool can_undo() const { return !(now_ == committed_) || !past_.empty(); }
  bool can_redo() const { return !future_.empty(); }

  // Shows a value while it is still being changed; no step yet.
  void edit(T value) { now_ = std::move(value); }
  // Makes what is shown a step, if it differs from the last one.
  void commit() {
    if (now_ == committed_) return;
    past_.push_back(std::move(committed_));
    if (past_.size() > kSteps) past_.erase(past_.begin());
    committed_ = now_;
    future_.clear();
  }
  void undo() {
    commit();
    if (past_.empty()) return;
    future_.push_back(std::move(committed_));
    committed_ = std::move(past_.back());
    past_.pop_back();
    now_ = committed_;
  }
  void redo() {
    if (future_.empty() || !(now_ == committed_)) return;
    past_.push_back(std::move(committed_));
    committed_ = std::move(future_.back());
    future_.pop_back();
    now_ = committed_;
  }

 private:
  static constexpr std::size_t kSteps = 200;
  T now_, committed_;
  std::vector<T> past_, future_;
};

}  // namespace likeness::ui
