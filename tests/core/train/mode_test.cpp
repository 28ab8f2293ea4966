// Claims about the modes: names and parts agree, every one learns, and an avatar records which it is.
#include "core/train/mode.h"

#include <gtest/gtest.h>

#include <set>
#include <tuple>

#include "core/train/train.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

TEST(FieldModes, EachNameReadsBackAsItsMode) {
  for (const FieldMode mode : kFieldModes) EXPECT_EQ(mode_named(mode_name(mode)), mode);
  EXPECT_EQ(mode_named("warp+hyper"), kDefaultMode);
  EXPECT_FALSE(mode_named("warp + hyper").has_value());
  EXPECT_FALSE(mode_named("").has_value());
}

TEST(FieldModes, NoTwoAreMadeOfTheSameParts) {
  std::set<std::tuple<bool, bool, bool>> seen;
  for (const FieldMode mode : kFieldModes) {
    const ModeParts parts = mode_parts(mode);
    seen.insert({parts.expression, parts.ambient, parts.warp});
    EXPECT_TRUE(parts.expression || (!parts.ambient && !parts.warp));  // they would have no input
  }
  EXPECT_EQ(seen.size(), kFieldModes.size());
}

// The loss of the first step, or a moving mean of the last ones; and the avatar.
std::pair<double, Avatar> trained(FieldMode mode, std::uint64_t steps) {
  static const TrainingSet set = ball_set(12, 24);
  TrainOptions options;
  options.fields.mode = mode;
  options.schedule.steps = steps;
  options.rays.per_step = 512;
  double loss = 0;
  auto avatar =
      train_avatar(set, options, {}, Progress(), [&](const TrainStatus& status) { loss = status.loss; }, {});
  EXPECT_TRUE(avatar.ok());
  return {loss, avatar ? *avatar : Avatar{}};
}

TEST(FieldModes, EachLearnsAndTheAvatarRecordsWhichItIs) {
  for (const FieldMode mode : kFieldModes) {
    const auto [first, fresh] = trained(mode, 1);
    const auto [last, avatar] = trained(mode, 60);
    EXPECT_LT(last, 0.4 * first) << mode_name(mode);
    EXPECT_EQ(mode_of(avatar), mode);
    EXPECT_EQ(avatar.head.field.config.condition_count > 0, mode_parts(mode).expression);
    EXPECT_EQ(avatar.condition.rows.rows(), avatar.head.field.config.condition_count);
    EXPECT_EQ(avatar.warp_cell > 0, mode_parts(mode).warp);
  }
}

}  // namespace
}  // namespace likeness
