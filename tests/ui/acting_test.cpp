// Claims about acting: halves move together, presets fit the model, the pose is what the sliders say.
#include "ui/acting.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/head/builtin_head.h"
#include "core/render/camera_path.h"

namespace likeness::ui {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const HeadModel& head() {
  static const HeadModel model = make_builtin_head();
  return model;
}

Avatar plain_avatar() {
  Avatar avatar;
  avatar.neutral = neutral_articulation(head());
  avatar.person.identity = Eigen::VectorXf::Zero(head().identity_count());
  avatar.intrinsics = {.width = 256, .height = 256, .fx = 500, .fy = 500, .cx = 128, .cy = 128};
  avatar.cam_from_world.translation() = Vec3d(0, 0, 1);
  return avatar;
}

TEST(Acting, NamesOfActionsBecomeWords) {
  EXPECT_EQ(action_words("mouthSmile_L"), "Mouth smile, left");
  EXPECT_EQ(action_words("jawOpen"), "Jaw open");
}

TEST(Acting, LinkedHalvesMoveTogether) {
  Acting acting;
  set_amount(acting, "mouthSmile_L", 0.5f);
  EXPECT_EQ(amount_of(acting, "mouthSmile_R"), 0.5f);
  acting.linked = false;
  set_amount(acting, "mouthSmile_R", 0.2f);
  EXPECT_EQ(amount_of(acting, "mouthSmile_L"), 0.5f);
  set_amount(acting, "mouthSmile_L", 0);
  set_amount(acting, "mouthSmile_R", -1);
  EXPECT_EQ(acting.amounts.size(), 0u);  // none is not remembered
}

TEST(Acting, EveryActionButGazeIsInExactlyOneGroup) {
  std::multiset<std::string> grouped, wanted;
  for (const ActionGroup& group : group_actions(head()))
    grouped.insert(group.actions.begin(), group.actions.end());
  for (const NamedAction& action : head().actions)
    if (!action.name.starts_with("eyeLook")) wanted.insert(action.name);
  EXPECT_EQ(grouped, wanted);
}

TEST(Acting, PresetsAreMadeOfActionsTheBuiltInHeadHas) {
  for (const Preset& preset : presets()) {
    const Acting acting = with_preset({}, preset, head());
    EXPECT_EQ(acting.amounts.empty(), preset.words == "Neutral") << preset.words;
  }
  Acting turned;
  turned.yaw_deg = 12;
  turned.amounts["jawOpen"] = 1;
  const Acting smile = with_preset(turned, presets()[1], head());
  EXPECT_EQ(smile.yaw_deg, 12);  // a preset is a face
  EXPECT_EQ(amount_of(smile, "jawOpen"), 0);
}

TEST(Acting, ThePoseIsWhatTheSlidersSay) {
  const Avatar avatar = plain_avatar();
  const AvatarRig rig{.model = &head(), .shape = shape_head(head(), avatar.person)};
  const AvatarPose rest = acting_pose({}, avatar, rig);
  EXPECT_TRUE(rest.articulation.expression.isApprox(avatar.neutral.expression));
  Acting acting;
  acting.amounts["jawOpen"] = 1;
  acting.amounts["noSuchAction"] = 1;
  acting.yaw_deg = 20;
  const AvatarPose open = acting_pose(acting, avatar, rig);
  const NamedAction& jaw = *find_action(head(), "jawOpen");
  EXPECT_TRUE((open.articulation.expression - rest.articulation.expression).isApprox(jaw.expression));
  EXPECT_TRUE((open.articulation.jaw - rest.articulation.jaw).isApprox(jaw.jaw));
  // Turning to the subject's left brings the nose, which points along z, towards +x.
  EXPECT_NEAR((open.world_from_head.linear() * Vec3d::UnitZ()).x(), std::sin(20 * 3.14159265 / 180), 1e-6);
}

TEST(Acting, BothEyesLookToOneSide) {
  const Avatar avatar = plain_avatar();
  const AvatarRig rig{.model = &head(), .shape = shape_head(head(), avatar.person)};
  Acting acting;
  acting.gaze_side = 1;
  const Articulation left = acting_pose(acting, avatar, rig).articulation;
  acting.gaze_side = -1;
  const Articulation right = acting_pose(acting, avatar, rig).articulation;
  EXPECT_GT(left.left_eye.y(), 0.1f);  // about +y: from +z towards +x, the subject's left
  EXPECT_GT(left.right_eye.y(), 0.1f);
  EXPECT_LT(right.left_eye.y(), -0.1f);
  EXPECT_LT(right.right_eye.y(), -0.1f);
}

TEST(Acting, ZoomAndShiftMoveThePictureAboutItsMiddle) {
  const Avatar avatar = plain_avatar();
  Acting acting;
  acting.view.zoom = 2;
  acting.view.shift_x = 0.25;
  const Camera camera = acting_camera(acting, avatar, 512);
  EXPECT_EQ(camera.intrinsics.width, 512);
  EXPECT_DOUBLE_EQ(camera.intrinsics.fx, 2000);
  const Vec2d middle = project<double>(camera.intrinsics, Vec3d(0, 0, 1));
  EXPECT_NEAR(middle.x(), 512 * 0.75, 1e-9);
  EXPECT_NEAR(middle.y(), 256, 1e-9);
}

TEST(Acting, WhatWasNeverSeenIsSaid) {
  const std::vector<SeenAction> shown{{"jawOpen", 0, 0.4f}};
  const SeenTurn seen{{-20, -10, -5}, {30, 10, 5}};
  Acting acting;
  acting.amounts["jawOpen"] = 0.4f;
  EXPECT_TRUE(beyond_seen(acting, shown, seen).empty());
  acting.amounts["jawOpen"] = 1;
  EXPECT_THAT(beyond_seen(acting, shown, seen), ElementsAre(HasSubstr("Jaw open")));
  acting.amounts.clear();
  acting.view.yaw_deg = 50;  // of the camera: the head seems turned by -50
  EXPECT_THAT(beyond_seen(acting, shown, seen), ElementsAre(HasSubstr("30")));
  acting.yaw_deg = 45;  // turned after the camera it is seen from the front again
  EXPECT_TRUE(beyond_seen(acting, shown, seen).empty());
}

TEST(Acting, TheSeenTurnIsInTheSlidersTerms) {
  const Avatar avatar = plain_avatar();
  const AvatarRig rig{.model = &head(), .shape = shape_head(head(), avatar.person)};
  Acting acting;
  acting.yaw_deg = 20, acting.pitch_deg = -10, acting.roll_deg = 5;
  const AvatarPose pose = acting_pose(acting, avatar, rig);
  const auto turn = relative_turn(avatar, avatar.cam_from_world, pose.world_from_head);
  EXPECT_NEAR(turn[0], 20, 1e-9);
  EXPECT_NEAR(turn[1], -10, 1e-9);
  EXPECT_NEAR(turn[2], 5, 1e-9);
  // A camera that walks to the subject's left sees the head as if it had turned to the right.
  Acting orbit;
  orbit.view.yaw_deg = 20;
  const auto walked =
      relative_turn(avatar, acting_camera(orbit, avatar, 256).cam_from_world, avatar.world_from_head);
  EXPECT_NEAR(walked[0], -20, 1e-9);
}

}  // namespace
}  // namespace likeness::ui
