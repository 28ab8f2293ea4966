// Claims about training the baselines: every mode learns, runs are reproducible, and snapshots change
// nothing.
#include "core/papers/train_nerf.h"

#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "core/image/metrics.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

NerfOptions small_options(FieldMode mode, std::uint64_t steps) {
  NerfOptions options;
  options.mode = mode;
  options.steps = steps;
  options.rays_per_step = 128;
  options.rate = 5e-3;
  options.seed = 2;
  options.march.coarse = options.march.fine = 12;
  options.head.position_frequencies = 4, options.head.direction_frequencies = 1;
  options.head.width = 32, options.head.layers = 3, options.head.skip = 2;
  options.head.slice_width = 16, options.head.slice_layers = 2, options.head.slice_skip = 1;
  return options;
}

const TrainingSet& ball() {
  static const TrainingSet set = ball_set(12, 24);
  return set;
}

TEST(TrainNerf, EveryModeOfThePapersLearns) {
  for (const FieldMode mode : {FieldMode::static_, FieldMode::concat, FieldMode::hyper, FieldMode::warp}) {
    double first = 0, last = 0;
    const NerfTap watch{[&](const TrainStatus& status) {
                          if (status.step == 1) first = status.loss;
                          last = status.loss;
                          return false;
                        },
                        {}};
    const auto avatar = train_nerf(ball(), small_options(mode, 60), Progress(), {}, watch);
    ASSERT_TRUE(avatar.ok()) << avatar.error().what;
    EXPECT_LT(last, 0.4 * first) << mode_name(mode);
    EXPECT_EQ(avatar->head[1].config.condition_count > 0, mode_parts(mode).expression);
    EXPECT_EQ(avatar->head[1].slice.layers.empty(), !mode_parts(mode).ambient);
    EXPECT_EQ(avatar->scene.warp_cell > 0, mode_parts(mode).warp);
    EXPECT_EQ(avatar->scene.steps, 60u);
  }
}

TEST(TrainNerf, ItsPicturesResembleTheirTruth) {
  const auto avatar = train_nerf(ball(), small_options(FieldMode::concat, 150), Progress(), {});
  ASSERT_TRUE(avatar.ok());
  const TrainingView truth = ball_view(gradient_plate(24), 24, 1.3);
  const AvatarRig rig = *make_rig(avatar->scene, ball().model);
  const RenderState state = pose_avatar(rig, truth.pose);
  const Image rgba = render_nerf(*avatar, truth.camera, state, {.coarse = 12, .fine = 12});
  EXPECT_GT(psnr_from_mse(mse(composite(rgba, gradient_plate(24)), to_float(truth.rgb))), 20);
}

TEST(TrainNerf, SameSeedGivesTheSameBitsWhateverTheThreadsAndSnapshots) {
  const NerfOptions options = small_options(FieldMode::hyper, 6);
  const auto a = train_nerf(ball(), options, Progress(), {});
  const ThreadLimit one(1);
  int looks = 0;
  const NerfTap tap{[](const TrainStatus&) { return true; },
                    [&](const NerfAvatar&, const TrainStatus&) { ++looks; }};
  const auto b = train_nerf(ball(), options, Progress(), {}, tap);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(looks, 6);
  EXPECT_EQ(a->head[0].parameters, b->head[0].parameters);
  EXPECT_EQ(a->head[1].parameters, b->head[1].parameters);
  NerfOptions other = options;
  other.seed = 3;
  EXPECT_NE(train_nerf(ball(), other, Progress(), {})->head[1].parameters, b->head[1].parameters);
}

TEST(TrainNerf, TorsoHasItsOwnSmallerPairOfFields) {
  TrainingSet set = ball();
  set.has_torso = true;
  const auto avatar = train_nerf(set, small_options(FieldMode::concat, 2), Progress(), {});
  ASSERT_TRUE(avatar.ok()) << avatar.error().what;
  ASSERT_TRUE(avatar->torso.has_value());
  EXPECT_EQ((*avatar->torso)[1].config.condition_count, 0);
  EXPECT_EQ(parameter_count(*avatar),
            2 * avatar->head[0].parameters.size() + 2 * (*avatar->torso)[0].parameters.size());
}

TEST(TrainNerf, StopsOnRequestAndRefusesABadSet) {
  std::stop_source source;
  source.request_stop();
  const auto stopped =
      train_nerf(ball(), small_options(FieldMode::concat, 5), Progress(), source.get_token());
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
  TrainingSet none = ball();
  none.views.clear();
  EXPECT_EQ(train_nerf(none, small_options(FieldMode::concat, 5), Progress(), {}).error().code,
            ErrorCode::bad_input);
}

}  // namespace
}  // namespace likeness
