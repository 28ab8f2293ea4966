// Parallel loops over oneTBB: see parallel.h.
#include "core/base/parallel.h"

#include <algorithm>

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

// GCC says so by a macro, Clang by a feature.
#if defined(__SANITIZE_THREAD__)
#define LIKENESS_THREAD_SANITIZER
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define LIKENESS_THREAD_SANITIZER
#endif
#endif

#ifdef LIKENESS_THREAD_SANITIZER
#include <sanitizer/tsan_interface.h>
#define LIKENESS_UNSEEN __attribute__((no_sanitize_thread))
#else
#define LIKENESS_UNSEEN
#endif

namespace likeness {
namespace {

// What happens before a loop happens before each of its bodies, and these before what comes after the loop.
// oneTBB's library is built without the thread sanitizer, so the sanitizer has to be informed; bodies stay
// unordered among themselves. Without that sanitizer this compiles to nothing.
struct LoopOrder {
#ifdef LIKENESS_THREAD_SANITIZER
  char start = 0, end = 0;
  LoopOrder() { __tsan_release(&start); }
  ~LoopOrder() { __tsan_acquire(&end); }
  void enter() { __tsan_acquire(&start); }
  void leave() { __tsan_release(&end); }
#else
  void enter() {}
  void leave() {}
#endif
};

// The tasks' own copies of a body are oneTBB's affair, so reading them is hidden from the sanitizer; the body
// itself is not.
template <class Body>
void run_tasks(std::size_t count, const Body& body) {
  LoopOrder order;
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) LIKENESS_UNSEEN {
    order.enter();
    body(i);
    order.leave();
  });
}

}  // namespace

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
  run_tasks(chunks, [&](std::size_t chunk) { body(chunk * grain, std::min(count, (chunk + 1) * grain)); });
}

void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body) { run_tasks(count, body); }

}  // namespace likeness
