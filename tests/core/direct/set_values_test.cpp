// Claims about setting values: constants stay constants, animated channels get keys, and nothing earlier
// changes.
#include "core/direct/set_values.h"

#include <gtest/gtest.h>

#include "core/direct/edit_keys.h"

namespace likeness {
namespace {

TEST(SetValue, WithoutRecordingAChannelIsConstant) {
  Performance performance;
  set_value(performance, "head yaw", 12, {.time_s = 2});
  for (const double t : {0.0, 2.0, 4.0}) EXPECT_EQ(value_at(performance, "head yaw", t), 12);
  EXPECT_FALSE(is_animated(performance, "head yaw"));
  set_value(performance, "head yaw", 0, {.time_s = 1});
  EXPECT_EQ(performance, Performance{});  // rest needs no key
}

TEST(SetValue, RecordingKeepsWhatWasThereBefore) {
  Performance performance;
  set_value(performance, "camera zoom", 2, {.time_s = 2, .record = true});
  EXPECT_EQ(value_at(performance, "camera zoom", 0), 1);
  EXPECT_EQ(value_at(performance, "camera zoom", 2), 2);
  set_value(performance, "head roll", 5, {});
  set_value(performance, "head roll", 9, {.time_s = 3, .record = true});
  EXPECT_EQ(value_at(performance, "head roll", 0), 5);
  EXPECT_EQ(value_at(performance, "head roll", 3), 9);
}

TEST(SetValue, ChannelWithSeveralKeysGetsAKeyEvenWithoutRecording) {
  Performance performance;
  set_key(performance, "head yaw", {0, 0});
  set_key(performance, "head yaw", {2, 20, Easing::hold});
  set_value(performance, "head yaw", 5, {.time_s = 1});
  EXPECT_EQ(performance.channels.at("head yaw").size(), 3u);
  // Within half a frame it is the same key, and keeps its easing.
  set_value(performance, "head yaw", 30, {.time_s = 2.01});
  ASSERT_EQ(performance.channels.at("head yaw").size(), 3u);
  EXPECT_EQ(performance.channels.at("head yaw").back(), (Key{2, 30, Easing::hold}));
}

TEST(SetValue, LinkedSidesChangeTogether) {
  Performance performance;
  set_value(performance, "action mouthSmile_L", 0.5f, {.linked = true});
  EXPECT_EQ(value_at(performance, "action mouthSmile_R", 0), 0.5f);
  set_value(performance, "action mouthSmile_R", 0.2f, {});
  EXPECT_EQ(value_at(performance, "action mouthSmile_L", 0), 0.5f);
}

TEST(SetToRest, ResetsOnlyOnePart) {
  Performance performance;
  set_value(performance, "head yaw", 5, {});
  set_value(performance, "action jawOpen", 1, {});
  set_value(performance, "gaze yaw", 9, {});
  set_value(performance, "camera yaw", 9, {});
  set_to_rest(performance, ChannelPart::face, {.time_s = 1});
  ASSERT_EQ(performance.channels.size(), 2u);
  EXPECT_TRUE(performance.channels.contains("head yaw"));
  EXPECT_TRUE(performance.channels.contains("camera yaw"));
}

TEST(PoseAt, HoldsHeadAndFaceAndCanBeSetAtAnotherTime) {
  Performance performance;
  set_value(performance, "head yaw", 5, {});
  set_value(performance, "action jawOpen", 1, {.time_s = 2, .record = true});
  set_value(performance, "camera yaw", 9, {});
  const PoseValues pose = pose_at(performance, 1);
  EXPECT_EQ(pose.size(), 2u);
  EXPECT_NEAR(pose.at("action jawOpen"), 0.5f, 1e-6f);
  Performance other;
  set_value(other, "head roll", 3, {});
  set_pose(other, pose, {.time_s = 4});
  EXPECT_EQ(pose_at(other, 0), pose);
}

TEST(HoldPose, KeepsAMomentWhateverChangesAroundIt) {
  Performance performance;
  set_key(performance, "head yaw", {0, 0, Easing::linear});
  set_key(performance, "head yaw", {4, 40});
  set_value(performance, "gaze yaw", 7, {});
  hold_pose(performance, 1);
  EXPECT_NEAR(find_key(performance, {"head yaw", 1})->value, 10, 1e-4);
  EXPECT_EQ(find_key(performance, {"gaze yaw", 1})->value, 7);
  set_key(performance, "head yaw", {4, -40});
  EXPECT_NEAR(value_at(performance, "head yaw", 1), 10, 1e-4);
}

}  // namespace
}  // namespace likeness
