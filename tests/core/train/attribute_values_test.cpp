// Claims about core/train/attribute_values.h: amounts of a made-up attribute come back from a few annotated
// frames, frames unlike any of them are marked, and nothing is learnt from held-out frames.
#include "core/train/attribute_values.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace likeness {
namespace {

struct Clip {
  std::vector<LookedFrame> frames;
  std::vector<double> truth;
};

// Looks of 60 points: the attribute along one pattern, an expression along another, noise. Of frame 150 on
// the region looks like nothing before.
Clip made_up(int frames, std::uint32_t seed, double noise = 0.02) {
  constexpr int kPoints = 60;
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  Eigen::VectorXf pattern(3 * kPoints), other(3 * kPoints), strange(3 * kPoints);
  for (int i = 0; i < 3 * kPoints; ++i)
    pattern[i] = 0.1f * normal(random), other[i] = 0.1f * normal(random), strange[i] = 0.5f * normal(random);
  Clip clip;
  for (int i = 0; i < frames; ++i) {
    const double t = i / 25.0, amount = std::max(0.0, std::sin(1.7 * t)), face = std::sin(4.1 * t + 1);
    LookedFrame frame;
    frame.look.colours = float(amount) * pattern + float(face) * other;
    for (float& v : frame.look.colours) v += float(noise) * normal(random);
    if (i >= 150) frame.look.colours += strange * float(1 + 0.2 * std::sin(9 * t));
    frame.look.seen.assign(kPoints, 1), frame.look.share = 1;
    frame.aside = Eigen::VectorXf::Constant(1, float(face));
    frame.time_s = t;
    clip.frames.push_back(frame), clip.truth.push_back(amount);
  }
  return clip;
}

void annotate(Clip& clip, std::initializer_list<int> frames) {
  for (const int i : frames)
    clip.frames[std::size_t(i)].annotated = true,
    clip.frames[std::size_t(i)].value = clip.truth[std::size_t(i)];
}

double correlation(const Clip& clip, const AmountFit& fit, std::size_t first, std::size_t last) {
  double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
  for (std::size_t i = first; i < last; ++i) {
    const double a = clip.truth[i], b = double(fit.frames[i].value);
    ++n, x += a, y += b, xx += a * a, yy += b * b, xy += a * b;
  }
  return (n * xy - x * y) / std::sqrt((n * xx - x * x) * (n * yy - y * y));
}

TEST(AttributeValues, AreRecoveredFromEightAnnotatedFrames) {
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    Clip clip = made_up(150, seed);
    annotate(clip, {2, 10, 23, 35, 60, 71, 95, 110});
    const AmountFit fit = regress_amounts(clip.frames);
    EXPECT_GT(correlation(clip, fit, 0, 150), 0.97) << seed;
    EXPECT_LT(fit.left_out_error, 0.25) << seed;
    EXPECT_LT(fit.unlike_any, 15) << seed;
    for (std::size_t i = 0; i < 150; ++i)
      if (clip.frames[i].annotated) {
        EXPECT_EQ(fit.frames[i].value, float(clip.truth[i]));
        EXPECT_EQ(fit.frames[i].uncertainty, 0);
      }
  }
}

TEST(AttributeValues, FramesUnlikeAnyAnnotatedOneAreMarked) {
  Clip clip = made_up(200, 4);
  annotate(clip, {2, 10, 23, 35, 60, 71, 95, 110});
  const AmountFit fit = regress_amounts(clip.frames);
  int strange = 0, usual = 0;
  for (std::size_t i = 0; i < 150; ++i) usual += fit.frames[i].uncertainty > kUnlikeAny;
  for (std::size_t i = 150; i < 200; ++i) strange += fit.frames[i].uncertainty > kUnlikeAny;
  EXPECT_LT(usual, 15);
  EXPECT_GT(strange, 40);
  EXPECT_EQ(fit.unlike_any, usual + strange);
}

TEST(AttributeValues, StayWithinWhatWasAnnotatedHoweverStrangeTheLook) {
  Clip clip = made_up(200, 4);  // the last fifty frames look like none of the others
  annotate(clip, {2, 10, 23, 35, 60, 71, 95, 110});
  float low = 1, high = -1;
  for (const LookedFrame& frame : clip.frames)
    if (frame.annotated) low = std::min(low, float(frame.value)), high = std::max(high, float(frame.value));
  for (const FrameAmount& amount : regress_amounts(clip.frames).frames) {
    EXPECT_GE(amount.value, low);
    EXPECT_LE(amount.value, high);
  }
}

TEST(AttributeValues, FramesThatAreNotSeenTakeTheirNeighboursAmounts) {
  Clip clip = made_up(150, 5);
  annotate(clip, {2, 10, 23, 35, 60, 71, 95, 110});
  const AmountFit whole = regress_amounts(clip.frames);
  for (std::size_t i = 20; i < 23; ++i)
    clip.frames[i].look = {Eigen::VectorXf::Zero(180), std::vector<std::uint8_t>(60), 0};
  const AmountFit fit = regress_amounts(clip.frames);
  for (std::size_t i = 20; i < 23; ++i) {
    EXPECT_EQ(fit.frames[i].uncertainty, 1) << i;
    EXPECT_NEAR(fit.frames[i].value, whole.frames[i].value, 0.2f) << i;
  }
}

TEST(AttributeValues, HeldOutFramesTeachNothing) {
  Clip clip = made_up(150, 6);
  annotate(clip, {2, 10, 23, 35, 60, 71, 95, 110});
  for (std::size_t i = 130; i < 150; ++i) clip.frames[i].training = false, clip.frames[i].run = -1;
  const AmountFit fit = regress_amounts(clip.frames);
  EXPECT_GT(correlation(clip, fit, 130, 150), 0.9) << "their own amounts are found";
  for (std::size_t i = 130; i < 150; ++i) clip.frames[i].look.colours *= -3.f;
  const AmountFit other = regress_amounts(clip.frames);
  for (std::size_t i = 0; i < 130; ++i) ASSERT_EQ(fit.frames[i].value, other.frames[i].value) << i;
}

TEST(AttributeValues, AnnotatedFramesThatShowTooLittleTeachNothing) {
  Clip clip = made_up(150, 8);
  annotate(clip, {2, 10, 23, 35, 60, 71, 95, 110});
  const AmountFit fit = regress_amounts(clip.frames);
  LookedFrame& turned = clip.frames[45];  // annotated with 1, but the region is not seen
  turned.look = {Eigen::VectorXf::Zero(180), std::vector<std::uint8_t>(60), 0};
  turned.annotated = true, turned.value = 1;
  const AmountFit other = regress_amounts(clip.frames);
  EXPECT_EQ(other.frames[45].value, 1);
  EXPECT_NEAR(other.left_out_error, fit.left_out_error, 0.02);
  EXPECT_GT(correlation(clip, other, 50, 150), 0.97);
}

TEST(AttributeValues, NeedTwoFramesThatShowItDifferently) {
  Clip clip = made_up(60, 9);
  EXPECT_FALSE(can_regress(clip.frames));
  annotate(clip, {20});
  EXPECT_FALSE(can_regress(clip.frames));
  clip.frames[5].annotated = true, clip.frames[5].value = clip.frames[20].value;
  EXPECT_FALSE(can_regress(clip.frames)) << "both show the same";
  clip.frames[5].value = clip.frames[20].value - 0.5;
  EXPECT_TRUE(can_regress(clip.frames));
  clip.frames[5].look.share = 0;
  EXPECT_FALSE(can_regress(clip.frames)) << "one of them is turned away";
  for (LookedFrame& frame : clip.frames) frame.look.share = 0;
  EXPECT_FALSE(can_regress(clip.frames));
}

TEST(AttributeValues, StayInRangeWhateverTheLooks) {
  Clip clip = made_up(60, 7, 5.0);
  annotate(clip, {2, 40});
  clip.frames[40].value = -1, clip.frames[2].value = 1;
  for (const FrameAmount& frame : regress_amounts(clip.frames).frames) {
    EXPECT_LE(std::abs(frame.value), 1);
    EXPECT_GE(frame.uncertainty, 0);
    EXPECT_LE(frame.uncertainty, 1);
  }
}

}  // namespace
}  // namespace likeness
