// Claims about random walks: the same for a seed, smooth, and within their limits.
#include "core/direct/random_walk.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/direct/set_values.h"

namespace likeness::test {
namespace {

TEST(RandomWalk, IsSmoothSeededAndWithinItsLimits) {
  const std::map<std::string, ValueRange> limits{{"head yaw", {-40, 20}},
                                                 {"camera yaw", {-40, 40}},
                                                 {"action jawOpen", {-0.1f, 0.5f}},
                                                 {"action mouthSmile_L", {0, 0.6f}},
                                                 {"action mouthSmile_R", {0, 0.6f}},
                                                 {"action noseSneer_L", {0, 0}}};
  const Performance walk = random_walk(limits, {.seed = 3, .duration_s = 60});
  EXPECT_EQ(walk, random_walk(limits, {.seed = 3, .duration_s = 60}));
  EXPECT_NE(walk, random_walk(limits, {.seed = 4, .duration_s = 60}));
  EXPECT_FALSE(walk.channels.contains("camera yaw"));
  EXPECT_FALSE(walk.channels.contains("action noseSneer_L"));
  EXPECT_EQ(walk.channels.at("action mouthSmile_L"), walk.channels.at("action mouthSmile_R"));
  for (const auto& [channel, keys] : walk.channels) {
    float low = 0, high = 0, previous = 0;
    for (double t = 0; t <= 60; t += 0.04) {
      const float value = value_at(keys, t, 0);
      low = std::min(low, value), high = std::max(high, value);
      const float span = limits.at(channel).high - limits.at(channel).low;
      EXPECT_LT(std::abs(value - previous), 0.15f * span) << channel << " at " << t;
      previous = value;
    }
    EXPECT_GE(low, limits.at(channel).low) << channel;
    EXPECT_LE(high, limits.at(channel).high) << channel;
    EXPECT_GT(high, 0.2f * limits.at(channel).high) << channel << " hardly moves";
    EXPECT_FLOAT_EQ(value_at(keys, 0, 9), 0);
    EXPECT_FLOAT_EQ(value_at(keys, 60, 9), 0);
  }
  EXPECT_GE(value_at(walk, "head yaw", 30), -25);  // not like an owl
}

TEST(SetWalk, ReplacesHeadAndFaceButNotTheCamera) {
  Performance performance;
  performance.duration_s = 6;
  set_value(performance, "head x", 0.01f, {});
  set_value(performance, "camera yaw", 9, {});
  set_walk(performance, {{"head yaw", {-20, 20}}}, 1);
  EXPECT_EQ(performance.duration_s, 6);
  EXPECT_FALSE(performance.channels.contains("head x"));
  EXPECT_TRUE(performance.channels.contains("head yaw"));
  EXPECT_EQ(value_at(performance, "camera yaw", 3), 9);
}

}  // namespace
}  // namespace likeness::test
