// Claims about dense poses beside the landmarks of a synthetic head.
#include "core/track/clip/wandering_poses.h"

#include <gtest/gtest.h>

#include "tests/core/face/synthetic_face.h"

namespace likeness {
namespace {

// Landmarks with noise, and dense poses that lie `aside(frame)` metres to the side of them.
template <class Aside>
ClipWork clip_of(int count, const Aside& aside) {
  ClipWork work;
  work.head = test_reduced_head();
  work.identity = Eigen::VectorXd::Zero(work.head.identity_count());
  const ReducedPerson person = reduced_person(work.head, work.identity);
  for (int i = 0; i < count; ++i) {
    FaceFrame face;
    face.seen = face.pose_given = true;
    face.held_out = i % 10 == 9;
    face.state.expression = Eigen::VectorXd::Zero(work.head.expression_count());
    face.state.cam_from_head = facing_pose(0.02 * i, 0, {0, 0, 0.7});
    face.observation = observe_state(work.head, person, face.state, 0.5, std::uint32_t(i));
    face.state.cam_from_head.translation().x() += aside(i);
    work.faces.push_back(face);
    work.dense.emplace_back().solved = true;
  }
  return work;
}

int given(const ClipWork& work) {
  int count = 0;
  for (std::size_t i = 0; i < work.faces.size(); ++i) {
    EXPECT_EQ(work.faces[i].pose_given, work.dense[i].solved);
    count += work.faces[i].pose_given;
  }
  return count;
}

// Eyes' outer corners are about 9 cm apart.
TEST(WanderingPoses, WhereLandmarksAgreeAllStay) {
  ClipWork work = clip_of(20, [](int) { return 0.0003; });
  EXPECT_FALSE(drop_wandering_poses(work));
  EXPECT_EQ(given(work), 20);
}

TEST(WanderingPoses, AFrameBesideItsFaceLosesItsPose) {
  ClipWork work = clip_of(20, [](int i) { return i == 4 || i == 9 ? 0.005 : 0.0; });  // 9 is held out
  EXPECT_TRUE(drop_wandering_poses(work));
  EXPECT_EQ(given(work), 18);
  EXPECT_FALSE(work.faces[4].pose_given);
  EXPECT_FALSE(work.faces[9].pose_given);
}

TEST(WanderingPoses, AClipWhosePointsWanderLosesAll) {
  ClipWork work = clip_of(20, [](int i) { return 0.0012 + 0.0001 * (i % 5); });
  EXPECT_TRUE(drop_wandering_poses(work));
  EXPECT_EQ(given(work), 0);
}

TEST(WanderingPoses, HeldOutFramesCondemnNoOther) {
  ClipWork work = clip_of(20, [](int i) { return i % 10 == 9 ? 0.005 : 0.0003; });
  EXPECT_TRUE(drop_wandering_poses(work));
  EXPECT_EQ(given(work), 18);
}

}  // namespace
}  // namespace likeness
