// Claims about what a performance makes an avatar do, and that a driven clip comes back out of its keys.
#include "core/direct/direct_avatar.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/direct/edit_keys.h"
#include "core/render/camera_path.h"
#include "tests/core/export/tiny_project.h"

namespace likeness::test {
namespace {

constexpr double kRad = std::numbers::pi / 180;

const OpenedAvatar& opened() {
  static const OpenedAvatar avatar = tiny_opened();
  return avatar;
}

DirectedMoment moment_of(const std::vector<std::pair<std::string, float>>& values) {
  Performance performance;
  for (const auto& [channel, value] : values) set_key(performance, channel, {0, value});
  return direct_moment(direct_avatar(opened().avatar, opened().model), performance, 0);
}

TEST(DirectMoment, WithoutKeysTheAvatarIsAtRest) {
  const Avatar& avatar = opened().avatar;
  const DirectedMoment moment = moment_of({});
  EXPECT_TRUE(moment.camera.cam_from_world.isApprox(avatar.cam_from_world, 1e-12));
  EXPECT_TRUE(moment.pose.world_from_head.isApprox(avatar.world_from_head, 1e-12));
  EXPECT_TRUE(moment.pose.world_from_torso.isApprox(avatar.world_from_torso, 1e-12));
  EXPECT_EQ(moment.pose.articulation.expression, avatar.neutral.expression);
}

TEST(DirectMoment, TurnsAndActionsMatchTheCommandLine) {
  const auto& [project, avatar, model, hash] = opened();
  const DirectedMoment moment =
      moment_of({{"head yaw", 20}, {"head pitch", -5}, {"head roll", 3}, {"action jawOpen", 0.5f}});
  const Vec3d neck = direct_avatar(avatar, model).neck;
  EXPECT_TRUE(moment.pose.world_from_head.isApprox(
      turned_head(avatar.world_from_head, neck, 20 * kRad, -5 * kRad, 3 * kRad), 1e-6));
  EXPECT_TRUE(moment.pose.articulation.jaw.isApprox(
      articulate(model, avatar.neutral, {{"jawOpen", 0.5f}})->jaw, 1e-6f));
  EXPECT_TRUE(
      moment_of({{"camera yaw", 30}, {"camera pitch", 10}})
          .camera.cam_from_world.isApprox(
              orbit_camera(avatar, avatar.world_from_head, 30 * kRad, 10 * kRad).cam_from_world, 1e-6));
}

TEST(DirectMoment, ACloserCameraKeepsTheHeadInItsPlace) {
  const Avatar& avatar = opened().avatar;
  const Vec3d centre = avatar.world_from_head * head_centre(avatar);
  const Vec3d typical = avatar.cam_from_world * centre;
  const Vec3d close =
      moment_of({{"camera distance", 0.5f}, {"camera yaw", 25}}).camera.cam_from_world * centre;
  EXPECT_TRUE(close.isApprox(0.5 * typical, 1e-5));
}

TEST(DirectMoment, ZoomAndShiftMoveThePictureAboutItsMiddle) {
  const Intrinsics plain = moment_of({}).camera.intrinsics;
  const Intrinsics k = moment_of({{"camera zoom", 2}, {"camera shift x", 0.25f}}).camera.intrinsics;
  EXPECT_DOUBLE_EQ(k.fx, 2 * plain.fx);
  const double middle = plain.width * 0.5;
  EXPECT_NEAR(k.cx - middle, 2 * (plain.cx - middle) + 0.25 * plain.width, 1e-6);
  EXPECT_NEAR(k.cy - 0.5 * plain.height, 2 * (plain.cy - 0.5 * plain.height), 1e-6);
}

TEST(DirectMoment, GazeTurnsBothEyesAlikeAndMovesTheLids) {
  const Articulation left = moment_of({{"gaze yaw", 12}}).pose.articulation;
  EXPECT_NEAR(left.left_eye.y(), 12 * kRad, 1e-4);
  EXPECT_NEAR(left.right_eye.y(), 12 * kRad, 1e-4);
  const Articulation down = moment_of({{"gaze pitch", -10}}).pose.articulation;
  EXPECT_NEAR(down.left_eye.x(), 10 * kRad, 1e-4);  // +x looks down
  EXPECT_NEAR(down.right_eye.x(), 10 * kRad, 1e-4);
  EXPECT_GT((down.expression - opened().avatar.neutral.expression).norm(), 0.1f);
}

TEST(DirectMoment, TheTorsoRestsUntilTheNeckIsStretched) {
  const auto& avatar = opened().avatar;
  const auto away = [&](float shift) {
    const AvatarPose pose = moment_of({{"head x", shift}, {"head yaw", 30}}).pose;
    return (pose.world_from_torso.translation() - avatar.world_from_torso.translation()).norm();
  };
  EXPECT_NEAR(away(0), 0, 1e-9);
  EXPECT_LT(away(0.01f), 0.001);
  EXPECT_NEAR(away(1), 1 - DriveOptions{}.reach_m, 1e-3);
}

TEST(DirectFilm, HasOneMomentPerFrameAndRefusesUnknownActions) {
  Performance performance;
  performance.duration_s = 2;
  set_key(performance, "camera yaw", {0, 0});
  set_key(performance, "camera yaw", {1.96, 45, Easing::linear});
  const auto film = direct_film(opened(), performance);
  ASSERT_TRUE(film.ok());
  ASSERT_EQ(film->frames, 50u);
  EXPECT_TRUE(film->at(49).camera.cam_from_world.isApprox(
      orbit_camera(opened().avatar, opened().avatar.world_from_head, 45 * kRad).cam_from_world, 1e-6));
  // An hour's poses are not made ahead: they would take gigabytes.
  performance.duration_s = 3600, performance.frames_per_second = 240;
  const auto hour = direct_film(opened(), performance);
  ASSERT_TRUE(hour.ok());
  EXPECT_EQ(hour->frames, 864'000u);
  EXPECT_TRUE(hour->at(863'999).camera.cam_from_world.isApprox(film->at(49).camera.cam_from_world, 1e-6));
  set_key(performance, "action grin", {0, 1});
  const auto refused = direct_film(opened(), performance);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().what.find("grin"), std::string::npos);
  EXPECT_NE(refused.error().fix.find("jawOpen"), std::string::npos);
}

TEST(PerformanceOf, FramesKeepTheirTimes) {
  const auto& [project, avatar, model, hash] = opened();
  const DirectedAvatar directed = direct_avatar(avatar, model);
  std::vector<DrivenFrame> frames(3);
  for (DrivenFrame& frame : frames) {
    frame.pose.world_from_head = turned_head(avatar.world_from_head, directed.neck, 0.2, 0, 0);
    frame.pose.articulation = avatar.neutral;
  }
  frames[0].time_s = 5, frames[1].time_s = 5.05, frames[2].time_s = 5.3;
  const Performance performance = performance_of(frames, 25, directed);
  ASSERT_EQ(performance.channels.at("head yaw").size(), 3u);
  EXPECT_DOUBLE_EQ(performance.channels.at("head yaw")[1].time_s, frames[1].time_s - 5);
  EXPECT_NEAR(performance.duration_s, 0.34, 1e-9);
}

TEST(PerformanceOf, KeysReproduceADrivenClip) {
  const auto& [project, avatar, model, hash] = opened();
  const DirectedAvatar directed = direct_avatar(avatar, model);
  // A clip as an avatar is driven: named actions on top of rest, eyes that move together.
  DrivenClip clip;
  clip.frames_per_second = 30;
  for (int i = 0; i < 20; ++i) {
    DrivenFrame frame;
    frame.frame = i, frame.time_s = i / 30.0;
    const float wave = std::sin(0.4f * float(i));
    Pose shifted = avatar.world_from_head;
    shifted.translate(Vec3d(0.01 * wave, 0, 0.005));
    frame.pose.world_from_head = turned_head(shifted, directed.neck, 0.3 * wave, 0.1, -0.2 * wave);
    frame.pose.articulation =
        *articulate(model, avatar.neutral, {{"jawOpen", 0.4f + 0.3f * wave}, {"mouthSmile_L", 0.5f}});
    frame.pose.articulation.left_eye = frame.pose.articulation.right_eye = {0, 0.1f * wave, 0};
    clip.frames.push_back(frame);
  }
  const Performance performance = performance_of(clip, directed);
  EXPECT_EQ(frame_count(performance), 20);
  EXPECT_EQ(performance.channels.at("head yaw").size(), 20u);
  EXPECT_FALSE(performance.channels.contains("camera yaw"));
  for (int i = 0; i < 20; ++i) {
    const AvatarPose pose = direct_moment(directed, performance, i / 30.0).pose;
    const DrivenFrame& frame = clip.frames[std::size_t(i)];
    EXPECT_TRUE(pose.world_from_head.isApprox(frame.pose.world_from_head, 1e-5)) << i;
    EXPECT_LT((pose.articulation.jaw - frame.pose.articulation.jaw).norm(), 0.02f) << i;
    EXPECT_LT((pose.articulation.left_eye - frame.pose.articulation.left_eye).norm(), 2e-3f) << i;
    const HeadShape shape = shape_head(model, avatar.person);
    // Lids follow the gaze in a performance; the mouth has to be where it was.
    Articulation wanted = frame.pose.articulation, got = pose.articulation;
    const auto a = landmark_positions(model, pose_head(model, shape, wanted));
    const auto b = landmark_positions(model, pose_head(model, shape, got));
    for (std::size_t l = 48; l < 68; ++l) EXPECT_LT((a[l] - b[l]).norm(), 1e-3f) << i << " " << l;
  }
}

}  // namespace
}  // namespace likeness::test
