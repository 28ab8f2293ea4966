// Claims about camera paths: there and back, within what was seen, and nothing else is touched.
#include "core/direct/camera_keys.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/direct/set_values.h"

namespace likeness {
namespace {

TEST(SetOrbit, GoesToBothSidesAndEndsWhereItBegan) {
  Performance performance;
  performance.duration_s = 8;
  set_value(performance, "head yaw", 5, {});
  set_orbit(performance, {-30, 15});
  float low = 0, high = 0;
  for (double t = 0; t <= 8; t += 0.02) {
    const float yaw = value_at(performance, "camera yaw", t);
    low = std::min(low, yaw), high = std::max(high, yaw);
  }
  EXPECT_NEAR(low, -30, 0.01);
  EXPECT_NEAR(high, 15, 0.01);
  EXPECT_EQ(value_at(performance, "camera yaw", 0), 0);
  EXPECT_EQ(value_at(performance, "camera yaw", 8), 0);
  EXPECT_EQ(value_at(performance, "head yaw", 3), 5);
  set_dolly(performance, 1, 0.6f);
  EXPECT_FLOAT_EQ(value_at(performance, "camera distance", 8), 0.6f);
}

TEST(OrbitRange, IsWhatHoldsOrWasSeenWithinLimits) {
  const std::map<std::string, ValueRange> limits{{"camera yaw", {-80, 3}}};
  EXPECT_EQ(orbit_range(limits, false).low, -45);
  EXPECT_EQ(orbit_range(limits, false).high, 10);
  EXPECT_EQ(orbit_range(limits, true).low, -45);
  EXPECT_EQ(orbit_range(limits, true).high, 3) << "beyond that it was found to fail";
}

}  // namespace
}  // namespace likeness
