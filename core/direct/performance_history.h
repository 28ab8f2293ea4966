// Undo and redo of a performance: a history of values, of which the oldest are dropped when they take too
// much memory.
#pragma once

#include <cstddef>
#include <deque>
#include <string>

#include "core/direct/performance.h"

namespace likeness {

class PerformanceHistory {
 public:
  // budget_bytes: of all kept states together; the current one is always kept.
  explicit PerformanceHistory(Performance start, std::size_t budget_bytes = std::size_t(64) << 20);

  const Performance& present() const { return states_[at_].performance; }

  // what: names the step, for a menu ("Undo: move keys"). A step with the name and the number of the one
  // before it replaces that (a slider still held down); number 0 never does. Undone steps are dropped.
  void record(Performance performance, std::string what, std::size_t gesture = 0);

  bool can_undo() const { return at_ > 0; }
  bool can_redo() const { return at_ + 1 < states_.size(); }
  const std::string& undo_name() const;  // of the step that would be undone; precondition: can_undo()
  const std::string& redo_name() const;
  void undo();  // does nothing if there is nothing to undo
  void redo();

  std::size_t bytes() const { return bytes_; }

 private:
  struct State {
    Performance performance;
    std::string what;
    std::size_t gesture = 0, bytes = 0;
  };
  void append(State state);

  std::deque<State> states_;
  std::size_t at_ = 0, bytes_ = 0, budget_bytes_;
};

}  // namespace likeness
