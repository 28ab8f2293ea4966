// Claims about landmarks followed between frames, on a texture that moves as a whole: the truth is known.
#include "core/track/points/optical_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace likeness {
namespace {

constexpr int kTextureSide = 220, kTextureFrames = 20;

Vec2d motion(int frame) { return {1.6 * frame, 6 * std::sin(0.4 * frame)}; }

// Smooth noise, the same at every run, sampled at a moving place.
std::uint8_t texture_level(double x, double y) {
  double v = 128;
  for (int k = 1; k <= 6; ++k)
    v += 22.0 * std::sin(0.05 * k * x + 0.083 * k * k * y + k) *
         std::cos(0.061 * k * y - 0.03 * k * x + 2 * k);
  return static_cast<std::uint8_t>(std::clamp(v, 0.0, 255.0));
}

Vec2d true_point(int landmark, int frame) {
  return Vec2d(60 + 8 * (landmark % 9), 60 + 9 * (landmark / 9)) + motion(frame);
}

ClipFrames moving_clip(double jitter_px) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, jitter_px);
  ClipFrames clip;
  clip.region = {0, 0, kTextureSide, kTextureSide};
  for (int f = 0; f < kTextureFrames; ++f) {
    ClipFrame frame;
    frame.frame = f;
    frame.detected = true;
    frame.grey = Image8(kTextureSide, kTextureSide, 1);
    for (int y = 0; y < kTextureSide; ++y)
      for (int x = 0; x < kTextureSide; ++x)
        *frame.grey.at(x, y) = texture_level(x + 0.5 - motion(f).x(), y + 0.5 - motion(f).y());
    Landmarks found;
    found.cluster_share = 1;
    for (int k = 0; k < kLandmarkCount; ++k) {
      found.points[k] = true_point(k, f) + Vec2d(noise(random), noise(random));
      found.spread[k] = jitter_px;
    }
    frame.landmarks = found;
    clip.frames.push_back(std::move(frame));
  }
  return clip;
}

double inner_error(const ClipFrames& clip, int frame) {
  double sum = 0;
  for (int k = 17; k < kLandmarkCount; ++k)
    sum += (clip.frames[frame].landmarks->points[k] - true_point(k, frame)).norm() / (kLandmarkCount - 17);
  return sum;
}

TEST(OpticalSupport, NeighboursSteadyTheLandmarks) {
  ClipFrames clip = moving_clip(1.5);
  const ClipFrames before = clip;
  const auto verdicts = support_landmarks(clip, {}, Progress(), {});
  ASSERT_TRUE(verdicts.ok()) << verdicts.error().what;
  double was = 0, is = 0;
  for (int f = 1; f + 1 < kTextureFrames; ++f) {
    was += inner_error(before, f), is += inner_error(clip, f);
    EXPECT_GT((*verdicts)[f].votes, 40) << f;
    for (int k = 0; k < 17; ++k)
      EXPECT_EQ(clip.frames[f].landmarks->points[k], before.frames[f].landmarks->points[k]);
  }
  EXPECT_LT(is, 0.9 * was);
}

TEST(OpticalSupport, FrameWithoutAFoundFaceIsCarriedOverAndMarked) {
  ClipFrames clip = moving_clip(0.3);
  for (int f : {8, 9, 10}) {
    clip.frames[f].detected = false;
    for (Vec2d& p : clip.frames[f].landmarks->points) p += Vec2d(25, -18);
  }
  const auto verdicts = support_landmarks(clip, {}, Progress(), {});
  ASSERT_TRUE(verdicts.ok());
  for (int f : {8, 9, 10}) {
    EXPECT_TRUE((*verdicts)[f].carried) << f;
    EXPECT_LT(inner_error(clip, f), 5) << f;
  }
  EXPECT_FALSE((*verdicts)[5].carried);
}

TEST(OpticalSupport, JumpAgainstTheMotionRaisesTheUncertainty) {
  ClipFrames clip = moving_clip(0.3);
  for (Vec2d& p : clip.frames[10].landmarks->points) p += Vec2d(12, 0);
  const ClipFrames before = clip;
  const auto verdicts = support_landmarks(clip, {}, Progress(), {});
  ASSERT_TRUE(verdicts.ok());
  EXPECT_GT((*verdicts)[10].disagreement_px, 9);
  EXPECT_LT((*verdicts)[4].disagreement_px, 3);
}

TEST(OpticalSupport, HeldOutFramesNeitherVoteNorChange) {
  ClipFrames clip = moving_clip(1.0);
  for (int f = 14; f < kTextureFrames; ++f) clip.frames[f].held_out = true;
  ClipFrames other = clip;
  for (int f = 14; f < kTextureFrames; ++f) {
    other.frames[f].grey = Image8(kTextureSide, kTextureSide, 1, 77);
    for (Vec2d& p : other.frames[f].landmarks->points) p += Vec2d(40, 40);
  }
  const ClipFrames before = other;
  ASSERT_TRUE(support_landmarks(clip, {}, Progress(), {}).ok());
  ASSERT_TRUE(support_landmarks(other, {}, Progress(), {}).ok());
  for (int f = 0; f < kTextureFrames; ++f)
    for (int k = 0; k < kLandmarkCount; ++k) {
      // Below 14: no held-out frame was used; from 14 on: nothing was changed.
      EXPECT_EQ(other.frames[f].landmarks->points[k],
                (f < 14 ? clip : before).frames[f].landmarks->points[k]);
    }
}

TEST(OpticalSupport, StopsOnRequest) {
  ClipFrames clip = moving_clip(1.0);
  std::stop_source stop;
  stop.request_stop();
  const auto verdicts = support_landmarks(clip, {}, Progress(), stop.get_token());
  ASSERT_FALSE(verdicts.ok());
  EXPECT_EQ(verdicts.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace likeness
