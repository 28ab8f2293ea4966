// Claims about the prior of the person's place from the track.
#include "core/matte/person_prior.h"

#include <gtest/gtest.h>

#include "tests/core/matte/made_scene.h"

namespace likeness {
namespace {

int first_row(const cv::Mat& mask, int column) {
  for (int y = 0; y < mask.rows; ++y)
    if (mask.at<unsigned char>(y, column)) return y;
  return mask.rows;
}

// Hair before a wall of its colour would be lost to the wall.
TEST(PersonPrior, AboveTheSkullThePersonIsLikelyButNotCertain) {
  const HeadModel& model = test::head_model();
  Track track;
  track.person.identity = Eigen::VectorXf::Zero(model.identity_count());
  const PersonModel person = make_person_model(model, track);
  TrackedFrame tracked;
  tracked.pose.articulation = neutral_articulation(model);
  tracked.pose.world_from_head = tracked.pose.world_from_torso =
      Pose(Eigen::Translation3d(0, 0, 1) * Eigen::AngleAxisd(EIGEN_PI, Vec3d::UnitX()));
  Intrinsics k;
  k.width = k.height = 512, k.fx = k.fy = 800, k.cx = k.cy = 256;
  const auto place = place_person(person, tracked, {0, k, Pose::Identity()}, k, 1);
  ASSERT_TRUE(place);
  const cv::Mat head = head_silhouette(person, *place, k, false);
  const PersonPrior prior = person_prior(person, *place, k);
  const double px_per_mm = place->px_per_metre / 1000;
  const int column = int(place->brow.x()), top = first_row(head, column);
  const auto location = [&](double mm) {
    return prior.location.at<float>(int(top + mm * px_per_mm), column);
  };
  const float skull = location(8), beside = location(-8),
              cheek = prior.location.at<float>(int(0.5 * (place->brow.y() + place->jaw_corners.y())), column);
  EXPECT_GT(first_row(prior.certain, column), top + 10 * px_per_mm);  // the model's skull may be too large
  EXPECT_GT(skull, 1.5f);
  EXPECT_GT(beside, 0.5f);  // hair, most likely
  EXPECT_LT(beside, 1);
  EXPECT_LT(cheek, 1);
  EXPECT_LT(location(-60), 0);
}

}  // namespace
}  // namespace likeness
