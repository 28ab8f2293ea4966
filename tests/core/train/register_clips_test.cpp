// Claims about further clips of a person: their heads are registered to the first clip's frame whatever their
// light, what the first clip never showed is learnt from them, and their light is not.
#include "core/train/register_clips.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/rigid.h"
#include "core/render/render.h"
#include "core/train/field_fit.h"
#include "core/train/refine_track.h"
#include "core/train/sides_seen.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

constexpr int kClipSize = 32;

// As clip 2 of the same person, in light weaker by a factor.
TrainingView of_further_clip(TrainingView view, double light) {
  view.further_clip = 2;
  view.has_plate = false;
  for (std::uint8_t& value : view.rgb.data) value = std::uint8_t(std::lround(light * value));
  return view;
}

// Mean square difference of what is seen of the head from a truth in a light.
double head_error(const Avatar& avatar, const HeadModel& model, const TrainingView& truth, double light = 1) {
  const AvatarRig rig = *make_rig(avatar, model);
  const RenderState state = pose_avatar(rig, truth.pose);
  const RenderedFrame seen = render_frame(avatar, truth.camera, state);
  double error = 0;
  int count = 0;
  for (int y = 0; y < kClipSize; ++y)
    for (int x = 0; x < kClipSize; ++x) {
      if (truth.alpha.at(x, y) < 255) continue;
      const std::size_t at = std::size_t(y) * kClipSize + std::size_t(x);
      for (std::size_t c = 0; c < 3; ++c, ++count)
        error += std::pow(seen.rgba.data[4 * at + c] - light * truth.rgb.data[3 * at + c] / 255, 2);
    }
  return error / count;
}

TEST(RegisterClips, FindsAFurtherClipsHeadWhateverItsLight) {
  TrainingSet set = ball_set(16, kClipSize);
  TrainOptions training = short_training(160);
  training.schedule.steps = 500;  // until it knows the stripes
  const auto avatar = train_avatar(set, training, {}, Progress(), {}, {});
  ASSERT_TRUE(avatar.ok()) << avatar.error().what;
  Pose offset = Pose::Identity();
  // Across the ball's stripes: along them nothing could be seen.
  offset.linear() = rotation_about(Vec3d(-4, 6, 0).normalized(), 0.06);
  offset.translation() = Vec3d(0.005, -0.004, 0);
  const Image8 plate = gradient_plate(kClipSize);
  std::vector<Pose> truth;
  for (int v = 0; v < 8; ++v) {
    set.views.push_back(of_further_clip(ball_view(plate, kClipSize, 0.2 + 0.41 * v), 0.6));
    truth.push_back(set.views.back().pose.world_from_head);
    set.views.back().pose.world_from_head = truth.back() * inverse(offset);
  }
  const AvatarRig rig = *make_rig(*avatar, set.model);
  const auto corrections = register_clips(set, *avatar, rig, {}, {});
  ASSERT_EQ(corrections.size(), set.views.size());
  for (std::size_t v = 0; v < 16; ++v) EXPECT_EQ(corrections[v].norm(), 0) << v;
  for (std::size_t v = 16; v < set.views.size(); ++v) {
    const Pose found = changed_pose(set.views[v].pose, avatar->condition, corrections[v]).world_from_head;
    const Pose left = inverse(found) * truth[v - 16];
    EXPECT_LT(rotation_angle(left.linear()), 0.03) << v;          // of 0.06
    EXPECT_LT(left.translation().head<2>().norm(), 0.0025) << v;  // of 0.0064
  }
  std::stop_source stopped;
  stopped.request_stop();
  EXPECT_TRUE(register_clips(set, *avatar, rig, {}, stopped.get_token()).empty());
}

TEST(RegisterClips, ViewsOfSomethingElseMoveNothing) {
  TrainingSet set = ball_set(12, kClipSize);
  const auto avatar = train_avatar(set, short_training(160), {}, Progress(), {}, {});
  ASSERT_TRUE(avatar.ok());
  RegisterOptions options;
  options.largest_turn = options.largest_shift = 0;  // everything found counts as implausible
  set.views.push_back(of_further_clip(set.views[3], 1));
  set.views.back().pose.world_from_head.translation().x() += 0.01;
  const auto corrections = register_clips(set, *avatar, *make_rig(*avatar, set.model), options, {});
  for (const Eigen::VectorXd& correction : corrections) EXPECT_EQ(correction.norm(), 0);
}

TEST(FurtherClips, TeachTheSideThatTheFirstClipNeverShowed) {
  const TrainingSet first = ball_set(12, kClipSize);
  TrainingSet both = first;
  const Image8 plate = gradient_plate(kClipSize);
  constexpr double kBack = 2.4;  // rad: the first clip turns by half a radian
  for (int v = 0; v < 12; ++v)
    both.views.push_back(of_further_clip(ball_view(plate, kClipSize, 0.37 * v, kBack * v / 11.0), 1));
  const TrainingView behind = ball_view(plate, kClipSize, 1.1, 2.0);
  TrainOptions training = short_training(160);
  training.schedule.steps =
      400;  // a quarter of them must be enough to see where the further clip's head lies
  const auto one = train_avatar(first, training, {}, Progress(), {}, {});
  const auto two = train_avatar(both, training, {}, Progress(), {}, {});
  ASSERT_TRUE(one.ok() && two.ok());
  EXPECT_LT(head_error(*two, first.model, behind), 0.5 * head_error(*one, first.model, behind));
}

TEST(FurtherClips, DropTheirCodesOnlyOnSidesThatTheFirstClipNeverShows) {
  TrainingSet set = ball_set(6, kClipSize);
  const HeadShape shape = shape_head(set.model, set.person);
  const FieldCube cube{Vec3f::Constant(-0.15f), 0.3f};
  const OccupancyGrid seen = sides_seen(set, shape, cube);
  constexpr std::size_t kSamples = 4000, kOwn = 6, kViews = 10;
  FieldSamples samples;
  samples.resize(2 * kSamples);
  const auto place = [&](std::size_t i, const Vec3f& head) {
    const Vec3f at = (head - cube.origin) / cube.side;
    samples.x[i] = at.x(), samples.y[i] = at.y(), samples.z[i] = at.z();
    samples.view[i] = std::int32_t(i % kViews);
  };
  for (std::size_t i = 0; i < kSamples; ++i) {
    place(i, Vec3f(0, 0, kBallRadius));              // the face
    place(kSamples + i, Vec3f(0, 0, -kBallRadius));  // the back of the head
  }
  drop_codes_on_new_sides(seen, kViews, kOwn, 3, 5, samples);
  std::size_t dropped = 0, further = 0;
  for (std::size_t i = 0; i < 2 * kSamples; ++i) {
    const bool drops = samples.view[i] >= std::int32_t(kViews);
    EXPECT_EQ(samples.view[i] % std::int32_t(kViews), std::int32_t(i % kViews));
    if (i < kSamples || i % kViews < kOwn) {
      EXPECT_FALSE(drops) << i;
    } else {
      ++further, dropped += drops;
    }
  }
  EXPECT_NEAR(double(dropped) / double(further), 0.5, 0.05);
}

TEST(FurtherClips, KeepTheirOwnLight) {
  TrainingSet set = ball_set(12, kClipSize);
  const Image8 plate = gradient_plate(kClipSize);
  for (int v = 0; v < 24; ++v)
    set.views.push_back(of_further_clip(ball_view(plate, kClipSize, 0.1 + 0.29 * v), 0.5));
  const auto avatar = train_avatar(set, short_training(160), {}, Progress(), {}, {});
  ASSERT_TRUE(avatar.ok());
  const TrainingView unseen = ball_view(plate, kClipSize, 0.9);
  EXPECT_LT(head_error(*avatar, set.model, unseen), 0.2 * head_error(*avatar, set.model, unseen, 0.5));
}

}  // namespace
}  // namespace likeness
