// Claims about the visual hull.
#include "core/matte/hull.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/rigid.h"

namespace likeness {
namespace {

// A ball of 0.1 m at 1 m, seen while it turns in front of a camera at rest; furniture to its right.
HullView ball(double yaw, bool with_furniture) {
  HullView view;
  view.cam_from_part.linear() = rotation_about(Vec3d::UnitY(), yaw);
  view.cam_from_part.translation() = Vec3d(0, 0, 1);
  view.picture.width = view.picture.height = 100;
  view.picture.fx = view.picture.fy = 250, view.picture.cx = view.picture.cy = 50;
  view.person = cv::Mat(100, 100, CV_8U, cv::Scalar(0));
  cv::circle(view.person, {50, 50}, 25, 255, cv::FILLED);
  if (with_furniture) view.person(cv::Rect(70, 45, 16, 10)).setTo(255);
  return view;
}

TEST(Hull, KeepsTheBodyAndDropsWhatOnlyOneDirectionShows) {
  std::vector<HullView> views;
  for (int direction = -2; direction <= 2; ++direction)
    for (int i = 0; i < 4; ++i) views.push_back(ball(0.3 * direction + 0.01 * i, direction == 0));
  const Hull hull = carve_hull(Vec3d::Constant(-0.16), Vec3d::Constant(0.16), 0.01, views);
  const HullView wrong = ball(0, true);  // directions to both sides of it see past the furniture
  const cv::Mat share = hull_share(hull, wrong.cam_from_part, wrong.picture);
  EXPECT_GT(share.at<float>(50, 50), 0.95f);
  EXPECT_GT(share.at<float>(50, 30), 0.7f);
  EXPECT_LT(share.at<float>(50, 82), 0.5f);
  EXPECT_LT(share.at<float>(10, 10), 0.5f);
}

TEST(Hull, IsEmptyWithoutViews) { EXPECT_TRUE(carve_hull(Vec3d::Zero(), Vec3d::Ones(), 0.1, {}).empty()); }

}  // namespace
}  // namespace likeness
