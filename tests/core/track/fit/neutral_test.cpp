// Claims about a person's calibrated resting face.
#include "core/track/fit/neutral.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/rigid.h"
#include "tests/core/face/synthetic_face.h"

namespace likeness {
namespace {

struct Take {
  double speech = 0.4;  // share of the frames
  double smile = 0.15;  // share of the frames, held
  double noise = 0.02;
  int frames = 300;
};

// A person whose rest is not zero: frames of rest, speech in stretches, a held smile and blinks.
std::vector<TrackedFrame> perform(const Articulation& rest, const Take& take) {
  const HeadModel& model = test_head();
  std::mt19937 random(11);
  std::normal_distribution<float> normal;
  std::vector<TrackedFrame> frames;
  for (int i = 0; i < take.frames; ++i) {
    TrackedFrame f;
    f.frame = i;
    f.pose.articulation = rest;
    const double share = double(i) / take.frames;
    const auto act = [&](const char* name, float amount) {
      add_action(f.pose.articulation, *find_action(model, name), amount);
    };
    if (share < take.speech) {
      const double syllable = i / 6.0;
      act("jawOpen", 0.4f * float(std::pow(std::sin(syllable), 2)));
      act("mouthFunnel", 0.3f * float(std::pow(std::sin(0.37 * syllable), 2)));
      act("mouthStretch_L", 0.3f * float(std::pow(std::sin(0.23 * syllable), 2)));
      act("mouthStretch_R", 0.3f * float(std::pow(std::sin(0.23 * syllable), 2)));
    } else if (share < take.speech + take.smile) {
      act("mouthSmile_L", 0.8f), act("mouthSmile_R", 0.8f), act("cheekSquint_L", 0.5f);
    }
    if (i % 50 < 6) act("eyeBlink_L", 0.9f), act("eyeBlink_R", 0.9f);
    for (float& v : f.pose.articulation.expression) v += float(take.noise) * normal(random);
    f.pose.articulation.jaw.x() += 0.2f * float(take.noise) * normal(random);
    f.pose.world_from_head.linear() = rotation_about(Vec3d::UnitY(), 0.3 * std::sin(i / 20.0));
    frames.push_back(f);
  }
  return frames;
}

Articulation odd_rest() {
  Articulation rest = neutral_articulation(test_head());
  add_action(rest, *find_action(test_head(), "browDown_L"), 0.4f);
  add_action(rest, *find_action(test_head(), "browDown_R"), 0.35f);
  add_action(rest, *find_action(test_head(), "mouthFrown_L"), 0.2f);
  add_action(rest, *find_action(test_head(), "jawOpen"), 0.05f);
  rest.left_eye = rest.right_eye = Vec3f(0.05f, -0.04f, 0);
  return rest;
}

void expect_near(const Articulation& a, const Articulation& b, double tolerance) {
  EXPECT_LT((a.expression - b.expression).cwiseAbs().maxCoeff(), tolerance);
  EXPECT_LT((a.jaw - b.jaw).cwiseAbs().maxCoeff(), tolerance);
  EXPECT_LT((a.left_eye - b.left_eye).cwiseAbs().maxCoeff(), tolerance);
}

TEST(Neutral, IsTheRestOfAPersonWhoTalksTwoFifthsOfTheTime) {
  expect_near(calibrate_neutral(test_head(), perform(odd_rest(), {}), {}), odd_rest(), 0.05);
}

TEST(Neutral, SurvivesMoreSpeechThanRest) {
  const Take take{.speech = 0.6, .smile = 0.1};
  expect_near(calibrate_neutral(test_head(), perform(odd_rest(), take), {}), odd_rest(), 0.06);
}

TEST(Neutral, HeldOutAndLostFramesTakeNoPart) {
  auto frames = perform(odd_rest(), {});
  const Articulation before = calibrate_neutral(test_head(), std::span(frames).first(270), {});
  std::set<int> held_out;
  for (int i = 270; i < 300; ++i) {
    frames[std::size_t(i)].pose.articulation.expression.setConstant(0.9f);
    if (i < 285)
      held_out.insert(i);
    else
      frames[std::size_t(i)].status = FrameStatus::lost;
  }
  const Articulation after = calibrate_neutral(test_head(), frames, held_out);
  EXPECT_EQ(before.expression, after.expression);
  EXPECT_EQ(before.jaw, after.jaw);
}

TEST(Neutral, IsThatOfTheFramesChosenTimesTheirTrust) {
  auto frames = perform(odd_rest(), {.speech = 0, .smile = 0.9});
  RestChoice rest;
  for (int i = 280; i < 296; ++i) rest.frames.push_back(i);
  expect_near(calibrate_neutral(test_head(), frames, {}, rest), odd_rest(), 0.05);
  rest.trust = 0.5;
  const Articulation half = calibrate_neutral(test_head(), frames, {}, rest);
  EXPECT_LT((half.expression - 0.5f * odd_rest().expression).cwiseAbs().maxCoeff(), 0.05);
  // Those held out do not count.
  rest.trust = 1;
  RestChoice more = rest;
  more.frames.insert(more.frames.begin(), {10, 20});
  EXPECT_EQ(calibrate_neutral(test_head(), frames, {10, 20}, more).expression,
            calibrate_neutral(test_head(), frames, {10, 20}, rest).expression);
}

TEST(Neutral, OfNothingIsZero) {
  const Articulation neutral = calibrate_neutral(test_head(), {}, {});
  EXPECT_EQ(neutral.expression.size(), test_head().expression_count());
  EXPECT_EQ(neutral.expression.cwiseAbs().maxCoeff(), 0);
}

}  // namespace
}  // namespace likeness
