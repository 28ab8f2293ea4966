// Claims about editing: keys keep their order and never share a time.
#include "core/direct/edit_keys.h"

#include <gtest/gtest.h>

#include <random>

namespace likeness::test {
namespace {

Performance two_channels() {
  Performance p;
  set_key(p, "head yaw", {1, 10});
  set_key(p, "head yaw", {0, 5, Easing::hold});
  set_key(p, "head yaw", {2, 20});
  set_key(p, "action jawOpen", {0.5, 1});
  return p;
}

bool in_order(const Performance& p) {
  for (const auto& [channel, keys] : p.channels) {
    if (keys.empty()) return false;
    for (std::size_t i = 1; i < keys.size(); ++i)
      if (keys[i].time_s <= keys[i - 1].time_s + kSameTime_s) return false;
  }
  return true;
}

TEST(EditKeys, AKeyIsInsertedInOrderOrReplacesTheOneAtItsTime) {
  Performance p = two_channels();
  EXPECT_TRUE(in_order(p));
  EXPECT_EQ(p.channels.at("head yaw").size(), 3u);
  set_key(p, "head yaw", {1 + kSameTime_s / 2, -3});
  EXPECT_EQ(p.channels.at("head yaw").size(), 3u);
  EXPECT_FLOAT_EQ(find_key(p, {"head yaw", 1})->value, -3);
  EXPECT_EQ(find_key(p, {"head yaw", 1.5}), nullptr);
  EXPECT_EQ(find_key(p, {"head roll", 1}), nullptr);
  EXPECT_EQ(all_keys(p).size(), 4u);
}

TEST(EditKeys, ErasingTheLastKeyEndsTheChannel) {
  Performance p = two_channels();
  const std::vector<KeyPlace> gone{
      {"action jawOpen", 0.5}, {"head yaw", 1}, {"head yaw", 7}, {"gaze yaw", 0}};
  erase_keys(p, gone);
  EXPECT_FALSE(p.channels.contains("action jawOpen"));
  EXPECT_EQ(p.channels.at("head yaw").size(), 2u);
}

TEST(EditKeys, KeysMoveTogetherAndReplaceThoseTheyMeet) {
  Performance p = two_channels();
  const std::vector<KeyPlace> both{{"head yaw", 0}, {"head yaw", 1}};
  const auto now = move_keys(p, both, 1);
  ASSERT_EQ(now.size(), 2u);
  ASSERT_EQ(p.channels.at("head yaw").size(), 2u);  // 2 s was met
  EXPECT_FLOAT_EQ(find_key(p, {"head yaw", 1})->value, 5);
  EXPECT_EQ(find_key(p, {"head yaw", 1})->easing, Easing::hold);
  EXPECT_FLOAT_EQ(find_key(p, {"head yaw", 2})->value, 10);
}

TEST(EditKeys, NothingMovesBeforeTheStart) {
  Performance p = two_channels();
  const std::vector<KeyPlace> two{{"head yaw", 2}, {"action jawOpen", 0.5}};
  move_keys(p, two, -3);
  EXPECT_FLOAT_EQ(find_key(p, {"action jawOpen", 0})->value, 1);
  EXPECT_FLOAT_EQ(find_key(p, {"head yaw", 1.5})->value, 20);  // kept its distance
  EXPECT_TRUE(in_order(p));
}

TEST(EditKeys, PasteRepeatsTheCopyAtAnotherTime) {
  Performance p = two_channels();
  const std::vector<KeyPlace> some{{"head yaw", 1}, {"action jawOpen", 0.5}};
  const KeyClip clip = copy_keys(p, some);
  const auto places = paste_keys(p, clip, 6);
  EXPECT_EQ(places.size(), 2u);
  EXPECT_FLOAT_EQ(find_key(p, {"action jawOpen", 6})->value, 1);
  EXPECT_FLOAT_EQ(find_key(p, {"head yaw", 6.5})->value, 10);
  EXPECT_DOUBLE_EQ(p.duration_s, 6.5);
  EXPECT_TRUE(paste_keys(p, {}, 1).empty());
}

TEST(EditKeys, AnyEditsKeepTheOrder) {
  std::mt19937 chance(7);
  const auto pick = [&](int n) { return int(chance() % unsigned(n)); };
  const char* channels[] = {"head yaw", "gaze pitch", "action jawOpen"};
  Performance p;
  for (int step = 0; step < 2000; ++step) {
    const std::vector<KeyPlace> keys = all_keys(p);
    std::vector<KeyPlace> some;
    for (const KeyPlace& place : keys)
      if (pick(4) == 0) some.push_back(place);
    switch (pick(5)) {
      case 0:
      case 1:
        set_key(p, channels[pick(3)], {pick(10000) * 3.7e-5, float(pick(10))});
        break;
      case 2:
        move_keys(p, some, (pick(10000) - 5000) * 3.7e-5);
        break;
      case 3:
        if (keys.size() > 30) erase_keys(p, some);
        break;
      case 4:
        if (keys.size() < 60) paste_keys(p, copy_keys(p, some), pick(10000) * 3.7e-5);
    }
    ASSERT_TRUE(in_order(p)) << "after step " << step;
  }
}

TEST(LinkedChannel, IsTheOtherSideOfTheFace) {
  EXPECT_EQ(linked_channel("action mouthSmile_L"), "action mouthSmile_R");
  EXPECT_EQ(linked_channel("action eyeBlink_R"), "action eyeBlink_L");
  EXPECT_EQ(linked_channel("action eyeLookOut_L"), "action eyeLookIn_R");
  EXPECT_EQ(linked_channel("action eyeLookOut_R"), "action eyeLookIn_L");
  EXPECT_EQ(linked_channel("action eyeLookUp_L"), "action eyeLookUp_R");
  EXPECT_EQ(linked_channel("action jawOpen"), "");
  EXPECT_EQ(linked_channel("head yaw"), "");
  for (const char* channel : {"action eyeLookIn_L", "action browDown_R"})
    EXPECT_EQ(linked_channel(linked_channel(channel)), channel);
}

TEST(LayOver, TakeReplacesOnlyHeadAndFace) {
  Performance performance;
  performance.duration_s = 3;
  set_key(performance, "head yaw", {0, 10});
  set_key(performance, "head yaw", {3, 20, Easing::linear});
  set_key(performance, "action jawOpen", {0, 0.5f});
  set_key(performance, "camera yaw", {0, 7});
  Performance take;
  take.duration_s = 2;
  for (int i = 0; i < 50; ++i) set_key(take, "head yaw", {i / 25.0, float(-i), Easing::linear});
  set_key(take, "head roll", {0, 3, Easing::linear});
  const float before = value_at(performance, "head yaw", 0.9);
  lay_over(performance, take, 1);
  EXPECT_NEAR(value_at(performance, "head yaw", 0.9), before, 0.3);  // eased over its shorter stretch
  EXPECT_EQ(value_at(performance, "head yaw", 2), -25);
  EXPECT_EQ(value_at(performance, "action jawOpen", 0.9), 0.5f);
  EXPECT_EQ(value_at(performance, "action jawOpen", 2), 0);  // the take's face is the take's
  EXPECT_EQ(value_at(performance, "head roll", 0.5), 0);
  EXPECT_EQ(value_at(performance, "head roll", 2), 3);
  EXPECT_EQ(value_at(performance, "camera yaw", 2), 7);
  EXPECT_GE(performance.duration_s, 3);
  for (const auto& [channel, keys] : performance.channels)
    for (std::size_t i = 1; i < keys.size(); ++i) EXPECT_GT(keys[i].time_s, keys[i - 1].time_s) << channel;
}

}  // namespace
}  // namespace likeness::test
