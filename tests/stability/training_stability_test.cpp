// Claims about training on what captures may hold: saturated pixels, wild numbers, rates that are too high.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "core/image/metrics.h"
#include "core/render/pose_avatar.h"
#include "core/train/train.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

TrainOptions options_of(std::uint64_t steps, FieldPrecision precision = FieldPrecision::bf16) {
  TrainOptions options;
  options.place.precision = precision;
  options.schedule.steps = steps;
  options.rays.per_step = 256;
  options.seed = 5;
  return options;
}

Result<Avatar> train(const TrainingSet& set, const TrainOptions& options, double* last_loss = nullptr) {
  return train_avatar(set, options, {}, Progress(),
                      [&](const TrainStatus& status) {
                        if (last_loss) *last_loss = status.loss;
                      },
                      {});
}

Image picture(const Avatar& avatar, const HeadModel& model, TrainingView view) {
  const RenderedFrame frame =
      render_frame(avatar, view.camera, pose_avatar(*make_rig(avatar, model), view.pose));
  return composite(frame.rgba, {}, Vec3f::Constant(0.5f));
}

bool is_picture(const Image& image) {
  for (const float v : image.data)
    if (!(v >= -1e-6f && v <= 1 + 1e-6f)) return false;
  return true;
}

class TrainingInPrecision : public testing::TestWithParam<FieldPrecision> {};
INSTANTIATE_TEST_SUITE_P(Stability, TrainingInPrecision,
                         testing::Values(FieldPrecision::exact, FieldPrecision::bf16), [](const auto& info) {
                           return info.param == FieldPrecision::exact ? "Exact" : "Bf16";
                         });

TEST_P(TrainingInPrecision, SaturatedPixelsAreLearntWithoutDivergence) {
  for (const std::uint8_t level : {0, 255}) {
    TrainingSet set = ball_set(12, 24, false);
    for (TrainingView& view : set.views)
      for (std::size_t i = 0; i < view.rgb.pixels(); ++i)
        for (std::size_t c = 0; c < 3; ++c) view.rgb.data[3 * i + c] = level;
    double loss = 1;
    const auto avatar = train(set, options_of(200, GetParam()), &loss);
    ASSERT_TRUE(avatar.ok()) << avatar.error().what;
    EXPECT_LT(loss, 0.01);
    for (const float p : avatar->head.field.parameters) ASSERT_TRUE(std::isfinite(p));
    const Image image = picture(*avatar, set.model, set.views[0]);
    ASSERT_TRUE(is_picture(image));
    EXPECT_NEAR(image.at(12, 12)[1], float(level) / 255.f, 0.06f);
  }
}

// The field is not asked for what it has not learnt: far outside, the face is the one at the edge of what was
// seen, moved further by the mesh.
TEST(TrainingStability, FiveDeviationsOutsideTheFaceIsStillAFace) {
  const TrainingSet set = ball_set(40, 32);
  const auto avatar = train(set, options_of(250));
  ASSERT_TRUE(avatar.ok()) << avatar.error().what;
  double sum = 0, squares = 0;
  for (const TrainingView& view : set.views)
    sum += view.pose.articulation.expression[0], squares += std::pow(view.pose.articulation.expression[0], 2);
  const double n = double(set.views.size()), mean = sum / n, deviation = std::sqrt(squares / n - mean * mean);
  for (const double sigmas : {-5.0, 5.0}) {
    TrainingView view = set.views[3], edge = view;
    view.pose.articulation.expression[0] = float(mean + sigmas * deviation);
    edge.pose.articulation.expression[0] = sigmas < 0 ? 0.f : 1.f;
    const Image far = picture(*avatar, set.model, view), near = picture(*avatar, set.model, edge);
    ASSERT_TRUE(is_picture(far));
    EXPECT_GT(psnr_from_mse(mse(far, near)), 20) << sigmas;
  }
}

TEST_P(TrainingInPrecision, RatesFarTooHighRecoverOrStopWithAMessage) {
  const TrainingSet set = ball_set(12, 24);
  for (const double rate : {10.0, 1e3, 1e6}) {
    TrainOptions options = options_of(150, GetParam());
    options.schedule.rate = rate;
    double loss = 1;
    const auto avatar = train(set, options, &loss);
    if (!avatar) {
      EXPECT_EQ(avatar.error().code, ErrorCode::failed);
      EXPECT_FALSE(avatar.error().fix.empty());
      continue;
    }
    for (const float p : avatar->head.field.parameters) ASSERT_TRUE(std::isfinite(p)) << rate;
    EXPECT_TRUE(is_picture(picture(*avatar, set.model, set.views[0]))) << rate;
    if (rate <= 10) {
      EXPECT_LT(loss, 0.02);
    }
  }
}

// What is no number is named, not trained on.
TEST(TrainingStability, RefusesNonFiniteNumbersByName) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const struct {
    const char* name;
    std::function<void(TrainingSet&, double)> spoil;
  } cases[] = {
      {"track", [](TrainingSet& s, double v) { s.views[2].pose.world_from_head.translation().x() = v; }},
      {"track", [](TrainingSet& s, double v) { s.views[2].pose.world_from_torso.matrix()(0, 1) = v; }},
      {"track", [](TrainingSet& s, double v) { s.views[2].pose.articulation.expression[1] = float(v); }},
      {"track", [](TrainingSet& s, double v) { s.views[2].pose.torso_shape[0] = float(v); }},
      {"camera", [](TrainingSet& s, double v) { s.views[2].camera.intrinsics.fx = v; }},
      {"camera", [](TrainingSet& s, double v) { s.views[2].camera.cam_from_world.translation().z() = v; }},
      {"person", [](TrainingSet& s, double v) { s.person.identity[0] = float(v); }},
      {"neutral", [](TrainingSet& s, double v) {
         s.neutral = s.views[0].pose.articulation;
         s.neutral.jaw.x() = float(v);
       }}};
  for (const auto& c : cases)
    for (const double value : {nan, inf}) {
      TrainingSet set = ball_set(4, 24);
      c.spoil(set, value);
      const auto avatar = train(set, options_of(5));
      ASSERT_FALSE(avatar.ok()) << c.name;
      EXPECT_EQ(avatar.error().code, ErrorCode::bad_input);
      EXPECT_NE(avatar.error().what.find(c.name), std::string::npos) << avatar.error().what;
      EXPECT_FALSE(avatar.error().fix.empty());
    }
}

}  // namespace
}  // namespace likeness
