// Parallel loops over oneTBB: see parallel.h.
#include "core/base/parallel.h"

#include <algorithm>

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

namespace likeness {

int hardware_threads() { return tbb::info::default_concurrency(); }

struct ThreadLimit::Impl {
  explicit Impl(int threads) : control(tbb::global_control::max_allowed_parallelism, std::size_t(threads)) {}
  tbb::global_control control;
};

ThreadLimit::ThreadLimit(int threads)
    : impl_(std::make_unique<Impl>(threads > 0 ? threads : hardware_threads())) {}
ThreadLimit::~ThreadLimit() = default;

int current_thread_limit() {
  return int(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

void parallel_ranges(std::size_t count, std::size_t grain,
                     const std::function<void(std::size_t, std::size_t)>& body) {
  if (count == 0) return;
  grain = std::max<std::size_t>(grain, 1);
  // Fixed chunks of `grain`: what a chunk computes does not depend on how threads share the chunks.
  const std::size_t chunks = (count + grain - 1) / grain;
  tbb::parallel_for(std::size_t{0}, chunks,
                    [&](std::size_t chunk) { body(chunk * grain, std::min(count, (chunk + 1) * grain)); });
}

void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body) {
  tbb::parallel_for(std::size_t{0}, count, body);
}

}  // namespace likeness
