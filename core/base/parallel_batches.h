// A parallel loop that can be watched, stopped and paused: see core/base/parallel.h.
#pragma once

#include <algorithm>
#include <stop_token>

#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/base/result.h"

namespace likeness {

// body(i) for every i in [0, count), `batch` of them between two reports. If stopped, some are left out.
inline Result<void> parallel_batches(std::size_t count, std::size_t batch,
                                     const std::function<void(std::size_t)>& body, const Progress& progress,
                                     const std::stop_token& stop) {
  for (std::size_t from = 0; from < count; from += batch) {
    if (stop.stop_requested()) return cancelled_error();
    progress.report(double(from) / double(count));
    parallel_for(std::min(batch, count - from), [&](std::size_t k) { body(from + k); });
  }
  if (stop.stop_requested()) return cancelled_error();
  return {};
}

}  // namespace likeness
