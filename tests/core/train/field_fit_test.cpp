// Fitting to a field: a wrong pose is corrected, no correction leaves the bounds, and training with
// corrections survives wrong training poses better than training without.
#include "core/train/field_fit.h"

#include <gtest/gtest.h>

#include "core/train/refine_track.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

class FieldFitTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    set_ = new TrainingSet(ball_set(16, 32));
    auto trained = train_avatar(*set_, short_training(120), {}, Progress(), {}, {});
    ASSERT_TRUE(trained.ok()) << trained.error().what;
    avatar_ = new Avatar(std::move(*trained));
  }
  static void TearDownTestSuite() { delete set_, delete avatar_; }
  static TrainingSet* set_;
  static Avatar* avatar_;
};
TrainingSet* FieldFitTest::set_ = nullptr;
Avatar* FieldFitTest::avatar_ = nullptr;

TEST_F(FieldFitTest, RecoversAShiftedHead) {
  const AvatarRig rig = *make_rig(*avatar_, set_->model);
  const TrainingView& view = set_->views[8];
  AvatarPose wrong = view.pose;
  wrong.world_from_head.translation() += Vec3d(0.004, -0.003, 0);
  Image8 everywhere(view.rgb.width, view.rgb.height, 1);
  std::fill(everywhere.data.begin(), everywhere.data.end(), std::uint8_t(255));
  FieldFitOptions options;
  options.components = 0;
  const FieldFit fit =
      fit_to_field(*avatar_, rig, view.camera, {&view.rgb, &set_->plate, &everywhere}, wrong, {}, options);
  EXPECT_LT(fit.mse_after, 0.6 * fit.mse_before);
  const AvatarPose found = changed_pose(wrong, avatar_->condition, fit.change);
  const Vec3d left = found.world_from_head.translation() - view.pose.world_from_head.translation();
  EXPECT_LT(left.head<2>().norm(), 0.0015);
}

TEST_F(FieldFitTest, AnEmptyRegionChangesNothing) {
  const AvatarRig rig = *make_rig(*avatar_, set_->model);
  const TrainingView& view = set_->views[0];
  const Image8 nowhere(view.rgb.width, view.rgb.height, 1);
  const FieldFit fit =
      fit_to_field(*avatar_, rig, view.camera, {&view.rgb, &set_->plate, &nowhere}, view.pose, {}, {});
  EXPECT_EQ(fit.change.norm(), 0);
}

TEST_F(FieldFitTest, CorrectionsHaveZeroMeanAndBounds) {
  const AvatarRig rig = *make_rig(*avatar_, set_->model);
  TrainingSet shifted = *set_;
  for (std::size_t v = 0; v < shifted.views.size(); ++v)
    shifted.views[v].pose.world_from_head.translation().x() += v % 2 ? 0.02 : -0.02;  // further than allowed
  RefineOptions options;
  const auto corrections = refine_track(shifted, *avatar_, rig, {}, options, {});
  ASSERT_EQ(corrections.size(), shifted.views.size());
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(corrections[0].size());
  for (const Eigen::VectorXd& change : corrections) {
    mean += change;
    EXPECT_LE(change.segment<3>(3).cwiseAbs().maxCoeff(), 2 * options.largest_shift);
    EXPECT_LE(change.head<3>().cwiseAbs().maxCoeff(), 2 * options.largest_turn);
  }
  EXPECT_LT(mean.norm(), 1e-9);
}

TEST(RefineTrack, MovesWrongTrainingPosesTowardsTheTruth) {
  const TrainingSet truth = ball_set(16, 32);
  TrainingSet wrong = truth;
  for (std::size_t v = 0; v < wrong.views.size(); ++v)
    wrong.views[v].pose.world_from_head.translation().x() += 0.003 * (v % 2 ? 1 : -1);
  TrainOptions options = short_training(120);
  options.refine_track = true;
  const auto refined = train_avatar(wrong, options, {}, Progress(), {}, {});
  options.refine_track = false;
  const auto plain = train_avatar(wrong, options, {}, Progress(), {}, {});
  ASSERT_TRUE(refined.ok() && plain.ok());
  const auto loss = [&](const Avatar& avatar) {
    const AvatarRig rig = *make_rig(avatar, truth.model);
    double error = 0;
    for (const TrainingView& view : truth.views) {
      const Image seen =
          composite(render_frame(avatar, view.camera, pose_avatar(rig, view.pose)).rgba, truth.plate);
      for (std::size_t i = 0; i < seen.data.size(); ++i)
        error += std::pow(seen.data[i] - float(view.rgb.data[i]) / 255.f, 2);
    }
    return error;
  };
  EXPECT_LT(loss(*refined), loss(*plain));
}

}  // namespace
}  // namespace likeness
