// Claims about the verdict on a tracked frame and about frames that are lost.
#include "core/track/clip/frame_verdict.h"

#include <gtest/gtest.h>

#include <set>

namespace likeness {
namespace {

FrameEvidence clear_frame() {
  FrameEvidence e;
  e.camera_known = e.seen = e.detected = e.dense_solved = true;
  e.inner_error_px = 1.5;
  e.cluster_share = 0.9;
  return e;
}

TEST(FrameVerdict, ClearFrameIsGoodAndHasNoReason) {
  const FrameVerdict verdict = judge_frame(clear_frame(), 1.5);
  EXPECT_EQ(verdict.status, FrameStatus::good);
  EXPECT_TRUE(verdict.reason.empty());
}

TEST(FrameVerdict, MissingEvidenceMakesItLostAndIsNamed) {
  FrameEvidence no_camera = clear_frame(), no_face = clear_frame();
  no_camera.camera_known = false;
  no_face.seen = false;
  EXPECT_EQ(judge_frame(no_camera, 1.5).status, FrameStatus::lost);
  EXPECT_NE(judge_frame(no_camera, 1.5).reason.find("camera"), std::string::npos);
  EXPECT_EQ(judge_frame(no_face, 1.5).status, FrameStatus::lost);
  EXPECT_NE(judge_frame(no_face, 1.5).reason.find("no face"), std::string::npos);
}

TEST(FrameVerdict, GrowingErrorNeverImprovesTheVerdict) {
  FrameEvidence e = clear_frame();
  FrameStatus last = FrameStatus::good;
  for (e.inner_error_px = 0.5; e.inner_error_px < 20; e.inner_error_px += 0.5) {
    const FrameStatus status = judge_frame(e, 1.5).status;
    EXPECT_GE(static_cast<int>(status), static_cast<int>(last)) << e.inner_error_px;
    last = status;
  }
  EXPECT_EQ(last, FrameStatus::lost);
}

// A clip whose head lies beside the face throughout has no good frames, however usual that is.
TEST(FrameVerdict, WhatIsUsualExcusesNoHeadBesideTheFace) {
  FrameEvidence e = clear_frame();
  e.eyes_px = 160;
  e.inner_error_px = 5;
  EXPECT_EQ(judge_frame(e, 5).status, FrameStatus::weak);
  EXPECT_NE(judge_frame(e, 5).reason.find("misses"), std::string::npos);
  e.eyes_px = 400;  // of a face as large as this, 5 px are little
  EXPECT_EQ(judge_frame(e, 5).status, FrameStatus::good);
  e.eyes_px = 40;  // what a small face's few pixels cannot show is not held against it
  e.inner_error_px = 3;
  EXPECT_EQ(judge_frame(e, 3).status, FrameStatus::good);
}

TEST(FrameVerdict, EachSingleDoubtMakesItWeakWithItsOwnReason) {
  std::vector<FrameEvidence> doubts(5, clear_frame());
  doubts[0].cluster_share = 0.2;
  doubts[1].spread = 0.2;
  doubts[2].look = 0.1;
  doubts[3].votes = 51, doubts[3].disagreement_px = 20;
  doubts[4].carried = true;
  std::set<std::string> reasons;
  for (const FrameEvidence& e : doubts) {
    EXPECT_EQ(judge_frame(e, 1.5).status, FrameStatus::weak);
    reasons.insert(judge_frame(e, 1.5).reason);
  }
  EXPECT_EQ(reasons.size(), doubts.size());
  EXPECT_FALSE(reasons.contains(""));
}

TEST(FrameVerdict, ReasonCountsInSourcePixels) {
  FrameEvidence e = clear_frame();
  e.inner_error_px = 5;
  e.source_px = 4;
  EXPECT_NE(judge_frame(e, 1.5).reason.find("20.0 px"), std::string::npos) << judge_frame(e, 1.5).reason;
}

TEST(BridgeLost, LiesBetweenItsNeighbours) {
  std::vector<TrackedFrame> frames(5);
  for (int i = 0; i < 5; ++i) {
    frames[i].frame = i;
    frames[i].pose.articulation.expression = Eigen::VectorXf::Constant(2, static_cast<float>(i));
    frames[i].pose.world_from_head.translation() = Vec3d(i, 0, 1);
    frames[i].status = i % 4 == 0 ? FrameStatus::good : FrameStatus::lost;
  }
  for (int i = 1; i < 4; ++i) {
    frames[i].pose.articulation.expression.setConstant(99);
    frames[i].pose.world_from_head.translation().setConstant(99);
  }
  bridge_lost(frames);
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(frames[i].pose.articulation.expression[0], i, 1e-5);
    EXPECT_NEAR(frames[i].pose.world_from_head.translation().x(), i, 1e-9);
  }
}

TEST(BridgeLost, NothingIsLearntAcrossTheSplit) {
  std::vector<TrackedFrame> frames(6);
  for (int i = 0; i < 6; ++i) {
    frames[i].frame = i;
    frames[i].pose.articulation.expression = Eigen::VectorXf::Zero(1);
    frames[i].pose.world_from_head.translation().x() = i;
    if (i == 2 || i == 4) frames[i].status = FrameStatus::lost;
  }
  bridge_lost(frames, {false, false, false, true, true, true});
  EXPECT_EQ(frames[2].pose.world_from_head.translation().x(), 1) << "it trains: what comes next is held out";
  EXPECT_EQ(frames[4].pose.world_from_head.translation().x(), 3)
      << "held out: what comes next is not known yet";
}

TEST(BridgeLost, AFrameTakesNothingFromBeyondACut) {
  std::vector<TrackedFrame> frames(6);
  for (int i = 0; i < 6; ++i) {
    frames[i].frame = i;
    frames[i].pose.articulation.expression = Eigen::VectorXf::Zero(1);
    frames[i].pose.world_from_head.translation().x() = i;
    if (i == 2 || i == 3) frames[i].status = FrameStatus::lost;
  }
  bridge_lost(frames, {}, {0, 0, 0, 1, 1, 1});
  EXPECT_EQ(frames[2].pose.world_from_head.translation().x(), 1) << "the last frame before the cut";
  EXPECT_EQ(frames[3].pose.world_from_head.translation().x(), 4) << "the first frame after it";
}

TEST(BridgeLost, WithoutKnownFramesNothingChanges) {
  std::vector<TrackedFrame> frames(2);
  for (TrackedFrame& f : frames) f.status = FrameStatus::lost;
  bridge_lost(frames);
  EXPECT_TRUE(frames[0].pose.world_from_head.isApprox(Pose::Identity()));
}

}  // namespace
}  // namespace likeness
