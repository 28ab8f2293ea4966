// Claims about expressions counted from the resting face.
#include "core/track/fit/rest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/track/fit/choose_rest.h"
#include "tests/core/face/synthetic_face.h"

namespace likeness {
namespace {

int expression_index(const char* name) {
  const auto& names = test_head().expression_names;
  return static_cast<int>(std::find(names.begin(), names.end(), name) - names.begin());
}

// A face that rests, smiles and pouts in turn, its poses known. As real landmark predictors do, the observed
// mouth is a tenth too narrow where the face rests, and right elsewhere.
std::vector<FaceFrame> moody_clip(double held_out_shift) {
  const ReducedHead& head = test_reduced_head();
  const ReducedPerson person = reduced_person(head, Eigen::VectorXd::Zero(head.identity_count()));
  std::vector<FaceFrame> frames;
  for (int i = 0; i < 60; ++i) {
    FaceFrame f;
    f.frame = i;
    f.seen = f.pose_given = true;
    f.held_out = i >= 54;
    f.state.cam_from_head = facing_pose(0.4 * std::sin(i * 0.3), 0.1, {0.01, 0.02, 0.6});
    f.state.expression = Eigen::VectorXd::Zero(head.expression_count());
    FaceState truth = f.state;
    const int mood = i / 6 % 4;  // rest, smile, rest, pout
    if (mood == 1)
      truth.expression[expression_index("mouthSmile_L")] =
          truth.expression[expression_index("mouthSmile_R")] = 0.6;
    else if (mood == 3)
      truth.expression[expression_index("mouthPucker")] = 0.7;
    f.observation = observe_state(head, person, truth, 0.2, static_cast<std::uint32_t>(i));
    if (mood == 0 || mood == 2) {
      Vec2d middle = Vec2d::Zero();
      for (int k = 48; k < kLandmarkCount; ++k) middle += f.observation.rays[k] / (kLandmarkCount - 48);
      for (int k = 48; k < kLandmarkCount; ++k)
        f.observation.rays[k].x() += 0.1 * (middle.x() - f.observation.rays[k].x());
    }
    if (f.held_out)
      for (Vec2d& r : f.observation.rays) r.x() += held_out_shift;
    frames.push_back(f);
  }
  return frames;
}

// Root mean square of the pucker about its mean, in training frames without one.
double false_pucker(const std::vector<FaceFrame>& frames) {
  double sum = 0, squares = 0;
  int count = 0;
  for (const FaceFrame& f : frames) {
    if (f.held_out || f.frame / 6 % 4 == 3) continue;
    const double x = f.state.expression[expression_index("mouthPucker")];
    sum += x, squares += x * x, ++count;
  }
  return std::sqrt(std::max(0.0, squares / count - sum * sum / (double(count) * count)));
}

TEST(Rest, IsWhatAFaceWithoutEvidenceShows) {
  const ReducedHead& head = test_reduced_head();
  const ReducedPerson person = reduced_person(head, Eigen::VectorXd::Zero(head.identity_count()));
  FaceState state;
  state.cam_from_head = facing_pose(0, 0, {0, 0, 0.6});
  state.expression = Eigen::VectorXd::Zero(head.expression_count());
  FaceObservation observation = observe_state(head, person, state, 0, 1);
  observation.sigma_px.fill(1e6);
  FrameFitOptions fit;
  fit.free_pose = false;
  Eigen::VectorXd rest = Eigen::VectorXd::Zero(head.expression_count());
  rest[expression_index("mouthPucker")] = 0.3;
  rest[expression_index("browDown_L")] = 0.2;  // of one side only: this face is not even at rest
  const ExpressionPrior prior = prior_from_rest(expression_prior(test_head()), rest);
  const FaceState found = fit_frame(head, person, observation, prior, {}, fit, state);
  EXPECT_LT((found.expression - rest).cwiseAbs().maxCoeff(), 0.01);
}

TEST(Rest, NarrowRestingMouthGivesNoFalsePucker) {
  const ReducedHead& head = test_reduced_head();
  const Eigen::VectorXd identity = Eigen::VectorXd::Zero(head.identity_count());
  const ExpressionPrior usual = expression_prior(test_head());
  std::vector<FaceFrame> frames = moody_clip(0);
  ASSERT_TRUE(fit_states(head, identity, usual, {}, frames, {}, {}).ok());
  const double before = false_pucker(frames);
  const auto prior = fit_from_rest(test_head(), head, identity, usual, {}, frames, {}, {});
  ASSERT_TRUE(prior.ok());
  std::printf("false pucker: %.3f before, %.3f from rest; rest %.3f\n", before, false_pucker(frames),
              prior->rest[expression_index("mouthPucker")]);
  EXPECT_GT(prior->rest[expression_index("mouthPucker")], 0.1);
  EXPECT_LT(false_pucker(frames), 0.7 * before);
  EXPECT_GT(frames[20].state.expression[expression_index("mouthPucker")],
            prior->rest[expression_index("mouthPucker")] + 0.2);
}

TEST(Rest, LearnsNothingFromHeldOutFrames) {
  const ReducedHead& head = test_reduced_head();
  const Eigen::VectorXd identity = Eigen::VectorXd::Zero(head.identity_count());
  const ExpressionPrior usual = expression_prior(test_head());
  Eigen::VectorXd rest[2];
  for (int k = 0; k < 2; ++k) {
    std::vector<FaceFrame> frames = moody_clip(k == 0 ? 0 : 0.03);
    ASSERT_TRUE(fit_states(head, identity, usual, {}, frames, {}, {}).ok());
    const auto prior = fit_from_rest(test_head(), head, identity, usual, {}, frames, {}, {});
    ASSERT_TRUE(prior.ok());
    rest[k] = prior->rest;
  }
  EXPECT_EQ(rest[0], rest[1]);
}

// Someone of another shape than the mean who smiles in all frames but twelve.
struct SmilingClip {
  SmilingClip() {
    const ReducedHead& head = test_reduced_head();
    identity = test_identity().head(head.identity_count()).cast<double>();
    const ReducedPerson person = reduced_person(head, identity);
    for (int i = 0; i < 120; ++i) {
      FaceFrame f;
      f.frame = i;
      f.seen = f.pose_given = true;
      f.held_out = i >= 108;
      f.state.cam_from_head = facing_pose(0.3 * std::sin(i * 0.2), 0.1, {0.01, 0.02, 0.6});
      f.state.expression = Eigen::VectorXd::Zero(head.expression_count());
      FaceState truth = f.state;
      if (i < 50 || i >= 62) {
        const double share = 0.8 + 0.1 * std::sin(0.4 * i);
        for (const char* side : {"mouthSmile_L", "mouthSmile_R"})
          truth.expression[expression_index(side)] = share;
      }
      f.observation = observe_state(head, person, truth, 0.3, static_cast<std::uint32_t>(i));
      frames.push_back(f);
    }
  }
  // The whole of a fit after the poses: the identity, the frames, and what counts as rest.
  Eigen::VectorXd fitted_rest(bool chosen) {
    const ReducedHead& head = test_reduced_head();
    const ExpressionPrior usual = expression_prior(test_head());
    const Eigen::VectorXd nobody = Eigen::VectorXd::Zero(head.identity_count());
    if (chosen) {
      std::vector<RestFrame> measured;
      for (const FaceFrame& f : frames)
        measured.push_back(
            {f.frame, f.frame / 25.0, !f.held_out,
             measure_face(head, reduced_person(head, nobody), f.observation, f.state.cam_from_head)});
      choice = choose_rest(measured, usual_mouth(head), {});
      for (FaceFrame& f : frames) f.rest = std::ranges::binary_search(choice.frames, f.frame);
    }
    const auto fit = fit_identity(head, usual, {}, nobody, frames, {}, {});
    EXPECT_TRUE(fit.ok());
    fitted = fit->identity;
    EXPECT_TRUE(fit_states(head, fitted, usual, {}, frames, {}, {}).ok());
    const auto prior = fit_from_rest(test_head(), head, fitted, usual, {}, frames, {}, {}, choice.trust);
    EXPECT_TRUE(prior.ok());
    return prior->rest;
  }
  // Root mean square over the mouth's landmarks, m, and of its width alone.
  std::pair<double, double> mouth_error(const Eigen::VectorXd& rest) const {
    const ReducedHead& head = test_reduced_head();
    const ReducedPerson true_person = reduced_person(head, identity), person = reduced_person(head, fitted);
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(head.expression_count());
    std::array<Vec3d, kLandmarkCount> off;
    Vec3d mean = Vec3d::Zero();  // where the face is in the head is another's business
    for (int k = 17; k < kLandmarkCount; ++k) {
      off[k] = reduced_point(head, person, k, rest, 0) - reduced_point(head, true_person, k, zero, 0);
      mean += off[k] / (kLandmarkCount - 17);
    }
    double sum = 0;
    for (int k = 48; k < kLandmarkCount; ++k) sum += (off[k] - mean).squaredNorm() / 20;
    return {std::sqrt(sum), std::abs((off[54] - off[48]).x())};
  }

  std::vector<FaceFrame> frames;
  Eigen::VectorXd identity, fitted;
  RestChoice choice;
};

TEST(Rest, ASmileThroughMostOfAClipGoesNeitherIntoTheRestNorIntoTheIdentity) {
  SmilingClip clip, usual;
  const auto [mouth, width] = clip.mouth_error(clip.fitted_rest(true));
  const auto [mouth_before, width_before] = usual.mouth_error(usual.fitted_rest(false));
  std::printf("resting mouth: %.2f mm rms, %.2f mm of width; without a choice %.2f and %.2f\n", 1000 * mouth,
              1000 * width, 1000 * mouth_before, 1000 * width_before);
  EXPECT_GE(clip.choice.frames.front(), 50);
  EXPECT_LT(clip.choice.frames.back(), 62);
  EXPECT_LT(mouth, 0.001);
  EXPECT_LT(width, 0.001);
  EXPECT_GT(width_before, 3 * width);
  // The smile is seen, and counted from there.
  const FaceState& smile = clip.frames[20].state;
  EXPECT_GT(smile.expression[expression_index("mouthSmile_L")], 0.5);
}

TEST(Rest, StopsWhenAsked) {
  const ReducedHead& head = test_reduced_head();
  std::vector<FaceFrame> frames = moody_clip(0);
  std::stop_source stop;
  stop.request_stop();
  const auto prior = fit_from_rest(test_head(), head, Eigen::VectorXd::Zero(head.identity_count()),
                                   expression_prior(test_head()), {}, frames, {}, stop.get_token());
  ASSERT_FALSE(prior.ok());
  EXPECT_EQ(prior.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace likeness
