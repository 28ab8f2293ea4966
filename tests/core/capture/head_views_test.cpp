// Claims about the sides from which frames see a head: told from few samples, off the typical one, and close
// to the truth of a rendered person; and about an import that splits by them.
#include "core/capture/head_views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/base/files.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/capture/hold_out.h"
#include "core/head/builtin_head.h"
#include "core/synth/demo_stage.h"
#include "tests/core/capture/demo_film.h"

namespace likeness {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr double kViewDegree = std::numbers::pi / 180;

// From the head to a camera that stands so far to the subject's left and above.
Vec3d camera_towards(double yaw_deg, double pitch_deg) {
  const double yaw = kViewDegree * yaw_deg, pitch = kViewDegree * pitch_deg;
  return {std::sin(yaw) * std::cos(pitch), std::sin(pitch), std::cos(yaw) * std::cos(pitch)};
}

std::vector<CaptureFrame> even_clip(int count) {
  std::vector<CaptureFrame> frames;
  for (int i = 0; i < count; ++i) frames.push_back({i, i / 25.0, 100, false, false, ""});
  return frames;
}

// Every fifth frame of a head that turns evenly by a fifth of a degree a frame, looking down a little.
std::vector<FaceSample> turning_head(int count, double first_deg) {
  std::vector<FaceSample> samples;
  for (int i = 0; i < count; i += 5) {
    samples.push_back({i, FaceBox{100, 100, 80, 80, 1}, false});
    samples.back().to_camera = camera_towards(first_deg + 0.2 * i, 4);
  }
  return samples;
}

TEST(HeadViews, LieOffTheTypicalSideAndBetweenTheSamplesOnALine) {
  auto frames = even_clip(201);
  fill_in_views(frames, turning_head(201, 12));  // 12 to 52 degrees
  for (const CaptureFrame& frame : frames) {
    ASSERT_TRUE(frame.view) << frame.frame;
    EXPECT_NEAR(frame.view->yaw_deg, 0.2 * frame.frame - 20, 0.15) << frame.frame;
    EXPECT_NEAR(frame.view->pitch_deg, 0, 0.3) << frame.frame;
  }
}

TEST(HeadViews, AMissingSampleOrTwoAreBridgedAndALongerGapIsNot) {
  auto samples = turning_head(201, 0);
  samples[4].to_camera.reset();                                        // of frame 20
  for (std::size_t i = 20; i < 24; ++i) samples[i].to_camera.reset();  // of frames 100 to 115
  samples.back().to_camera.reset();
  auto frames = even_clip(201);
  fill_in_views(frames, samples);
  for (const CaptureFrame& frame : frames)
    EXPECT_EQ(frame.view.has_value(), frame.frame <= 95 || frame.frame >= 120) << frame.frame;
  samples = turning_head(201, 0);
  for (FaceSample& sample : samples) sample.to_camera.reset();
  fill_in_views(frames, samples);
  for (const CaptureFrame& frame : frames) EXPECT_FALSE(frame.view);
}

TEST(HeadViews, TheAngleOffTheTypicalSideIsThatBetweenTheDirections) {
  for (const HeadView view : {HeadView{0, 0}, {12, 0}, {0, -25}, {30, 20}, {-70, 5}})
    EXPECT_NEAR(std::cos(kViewDegree * angle_deg(view)),
                camera_towards(view.yaw_deg, view.pitch_deg).dot(camera_towards(0, 0)), 1e-9);
}

std::vector<CaptureFrame> frames_seen_from(const std::vector<double>& yaws_deg) {
  auto frames = even_clip(int(yaws_deg.size()));
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].view = {yaws_deg[i], 0};
  return frames;
}

TEST(JudgeSides, SaysHowFarTheHeadTurnsWhereItDoesNotTurnFarEnough) {
  std::vector<double> yaws(100, 2.0);
  yaws[7] = -13.25;
  const auto judged = judge_sides(frames_seen_from(yaws), {}, "clip.mp4");
  ASSERT_FALSE(judged);
  EXPECT_EQ(judged.error().code, ErrorCode::bad_input);
  EXPECT_THAT(judged.error().what, HasSubstr("at most 13.2 degrees"));
  EXPECT_THAT(judged.error().what, HasSubstr("0 lie beyond 20 degrees"));
  EXPECT_THAT(judged.error().fix, HasSubstr("--beyond"));
  EXPECT_EQ(judged.error().where, "clip.mp4");
}

TEST(JudgeSides, SaysSoWhereHardlyAFrameSeesTheTypicalSide) {
  std::vector<double> yaws(100, 25.0);
  for (std::size_t i = 0; i < 12; ++i) yaws[i] = 0;
  const auto judged = judge_sides(frames_seen_from(yaws), {}, "");
  ASSERT_FALSE(judged);
  EXPECT_THAT(judged.error().what, HasSubstr("only 12 lie within 10 degrees"));
  EXPECT_THAT(judged.error().fix, HasSubstr("--inside"));
  for (std::size_t i = 12; i < 30; ++i) yaws[i] = 5;
  EXPECT_TRUE(judge_sides(frames_seen_from(yaws), {}, ""));
}

TEST(JudgeSides, SaysSoWhereTheSideIsNotKnownOfMostFrames) {
  auto frames = frames_seen_from(std::vector<double>(100, 0.0));
  for (std::size_t i = 30; i < 100; ++i) frames[i].view.reset();
  const auto judged = judge_sides(frames, {}, "");
  ASSERT_FALSE(judged);
  EXPECT_THAT(judged.error().what, HasSubstr("30 of 100 frames"));
}

// A demo's person whose head turns as far as it ever does, with the true view of every frame.
class ImportSides : public ::testing::Test {
 protected:
  static constexpr int kFrames = 80;

  static void SetUpTestSuite() {
    if (!FaceDetector::load()) return;  // the tests are skipped
    film_ = new test::FilmFolder;
    DemoOptions demo;
    demo.width = demo.height = 224;
    demo.frames = kFrames;
    demo.samples_per_pixel = 1;
    demo.moving_share = 0;
    DemoStage stage(make_builtin_head(), demo);
    std::vector<Image8> pictures;
    Vec3d sum = Vec3d::Zero();
    std::vector<Vec3d> views;
    for (int f = 0; f < kFrames; ++f) {
      const Shot shot = stage.shot(f);
      pictures.push_back(stage.film(f, {}).rgb);
      views.push_back(inverse(shot.camera.cam_from_world * shot.world_from_head).translation().normalized());
      sum += views.back();
    }
    for (const Vec3d& view : views)
      true_off_deg_.push_back(std::acos(std::min(1.0, view.dot(sum.normalized()))) / kViewDegree);
    test::write_film(film_->path / "a.mp4", pictures, {.crf = 12});
  }
  static void TearDownTestSuite() {
    delete film_;
    film_ = nullptr, true_off_deg_.clear();
  }
  void SetUp() override {
    if (film_ == nullptr) GTEST_SKIP() << "no landmark model is here";
  }
  static Result<Capture> import(const char* project, const SideRange& sides) {
    ImportOptions options{.size = 128, .split = Split::sides};
    options.sides = sides;
    return import_clip(film_->path / "a.mp4", film_->path / project, options, Progress(), {});
  }

  static inline test::FilmFolder* film_ = nullptr;
  static inline std::vector<double> true_off_deg_;
};

TEST_F(ImportSides, TrainsOnTrulyNearFramesAndHoldsOutTrulyFarOnes) {
  constexpr SideRange kSides{22, 28};
  const auto capture = import("p", kSides);
  ASSERT_TRUE(capture) << capture.error().what << capture.error().fix;
  std::vector<double> errors;
  int used = 0, inside = 0, beyond = 0, apart = 0;
  for (const CaptureFrame& frame : capture->frames) {
    const bool written = fs::exists(film_->path / "p" / frame_name(frame.frame));
    EXPECT_EQ(written, frame.used || frame.held_out) << frame.frame;
    used += frame.used, apart += frame.apart;
    if (!frame.view) continue;
    const double off = angle_deg(*frame.view), truth = true_off_deg_[std::size_t(frame.frame)];
    errors.push_back(std::abs(off - truth));
    inside += frame.held_out && off <= kSides.inside_deg, beyond += frame.held_out && off > kSides.beyond_deg;
    if (frame.used) {
      EXPECT_LE(off, kSides.inside_deg) << frame.frame;
      EXPECT_LT(truth, kSides.beyond_deg) << frame.frame;
    }
    if (off > kSides.beyond_deg) {
      EXPECT_TRUE(frame.held_out) << frame.frame;
      EXPECT_GT(truth, kSides.inside_deg) << frame.frame;
    }
    EXPECT_EQ(frame.apart, off > kSides.inside_deg && off <= kSides.beyond_deg) << frame.frame;
  }
  EXPECT_GE(errors.size(), std::size_t(kFrames - 10));
  EXPECT_LT(median(errors), 3);
  EXPECT_GE(used, 20);
  EXPECT_GE(inside, 2);
  EXPECT_GE(beyond, 10);
  EXPECT_GE(apart, 5);
  EXPECT_EQ(int(silent_frames(*capture).size()), inside + beyond + apart);
}

TEST_F(ImportSides, IsTheSameTheSecondTime) {
  std::string texts[2];
  for (int i = 0; i < 2; ++i) {
    const auto capture = import(i == 0 ? "first" : "second", {22, 28});
    ASSERT_TRUE(capture) << capture.error().what;
    ASSERT_TRUE(write_capture(film_->path / "capture.json", *capture));
    texts[i] = *read_text(film_->path / "capture.json");
  }
  EXPECT_EQ(texts[0], texts[1]);
}

TEST_F(ImportSides, IsRefusedWhereTheHeadDoesNotTurnSoFar) {
  const auto capture = import("far", {10, 60});
  ASSERT_FALSE(capture);
  EXPECT_EQ(capture.error().code, ErrorCode::bad_input);
  EXPECT_THAT(capture.error().what, HasSubstr("0 lie beyond 60 degrees"));
  EXPECT_FALSE(fs::exists(film_->path / "far" / "frames"));
  const auto swapped = import("swapped", {20, 10});
  ASSERT_FALSE(swapped);
  EXPECT_THAT(swapped.error().fix, HasSubstr("--beyond"));
}

}  // namespace
}  // namespace likeness
