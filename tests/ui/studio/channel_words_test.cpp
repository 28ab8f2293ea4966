// Claims about the words of channels: every one has its own, and stands in exactly one group.
#include "ui/studio/channel_words.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "core/head/builtin_head.h"

namespace likeness::ui {
namespace {

const HeadModel& head() {
  static const HeadModel model = make_builtin_head();
  return model;
}

TEST(ChannelWords, NamesOfActionsBecomeWords) {
  EXPECT_EQ(action_words("mouthSmile_L"), "Mouth smile, left");
  EXPECT_EQ(channel_words("action jawOpen"), "Jaw open");
  EXPECT_EQ(channel_words("head yaw"), "Turn");
  std::set<std::string> words;
  for (const char* channel : kPoseChannels)
    EXPECT_TRUE(words.insert(channel_words(channel)).second) << channel;
}

TEST(ChannelWords, EveryChannelButSingleEyesIsInExactlyOneGroup) {
  std::multiset<std::string> grouped, wanted(std::begin(kPoseChannels), std::end(kPoseChannels));
  for (const ChannelGroup& group : group_channels(head()))
    grouped.insert(group.channels.begin(), group.channels.end());
  for (const NamedAction& action : head().actions)
    if (!action.name.starts_with("eyeLook")) wanted.insert(action_channel(action.name));
  EXPECT_EQ(grouped, wanted);
}

TEST(ChannelWords, UnderItsHeadingAChannelDoesNotRepeatIt) {
  const ChannelGroup mouth{"Mouth", {}}, brows{"Brows", {}}, face{"Cheeks and nose", {}}, gaze{"Gaze", {}};
  EXPECT_EQ(words_within(mouth, "action mouthLowerDown_R"), "Lower down, right");
  EXPECT_EQ(words_within(mouth, "action tongueOut"), "Tongue out");
  EXPECT_EQ(words_within(brows, "action browInnerUp"), "Inner up");
  EXPECT_EQ(words_within(face, "action cheekPuff"), "Cheek puff");
  EXPECT_EQ(words_within(gaze, "gaze yaw"), "Look aside");
  // What is shortened is still told from its neighbours.
  for (const ChannelGroup& group : group_channels(head())) {
    std::set<std::string> words;
    for (const std::string& channel : group.channels)
      EXPECT_TRUE(words.insert(words_within(group, channel)).second) << channel;
  }
}

TEST(ChannelWords, SlidersHoldTheRestOfTheirChannel) {
  for (const char* channel : kPoseChannels) {
    const ChannelScale scale = channel_scale(channel);
    EXPECT_LT(scale.low, rest_value(channel)) << channel;
    EXPECT_GT(scale.high, rest_value(channel)) << channel;
  }
}

TEST(BeyondWords, SayHowFarAndWhich) {
  EXPECT_TRUE(beyond_words({}).empty());
  const double degree = std::numbers::pi / 180;
  EXPECT_TRUE(beyond_words({2 * degree, {}}).empty());
  const auto words = beyond_words({30 * degree, {"jawOpen"}});
  ASSERT_EQ(words.size(), 2u);
  EXPECT_NE(words[0].find("30"), std::string::npos);
  EXPECT_NE(words[1].find("Jaw open"), std::string::npos);
}

TEST(BeyondWords, OfWhatWasCheckedSayWhatToFilm) {
  const double degree = std::numbers::pi / 180;
  BeyondSeen beyond;
  beyond.checked = true;
  EXPECT_TRUE(beyond_words(beyond).empty());
  beyond.view = 12 * degree, beyond.sides = {HeadSide::above, HeadSide::left};
  beyond.actions = {"mouthSmile_L", "jawOpen"};
  const auto words = beyond_words(beyond);
  ASSERT_EQ(words.size(), 2u);
  EXPECT_NE(words[0].find("12"), std::string::npos);
  EXPECT_NE(words[0].find(film_again_side(HeadSide::above)), std::string::npos);
  EXPECT_NE(words[1].find("Mouth smile, left, Jaw open"), std::string::npos);
  EXPECT_NE(words[1].find("Smile as broadly"), std::string::npos);
}

}  // namespace
}  // namespace likeness::ui
