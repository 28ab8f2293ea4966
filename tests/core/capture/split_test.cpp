// Claims about the splits' names.
#include "core/capture/split.h"

#include <gtest/gtest.h>

namespace likeness {
namespace {

TEST(Split, NamesAreReadBack) {
  for (const Split split : kSplits) EXPECT_EQ(split_named(split_name(split)), split);
  EXPECT_FALSE(split_named("random"));
  EXPECT_EQ(split_named("sides"), Split::sides);
}

}  // namespace
}  // namespace likeness
