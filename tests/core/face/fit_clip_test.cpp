// Claims about the fit of a clip: one identity, and nothing shared learns from held-out frames.
#include "core/face/fit_clip.h"

#include <gtest/gtest.h>

#include "core/base/rigid.h"
#include "core/track/frame_spacing.h"
#include "tests/core/face/synthetic_face.h"

namespace likeness {
namespace {

Pose true_pose(int frame) {
  return facing_pose(0.6 * std::sin(frame * 0.3), 0.2 * std::sin(frame * 0.2), {0.01, 0.02, 0.6});
}

std::vector<FaceFrame> make_clip(const ReducedHead& head, const Eigen::VectorXd& identity,
                                 double held_out_shift) {
  const ReducedPerson person = reduced_person(head, identity);
  std::vector<FaceFrame> frames;
  for (int i = 0; i < 30; ++i) {
    FaceFrame f;
    f.frame = i;
    f.seen = true;
    f.held_out = i >= 20 && i < 25;
    FaceState truth;
    truth.cam_from_head = true_pose(i);
    truth.expression = Eigen::VectorXd::Zero(head.expression_count());
    truth.jaw = 0.1 + 0.1 * std::sin(i * 0.5);
    f.observation = observe_state(head, person, truth, 0.5, static_cast<std::uint32_t>(i));
    const JawLine line = pick_jaw_line(head, person, f.observation, truth);
    for (int k = 0; k < kJawLineCount; ++k)
      f.observation.rays[k] =
          (truth.cam_from_head * reduced_point(head, person, line.point[k], truth.expression, truth.jaw))
              .hnormalized();
    if (f.held_out)
      for (Vec2d& r : f.observation.rays) r += Vec2d(held_out_shift, 0.5 * held_out_shift);
    f.state.expression = Eigen::VectorXd::Zero(head.expression_count());
    frames.push_back(f);
  }
  return frames;
}

struct Fitted {
  Eigen::VectorXd identity;
  std::vector<FaceFrame> frames;
};

Fitted fit(std::vector<FaceFrame> frames) {
  const ReducedHead& head = test_reduced_head();
  const ExpressionPrior prior = expression_prior(test_head());
  Eigen::VectorXd identity = Eigen::VectorXd::Zero(head.identity_count());
  EXPECT_TRUE(start_clip(head, identity, prior, frames).ok());
  auto found = fit_identity(head, prior, {}, identity, frames, {}, {});
  EXPECT_TRUE(found.ok());
  EXPECT_TRUE(fit_states(head, found->identity, prior, {}, frames, {}, {}).ok());
  return {found->identity, frames};
}

TEST(FitClip, FindsAShapeThatExplainsAllFrames) {
  const ReducedHead& head = test_reduced_head();
  Eigen::VectorXd truth = Eigen::VectorXd::Zero(head.identity_count());
  for (int i = 0; i < truth.size(); ++i) truth[i] = i % 3 == 0 ? 1.2 : -0.6;
  const Fitted fitted = fit(make_clip(head, truth, 0));
  const ReducedPerson person = reduced_person(head, fitted.identity);
  const ReducedPerson mean = reduced_person(head, Eigen::VectorXd::Zero(head.identity_count()));
  const ReducedPerson real = reduced_person(head, truth);
  double error = 0, start = 0;
  // Size and depth are one to a single camera, so shapes are compared after scaling to one size.
  const auto size = [&](const ReducedPerson& p) {
    return (p.base.segment<3>(3 * 36) - p.base.segment<3>(3 * 45)).norm();
  };
  const auto relative = [&](const ReducedPerson& p, int i) {
    return Vec3d((p.base.segment<3>(3 * i) - p.base.segment<3>(3 * 30)) / size(p));
  };
  for (int i = kJawLineCount; i < kLandmarkCount; ++i) {
    error += (relative(person, i) - relative(real, i)).norm();
    start += (relative(mean, i) - relative(real, i)).norm();
  }
  EXPECT_LT(error, 0.6 * start);
  for (const FaceFrame& f : fitted.frames) EXPECT_LT(inner_error(head, person, f.observation, f.state), 1.5);
}

TEST(FrameSpacing, IsOneUnlessFramesWereSkippedAndZeroForPhotographs) {
  struct Moment {
    int frame;
    double time_s;
  };
  EXPECT_EQ(frame_spacing(std::vector<Moment>{}), 1);
  EXPECT_EQ(frame_spacing(std::vector<Moment>{{0, 0}, {1, 0.04}, {5, 0.2}}), 1);
  EXPECT_EQ(frame_spacing(std::vector<Moment>{{0, 0}, {8, 0.066}, {12, 0.1}, {16, 0.133}}), 4);
  EXPECT_EQ(frame_spacing(std::vector<Moment>{{0, 0}, {1, 1}, {2, 2}}), 0);
}

TEST(FitClip, FramesOfAFastClipAreSmoothedWithTheNearestOnesRead) {
  const ReducedHead& head = test_reduced_head();
  const Eigen::VectorXd identity = Eigen::VectorXd::Zero(head.identity_count());
  const ExpressionPrior prior = expression_prior(test_head());
  const auto fitted = [&](int apart, int spacing) {
    std::vector<FaceFrame> frames = make_clip(head, identity, 0);
    for (FaceFrame& frame : frames) frame.frame *= apart;
    EXPECT_TRUE(start_clip(head, identity, prior, frames).ok());
    EXPECT_TRUE(fit_states(head, identity, prior, {.spacing = spacing}, frames, {}, {}).ok());
    return frames;
  };
  const auto usual = fitted(1, 1), fast = fitted(4, 4), alone = fitted(4, 1);
  double leaned = 0;
  for (std::size_t i = 0; i < usual.size(); ++i) {
    EXPECT_EQ(usual[i].state.expression, fast[i].state.expression);
    leaned += (usual[i].state.expression - alone[i].state.expression).norm();
  }
  EXPECT_GT(leaned, 0.01) << "numbers that are not each other's next have no pull";
}

TEST(FitClip, HeldOutPicturesChangeNothingShared) {
  const ReducedHead& head = test_reduced_head();
  const Eigen::VectorXd truth = Eigen::VectorXd::Constant(head.identity_count(), 0.5);
  const Fitted a = fit(make_clip(head, truth, 0)), b = fit(make_clip(head, truth, 0.03));
  EXPECT_EQ(a.identity, b.identity);
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    const bool same = a.frames[i].state.expression == b.frames[i].state.expression &&
                      a.frames[i].state.cam_from_head.matrix() == b.frames[i].state.cam_from_head.matrix();
    if (!a.frames[i].held_out) {
      EXPECT_TRUE(same) << "training frame " << i;
    }
  }
  EXPECT_NE(a.frames[22].state.cam_from_head.matrix(), b.frames[22].state.cam_from_head.matrix());
}

// What dense tracks leave undetermined: correct motion of a head frame that is not the face's.
TEST(FitClip, RegistersTheFaceInTheGivenFrame) {
  const ReducedHead& head = test_reduced_head();
  std::vector<FaceFrame> frames = make_clip(head, Eigen::VectorXd::Zero(head.identity_count()), 0);
  Pose offset = Pose::Identity();  // the face's frame in the given one
  offset.linear() = turn_from_vector({0.06, -0.03, 0.02});
  offset.translation() = Vec3d(0.004, -0.008, 0.02);
  for (FaceFrame& f : frames) {
    f.pose_given = true;
    f.state.cam_from_head = true_pose(f.frame) * inverse(offset);
  }
  const ExpressionPrior prior = expression_prior(test_head());
  const Eigen::VectorXd identity = Eigen::VectorXd::Zero(head.identity_count());
  const auto found = fit_identity(head, prior, {}, identity, frames, {}, {});
  ASSERT_TRUE(found.ok());
  const Pose left = inverse(found->registration) * offset;
  EXPECT_LT(vector_from_turn(left.linear()).norm(), 0.02);
  EXPECT_LT(left.translation().norm(), 0.005);
  // Held-out frames undergo the same motion.
  for (const int i : {3, 22}) {
    const Pose off = inverse(frames[std::size_t(i)].state.cam_from_head) * true_pose(i);
    EXPECT_LT((off.matrix() - left.matrix()).norm(), 1e-6) << i;
  }
}

// Another clip of a person whose shape is known: only the place of the face in the given frame is fitted.
TEST(FitClip, KeepsAGivenIdentityAndStillRegistersTheFrame) {
  const ReducedHead& head = test_reduced_head();
  Eigen::VectorXd truth = Eigen::VectorXd::Zero(head.identity_count());
  for (int i = 0; i < truth.size(); ++i) truth[i] = i % 2 == 0 ? 0.8 : -0.5;
  std::vector<FaceFrame> frames = make_clip(head, truth, 0);
  const Pose offset(Eigen::Translation3d(0.004, -0.008, 0.02));
  for (FaceFrame& f : frames) {
    f.pose_given = true;
    f.state.cam_from_head = true_pose(f.frame) * inverse(offset);
  }
  ClipFitOptions options;
  options.hold_identity = true;
  const auto found = fit_identity(head, expression_prior(test_head()), options, truth, frames, {}, {});
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found->identity, truth);
  EXPECT_LT((found->registration.translation() - offset.translation()).norm(), 0.004);
}

TEST(FitClip, StopsWhenAsked) {
  const ReducedHead& head = test_reduced_head();
  std::vector<FaceFrame> frames = make_clip(head, Eigen::VectorXd::Zero(head.identity_count()), 0);
  std::stop_source source;
  source.request_stop();
  const ExpressionPrior prior = expression_prior(test_head());
  const Eigen::VectorXd identity = Eigen::VectorXd::Zero(head.identity_count());
  const auto stopped = fit_identity(head, prior, {}, identity, frames, {}, source.get_token());
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace likeness
