// Claims about training: it learns, repeats, resumes exactly, stops, and explains what it cannot do.
#include "core/train/train.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <vector>

#include "core/base/files.h"
#include "core/image/metrics.h"
#include "core/render/pose_avatar.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

class TrainAvatar : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("likeness_train_" + std::to_string(getpid()) + "_" +
               testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
    checkpoint_ = folder_ / "checkpoint.bin";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  static Result<Avatar> train(const TrainingSet& set, const TrainOptions& options,
                              const std::filesystem::path& checkpoint = {}, std::stop_token stop = {},
                              const std::function<void(const TrainStatus&)>& observe = {}) {
    return train_avatar(set, options, checkpoint, Progress(), observe, stop);
  }
  static TrainOptions short_options(std::uint64_t steps, int rays = 256) {
    TrainOptions options;
    options.schedule.steps = steps;
    options.rays.per_step = rays;
    options.seed = 3;
    return options;
  }
  std::filesystem::path folder_, checkpoint_;
};

RenderedFrame render_view(const Avatar& avatar, const HeadModel& model, const TrainingView& view) {
  return render_frame(avatar, view.camera, pose_avatar(*make_rig(avatar, model), view.pose));
}

double held_out_psnr(const Avatar& avatar, const TrainingSet& set, double time) {
  const TrainingView truth = ball_view(gradient_plate(set.size), set.size, time);
  const RenderedFrame frame = render_view(avatar, set.model, truth);
  return psnr_from_mse(mse(composite(frame.rgba, gradient_plate(set.size)), to_float(truth.rgb)));
}

TEST_F(TrainAvatar, ReachesThirtyDecibelsOnUnseenPosesOfABall) {
  const TrainingSet set = ball_set(40, 32);
  const auto avatar = train(set, short_options(150, 1024));
  ASSERT_TRUE(avatar.ok()) << avatar.error().what;
  for (const double time : {0.2, 1.3, 2.9}) EXPECT_GT(held_out_psnr(*avatar, set, time), 30) << time;
  for (const float p : avatar->head.field.parameters) ASSERT_TRUE(std::isfinite(p));
  EXPECT_EQ(avatar->steps, 150u);
}

TEST_F(TrainAvatar, SeparatesThePersonByTheMatteWhereThereIsNoPlate) {
  const TrainingSet set = ball_set(40, 32, false);
  const auto avatar = train(set, short_options(150, 1024));
  ASSERT_TRUE(avatar.ok()) << avatar.error().what;
  EXPECT_TRUE(avatar->plate.empty());
  const TrainingView& view = set.views[7];
  const RenderedFrame frame = render_view(*avatar, set.model, view);
  const Image8 matte = to_image(view.alpha);
  double error = 0;
  for (std::size_t i = 0; i < frame.rgba.pixels(); ++i)
    error += std::abs(frame.rgba.data[4 * i + 3] - float(matte.data[i]) / 255.f);
  EXPECT_LT(error / double(frame.rgba.pixels()), 0.03);
}

TEST_F(TrainAvatar, TheSameSeedGivesTheSameBits) {
  const TrainingSet set = ball_set(12, 24);
  const auto a = train(set, short_options(12)), b = train(set, short_options(12));
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a->head.field.parameters, b->head.field.parameters);
}

TEST_F(TrainAvatar, SnapshotOfARunningTrainingChangesNoBit) {
  const TrainingSet set = ball_set(12, 24);
  const auto unseen = train(set, short_options(40, 64));
  std::vector<std::uint64_t> steps;
  std::vector<float> last;
  const AvatarTap tap{[] { return true; },
                      [&](const Avatar& avatar) {
                        steps.push_back(avatar.steps);
                        last = avatar.head.field.parameters;
                      }};
  const auto seen = train_avatar(set, short_options(40, 64), {}, Progress(), {}, {}, tap);
  ASSERT_TRUE(unseen.ok() && seen.ok());
  EXPECT_EQ(steps.size(), 40u);
  EXPECT_TRUE(std::ranges::is_sorted(steps));
  EXPECT_EQ(unseen->head.field.parameters, seen->head.field.parameters);
  EXPECT_EQ(last, seen->head.field.parameters);  // the last snapshot equals the result
}

TEST_F(TrainAvatar, StoppedAndResumedRunEqualsAnUninterruptedOneBitForBit) {
  const TrainingSet set = ball_set(12, 24);
  const TrainOptions options = short_options(160, 64);  // past the first refresh of the occupancy
  const auto uncut = train(set, options, folder_ / "other.bin");
  ASSERT_TRUE(uncut.ok());
  // A checkpoint after every step, and a stop at the first report past the third step.
  std::stop_source source;
  TrainOptions slow = options;
  slow.schedule.checkpoint_every_s = 0;
  const auto cut = train(set, slow, checkpoint_, source.get_token(), [&](const TrainStatus& status) {
    if (status.step > 3) source.request_stop();
  });
  if (!cut.ok()) {
    EXPECT_EQ(cut.error().code, ErrorCode::cancelled);
    EXPECT_TRUE(std::filesystem::exists(checkpoint_));
  }
  const auto resumed = train(set, options, checkpoint_);
  ASSERT_TRUE(resumed.ok());
  EXPECT_EQ(uncut->head.field.parameters, resumed->head.field.parameters);
  EXPECT_EQ(uncut->head.occupancy.bits, resumed->head.occupancy.bits);
}

TEST_F(TrainAvatar, CanonicalCellsSurviveAStop) {
  const TrainingSet set = ball_set(12, 24);
  TrainOptions options = short_options(200, 64);  // past three updates of the cells
  options.rays.canonical_occupancy = true;
  double samples = 0;
  const auto uncut = train(set, options, {}, {}, [&](const TrainStatus& s) { samples = s.samples_per_ray; });
  ASSERT_TRUE(uncut.ok()) << uncut.error().what;
  EXPECT_GT(samples, 0.5);
  EXPECT_LE(samples, 16);
  std::stop_source source;
  TrainOptions slow = options;
  slow.schedule.checkpoint_every_s = 0;
  (void)train(set, slow, checkpoint_, source.get_token(), [&](const TrainStatus& status) {
    if (status.step > 3) source.request_stop();
  });
  ASSERT_TRUE(std::filesystem::exists(checkpoint_));
  const auto resumed = train(set, options, checkpoint_);
  ASSERT_TRUE(resumed.ok());
  EXPECT_EQ(uncut->head.field.parameters, resumed->head.field.parameters);
  // They cull other samples than the posed head's cells do, and cannot continue from those.
  options.rays.canonical_occupancy = false;
  const auto posed = train(set, options, checkpoint_);
  ASSERT_TRUE(posed.ok());
  EXPECT_NE(uncut->head.field.parameters, posed->head.field.parameters);
}

// Heights on the ball's lower front, by its expression; three views with their own.
TrainingSet with_detail(TrainingSet set) {
  std::vector<DetailFrame> frames;
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    DetailFrame& frame = frames.emplace_back();
    frame.frame = int(v), frame.articulation = set.views[v].pose.articulation;
    frame.height = Eigen::VectorXf::Zero(set.model.vertex_count());
    for (Eigen::Index i = 0; i < frame.height.size(); ++i)
      if (const Vec3f& p = set.model.vertices[std::size_t(i)]; p.y() < 0 && p.z() > 0)
        frame.height[i] = 0.05f * p.y() * frame.articulation.expression[0];
  }
  const LearntDetail learnt = learn_detail(frames);
  set.detail = learnt.detail;
  for (const std::size_t v : {0u, 3u, 5u})
    set.views[v].pose.detail = learnt.scores.row(Eigen::Index(v)).transpose();
  return set;
}

TEST_F(TrainAvatar, DetailMovesTheSurfaceItLearnsOnAndStaysInTheAvatar) {
  const TrainingSet plain = ball_set(12, 24), detailed = with_detail(plain);
  ASSERT_GT(detailed.detail.components(), 0);
  const TrainOptions options = short_options(8, 64);
  const auto without = train(plain, options, checkpoint_), with = train(detailed, options, checkpoint_),
             fresh = train(detailed, options);
  ASSERT_TRUE(without.ok() && with.ok() && fresh.ok());
  EXPECT_EQ(with->head.field.parameters, fresh->head.field.parameters);  // another surface: no continuation
  EXPECT_NE(with->head.field.parameters, without->head.field.parameters);
  EXPECT_TRUE(without->detail.empty());
  EXPECT_EQ(with->detail.basis, detailed.detail.basis);
  // A face that no view showed has its own heights: the lattice of the pose is another one.
  const AvatarRig rig = *make_rig(*with, detailed.model);
  AvatarPose pose = typical_state(*with).pose;
  pose.articulation.expression[0] = 0.5f * (detailed.views[0].pose.articulation.expression[0] +
                                            detailed.views[6].pose.articulation.expression[0]) +
                                    0.1f;
  AvatarRig bare = rig;
  bare.detail = {};
  EXPECT_NE(pose_avatar(rig, pose).warp.displacement, pose_avatar(bare, pose).warp.displacement);
  // A view's own scores take precedence over those predicted from its expression.
  AvatarPose own = pose;
  own.detail = detail_scores(rig.detail, pose.articulation);
  EXPECT_EQ(pose_avatar(rig, pose).warp.displacement, pose_avatar(rig, own).warp.displacement);
  own.detail = own.detail.array() + 1;
  EXPECT_NE(pose_avatar(rig, pose).warp.displacement, pose_avatar(rig, own).warp.displacement);
}

TEST_F(TrainAvatar, StartsOverAfterADamagedCheckpoint) {
  const TrainingSet set = ball_set(8, 24);
  ASSERT_TRUE(train(set, short_options(4, 64), checkpoint_).ok());
  auto bytes = *read_file(checkpoint_);
  bytes[bytes.size() / 2] ^= std::byte(1);
  ASSERT_TRUE(write_file(checkpoint_, bytes).ok());
  std::string warning;
  const Progress progress([&](const ProgressReport& report) {
    if (report.text.find("starts over") != std::string::npos) warning = report.text;
  });
  const auto avatar = train_avatar(set, short_options(4, 64), checkpoint_, progress, {}, {});
  ASSERT_TRUE(avatar.ok());
  EXPECT_EQ(avatar->steps, 4u);
  EXPECT_NE(warning.find("checksum"), std::string::npos);
}

TEST_F(TrainAvatar, AnotherTrackDoesNotContinueTheCheckpoint) {
  TrainingSet set = ball_set(8, 24);
  ASSERT_TRUE(train(set, short_options(4, 64), checkpoint_).ok());
  set.views[3].pose.world_from_head.pretranslate(Vec3d(0.001, 0, 0));
  const auto moved = train(set, short_options(4, 64), checkpoint_);
  const auto fresh = train(set, short_options(4, 64));
  ASSERT_TRUE(moved.ok() && fresh.ok());
  EXPECT_EQ(moved->head.field.parameters, fresh->head.field.parameters);
}

TEST_F(TrainAvatar, StoppedBeforeTheStartDoesNothing) {
  std::stop_source source;
  source.request_stop();
  const auto avatar = train(ball_set(4, 24), short_options(10), checkpoint_, source.get_token());
  ASSERT_FALSE(avatar.ok());
  EXPECT_EQ(avatar.error().code, ErrorCode::cancelled);
  EXPECT_FALSE(std::filesystem::exists(checkpoint_));
}

TEST_F(TrainAvatar, ABudgetedRunEndsWithItsScheduleComplete) {
  const TrainingSet set = ball_set(8, 24);
  TrainOptions options = short_options(0, 64);
  options.schedule.budget_s = 4;  // preparation counts too, and the computer may be busy
  const auto avatar = train(set, options, checkpoint_);
  ASSERT_TRUE(avatar.ok());
  EXPECT_GT(avatar->steps, 0u);
  EXPECT_GT(avatar->train_seconds, 0.0);
}

TEST_F(TrainAvatar, SaysWhatIsWrongWithASet) {
  TrainingSet none = ball_set(1, 24);
  none.views.clear();
  EXPECT_EQ(train(none, short_options(1)).error().code, ErrorCode::bad_input);
  TrainingSet small_plate = ball_set(2, 24);
  small_plate.plate = gradient_plate(20);
  EXPECT_NE(train(small_plate, short_options(1)).error().what.find("20x20"), std::string::npos);
  TrainingSet lost = ball_set(2, 24);
  lost.views[1].pose.world_from_head.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(train(lost, short_options(1)).ok());
  TrainingSet unmatted = ball_set(2, 24, false);
  unmatted.views[0].alpha = {};
  EXPECT_FALSE(train(unmatted, short_options(1)).error().fix.empty());
}

}  // namespace
}  // namespace likeness
