// Claims about which pictures of a clip follow each other.
#include "core/track/frame_spacing.h"

#include <gtest/gtest.h>

#include <vector>

namespace likeness {
namespace {

struct Moment {
  int frame = 0;
  double time_s = 0;
};

TEST(FrameSpacing, OfAFilmAndOfPhotographs) {
  EXPECT_EQ(frame_spacing(std::vector<Moment>{{0, 0}, {1, 0.04}, {2, 0.08}}), 1);
  EXPECT_EQ(frame_spacing(std::vector<Moment>{{0, 0}, {4, 0.13}, {8, 0.27}}), 4);
  EXPECT_EQ(frame_spacing(std::vector<Moment>{{0, 0}, {1, 1}, {2, 2}}), 0);
}

TEST(FrameSpacing, AFilmThatPausesIsAFilmStill) {
  EXPECT_EQ(frame_spacing(std::vector<Moment>{{0, 0}, {1, 3}, {2, 3.04}, {3, 3.08}}), 1);
}

}  // namespace
}  // namespace likeness
