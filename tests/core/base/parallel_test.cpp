// Claims about parallel loops.
#include "core/base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <numeric>
#include <vector>

namespace likeness {
namespace {

TEST(Parallel, RangesCoverEveryIndexOnceInFixedChunks) {
  std::vector<int> hits(1003, 0);
  std::atomic<int> short_chunks{0};
  parallel_ranges(hits.size(), 100, [&](std::size_t begin, std::size_t end) {
    EXPECT_EQ(begin % 100, 0u);
    if (end - begin != 100) ++short_chunks;
    for (std::size_t i = begin; i < end; ++i) ++hits[i];
  });
  EXPECT_EQ(std::accumulate(hits.begin(), hits.end(), 0), 1003);
  EXPECT_EQ(*std::min_element(hits.begin(), hits.end()), 1);
  EXPECT_EQ(short_chunks, 1);
}

TEST(Parallel, EmptyRangeCallsNothing) {
  parallel_ranges(0, 16, [](std::size_t, std::size_t) { FAIL(); });
  parallel_for(0, [](std::size_t) { FAIL(); });
}

TEST(Parallel, LimitHoldsWhileItsObjectLives) {
  const int before = current_thread_limit();
  {
    const ThreadLimit limit(1);
    EXPECT_EQ(current_thread_limit(), 1);
  }
  EXPECT_EQ(current_thread_limit(), before);
}

}  // namespace
}  // namespace likeness
