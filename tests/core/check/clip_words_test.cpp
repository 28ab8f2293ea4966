// Claims about the sentences on a clip: each says what is so, and no more than that.
#include "core/check/clip_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace likeness {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(ClipWords, TheCameraRestsIsHeldOrWalks) {
  const auto of = [](std::optional<CameraKind> kind, bool sure = true, bool stated = false) {
    return camera_sentence({kind, sure, stated, ""});
  };
  EXPECT_THAT(of(CameraKind::resting), HasSubstr("rests"));
  EXPECT_THAT(of(CameraKind::handheld), HasSubstr("held in the hand"));
  EXPECT_THAT(of(CameraKind::walking), HasSubstr("walks"));
  for (const CameraKind kind : {CameraKind::resting, CameraKind::handheld, CameraKind::walking}) {
    EXPECT_THAT(of(kind), Not(HasSubstr("seems")));
    EXPECT_THAT(of(kind, false), HasSubstr("seems to"));
    EXPECT_THAT(of(kind, true, true), HasSubstr("As you said"));
  }
  EXPECT_THAT(of(std::nullopt), HasSubstr("not known yet"));
}

TEST(ClipWords, TheMaskIsTrustedAsFarAsThePersonNetworkSees) {
  EXPECT_THAT(mask_sentence({}), HasSubstr("not used"));
  EXPECT_THAT(mask_sentence({MaskPrior::person_network, 0, 0}), HasSubstr("is there"));
  EXPECT_THAT(mask_sentence({MaskPrior::person_network, 200, 198}), HasSubstr("in 99 % of 200 frames"));
  EXPECT_THAT(mask_sentence({MaskPrior::person_network, 200, 198}), HasSubstr("can be trusted"));
  EXPECT_THAT(mask_sentence({MaskPrior::person_network, 200, 60}), Not(HasSubstr("can be trusted")));
  EXPECT_THAT(mask_sentence({MaskPrior::matting_network, 200, 200}), HasSubstr("matting network"));
}

TEST(ClipWords, WhatServesNamesWhatDoesNot) {
  PartsFacts facts;
  facts.seconds = 60, facts.frames = 1800, facts.width = 1280, facts.height = 720;
  EXPECT_EQ(parts_sentence(facts), "All 60.0 s of the clip serve.");
  facts.faceless_s = 4, facts.repeated = 360, facts.film = {160, 0, 960, 720};
  const std::string words = parts_sentence(facts);
  EXPECT_THAT(words, HasSubstr("56.0 of 60.0 s"));
  EXPECT_THAT(words, HasSubstr("4.0 s show no face"));
  EXPECT_THAT(words, HasSubstr("360 of 1800 frames only repeat the one before"));
  EXPECT_THAT(words, HasSubstr("bars beside it"));
  facts.film = {0, 60, 1280, 600};
  EXPECT_THAT(parts_sentence(facts), HasSubstr("bars above and below it"));
  facts.shots = {{0, 599, 0, 20, true, ""}, {600, 1799, 20, 60, true, ""}};
  EXPECT_THAT(parts_sentence(facts), HasSubstr("it is cut at 20.0 s"));
  facts.shots[0].used = false;
  EXPECT_THAT(parts_sentence(facts), HasSubstr("36.0 of 60.0 s"));
  EXPECT_THAT(parts_sentence(facts), HasSubstr("outside 0:20-1:00 it shows another place"));
}

Capture capture_of(int frames) {
  Capture capture;
  capture.width = 640, capture.height = 480;
  for (int i = 0; i < frames; ++i) {
    CaptureFrame& frame = capture.frames.emplace_back();
    frame.frame = i, frame.time_s = i / 25.0, frame.used = true;
  }
  return capture;
}

TEST(ClipWords, AnImportAccountsForItsFrames) {
  Capture capture = capture_of(100);
  for (int i = 0; i < 25; ++i) {
    capture.frames[std::size_t(i)].used = false;
    capture.frames[std::size_t(i)].refused = i < 15   ? "No face was found near this frame."
                                             : i < 20 ? "Blurred: 3"
                                                      : "Repeats the frame before it.";
  }
  const PartsFacts parts = clip_facts({.capture = &capture}).parts;
  EXPECT_NEAR(parts.seconds, 4, 1e-9);
  EXPECT_NEAR(parts.faceless_s, 0.6, 1e-9);
  EXPECT_NEAR(parts.blurred_s, 0.2, 1e-9);
  EXPECT_EQ(parts.repeated, 5);
}

TEST(ClipWords, TheUsersWordCountsUntilCamerasAreMadeByIt) {
  CameraSet cameras;
  cameras.kind = CameraKind::walking;
  ClipResults results;
  results.cameras = &cameras, results.camera_evidence = "The camera travels: 12 %.";
  EXPECT_EQ(clip_facts(results).camera.kind, CameraKind::walking);
  EXPECT_FALSE(clip_facts(results).camera.stated);
  results.stated = CameraKind::resting;
  const CameraFacts stated = clip_facts(results).camera;
  EXPECT_EQ(stated.kind, CameraKind::resting);
  EXPECT_TRUE(stated.stated);
  EXPECT_EQ(stated.evidence, "");  // found of another kind
}

TEST(ClipWords, WhatTheStagesDoNotKnowIsTakenFromTheCheck) {
  ClipFacts checked;
  checked.camera = {CameraKind::handheld, true, false, "It sways."};
  checked.mask = {MaskPrior::person_network, 40, 39};
  checked.parts.frames = 90;
  ClipFacts known;
  known.parts.frames = 100;
  const ClipFacts joined = joined_facts(known, checked);
  EXPECT_EQ(joined.camera.kind, CameraKind::handheld);
  EXPECT_EQ(joined.mask.used, 39);
  EXPECT_EQ(joined.parts.frames, 100);
}

}  // namespace
}  // namespace likeness
