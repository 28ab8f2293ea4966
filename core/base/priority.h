// Threads of low priority, which yield the processor to others: long work beside a window that must stay
// responsive.
#pragma once

#include <memory>

namespace likeness {

// Applies to this thread from now on, and to those it starts. Does nothing where the system does not allow
// it.
void lower_thread_priority();

// While alive, the worker threads of the loops of core/base/parallel.h are given low priority, which they
// keep for good. The thread that calls a loop also works in it, and keeps its own priority.
class LowPriorityLoops {
 public:
  LowPriorityLoops();
  ~LowPriorityLoops();
  LowPriorityLoops(const LowPriorityLoops&) = delete;
  LowPriorityLoops& operator=(const LowPriorityLoops&) = delete;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace likeness
