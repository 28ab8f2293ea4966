#include "core/base/priority.h"

#include <sys/resource.h>
#include <sys/syscall.h>
#include <tbb/task_scheduler_observer.h>
#include <unistd.h>

namespace likeness {
namespace {

constexpr int kBack = 10;  // nice: a tenth of the processor beside a thread of normal priority

}  // namespace

void lower_thread_priority() {
  thread_local bool stepped = false;
  if (stepped) return;
  stepped = true;
  // Linux keeps the value for each thread.
  const auto thread = static_cast<id_t>(::syscall(SYS_gettid));
  if (::getpriority(PRIO_PROCESS, thread) < kBack) (void)::setpriority(PRIO_PROCESS, thread, kBack);
}

struct LowPriorityLoops::Impl final : tbb::task_scheduler_observer {
  Impl() { observe(true); }
  ~Impl() override { observe(false); }
  void on_scheduler_entry(bool lends_itself) override {
    if (lends_itself) lower_thread_priority();
  }
};

LowPriorityLoops::LowPriorityLoops() : impl_(std::make_unique<Impl>()) {}
LowPriorityLoops::~LowPriorityLoops() = default;

}  // namespace likeness
