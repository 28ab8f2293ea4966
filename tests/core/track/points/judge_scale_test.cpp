// Claims about which camera paths the head's size takes for possible.
#include "core/track/points/judge_scale.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/rigid.h"

namespace likeness {
namespace {

constexpr int kSightings = 200;

// A camera on an arc of `sweep` radians round a head that it sees from `distance` metres, in a world of
// `metres_per_unit`.
std::vector<HeadSighting> walk(double distance, double sweep, double metres_per_unit) {
  std::vector<HeadSighting> sightings;
  for (int i = 0; i < kSightings; ++i) {
    Pose world_from_cam = Pose::Identity(), world_from_head = Pose::Identity();
    world_from_cam.linear() = rotation_about(Vec3d::UnitY(), sweep * i / (kSightings - 1));
    world_from_cam.translation() = -distance * world_from_cam.linear().col(2);
    HeadSighting s;
    s.cam_from_head = inverse(world_from_cam) * world_from_head;
    s.cam_from_world = inverse(world_from_cam);
    s.cam_from_world.translation() /= metres_per_unit;
    sightings.push_back(s);
  }
  return sightings;
}

// As the solve and the fit leave it.
struct Tracked {
  CameraSet cameras;
  Track track;
};
Tracked tracked(const std::vector<HeadSighting>& sightings, double metres_per_unit) {
  Tracked made;
  made.cameras.kind = CameraKind::walking;
  made.cameras.scale = CameraScale::arbitrary;
  made.track.metres_per_unit = metres_per_unit;
  for (const HeadSighting& s : sightings) {
    const int frame = 3 * int(made.track.frames.size());
    made.cameras.cameras.push_back({frame, {}, s.cam_from_world});
    TrackedFrame& own = made.track.frames.emplace_back();
    own.frame = frame;
    own.pose.world_from_head = inverse(metric_camera(s.cam_from_world, metres_per_unit)) * s.cam_from_head;
  }
  return made;
}

TEST(JudgeScale, BelievesWalksRoundAHeadInAnyUnit) {
  for (const double unit : {0.01, 0.37, 12.0})
    for (const double distance : {0.3, 0.6, 2.0, 5.0}) {
      const auto judged = judge_scale(walk(distance, 1.5, unit), unit);
      EXPECT_TRUE(judged.reasons.empty()) << judged.reasons[0];
      EXPECT_NEAR(judged.distance_m, distance, 1e-9);
      // Its chord is the shortest that the places can lie apart.
      EXPECT_GT(judged.reach_m, 2 * distance * std::sin(1.5 / 2) * 0.9);
      EXPECT_LT(judged.reach_m, 1.5 * distance);
    }
}

TEST(JudgeScale, DoubtsAHeadFromWhichNobodyFilms) {
  for (const double distance : {0.05, 12.0, 80.0}) {
    const auto judged = judge_scale(walk(distance, 1.0, 0.37), 0.37);
    ASSERT_FALSE(judged.reasons.empty()) << distance;
    EXPECT_NE(judged.reasons[0].find("from the camera"), std::string::npos) << judged.reasons[0];
  }
}

TEST(JudgeScale, DoubtsACameraThatHardlyMovesOrLeaves) {
  const auto still = judge_scale(walk(0.6, 0.01, 0.37), 0.37);  // 6 mm
  ASSERT_EQ(still.reasons.size(), 1u);
  EXPECT_NE(still.reasons[0].find("only 0.6 cm"), std::string::npos) << still.reasons[0];
  const auto far = judge_scale(walk(0.6, 1.0, 0.37), 100 * 0.37);
  ASSERT_EQ(far.reasons.size(), 1u);
  EXPECT_NE(far.reasons[0].find("nobody walks"), std::string::npos) << far.reasons[0];
}

TEST(JudgeScale, SaysNothingOfAPathWhoseScaleIsNotKnown) {
  EXPECT_TRUE(judge_scale(walk(0.6, 0.01, 0.37), std::nullopt).reasons.empty());
  EXPECT_TRUE(judge_scale({}, 1.0).reasons.empty());
}

TEST(JudgeScale, ASingleCameraThatWasPlacedWronglyMakesNoPath) {
  auto sightings = walk(0.6, 1.0, 0.37);
  const double before = judge_scale(sightings, 0.37).reach_m;
  sightings[70].cam_from_world.translation() += Vec3d(900, 0, 0);
  const auto judged = judge_scale(sightings, 0.37);
  EXPECT_TRUE(judged.reasons.empty()) << judged.reasons[0];
  EXPECT_NEAR(judged.reach_m, before, 0.05 * before);
}

TEST(JudgeScale, OfATrackTheSightingsAreThoseItWasMadeFrom) {
  const auto sightings = walk(0.6, 1.0, 0.37);
  auto [cameras, track] = tracked(sightings, 0.37);
  track.frames[5].status = FrameStatus::lost;
  cameras.cameras.erase(cameras.cameras.begin() + 9);
  const auto found = sightings_of(track, cameras);
  ASSERT_EQ(found.size(), sightings.size() - 2);
  EXPECT_TRUE(found[0].cam_from_head.isApprox(sightings[0].cam_from_head, 1e-9));
  EXPECT_TRUE(found.back().cam_from_head.isApprox(sightings.back().cam_from_head, 1e-9));
}

TEST(JudgeScale, WarnsWithWhatToDoAndOnlyOfPathsThatWereFound) {
  auto [cameras, track] = tracked(walk(0.6, 1.0, 0.37), 0.37);
  EXPECT_EQ(scale_warning(track, cameras), "");
  auto [far_cameras, far_track] = tracked(walk(15, 1.0, 0.37), 0.37);
  const std::string warning = scale_warning(far_track, far_cameras);
  EXPECT_NE(warning.find("15 m from the camera"), std::string::npos) << warning;
  EXPECT_NE(warning.find("--camera-kind"), std::string::npos) << warning;
  far_cameras.scale = CameraScale::metric;
  EXPECT_EQ(scale_warning(far_track, far_cameras), "");
}

}  // namespace
}  // namespace likeness
