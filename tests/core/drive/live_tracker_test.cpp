// Claims about live tracking: it follows a known performance frame by frame, and says when there is no face.
#include "core/drive/live_tracker.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/head/action_amounts.h"
#include "core/lab/truth/track_truth.h"
#include "tests/core/drive/demo_clip.h"

namespace likeness::test {
namespace {

// How far a head is turned to its left in its camera, rad.
double yaw_of(const Pose& cam_from_head) {
  const Vec3d out = cam_from_head.linear() * Vec3d::UnitZ();
  return std::atan2(out.x(), -out.z());
}

TEST(LiveTracker, FollowsAKnownPerformanceFrameByFrame) {
  const auto truth = read_track_truth(demo_folder());
  ASSERT_TRUE(truth.ok());
  auto tracker = LiveTracker::create(driven_head(), {});
  ASSERT_TRUE(tracker.ok()) << tracker.error().what;
  tracker->begin_rest();
  for (int i = 0; i < 25; ++i)
    EXPECT_NE(tracker->next(demo_frames()[std::size_t(i)].rgb, i / 25.0).status, FrameStatus::lost) << i;
  const auto person = tracker->settle();
  ASSERT_TRUE(person.ok()) << person.error().what;
  EXPECT_GT(person->person.identity.norm(), 0.1f);
  const ActionBasis basis = action_basis(driven_head());
  const int jaw = action_index(basis, "jawOpen");
  std::vector<double> yaw, yaw_truth, open, open_truth;
  for (std::size_t i = 25; i < demo_frames().size(); ++i) {
    const TrackedFrame frame = tracker->next(demo_frames()[i].rgb, double(i) / 25);
    const TrackedFrame* known = find_tracked(truth->track, int(i));
    ASSERT_NE(known, nullptr);
    ASSERT_NE(frame.status, FrameStatus::lost) << i << ": " << frame.reason;
    EXPECT_EQ(frame.frame, int(i));
    const Pose& camera = truth->cameras.cameras.front().cam_from_world;
    yaw.push_back(yaw_of(frame.pose.world_from_head));
    yaw_truth.push_back(yaw_of(camera * known->pose.world_from_head));
    open.push_back(double(face_amounts(basis, frame.pose.articulation)[jaw]));
    open_truth.push_back(double(face_amounts(basis, known->pose.articulation)[jaw]));
  }
  EXPECT_GT(course_correlation(yaw_truth, yaw).value_or(0), 0.95);
  EXPECT_GT(course_correlation(open_truth, open).value_or(0), 0.4);  // lips of 320 px, by landmarks alone
}

TEST(LiveTracker, SaysWhenThereIsNoFaceAndFindsItAgain) {
  auto tracker = LiveTracker::create(driven_head(), {});
  ASSERT_TRUE(tracker.ok());
  const Image8& face = demo_frames().front().rgb;
  EXPECT_NE(tracker->next(face, 0).status, FrameStatus::lost);
  // A picture or two may still be followed weakly; the detector is asked every few.
  TrackedFrame blank;
  double time_s = 0;
  for (int i = 0; i < 30 && blank.status != FrameStatus::lost; ++i) {
    blank = tracker->next(Image8(320, 320, 3, 90), time_s += 0.04);
    EXPECT_NE(blank.status, FrameStatus::good) << i;
  }
  EXPECT_EQ(blank.status, FrameStatus::lost);
  EXPECT_FALSE(blank.reason.empty());
  EXPECT_NE(tracker->next(face, time_s += 0.04).status, FrameStatus::lost);
  tracker->begin_rest();
  tracker->next(face, time_s += 0.04);
  const auto unsettled = tracker->settle();
  ASSERT_FALSE(unsettled.ok());
  EXPECT_FALSE(unsettled.error().fix.empty());
}

}  // namespace
}  // namespace likeness::test
