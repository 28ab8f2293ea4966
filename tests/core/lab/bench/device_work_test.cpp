// Claims about core/lab/bench/device_work.h: floors follow from work and ceilings.
#include "core/lab/bench/device_work.h"

#include <gtest/gtest.h>

#include "core/lab/bench/standard_field.h"

namespace likeness {
namespace {

TEST(DeviceWork, FloorsAreTheLongerOfMovingAndMultiplying) {
  EXPECT_DOUBLE_EQ(floor_seconds({2e12, 1e9}, {1000, 1}), 2);
  EXPECT_DOUBLE_EQ(floor_seconds({2e9, 1e13}, {1000, 1}), 10);
  EXPECT_DOUBLE_EQ(floor_seconds({2e12, 1e9}, {1000, 0}), 1e-3);  // no matrix units: bytes alone
}

TEST(DeviceWork, AStepIsMoreWorkThanAForwardPassAndTablesAreMovedOnce) {
  const FieldConfig config = standard_field_config();
  for (const std::size_t samples : {std::size_t{1000}, std::size_t{1000000}}) {
    EXPECT_GT(training_work(config, samples).flops, 2 * inference_work(config, samples).flops);
    EXPECT_GT(training_work(config, samples).bytes, inference_work(config, samples).bytes);
  }
  // From where every entry is needed, a sample adds only its own numbers.
  const double more = inference_work(config, 4000000).bytes - inference_work(config, 3000000).bytes;
  EXPECT_NEAR(more, 1e6 * (7 + 4) * 4, 1);
}

}  // namespace
}  // namespace likeness
