// Claims about the verdict: a good clip passes, each fault alone is named, with the stretch that shows it.
#include "core/check/verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

namespace likeness {
namespace {

// A minute of a person who turns, nods and speaks before a resting camera.
ClipMeasures good_clip() {
  ClipMeasures clip;
  clip.info.width = 1920, clip.info.height = 1080, clip.info.frames_per_second = 30;
  clip.frames = 1800, clip.duration_s = 60;
  clip.camera = {true, 0.4, 0.5, {1, 0}, 200};
  for (int i = 0; i < 300; ++i) {
    Look look;
    look.frame = 6 * i, look.time_s = 0.2 * i;
    look.face = FaceBox{700, 300, 320, 320, 1};
    look.sharpness = 400, look.level = 120, look.posed = true;
    const double wave = std::sin(2 * std::numbers::pi * i / 75.0);
    look.yaw_deg = 40 * wave, look.pitch_deg = 12 * std::cos(2 * std::numbers::pi * i / 75.0);
    for (std::size_t d = 0; d < kKeyExpressions.size(); ++d)
      look.expressions[d] = 0.5 + 0.5 * std::sin(0.9 * i + static_cast<double>(d));
    clip.looks.push_back(look);
  }
  return clip;
}

std::vector<Fault> faults(const CaptureVerdict& verdict) {
  std::vector<Fault> list;
  for (const Remark& r : verdict.remarks) list.push_back(r.fault);
  return list;
}

template <class Spoil>
CaptureVerdict spoilt(Spoil spoil) {
  ClipMeasures clip = good_clip();
  spoil(clip);
  return judge_capture(clip);
}

using testing::ElementsAre;

TEST(Verdict, AGoodClipIsReady) {
  const CaptureVerdict verdict = judge_capture(good_clip());
  EXPECT_EQ(verdict.verdict, Verdict::ready);
  EXPECT_TRUE(verdict.remarks.empty());
}

TEST(Verdict, FaultOfOneStretchIsNamedWithItsTime) {
  const CaptureVerdict verdict = spoilt([](ClipMeasures& clip) {
    for (Look& look : clip.looks)
      if (look.time_s >= 20 && look.time_s < 35) look.sharpness = 5;
  });
  ASSERT_THAT(faults(verdict), ElementsAre(Fault::blurred));
  EXPECT_EQ(verdict.verdict, Verdict::usable);
  EXPECT_NEAR(verdict.remarks[0].from_s, 20, 0.21);
  EXPECT_NEAR(verdict.remarks[0].to_s, 35, 0.21);
  EXPECT_FALSE(verdict.remarks[0].remedy.empty());
}

TEST(Verdict, FaultOfTheWholeClipMeansFilmingAgain) {
  const CaptureVerdict verdict = spoilt([](ClipMeasures& clip) {
    for (Look& look : clip.looks) look.sharpness = 5;
  });
  EXPECT_EQ(verdict.verdict, Verdict::refilm);
  EXPECT_THAT(faults(verdict), ElementsAre(Fault::blurred));
}

TEST(Verdict, EachSingleFaultIsTheOnlyOneNamed) {
  const auto each = [](auto spoil) {
    return faults(spoilt([&](ClipMeasures& clip) {
      for (Look& look : clip.looks) spoil(look);
    }));
  };
  EXPECT_THAT(each([](Look& l) { l.level = 20, l.dark_share = 0.8; }), ElementsAre(Fault::too_dark));
  EXPECT_THAT(each([](Look& l) { l.bright_share = 0.5; }), ElementsAre(Fault::too_bright));
  EXPECT_THAT(each([](Look& l) { l.face->width = 60; }), ElementsAre(Fault::small_face));
  EXPECT_THAT(each([](Look& l) { l.cut_share = 0.3; }), ElementsAre(Fault::head_cut));
  EXPECT_THAT(each([](Look& l) { l.yaw_deg = l.pitch_deg = 3; }), ElementsAre(Fault::few_angles));
  EXPECT_THAT(each([](Look& l) { l.expressions.fill(0.1); }), ElementsAre(Fault::few_expressions));
  EXPECT_THAT(each([](Look& l) { l.second_face = true; }), ElementsAre(Fault::second_person));
  EXPECT_THAT(each([](Look& l) {
                if (l.time_s > 30) l.level = 40;
              }),
              ElementsAre(Fault::light_changes));
  EXPECT_THAT(faults(spoilt([](ClipMeasures& clip) { clip.duration_s = 4; })), ElementsAre(Fault::too_short));
  const Error cut{ErrorCode::bad_input, "Cut short.", "Copy it again.", ""};
  EXPECT_THAT(faults(spoilt([&](ClipMeasures& clip) { clip.fault = cut; })), ElementsAre(Fault::incomplete));
  EXPECT_THAT(faults(spoilt([](ClipMeasures& clip) {
                clip.camera = {false, 30, 12, {20, 0.5}, 200};
              })),
              ElementsAre(Fault::camera_shakes));
  EXPECT_THAT(faults(spoilt([](ClipMeasures& clip) {
                clip.camera = {false, 900, 800, {700, 0.1}, 5, CameraKind::walking, false};
              })),
              ElementsAre(Fault::plain_background));
  // Whose background one turning camera explains needs no features to be followed.
  EXPECT_THAT(faults(spoilt([](ClipMeasures& clip) {
                clip.camera = {false, 900, 800, {700, 0.1}, 5, CameraKind::handheld};
              })),
              ElementsAre());
}

TEST(Verdict, WidelyShakingHandIsNotTakenForAGuidedCamera) {
  // Three percent of the width to either side, four times a second: its swings add up to a long way.
  EXPECT_THAT(faults(spoilt([](ClipMeasures& clip) {
                clip.camera = {false, 9000, 8000, {60, 8}, 200};
              })),
              ElementsAre(Fault::camera_shakes));
  EXPECT_THAT(faults(spoilt([](ClipMeasures& clip) {
                clip.camera = {false, 30000, 30000, {200, 6}, 200};
              })),
              ElementsAre(Fault::camera_shakes));
}

TEST(Verdict, MovingCameraBeforeARichBackgroundIsNotAFault) {
  EXPECT_EQ(spoilt([](ClipMeasures& clip) {
              clip.camera = {false, 900, 800, {700, 0.1}, 150};
            }).verdict,
            Verdict::ready);
}

TEST(Verdict, WithoutAFaceNothingElseAboutItIsReported) {
  const CaptureVerdict verdict = spoilt([](ClipMeasures& clip) {
    for (Look& look : clip.looks) look = {.frame = look.frame, .time_s = look.time_s};
  });
  EXPECT_THAT(faults(verdict), ElementsAre(Fault::no_face));
  EXPECT_EQ(verdict.verdict, Verdict::refilm);
}

TEST(Verdict, UnreadableFaceIsNotReportedAsMissingExpressions) {
  const CaptureVerdict verdict = spoilt([](ClipMeasures& clip) {
    for (Look& look : clip.looks)
      look.posed = false, look.yaw_deg = look.pitch_deg = 0, look.expressions = {};
  });
  ASSERT_THAT(faults(verdict), ElementsAre(Fault::few_angles));
  EXPECT_THAT(verdict.remarks[0].what, testing::HasSubstr("could not be made out"));
  EXPECT_EQ(verdict.verdict, Verdict::usable);
}

// As few faces as import refuses (kLeastFaceShare): others can be made, if badly.
TEST(Verdict, AClipWithoutAFaceMakesNoAvatarAtAll) {
  const auto with_faces = [](int every) {
    return spoilt([&](ClipMeasures& clip) {
      for (std::size_t i = 0; i < clip.looks.size(); ++i)
        if (every == 0 || i % std::size_t(every) != 0)
          clip.looks[i].face.reset(), clip.looks[i].posed = false;
    });
  };
  for (const int every : {0, 11}) {
    EXPECT_TRUE(with_faces(every).faceless) << every;
    EXPECT_EQ(with_faces(every).verdict, Verdict::refilm) << every;
    EXPECT_NE(verdict_words(with_faces(every)).find("no face"), std::string_view::npos) << every;
  }
  EXPECT_FALSE(with_faces(8).faceless);
  EXPECT_FALSE(judge_capture(good_clip()).faceless);
}

TEST(Verdict, AnUndecodedClipIsJudgedWithoutACrash) { EXPECT_EQ(judge_capture({}).verdict, Verdict::refilm); }

TEST(Verdict, NamesAreDistinct) {
  std::set<std::string_view> names;
  for (int f = 0; f <= static_cast<int>(Fault::plain_background); ++f)
    names.insert(fault_name(static_cast<Fault>(f)));
  EXPECT_EQ(names.size(), 14u);
  EXPECT_EQ(fault_name(Fault::plain_background), "plain_background");
  EXPECT_EQ(verdict_name(Verdict::refilm), "refilm");
}

}  // namespace
}  // namespace likeness
