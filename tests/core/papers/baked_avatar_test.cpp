// Claims about an avatar whose fields are stored.
#include "core/papers/baked_avatar.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/image/metrics.h"
#include "core/train/random_stream.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

constexpr int kGiven = 6;

// A ray's samples of head and torso, with values made up.
struct MadeRay {
  std::vector<std::vector<float>> values;
  std::vector<BakedSample> samples;
};
MadeRay made_ray(std::uint64_t seed, int count) {
  MadeRay ray;
  RandomStream random(seed, 0, 1);
  for (int k = 0; k < count; ++k) {
    auto& values = ray.values.emplace_back(3 + kGiven);
    for (float& v : values) v = random.uniform();
  }
  for (const auto& values : ray.values)
    ray.samples.push_back({random.uniform() < 0.3f ? 1 : 0, 0.5f * random.uniform(), values.data()});
  return ray;
}

BakedRays made_rays(int count) {
  BakedRays rays;
  rays.features = kGiven;
  for (int r = 0; r < count; ++r) {
    RandomStream random(std::uint64_t(r), 7, 7);
    const Vec3f d = Vec3f(random.uniform() - 0.5f, random.uniform() - 0.5f, 1).normalized();
    add_ray(made_ray(std::uint64_t(r), 9).samples, d, r % 3, Vec3f(0.2f, 0.4f, 0.6f),
            Vec3f(random.uniform(), random.uniform(), random.uniform()), rays);
  }
  return rays;
}

TEST(BakedAvatar, RaysAreCompositedAsInDoublePrecision) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const MadeRay ray = made_ray(seed, 12);
    BakedRays rays;
    rays.features = kGiven;
    add_ray(ray.samples, Vec3f(0, 0.6f, 0.8f), 4, Vec3f(0.1f, 0.2f, 0.3f), Vec3f(1, 0, 1), rays);
    ASSERT_EQ(rays.count(), 1u);
    double mean[3 + kGiven] = {}, rest[3] = {}, transmittance = 1, light = 0;
    for (const BakedSample& s : ray.samples) {
      const double weight = transmittance * (1 - std::exp(-double(s.depth)));
      transmittance *= std::exp(-double(s.depth));
      for (int i = 0; i < 3 + kGiven && s.part == 0; ++i) mean[i] += weight * double(s.values[i]);
      for (int c = 0; c < 3 && s.part == 1; ++c) rest[c] += weight * double(s.values[c]);
      if (s.part == 0) light += weight;
    }
    EXPECT_NEAR(rays.light[0], light, 1e-5);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(rays.diffuse[std::size_t(i)], mean[i] / light, 1e-5);
      EXPECT_NEAR(rays.rest[std::size_t(i)], rest[i] + transmittance * 0.1 * (i + 1), 1e-5);
    }
    for (int i = 0; i < kGiven; ++i) EXPECT_NEAR(rays.given[std::size_t(i)], mean[3 + i] / light, 1e-5);
    EXPECT_EQ(rays.condition[0], 4);
    EXPECT_FLOAT_EQ(rays.view[4], 0.48f);
  }
}

TEST(BakedAvatar, RaysThatMissTheHeadTeachNothing) {
  MadeRay ray = made_ray(1, 8);
  for (BakedSample& s : ray.samples) s.part = 1;
  BakedRays rays;
  rays.features = kGiven;
  add_ray(ray.samples, Vec3f(0, 0, 1), 0, Vec3f::Zero(), Vec3f::Zero(), rays);
  EXPECT_EQ(rays.count(), 0u);
  EXPECT_TRUE(rays.given.empty() && rays.target.empty());
}

TEST(BakedAvatar, NetworkGradientsPerRayMatchFiniteDifferences) {
  constexpr int kConditions = 2;
  const BakedRays rays = made_rays(24);
  const DenseNetworkSpec network = ray_network(kGiven, kConditions);
  EXPECT_EQ(parameter_count(network),
            std::size_t(4 * (kGiven + 1) + 16 * (4 + 3 + 8 + 2 + 1) + 16 * 17 + 3 * 17));
  std::vector<float> start(parameter_count(network));
  initialise(network, 5, start);
  std::vector<double> parameters(start.begin(), start.end()), gradients(start.size(), 0.0);
  const std::vector<float> conditions{0.1f, -0.3f, 0.4f, 0.2f, -0.5f, 0.6f};
  std::vector<std::uint32_t> chosen{0, 3, 5, 5, 11, 17, 22};
  (void)ray_loss(network, parameters.data(), rays, chosen, conditions, gradients.data());
  double largest = 0;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    constexpr double kStep = 1e-6;
    const double at = parameters[i];
    parameters[i] = at + kStep;
    const double above = ray_loss<double>(network, parameters.data(), rays, chosen, conditions, nullptr);
    parameters[i] = at - kStep;
    const double below = ray_loss<double>(network, parameters.data(), rays, chosen, conditions, nullptr);
    parameters[i] = at;
    EXPECT_NEAR(gradients[i], (above - below) / (2 * kStep), 1e-7 + 1e-5 * std::abs(gradients[i])) << i;
    largest = std::max(largest, std::abs(gradients[i]));
  }
  EXPECT_GT(largest, 1e-3);
  // The single precision that trains says the same.
  std::vector<float> single(start.size(), 0.f);
  (void)ray_loss(network, start.data(), rays, chosen, conditions, single.data());
  for (std::size_t i = 0; i < single.size(); ++i) EXPECT_NEAR(single[i], gradients[i], 1e-5) << i;
}

class BakedBall : public testing::Test {
 protected:
  static const TrainingSet& set() {
    static const TrainingSet kSet = ball_set(16, 48);
    return kSet;
  }
  static const Avatar& avatar() {
    static const Avatar kAvatar = [] {
      TrainOptions options;
      options.schedule.steps = 150, options.rays.per_step = 1024,
      options.place.precision = FieldPrecision::exact;
      auto trained = train_avatar(set(), options, {}, Progress(), {}, {});
      EXPECT_TRUE(trained.ok()) << trained.error().what;
      return trained.ok() ? std::move(*trained) : Avatar{};
    }();
    return kAvatar;
  }
  static BakeOptions small() {
    BakeOptions options;
    options.head_resolution = 96, options.torso_resolution = 64, options.rays = 8192, options.steps = 300;
    options.rays_per_step = 1024;
    return options;
  }
  static const BakedAvatar& baked() {
    static BakeReport report;
    static const BakedAvatar kBaked = [] {
      auto made = bake_avatar(avatar(), set(), small(), Progress(), {}, &report);
      EXPECT_TRUE(made.ok()) << made.error().what;
      EXPECT_GE(report.rays, 8192u);
      EXPECT_LT(report.loss_after, report.loss_before);
      return made.ok() ? std::move(*made) : BakedAvatar{};
    }();
    return kBaked;
  }
};

TEST_F(BakedBall, PicturesAreCloseToTheAvatars) {
  const AvatarRig rig = *make_rig(avatar(), set().model);
  for (const std::size_t v : {1u, 6u, 11u}) {
    const TrainingView& view = set().views[v];
    const RenderState state = pose_avatar(rig, view.pose);
    const Image truth = to_float(view.rgb);
    const Image own = composite(render_frame(avatar(), view.camera, state).rgba, set().plate),
                stored = composite(render_baked(baked(), view.camera, state).rgba, set().plate);
    EXPECT_GT(psnr_from_mse(mse(own, stored)), 32) << v;
    EXPECT_GT(psnr_from_mse(mse(stored, truth)), 34) << v;  // the avatar itself: 43 in the last one
  }
}

TEST_F(BakedBall, TheFieldsThemselvesAreNotNeeded) {
  EXPECT_TRUE(baked().scene.head.field.parameters.empty());
  EXPECT_GT(stored_bytes(baked()), baked().head.nodes.size() * sizeof(float));
  EXPECT_EQ(baked().head.channels, 8);
}

// Only the term added per ray depends on the expression.
TEST_F(BakedBall, ExpressionChangesColoursButNotShape) {
  const AvatarRig rig = *make_rig(avatar(), set().model);
  const TrainingView& view = set().views[0];
  const auto render = [&](float bulge) {
    Articulation articulation = view.pose.articulation;
    articulation.expression[0] = bulge;
    // The rest's lattice: the deformation would move the shape.
    RenderState state = pose_avatar(rig, view.pose);
    state.pose.articulation = articulation;
    return render_baked(baked(), view.camera, state).rgba;
  };
  const Image rest = render(0), bulged = render(1);
  double alpha = 0, colour = 0;
  for (std::size_t i = 0; i < rest.pixels(); ++i) {
    alpha = std::max(alpha, double(std::abs(rest.data[4 * i + 3] - bulged.data[4 * i + 3])));
    colour = std::max(colour, double(std::abs(rest.data[4 * i + 1] - bulged.data[4 * i + 1])));
  }
  EXPECT_EQ(alpha, 0);
  EXPECT_GT(colour, 0.01);
}

TEST_F(BakedBall, TheSameSeedGivesTheSameBits) {
  const auto again = bake_avatar(avatar(), set(), small(), Progress(), {});
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again->head.nodes, baked().head.nodes);
  EXPECT_EQ(again->parameters, baked().parameters);
}

TEST_F(BakedBall, StopsWhenAsked) {
  std::stop_source source;
  source.request_stop();
  const auto stopped = bake_avatar(avatar(), set(), small(), Progress(), source.get_token());
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
  std::stop_source later;
  const Progress progress([&](const ProgressReport& report) {
    if (report.fraction > 0.7) later.request_stop();
  });
  const auto midway = bake_avatar(avatar(), set(), small(), progress, later.get_token());
  ASSERT_FALSE(midway.ok());
  EXPECT_EQ(midway.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace likeness
