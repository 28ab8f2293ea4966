// Claims about a span fitted again, on a rendered person whose true track is known and spoilt on purpose.
#include "core/track/clip/refit_span.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <functional>
#include <numbers>

#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/face/landmarks.h"
#include "core/head/builtin_head.h"
#include "core/synth/demo_capture.h"
#include "core/video/decode.h"
#include "core/video/encode.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kRefitSide = 320, kRefitFrames = 44;
constexpr RefitSpan kSpan{18, 25};

double turn_deg(const Pose& a, const Pose& b) {
  return vector_from_turn(a.linear() * b.linear().transpose()).norm() * 180 / std::numbers::pi;
}

bool same_bits(const TrackedFrame& a, const TrackedFrame& b) {
  return a.status == b.status && a.reason == b.reason && a.look == b.look &&
         a.inner_error_px == b.inner_error_px && a.landmarks == b.landmarks &&
         a.landmark_spread == b.landmark_spread && a.pose.torso_shape == b.pose.torso_shape &&
         a.pose.world_from_head.matrix() == b.pose.world_from_head.matrix() &&
         a.pose.world_from_torso.matrix() == b.pose.world_from_torso.matrix() &&
         a.pose.articulation.expression == b.pose.articulation.expression &&
         a.pose.articulation.jaw == b.pose.articulation.jaw &&
         a.pose.articulation.left_eye == b.pose.articulation.left_eye;
}

// One film and its truth for all tests.
class RefitSpans : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string name = (fs::temp_directory_path() / "likeness_refit_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    DemoOptions options;
    options.width = options.height = kRefitSide;
    options.frames = kRefitFrames;
    options.moving_share = 0;
    options.samples_per_pixel = 1;
    ASSERT_TRUE(write_demo_capture(folder_, options, Progress(), {}).ok());
    auto track = read_track(folder_ / "track_truth.json");
    auto cameras = read_cameras(folder_ / "cameras_truth.json");
    ASSERT_TRUE(track.ok() && cameras.ok());
    truth_ = std::move(*track);
    cameras_ = std::move(*cameras);
    for (TrackedFrame& frame : truth_.frames) frame.inner_error_px = 1.5;
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }
  void SetUp() override {
    if (auto detector = FaceDetector::load(); !detector) GTEST_SKIP() << detector.error().what;
  }

  static fs::path clip() { return folder_ / "demo.mp4"; }
  // The film with some of its pictures made grey; lossless, so that they leave no trace in the others.
  static fs::path clip_without(const std::string& name, const std::function<bool(int)>& gone) {
    const fs::path path = folder_ / (name + ".mp4");
    EncodeOptions lossless;
    lossless.crf = 0;
    auto writer = VideoWriter::create(path, kRefitSide, kRefitSide, lossless);
    auto reader = VideoReader::open(clip());
    EXPECT_TRUE(writer.ok() && reader.ok());
    for (int f = 0; f < kRefitFrames; ++f) {
      const auto frame = reader->next();
      EXPECT_TRUE(frame.ok() && frame->has_value());
      EXPECT_TRUE(writer->add(gone(f) ? Image8(kRefitSide, kRefitSide, 3, 120) : (*frame)->rgb).ok());
    }
    EXPECT_TRUE(writer->finish().ok());
    return path;
  }
  // The first half of the span turned and shifted away from the face, the second lost.
  static Track spoilt(const RefitSpan& span) {
    Track track = truth_;
    for (TrackedFrame& frame : track.frames) {
      if (frame.frame < span.first || frame.frame > span.last) continue;
      if (2 * (frame.frame - span.first) > span.last - span.first) {
        frame.status = FrameStatus::lost;
        frame.reason = "no face found";
        frame.landmarks.fill(Vec2d::Zero());
      }
      frame.pose.world_from_head.linear() =
          frame.pose.world_from_head.linear() * rotation_about(Vec3d::UnitY(), 0.45);
      frame.pose.world_from_head.translation() += Vec3d(0.02, 0, 0.03);
    }
    return track;
  }
  static Result<Refit> refit(const Track& track, const RefitSpan& span, const std::set<int>& held_out = {},
                             const fs::path& path = clip(), std::stop_token stop = {},
                             const std::vector<FrameSpan>& shots = {}) {
    RefitOptions options;
    options.track.shots = shots;
    return refit_span(path, {0, 0, kRefitSide, kRefitSide}, cameras_, held_out, model(), track, span, options,
                      Progress(), stop);
  }
  static const HeadModel& model() {
    static const HeadModel head = make_builtin_head();
    return head;
  }

  static inline fs::path folder_;
  static inline Track truth_;
  static inline CameraSet cameras_;
};

TEST_F(RefitSpans, RecoversSpoiltFrames) {
  const Track track = spoilt(kSpan);
  const auto fitted = refit(track, kSpan);
  ASSERT_TRUE(fitted.ok()) << fitted.error().what;
  EXPECT_EQ(fitted->outcome.frames, 8);
  EXPECT_EQ(fitted->outcome.better, 8) << refit_words(fitted->outcome);
  EXPECT_GE(fitted->outcome.good, 6);
  ASSERT_EQ(fitted->frames.size(), 8u);
  for (const TrackedFrame& frame : fitted->frames) {
    const TrackedFrame& truth = *find_tracked(truth_, frame.frame);
    EXPECT_LT(turn_deg(frame.pose.world_from_head, truth.pose.world_from_head), 3.0) << frame.frame;
    EXPECT_LT((frame.pose.world_from_head.translation() - truth.pose.world_from_head.translation()).norm(),
              0.015)
        << frame.frame;
    EXPECT_NE(frame.status, FrameStatus::lost) << frame.frame;
    EXPECT_EQ(frame.pose.world_from_torso.matrix(), truth.pose.world_from_torso.matrix());
  }
  Track whole = track;
  put_frames(fitted->frames, whole);
  for (std::size_t i = 0; i < whole.frames.size(); ++i) {
    const int number = whole.frames[i].frame;
    const bool inside = number >= kSpan.first && number <= kSpan.last;
    EXPECT_EQ(same_bits(whole.frames[i], track.frames[i]), !inside) << number;
  }
  // The same again, on one thread.
  const ThreadLimit alone(1);
  const auto again = refit(track, kSpan);
  ASSERT_TRUE(again.ok());
  for (std::size_t i = 0; i < again->frames.size(); ++i)
    EXPECT_TRUE(same_bits(again->frames[i], fitted->frames[i])) << again->frames[i].frame;
}

TEST_F(RefitSpans, GoodFramesStayBitIdentical) {
  const auto fitted = refit(truth_, kSpan);
  ASSERT_TRUE(fitted.ok()) << fitted.error().what;
  EXPECT_EQ(fitted->outcome.better, 0) << refit_words(fitted->outcome);
  for (const TrackedFrame& frame : fitted->frames)
    EXPECT_TRUE(same_bits(frame, *find_tracked(truth_, frame.frame))) << frame.frame;
}

TEST_F(RefitSpans, InventsNoFaceWhereNoneIsSeen) {
  const Track track = spoilt(kSpan);
  const auto in_span = [](int f) { return f >= kSpan.first && f <= kSpan.last; };
  const auto fitted = refit(track, kSpan, {}, clip_without("nobody", in_span));
  ASSERT_TRUE(fitted.ok()) << fitted.error().what;
  EXPECT_EQ(fitted->outcome.better, 0) << refit_words(fitted->outcome);
  for (const TrackedFrame& frame : fitted->frames)
    EXPECT_TRUE(same_bits(frame, *find_tracked(track, frame.frame))) << frame.frame;
}

TEST_F(RefitSpans, AHeldOutFrameTeachesNoTrainingFrame) {
  const Track track = spoilt(kSpan);
  std::set<int> held_out;
  for (int f = 22; f <= 26; ++f) held_out.insert(f);
  const auto seen = refit(track, kSpan, held_out, clip_without("all", [](int) { return false; }));
  const auto hidden =
      refit(track, kSpan, held_out, clip_without("held", [&](int f) { return held_out.contains(f); }));
  ASSERT_TRUE(seen.ok() && hidden.ok());
  bool differs = false;
  for (std::size_t i = 0; i < seen->frames.size(); ++i) {
    const bool same = same_bits(seen->frames[i], hidden->frames[i]);
    if (held_out.contains(seen->frames[i].frame))
      differs |= !same;
    else
      EXPECT_TRUE(same) << seen->frames[i].frame;
  }
  EXPECT_TRUE(differs);
}

TEST_F(RefitSpans, AHeldOutFrameKnowsNothingAfterIt) {
  const RefitSpan span{22, 25};
  const Track track = spoilt(span);
  std::set<int> held_out;
  for (int f = 22; f <= 29; ++f) held_out.insert(f);
  const auto whole = refit(track, span, held_out, clip_without("to_the_end", [](int) { return false; }));
  const auto cut = refit(track, span, held_out, clip_without("cut", [](int f) { return f > 25; }));
  const auto shorter = refit(track, {22, 23}, held_out, clip_without("short", [](int f) { return f > 23; }));
  ASSERT_TRUE(whole.ok() && cut.ok() && shorter.ok());
  EXPECT_GE(whole->outcome.better, 3) << refit_words(whole->outcome);
  for (std::size_t i = 0; i < whole->frames.size(); ++i)
    EXPECT_TRUE(same_bits(whole->frames[i], cut->frames[i])) << whole->frames[i].frame;
  for (std::size_t i = 0; i < shorter->frames.size(); ++i)
    EXPECT_TRUE(same_bits(whole->frames[i], shorter->frames[i])) << whole->frames[i].frame;
}

TEST_F(RefitSpans, NothingIsReadBeyondACut) {
  const Track track = spoilt(kSpan);
  constexpr int kCut = 26;  // the first frame of the next shot
  const std::vector<FrameSpan> shots{{0, kCut - 1}, {kCut, kRefitFrames - 1}};
  const auto gone = [](int f) { return f >= kCut; };
  const auto whole = refit(track, kSpan, {}, clip_without("uncut", [](int) { return false; }), {}, shots);
  const auto ends = refit(track, kSpan, {}, clip_without("ends", gone), {}, shots);
  ASSERT_TRUE(whole.ok() && ends.ok());
  EXPECT_GE(whole->outcome.better, 6) << refit_words(whole->outcome);
  for (std::size_t i = 0; i < whole->frames.size(); ++i)
    EXPECT_TRUE(same_bits(whole->frames[i], ends->frames[i])) << whole->frames[i].frame;
}

TEST_F(RefitSpans, RefusesWithAReasonAndStopsOnRequest) {
  for (const RefitSpan& span : {RefitSpan{40, 50}, RefitSpan{100, 120}, RefitSpan{9, 3}}) {
    const auto refused = refit(truth_, span);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::bad_input);
    EXPECT_NE(refused.error().fix.find("0 to 43"), std::string::npos) << refused.error().fix;
  }
  std::stop_source source;
  source.request_stop();
  const auto stopped = refit(truth_, kSpan, {}, clip(), source.get_token());
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
  Track other = truth_;
  other.head_model_hash = "another";
  EXPECT_FALSE(refit(other, kSpan).ok());
  // All of the clip: nothing is left to start from.
  const auto alone = refit(truth_, {0, kRefitFrames - 1});
  ASSERT_TRUE(alone.ok());
  EXPECT_EQ(alone->outcome.better, 0);
}

TEST(RefitSpan, MergesAdjoiningSpans) {
  EXPECT_EQ(merged_spans({{20, 22}, {4, 6}, {7, 9}, {21, 30}, {12, 12}}),
            (std::vector<RefitSpan>{{4, 9}, {12, 12}, {20, 30}}));
  EXPECT_TRUE(merged_spans({}).empty());
}

TEST(RefitSpan, SaysWhatHappened) {
  EXPECT_EQ(refit_words({{190, 204}, 15, 12, 9, 1}),
            "Frames 190 to 204 fitted again: 12 of 15 lie better, 9 are good (before 1).");
  EXPECT_EQ(refit_words({{3, 4}, 2, 1, 1, 0}),
            "Frames 3 to 4 fitted again: 1 of 2 lies better, 1 is good (before 0).");
  EXPECT_EQ(refit_words({{3, 4}, 2, 0, 1, 1}),
            "Frames 3 to 4 fitted again: nothing lies better, so all keep what they had.");
  EXPECT_EQ(refit_words({{3, 3}, 1, 1, 1, 0}), "Frame 3 fitted again: it lies better.");
}

}  // namespace
}  // namespace likeness
