// Parallel loops over oneTBB. Iterations must be independent; results must not depend on their order.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace likeness {

int hardware_threads();

// While alive, at most `threads` threads run the loops below. main() holds one.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);  // 0: all
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

int current_thread_limit();

// body(begin, end) over consecutive chunks of `grain` (the last may be shorter) that cover [0, count): the
// chunks are the same whatever the number of threads, so sums kept per chunk and added in order repeat bit
// for bit.
void parallel_ranges(std::size_t count, std::size_t grain,
                     const std::function<void(std::size_t, std::size_t)>& body);
// body(i) for every i in [0, count).
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body);

}  // namespace likeness
