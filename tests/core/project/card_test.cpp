// Claims about the card: it finds the moments that were spoilt on purpose, says why, and asks for what is
// missing.
#include "core/project/card.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "core/base/rigid.h"
#include "tests/core/export/tiny_project.h"
#include "tests/core/lab/truth/acted_track.h"

namespace likeness::test {
namespace {

using testing::HasSubstr;

constexpr double kDegrees = 180 / std::numbers::pi;

// Twelve seconds of even track, the head turning by 29 degrees to each side and nodding by 11.
struct Clip {
  explicit Clip(int frames = 300) {
    TrackTruth acted = acted_truth(frames);
    track = acted.track;
    track.neutral = neutral_articulation(acting_head());
    cameras = acted.cameras;
    capture.width = capture.height = 512, capture.crop = {0, 0, 512};
    for (TrackedFrame& frame : track.frames) {
      frame.inner_error_px = 1.5;
      frame.pose.articulation = neutral_articulation(acting_head());
      capture.frames.push_back({frame.frame, frame.time_s, 100, false, true, ""});
    }
  }
  void turn(int from, int to, double yaw) {
    for (int i = from; i < to; ++i) {
      Pose& pose = track.frames[std::size_t(i)].pose.world_from_head;
      pose.translation() = Vec3d(0, 0, 0.6);
      pose.linear() = Mat3d(Vec3d(1, -1, -1).asDiagonal()) * rotation_about(Vec3d::UnitY(), yaw);
    }
  }
  Card card() const { return make_card(capture, cameras, track, {}, filmed_avatar(), acting_head()); }

  Capture capture;
  CameraSet cameras;
  Track track;
};

TEST(Card, AnEvenTrackHasNoWorstMoments) {
  const Card card = Clip().card();
  EXPECT_TRUE(card.worst.empty());
  EXPECT_EQ(card.trained, 300);
  EXPECT_NEAR(card.high.yaw * kDegrees, 29, 3);
  EXPECT_NEAR(card.low.yaw * kDegrees, -29, 3);
}

TEST(Card, TheSpoiltMomentsAreFoundWorstFirstWithTheirCause) {
  Clip clip;
  for (int i = 40; i < 65; ++i) clip.track.frames[std::size_t(i)].status = FrameStatus::lost;
  for (int i = 125; i < 150; ++i) {
    clip.track.frames[std::size_t(i)].inner_error_px = 3.6;
    add_action(clip.track.frames[std::size_t(i)].pose.articulation, *find_action(acting_head(), "browDown_L"),
               0.9f);
    add_action(clip.track.frames[std::size_t(i)].pose.articulation, *find_action(acting_head(), "browDown_R"),
               0.9f);
  }
  for (int i = 220; i < 245; ++i) {
    clip.capture.frames[std::size_t(i)].used = false;
    clip.capture.frames[std::size_t(i)].refused = "Blurred: sharpness 9, its neighbours' median is 40.";
    clip.track.frames[std::size_t(i)].inner_error_px = 2.7;
  }
  const Card card = clip.card();
  ASSERT_EQ(card.worst.size(), 3u);
  const auto within = [](const CardMoment& m, double from, double to) {
    return m.from_s >= from - 0.1 && m.to_s <= to + 0.1 && m.to_s > m.from_s;
  };
  EXPECT_TRUE(within(card.worst[0], 1.6, 2.6)) << card.worst[0].from_s;
  EXPECT_THAT(card.worst[0].what, HasSubstr("lost"));
  EXPECT_TRUE(within(card.worst[1], 5, 6)) << card.worst[1].from_s;
  EXPECT_THAT(card.worst[1].film_again, HasSubstr("brows together"));
  EXPECT_TRUE(within(card.worst[2], 8.8, 9.8)) << card.worst[2].from_s;
  EXPECT_THAT(card.worst[2].what, HasSubstr("blurred"));
  EXPECT_GT(card.worst[0].badness, card.worst[1].badness);
  EXPECT_EQ(card.lost, 25);
  EXPECT_EQ(card.refused, 25);
  EXPECT_EQ(card.trained, 250);
}

TEST(Card, AFarTurnIsNamedAsSuch) {
  Clip clip;
  clip.turn(100, 130, 0.9);
  for (int i = 100; i < 130; ++i) clip.track.frames[std::size_t(i)].status = FrameStatus::weak;
  const Card card = clip.card();
  ASSERT_EQ(card.worst.size(), 1u);
  EXPECT_THAT(card.worst[0].what, HasSubstr("turned"));
}

TEST(Card, ASmileInThePicturesCountsWhereTheTrackSawNone) {
  const Clip clip;
  const auto learnt = [&](const SeenMouth& mouth) {
    const Card card =
        make_card(clip.capture, clip.cameras, clip.track, {}, filmed_avatar(), acting_head(), mouth);
    const bool asked = std::ranges::any_of(card.gaps, [](const CardGap& gap) {
      return gap.what.find("A smile was never") != std::string::npos;
    });
    const Learnt smile = std::ranges::find(card.expressions, "mouthSmile", &CardExpression::name)->learnt;
    EXPECT_EQ(asked, smile == Learnt::never);
    return smile;
  };
  EXPECT_EQ(learnt({}), Learnt::never);
  EXPECT_EQ(learnt({.widest = 1.1, .smile = 0.3}), Learnt::little);
  EXPECT_EQ(learnt({.widest = 1.2, .smile = 0.8}), Learnt::well);
  EXPECT_EQ(learnt({.widest = 1.07, .smile = 0.1, .teeth = true}), Learnt::well);
}

TEST(Card, WhatWasNotSeenIsAskedFor) {
  const Card card = Clip().card();
  const auto learnt = [&](const char* name) {
    return std::ranges::find(card.expressions, name, &CardExpression::name)->learnt;
  };
  EXPECT_EQ(learnt("jawOpen"), Learnt::well);
  EXPECT_EQ(learnt("mouthSmile"), Learnt::never);  // one side only
  const auto asked = [&](const std::string& word) {
    return std::ranges::any_of(card.gaps, [&](const CardGap& gap) {
      EXPECT_FALSE(gap.film_again.empty());
      return gap.what.find(word) != std::string::npos;
    });
  };
  EXPECT_TRUE(asked("A smile"));
  EXPECT_FALSE(asked("open mouth"));
  Clip narrow;
  narrow.turn(0, 300, 0.2);  // always a little to the left, which shows the right side
  const Card turned = narrow.card();
  const auto side = [&](const std::string& word) {
    return std::ranges::any_of(turned.gaps,
                               [&](const CardGap& gap) { return gap.what.find(word) != std::string::npos; });
  };
  EXPECT_TRUE(side("the person's left only up to 0 degrees"));
  EXPECT_TRUE(side("the person's right only up to 11 degrees"));
  Clip wide;
  wide.turn(0, 150, 0.7), wide.turn(150, 300, -0.7);
  for (const CardGap& gap : wide.card().gaps)
    EXPECT_EQ(gap.what.find("person's"), std::string::npos) << gap.what;
}

}  // namespace
}  // namespace likeness::test
