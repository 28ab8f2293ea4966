// Claims about maps from patches to landmarks' offsets, the patches in ray batches, and training with them.
#include "core/train/landmark_patches.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/render/backend.h"
#include "core/train/condition_map.h"
#include "core/train/ray_batch.h"
#include "core/train/refine_track.h"
#include "core/train/training_step.h"
#include "core/train/volumes.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

using testing::HasSubstr;

constexpr int kWideBallSize = 96;

// Patterned finely enough for a patch to tell where it is.
Vec3f freckled(const Vec3f& n, float expression) {
  const float pattern = std::sin(15 * n.x() + 4) * std::sin(13 * n.y()) + std::sin(11 * (n.x() - n.y()));
  return ball_colour(n, expression) * 0.6f + Vec3f::Constant(0.17f * (pattern + 1.2f));
}
Vec3f one_colour(const Vec3f&, float) { return {0.6f, 0.5f, 0.4f}; }

// The ball with its landmarks all over its front, the eyes' corners left and right.
HeadModel wide_ball_head() {
  HeadModel model = ball_head();
  const auto middle = [&](std::size_t t) -> Vec3f {
    const Triangle& corners = model.triangles[t];
    return (model.vertices[std::size_t(corners[0])] + model.vertices[std::size_t(corners[1])] +
            model.vertices[std::size_t(corners[2])]) /
           (3 * kBallRadius);
  };
  for (int k = kFirstPatchLandmark; k < kLandmarkCount; ++k) {
    Vec3f at(0.25f * float(k % 5 - 2), 0.25f * float(k / 5 % 5 - 2), 0.7f);
    if (k == 36 || k == 45) at = Vec3f(k == 36 ? -0.5f : 0.5f, 0.3f, 0.8f);
    std::size_t best = 0;
    for (std::size_t t = 0; t < model.triangles.size(); ++t)
      if ((middle(t) - at.normalized()).norm() < (middle(best) - at.normalized()).norm()) best = t;
    model.landmark_triangle[std::size_t(k)] = int(best);
    model.landmark_barycentric[std::size_t(k)] = Vec3f::Constant(1.f / 3);
  }
  return model;
}

TrainingSet wide_ball_set(int views, Vec3f (*colour)(const Vec3f&, float) = freckled) {
  TrainingSet set;
  set.size = kWideBallSize;
  set.model = wide_ball_head();
  set.person.identity = Eigen::VectorXf::Zero(1);
  set.has_torso = false;
  set.plate = gradient_plate(kWideBallSize);
  for (int v = 0; v < views; ++v)
    set.views.push_back(ball_view(set.plate, kWideBallSize, 0.37 * v, 0, colour));
  return set;
}

Result<LandmarkPatches> learn(const TrainingSet& set, std::uint64_t seed = 0) {
  return learn_landmark_patches(set, shape_head(set.model, set.person), seed);
}

struct Agreement {
  double predicted = 0, truth = 0, both = 0, error = 0;
  int count = 0;
  double correlation() const { return both / std::sqrt(predicted * truth); }
  double rms() const { return std::sqrt(error / count); }
  void add(const Vec2f& guess, const Vec2d& offset) {
    const Vec2d g = guess.cast<double>();
    both += g.dot(offset), predicted += g.squaredNorm(), truth += offset.squaredNorm();
    error += (g - offset).squaredNorm(), ++count;
  }
};

// Places of a set's view are taken to a picture of a time between the views, which nothing was learnt from,
// and to the same moment through a camera whose picture lies elsewhere.
Agreement agreement(const LandmarkPatches& patches, double gain) {
  Agreement all;
  const Image8 plate = gradient_plate(kWideBallSize);
  const TrainingView truth = ball_view(plate, kWideBallSize, 0.37 * 4 + 0.02, 0, freckled);
  for (const Vec2d& shift : {Vec2d(0.6, 0.2), Vec2d(-0.5, 0.6), Vec2d(0.1, -0.8), Vec2d(-0.7, -0.3)}) {
    TrainingView moved = ball_view(plate, kWideBallSize, 0.37 * 4 + 0.02, 0, freckled, shift);
    for (std::uint8_t& value : moved.rgb.data) value = std::uint8_t(std::lround(gain * value));
    for (const PatchPlace& place : patches.places[4])
      if (place.visibility > 0.9f)
        all.add(landmark_offset(patches.maps[std::size_t(place.landmark)], place, patches.stride, moved.rgb,
                                truth.rgb),
                shift / patches.interocular_px);
  }
  return all;
}

TEST(LandmarkPatches, FindKnownShiftsInPicturesNotLearntFrom) {
  const auto patches = learn(wide_ball_set(24));
  ASSERT_TRUE(patches.ok()) << patches.error().what;
  EXPECT_GT(patches->accepted(), 25);
  const Agreement sharp = agreement(*patches, 1), dark = agreement(*patches, 0.95);
  EXPECT_GT(sharp.count, 40);
  EXPECT_GT(sharp.correlation(), 0.95);
  EXPECT_LT(sharp.rms(), 0.4 * std::sqrt(sharp.truth / sharp.count));
  EXPECT_GT(dark.correlation(), 0.95);
}

TEST(LandmarkPatches, AreAcceptedByTheirOwnHeldOutCorrelationAndWeighedByTheirSpread) {
  const auto patches = learn(wide_ball_set(24));
  ASSERT_TRUE(patches.ok());
  for (int k = 0; k < kLandmarkCount; ++k) {
    const LandmarkMap& map = patches->maps[std::size_t(k)];
    EXPECT_EQ(map.weight > 0, k >= kFirstPatchLandmark && map.correlation >= kMinCorrelation) << k;
    if (map.weight == 0) continue;
    EXPECT_NEAR(map.weight, 1 / (1 + std::pow(map.spread / kUsualSpread, 2)), 1e-6) << k;
  }
  for (const auto& places : patches->places)
    for (const PatchPlace& place : places) EXPECT_GT(patches->maps[std::size_t(place.landmark)].weight, 0);
}

TEST(LandmarkPatches, RefuseAFaceWithoutTexture) {
  const auto patches = learn(wide_ball_set(16, one_colour));
  ASSERT_FALSE(patches.ok());
  EXPECT_THAT(patches.error().what, HasSubstr("No landmark"));
  EXPECT_THAT(patches.error().fix, HasSubstr("--landmark-loss"));
}

TEST(LandmarkPatches, RepeatBitForBit) {
  const TrainingSet set = wide_ball_set(12);
  const auto one = learn(set, 5), other = learn(set, 5);
  ASSERT_TRUE(one.ok() && other.ok());
  for (std::size_t k = 0; k < one->maps.size(); ++k) EXPECT_EQ(one->maps[k].map, other->maps[k].map);
}

// What a training step needs, without the trainer.
struct Bench {
  TrainingSet set = wide_ball_set(24);
  HeadShape shape = shape_head(set.model, set.person);
  ConditionMap map;
  Volumes volumes = make_volumes(set, shape);
  LandmarkPatches patches = std::move(*learn(set));
  std::vector<AvatarPose> poses;
  RaySource source;

  Bench() {
    std::vector<Articulation> articulations;
    for (const TrainingView& view : set.views) articulations.push_back(view.pose.articulation);
    map = learn_condition_map(set.model, shape, articulations);
    poses = corrected_poses(set, map, {});
    source = make_ray_source(set, poses, shape, volumes.head.cube, nullptr);
    source.patches = &patches;
  }
};

TEST(ChooseRays, PatchesAreWholeAndOfOneViewBeforeThePlate) {
  const Bench bench;
  const OccupancyGrid everywhere = make_occupancy(8, true), none;
  MarchVolumes volumes;
  volumes.fields[0] = march_volume(everywhere, none);
  constexpr int kRays = 1000;
  const std::size_t views = bench.set.views.size();
  RayBatch batch;
  choose_rays(bench.source, volumes, true, 3, 7, kRays, batch);
  ASSERT_EQ(batch.patches.size(), std::size_t(kRays) / 4 / kPatchRays);
  ASSERT_EQ(batch.requests.size(), std::size_t(kRays));
  for (std::size_t p = 0; p < batch.patches.size(); ++p) {
    const RayPatch& patch = batch.patches[p];
    EXPECT_EQ(patch.first, p * kPatchRays);
    ASSERT_EQ(patch.count, std::size_t(kPatchRays));
    const std::size_t row = std::size_t(batch.requests[patch.first].view), v = row % views;
    const auto place = std::ranges::find(bench.patches.places[v], patch.landmark, &PatchPlace::landmark);
    ASSERT_NE(place, bench.patches.places[v].end());
    EXPECT_EQ(patch.map.data(), bench.patches.maps[std::size_t(patch.landmark)].map.data());
    for (int i = 0; i < kPatchRays; ++i) {
      const std::size_t r = patch.first + std::size_t(i);
      EXPECT_EQ(std::size_t(batch.requests[r].view), row);
      const auto [x, y] = patch_pixel(*place, bench.patches.stride, i);
      for (int c = 0; c < 3; ++c) {
        EXPECT_FLOAT_EQ(255 * batch.target[r][c], float(bench.set.views[v].rgb.at(x, y)[c]));
        EXPECT_FLOAT_EQ(255 * batch.background[r][c], float(bench.set.plate.at(x, y)[c]));
      }
    }
  }
  RaySource alone = bench.source;
  alone.patches = nullptr;
  choose_rays(alone, volumes, true, 3, 7, kRays, batch);
  EXPECT_TRUE(batch.patches.empty());
}

TEST(LandmarkLoss, Falls) {
  const Bench bench;
  TrainOptions training;
  constexpr int kSteps = 400, kMeant = 20;  // one step's patches say little
  training.schedule.steps = kSteps;
  TrainingState state = make_training_state(bench.set, training, bench.map, bench.volumes);
  StepOptions options;
  options.rays = 1000, options.landmark_weight = 0.1;
  const auto backend = cpu_backend();
  const auto learner = make_learner(*backend, state, options, bench.set);
  ASSERT_TRUE(learner.ok());
  double first = 0, last = 0;
  for (int k = 0; k < kSteps; ++k) {
    const auto step = training_step(state, **learner, bench.source, options);
    ASSERT_TRUE(step.ok() && step->finite);
    if (k < kMeant) first += step->landmark_loss;
    if (k >= kSteps - kMeant) last += step->landmark_loss;
  }
  EXPECT_GT(first, 0);
  EXPECT_LT(last, 0.5 * first);
}

Result<Avatar> train_patched(const TrainingSet& set, const TrainOptions& options) {
  return train_avatar(set, options, {}, Progress(), {}, {});
}

TEST(LandmarkLoss, TrainingRepeatsBitForBitAndDiffersFromTrainingWithoutIt) {
  const TrainingSet set = wide_ball_set(12);
  TrainOptions options;
  options.schedule.steps = 20, options.rays.per_step = 600, options.losses.landmark_weight = 0.1;
  const auto one = train_patched(set, options), other = train_patched(set, options);
  ASSERT_TRUE(one.ok() && other.ok());
  EXPECT_EQ(one->head.field.parameters, other->head.field.parameters);
  options.losses.landmark_weight = 0;
  const auto without = train_patched(set, options);
  ASSERT_TRUE(without.ok());
  EXPECT_NE(one->head.field.parameters, without->head.field.parameters);
}

TEST(LandmarkLoss, RefusesInvalidWeightsAndTooFewRays) {
  const TrainingSet set = wide_ball_set(8);
  TrainOptions options;
  options.schedule.steps = 1;
  for (const double weight : {-0.1, std::nan(""), std::numeric_limits<double>::infinity()}) {
    options.losses.landmark_weight = weight;
    const auto avatar = train_patched(set, options);
    ASSERT_FALSE(avatar.ok()) << weight;
    EXPECT_THAT(avatar.error().fix, HasSubstr("--landmark-loss 0.1"));
  }
  options.losses.landmark_weight = 0.1, options.rays.per_step = 4 * kPatchRays - 1;
  const auto avatar = train_patched(set, options);
  ASSERT_FALSE(avatar.ok());
  EXPECT_THAT(avatar.error().what, HasSubstr("patch"));
}

}  // namespace
}  // namespace likeness
