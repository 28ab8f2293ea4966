// Threads that step back where another wants the processor: long work beside a window that is to stay lively.
#pragma once

#include <memory>

namespace likeness {

// This thread from now on, and what it starts. Where the system does not allow it, nothing happens.
void lower_thread_priority();

// While alive, the threads that lend themselves to the loops of core/base/parallel.h step back, for good. The
// thread that calls a loop works in it, too, and keeps its own priority.
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
