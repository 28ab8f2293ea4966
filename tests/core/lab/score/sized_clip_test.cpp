// Claims about a clip at another size, and about choosing its frames.
#include "core/lab/score/sized_clip.h"

#include <gtest/gtest.h>

#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

TEST(SizedClip, FramesAreChosenEvenly) {
  EXPECT_EQ(evenly_chosen(10, 5), (std::vector<std::size_t>{0, 2, 4, 6, 8}));
  EXPECT_EQ(evenly_chosen(3, 0), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(evenly_chosen(3, 9), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_TRUE(evenly_chosen(0, 4).empty());
}

TEST(SizedClip, ASmallerSetShowsTheSameFromTheSamePlaces) {
  const TrainingSet large = ball_set(3, 48), small = resized(ball_set(3, 48), 24), direct = ball_set(3, 24);
  EXPECT_EQ(small.size, 24);
  EXPECT_EQ(small.plate.width, 24);
  for (std::size_t v = 0; v < 3; ++v) {
    const Intrinsics &a = small.views[v].camera.intrinsics, &b = direct.views[v].camera.intrinsics;
    EXPECT_EQ(a.width, 24);
    EXPECT_NEAR(a.fx, b.fx, 1e-9);
    EXPECT_NEAR(a.cx, b.cx, 1e-9);
    double difference = 0;
    for (std::size_t i = 0; i < direct.views[v].rgb.data.size(); ++i)
      difference += std::abs(int(small.views[v].rgb.data[i]) - int(direct.views[v].rgb.data[i]));
    EXPECT_LT(difference / double(direct.views[v].rgb.data.size()), 3);
    EXPECT_EQ(small.views[v].alpha.width, 24);
  }
  EXPECT_EQ(resized(large, 48).views[0].rgb.data, large.views[0].rgb.data);
}

}  // namespace
}  // namespace likeness
