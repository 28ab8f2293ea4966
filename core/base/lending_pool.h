// Scratch memory lent to a piece of work and kept for the next: fresh memory is slow to touch. Not one per
// thread: a thread that waits for others inside a loop may begin another piece of work meanwhile.
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace likeness {

template <class T>
class LendingPool {
 public:
  // As its last user left it, or new.
  std::unique_ptr<T> take() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return std::make_unique<T>();
    auto lent = std::move(free_.back());
    free_.pop_back();
    return lent;
  }
  void give(std::unique_ptr<T> lent) {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(lent));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> free_;
};

}  // namespace likeness
