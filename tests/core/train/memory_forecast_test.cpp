// Claims about the forecast of memory.
#include "core/train/memory_forecast.h"

#include <gtest/gtest.h>

#include "core/base/memory.h"
#include "core/head/builtin_head.h"
#include "core/scene/warp_lattice.h"
#include "core/train/capture_summary.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

TEST(MemoryForecast, CountsPicturesAndLatticesAsTheyAreStored) {
  TrainingSet set = ball_set(8, 128);
  set.neutral = neutral_articulation(set.model);
  for (std::size_t v = 0; v < set.views.size(); ++v)  // an acting face: none of them rests
    set.views[v].pose.articulation.expression.setConstant(v % 2 == 0 ? 0.1f : -0.1f);
  const MemoryForecast forecast = forecast_memory(set, {});
  std::uint64_t pictures = 0, lattices = 0;
  const HeadShape shape = shape_head(set.model, set.person);
  const WarpFrame warp = *make_warp_frame(set.model, shape, typical_articulation(set));
  for (const TrainingView& view : set.views) {
    pictures += view.rgb.data.size() + view.alpha.bytes();
    const WarpLattice lattice = make_warp_lattice(warp, pose_head(set.model, shape, view.pose.articulation));
    lattices += lattice.bytes();
  }
  EXPECT_NEAR(double(forecast.pictures), double(pictures), 0.05 * double(pictures));
  EXPECT_NEAR(double(forecast.lattices), double(lattices), 0.1 * double(lattices));
  TrainOptions rigid;
  rigid.fields.mode = FieldMode::hyper;
  EXPECT_EQ(forecast_memory(set, rigid).lattices, 0u);
}

TEST(MemoryForecast, CountsWhatLargerGridsTake) {
  const TrainingSet set = ball_set(3, 32);
  TrainOptions small, large;
  small.fields.sizes.head_log2_entries = 14, large.fields.sizes.head_log2_entries = 20;
  const auto engine = [&](const TrainOptions& options) { return forecast_memory(set, options).engine; };
  EXPECT_LT(engine(small), engine({}));
  // Thirty-two numbers an entry, of which each is kept with two moments and, while it learns, a gradient.
  EXPECT_GT(engine(large), engine({}) + ((1ull << 20) - (1ull << 16)) * 32 * 16);
}

TEST(MemoryForecast, TwoThousandPicturesTrainInThreeGigabytes) {
  const HeadModel model = make_builtin_head();
  const MemoryForecast forecast = forecast_memory(2000, 512, model, {});
  EXPECT_LT(forecast.total(), 3ull << 30);
  EXPECT_GT(forecast.pictures, 2000ull * 512 * 512 * 3);
  EXPECT_GT(forecast.lattices, 200ull << 20);
}

TEST(MemoryForecast, RefusesWhatWillNotFitWithFiguresAndAdvice) {
  const MemoryForecast forecast{2ull << 30, 1ull << 30, 1ull << 29};
  EXPECT_TRUE(check_memory(forecast, 4ull << 30).ok());
  const auto refused = check_memory(forecast, 3ull << 30);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().what.find("3.5 GiB"), std::string::npos) << refused.error().what;
  EXPECT_NE(refused.error().fix.find("--size"), std::string::npos);
}

TEST(AvailableMemory, IsKnownAndPositive) {
  const auto bytes = available_memory();
  ASSERT_TRUE(bytes.has_value());
  EXPECT_GT(*bytes, 100ull << 20);
}

}  // namespace
}  // namespace likeness
