// Claims about the forecast of memory.
#include "core/train/memory_forecast.h"

#include <gtest/gtest.h>

#include "core/base/memory.h"
#include "core/scene/warp_lattice.h"
#include "core/train/capture_summary.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

TEST(MemoryForecast, CountsPicturesAndLatticesAsTheyAreStored) {
  const TrainingSet set = ball_set(7, 48);
  const MemoryForecast forecast = forecast_memory(set, {});
  std::uint64_t pictures = 0, lattices = 0;
  const HeadShape shape = shape_head(set.model, set.person);
  const WarpFrame warp = make_warp_frame(set.model, shape, typical_articulation(set));
  for (const TrainingView& view : set.views) {
    pictures += view.rgb.data.size() + view.alpha.data.size();
    const WarpLattice lattice = make_warp_lattice(warp, pose_head(set.model, shape, view.articulation));
    lattices += lattice.displacement.size() * sizeof(lattice.displacement[0]);
  }
  EXPECT_EQ(forecast.pictures, pictures);
  EXPECT_EQ(forecast.lattices, lattices);
  TrainOptions rigid;
  rigid.mode = FieldMode::hyper;
  EXPECT_EQ(forecast_memory(set, rigid).lattices, 0u);
}

TEST(MemoryForecast, RefusesWhatWillNotFitWithFiguresAndAdvice) {
  const MemoryForecast forecast{2ull << 30, 1ull << 30, 1ull << 29};
  EXPECT_TRUE(check_memory(forecast, 4ull << 30).ok());
  const auto refused = check_memory(forecast, 3ull << 30);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().what.find("3.5 GiB"), std::string::npos) << refused.error().what;
  EXPECT_NE(refused.error().fix.find("--size"), std::string::npos);
}

TEST(AvailableMemory, IsKnownHereAndNotNothing) {
  const auto bytes = available_memory();
  ASSERT_TRUE(bytes.has_value());
  EXPECT_GT(*bytes, 100ull << 20);
}

}  // namespace
}  // namespace likeness
