// Claims about training with an attribute: a patch of a ball that changes its colour as no expression does is
// learnt with its amounts, the slider moves that patch and nothing else, and training without attributes is
// unchanged.
#include <gtest/gtest.h>

#include "core/image/metrics.h"
#include "core/render/pose_avatar.h"
#include "core/train/still_cells.h"
#include "core/train/train.h"
#include "core/train/training_step.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

float shown = 0;  // of the attribute, by the picture being drawn

// A round patch on the right cheek darkens.
Vec3f blushing(const Vec3f& n, float expression) {
  const float near = (n - Vec3f(-0.45f, -0.1f, 0.89f)).norm();
  const float patch = std::clamp((0.35f - near) / 0.08f, 0.f, 1.f);
  return ball_colour(n, expression) * (1 - 0.7f * shown * patch);
}

// A region around that patch.
AttributeRegion patch_region() {
  AttributeRegion region;
  region.name = "blush";
  region.low = 0, region.high = 1;
  region.cell = 0.005f;
  region.count = {20, 20, 20};
  const Vec3f middle = kBallRadius * Vec3f(-0.45f, -0.1f, 0.89f);
  region.origin = middle - Vec3f::Constant(9.5f * region.cell);
  for (int z = 0; z < 20; ++z)
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 20; ++x) {
        const float r = (Vec3f(float(x), float(y), float(z)) - Vec3f::Constant(9.5f)).norm() * region.cell;
        region.weights.push_back(std::uint8_t(255 * std::clamp((0.045f - r) / 0.006f, 0.f, 1.f)));
      }
  return region;
}

float amount_of(int view) { return view % 3 == 0 ? 1.f : view % 3 == 1 ? 0.f : 0.5f; }

TrainingSet blushing_set(int views, int size) {
  TrainingSet set = ball_set(views, size);
  for (int v = 0; v < views; ++v) {
    TrainingView& view = set.views[std::size_t(v)];
    shown = amount_of(v);
    const TrainingView drawn = ball_view(gradient_plate(size), size, 0.37 * v, 0, blushing);
    view.rgb = drawn.rgb, view.alpha = drawn.alpha;
    view.pose = drawn.pose;
  }
  return set;
}

void with_amounts(TrainingSet& set) {
  set.attributes = {patch_region()};
  for (std::size_t v = 0; v < set.views.size(); ++v) set.views[v].pose.attributes = {amount_of(int(v))};
}

TrainOptions options(FieldMode mode) {
  TrainOptions o;
  o.schedule.steps = 250, o.rays.per_step = 1024, o.seed = 3, o.fields.mode = mode;
  return o;
}

Result<Avatar> train_blushing(const TrainingSet& set, FieldMode mode) {
  return train_avatar(set, options(mode), {}, Progress(), nullptr, {});
}

Image picture(const Avatar& avatar, const HeadModel& model, const TrainingView& view, float amount) {
  AvatarPose pose = view.pose;
  if (!avatar.attributes.empty()) pose.attributes = {amount};
  return composite(render_frame(avatar, view.camera, pose_avatar(*make_rig(avatar, model), pose)).rgba,
                   gradient_plate(view.rgb.width));
}

// Views never seen.
double unseen_psnr(const Avatar& avatar, const HeadModel& model, int size) {
  double sum = 0;
  int count = 0;
  for (const double time : {0.21, 1.33, 2.97})
    for (const float amount : {0.f, 0.5f, 1.f}) {
      shown = amount;
      const TrainingView view = ball_view(gradient_plate(size), size, time, 0, blushing);
      sum += mse(picture(avatar, model, view, amount), to_float(view.rgb)), ++count;
    }
  return psnr_from_mse(sum / count);
}

class AttributeTraining : public testing::TestWithParam<FieldMode> {};
INSTANTIATE_TEST_SUITE_P(Modes, AttributeTraining, testing::Values(FieldMode::warp_hyper, FieldMode::concat),
                         [](const auto& info) {
                           return info.param == FieldMode::concat ? "Concat" : "WarpHyper";
                         });

TEST_P(AttributeTraining, RendersUnseenAmountsBetterAndLeavesTheRestOfTheFaceIdentical) {
  constexpr int kSize = 40;
  TrainingSet set = blushing_set(36, kSize);
  const auto without = train_blushing(set, GetParam());
  ASSERT_TRUE(without.ok()) << without.error().what;
  EXPECT_TRUE(without->attributes.empty());
  EXPECT_EQ(without->head.field.config.local_conditions, 0);
  with_amounts(set);
  const auto with = train_blushing(set, GetParam());
  ASSERT_TRUE(with.ok()) << with.error().what;
  ASSERT_EQ(with->attributes.size(), 1u);
  EXPECT_EQ(with->head.field.config.local_conditions, 1);
  const double plain = unseen_psnr(*without, set.model, kSize),
               conditioned = unseen_psnr(*with, set.model, kSize);
  EXPECT_GT(conditioned, plain + 1.5);

  // -- Locality: of pixels none of whose samples the region reaches.
  const TrainingView& view = set.views[4];
  const Image low = picture(*with, set.model, view, 0.1f), high = picture(*with, set.model, view, 1);
  const UnitFromCamera map =
      unit_from_camera({Vec3f::Zero(), 1}, view.camera.cam_from_world, view.pose.world_from_head);
  double inside = 0;
  int outside = 0;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const FieldRay ray = field_ray(
          map, ray_direction(view.camera.intrinsics, Vec2d(x + 0.5, y + 0.5)).normalized().cast<float>());
      // The nearest any point of the ray comes to the middle of the region; more than its corner is outside.
      const Vec3f to = kBallRadius * Vec3f(-0.45f, -0.1f, 0.89f) - ray.origin;
      const float near = (to - to.dot(ray.direction) * ray.direction).norm();
      const std::size_t at = 3 * (std::size_t(y) * kSize + std::size_t(x));
      for (std::size_t c = 0; c < 3; ++c) {
        const float change = std::abs(low.data[at + c] - high.data[at + c]);
        if (near > 0.075f) {
          ++outside;
          ASSERT_EQ(change, 0) << x << " " << y;
        } else if (near < 0.02f) {
          inside = std::max(inside, double(change));
        }
      }
    }
  EXPECT_GT(outside, 300);
  EXPECT_GT(inside, 0.15);
  // Beyond the seen range nothing more changes.
  EXPECT_EQ(picture(*with, set.model, view, 7).data, high.data);
  EXPECT_EQ(picture(*with, set.model, view, -3).data, picture(*with, set.model, view, 0).data);
}

TEST(AttributeCells, AreConditionedInTheWholeRegion) {
  TrainingSet set = ball_set(8, 24);
  const FieldCube cube{Vec3f::Constant(-0.15f), 0.3f};
  OccupancyGrid still = make_occupancy(32, true);
  const AttributeRegion region = patch_region();
  clear_region(region, cube, still);
  int cleared = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto unit = [&](int prime) { return float(i * prime % 997) / 997.f; };
    const Vec3f at = cube.origin + cube.side * Vec3f(unit(7), unit(31), unit(113));
    const Vec3f cell = (at - cube.origin) / cube.side * 32;
    if (region_weight(region, at) == 0) continue;
    EXPECT_FALSE(still.occupied(int(cell.x()), int(cell.y()), int(cell.z())));
    ++cleared;
  }
  EXPECT_GT(cleared, 3);
  EXPECT_TRUE(still.occupied(1, 1, 1));
}

}  // namespace
}  // namespace likeness
