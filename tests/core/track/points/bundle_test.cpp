// Claims about the rigid bundle adjustment, on synthetic tracks.
#include "core/track/points/bundle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/base/rigid.h"

namespace likeness {
namespace {

struct BundleScene {
  std::vector<Pose> truth;
  std::vector<BundleFrame> frames;
  std::vector<BundleTrack> tracks;
  std::vector<Vec3d> points;
};

// Points on a head-sized ellipsoid seen over turning frames; start poses off by degrees and millimetres, some
// tracks stuck to the background, pixel noise on all. turn: share of half a radian to either side. drift_px:
// how far a track slides off its point from its first sighting to its last.
BundleScene make_scene(int frame_count, double noise_px, double turn = 1, double drift_px = 0) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  BundleScene scene;
  constexpr double kFocal = 1000;
  const Mat3d facing = Vec3d(1, -1, -1).asDiagonal();
  for (int i = 0; i < frame_count; ++i) {
    Pose pose = Pose::Identity();
    pose.linear() = facing * rotation_about(Vec3d::UnitY(), turn * 0.5 * std::sin(i * 0.08)) *
                    rotation_about(Vec3d::UnitX(), turn * 0.2 * std::sin(i * 0.05));
    pose.translation() = Vec3d(0.02 * std::sin(i * 0.1), 0.01 * std::cos(i * 0.06), 0.7);
    scene.truth.push_back(pose);
    // The landmark fit's error changes slowly: what temporal smoothing cannot remove.
    const Vec3d off(0.03 * std::sin(i * 0.11 + 1), 0.04 * std::sin(i * 0.07), 0.03 * std::sin(i * 0.09 + 2));
    BundleFrame frame{true, kFocal, pose};
    frame.cam_from_head.linear() = turn_from_vector(off) * pose.linear();
    frame.cam_from_head.translation() +=
        0.006 * Vec3d(std::sin(i * 0.13), std::sin(i * 0.17), 2 * std::sin(i * 0.1));
    scene.frames.push_back(frame);
  }
  for (int t = 0; t < 120; ++t) {
    const Vec3d direction =
        Vec3d(normal(random), normal(random), std::abs(normal(random)) + 0.4).normalized();
    const Vec3d point = direction.cwiseProduct(Vec3d(0.075, 0.11, 0.1));
    const bool stuck = t % 12 == 0;
    // Some run past either end, so that every frame sees enough of them.
    const int start = static_cast<int>(random() % static_cast<unsigned>(frame_count + 30)) - 40;
    const int from = std::max(0, start),
              to = std::min(std::max(start + 50 + static_cast<int>(random() % 50), from + 12), frame_count);
    BundleTrack track;
    track.point = point + 0.006 * Vec3d(normal(random), normal(random), normal(random));
    const Vec2d slides = Vec2d(std::cos(t), std::sin(t)) * (drift_px / kFocal);
    for (int i = from; i < to; ++i) {
      const Pose& seen_at = stuck ? scene.truth[from] : scene.truth[i];
      const Vec2d noise(normal(random), normal(random));
      track.seen.push_back({i, (seen_at * point).hnormalized() + noise * noise_px / kFocal +
                                   slides * (double(i - from) / double(to - from))});
    }
    scene.points.push_back(point);
    scene.tracks.push_back(track);
  }
  return scene;
}

// Largest rotation between the two sequences after their constant offset is taken out.
double worst_turn(const std::vector<Pose>& truth, const std::vector<BundleFrame>& found) {
  Vec3d mean = Vec3d::Zero();
  std::vector<Vec3d> offs;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    offs.push_back(vector_from_turn(truth[i].linear().transpose() * found[i].cam_from_head.linear()));
    mean += offs.back() / static_cast<double>(truth.size());
  }
  double worst = 0;
  for (const Vec3d& o : offs) worst = std::max(worst, (o - mean).norm());
  return worst;
}

TEST(Bundle, RecoversAKnownRigidMotion) {
  BundleScene scene = make_scene(90, 0.3);
  const double before = worst_turn(scene.truth, scene.frames);
  const auto summary = bundle_adjust(scene.frames, scene.tracks, {}, {}, {});
  ASSERT_TRUE(summary.ok());
  const double after = worst_turn(scene.truth, scene.frames);
  EXPECT_GT(before, 0.03);
  EXPECT_LT(after, 0.008) << "rad; before: " << before;
  EXPECT_LT(summary->median_px, 0.5);
}

TEST(Bundle, DropsTracksThatDoNotMoveWithTheHead) {
  BundleScene scene = make_scene(90, 0.3);
  ASSERT_TRUE(bundle_adjust(scene.frames, scene.tracks, {}, {}, {}).ok());
  int stuck_kept = 0, good_kept = 0;
  for (std::size_t t = 0; t < scene.tracks.size(); ++t)
    (t % 12 == 0 ? stuck_kept : good_kept) += scene.tracks[t].kept;
  EXPECT_LE(stuck_kept, 2);
  EXPECT_GE(good_kept, 105);
}

TEST(Bundle, FramesBetweenKeyFramesAreAsGood) {
  BundleScene scene = make_scene(90, 0.3);
  BundleOptions sparse;
  sparse.key_frames = 30;
  ASSERT_TRUE(bundle_adjust(scene.frames, scene.tracks, sparse, {}, {}).ok());
  EXPECT_LT(worst_turn(scene.truth, scene.frames), 0.01);
}

// A face that looks up for a while, as frames 60 to 110, shows points of its own, whose places are not known
// any better than the head's depth meanwhile.
BundleScene make_look_up(double start_error, double retreat = 0) {
  constexpr double kFocal = 1000;
  const Vec3d neck(0, -0.06, -0.02);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  BundleScene scene;
  const Mat3d facing = Vec3d(1, -1, -1).asDiagonal();
  const auto apart = [](int i) { return i >= 60 && i < 110; };
  for (int i = 0; i < 150; ++i) {
    Pose pose = Pose::Identity();
    pose.linear() = facing * rotation_about(Vec3d::UnitY(), 0.5 * std::sin(i * 0.06)) *
                    rotation_about(Vec3d::UnitX(), 0.3 * std::sin(i * 0.042));
    pose.translation() = Vec3d(0, 0.05, 0.8 + retreat * i) - pose.linear() * neck;  // the neck rests at 0
    scene.truth.push_back(pose);
    scene.frames.push_back({true, kFocal, pose});
    if (apart(i)) scene.frames.back().cam_from_head.translation() *= 1 + start_error / 0.8;
  }
  for (int t = 0; t < 160; ++t) {
    const bool of_look_up = t % 2 == 1;
    const Vec3d direction =
        Vec3d(normal(random), normal(random), std::abs(normal(random)) + 0.4).normalized();
    const Vec3d point = direction.cwiseProduct(Vec3d(0.075, 0.11, 0.1));
    BundleTrack track;
    track.point = point + 0.002 * Vec3d(normal(random), normal(random), normal(random));
    for (int i = 0; i < 150; ++i)
      if (apart(i) == of_look_up)
        track.seen.push_back({i, (scene.truth[i] * point).hnormalized() +
                                     0.3 / kFocal * Vec2d(normal(random), normal(random))});
    scene.points.push_back(point);
    scene.tracks.push_back(track);
  }
  return scene;
}

// Mean depth of the look-up's poses beside that of the others, m off.
double depth_error(const BundleScene& scene) {
  double sum[2] = {0, 0};
  int count[2] = {0, 0};
  for (std::size_t i = 0; i < scene.truth.size(); ++i) {
    const int part = i >= 60 && i < 110;
    sum[part] += scene.frames[i].cam_from_head.translation().z() - scene.truth[i].translation().z();
    ++count[part];
  }
  return std::abs(sum[1] / count[1] - sum[0] / count[0]);
}

TEST(Bundle, ARestingNeckHoldsTheDepthOfViewsThatShareNoPoints) {
  double error[2];
  for (const int rests : {0, 1}) {
    BundleScene scene = make_look_up(0.012);
    BundleOptions options;
    options.shift_prior = 10;  // landmarks alone do not know the depth either
    options.neck_rest = rests ? 60 : 0;
    ASSERT_TRUE(bundle_adjust(scene.frames, scene.tracks, options, {}, {}).ok());
    error[rests] = depth_error(scene);
  }
  EXPECT_GT(error[0], 0.004) << "m";
  EXPECT_LT(error[1], 0.6 * error[0]) << "m";
}

// As where the camera draws back: near views must not be drawn away with it, nor far ones nearer.
TEST(Bundle, ANeckThatDoesNotRestIsNotHeld) {
  std::vector<BundleFrame> found[2];
  for (const int rests : {0, 1}) {
    BundleScene scene = make_look_up(0, 0.002);
    BundleOptions options;
    options.neck_rest = rests ? 60 : 0;
    ASSERT_TRUE(bundle_adjust(scene.frames, scene.tracks, options, {}, {}).ok());
    found[rests] = scene.frames;
  }
  for (std::size_t i = 0; i < found[0].size(); ++i)
    EXPECT_EQ(found[0][i].cam_from_head.matrix(), found[1][i].cam_from_head.matrix()) << i;
}

// Root mean square distance of the kept points from where they are, m.
double points_off(const BundleScene& scene) {
  double sum = 0;
  int count = 0;
  for (std::size_t t = 0; t < scene.tracks.size(); ++t)
    if (scene.tracks[t].kept) sum += (scene.tracks[t].point - scene.points[t]).squaredNorm(), ++count;
  return std::sqrt(sum / std::max(1, count));
}

TEST(Bundle, InitialPointsWeighMoreOnAHeadThatHardlyTurns) {
  BundleOptions same;
  same.max_point_prior = same.point_prior;
  BundleScene with = make_scene(90, 0.2, 0.08, 1), without = with;
  ASSERT_TRUE(bundle_adjust(with.frames, with.tracks, {}, {}, {}).ok());
  ASSERT_TRUE(bundle_adjust(without.frames, without.tracks, same, {}, {}).ok());
  EXPECT_LT(points_off(with), 0.8 * points_off(without));
  EXPECT_LT(worst_turn(with.truth, with.frames), worst_turn(without.truth, without.frames));
  BundleScene turning = make_scene(90, 0.2), turning_same = turning;
  ASSERT_TRUE(bundle_adjust(turning.frames, turning.tracks, {}, {}, {}).ok());
  ASSERT_TRUE(bundle_adjust(turning_same.frames, turning_same.tracks, same, {}, {}).ok());
  EXPECT_EQ(points_off(turning), points_off(turning_same)) << "a head that turns tells its depth itself";
}

TEST(Bundle, StopsWhenAsked) {
  BundleScene scene = make_scene(40, 0.3);
  std::stop_source source;
  source.request_stop();
  const auto summary = bundle_adjust(scene.frames, scene.tracks, {}, {}, source.get_token());
  ASSERT_FALSE(summary.ok());
  EXPECT_EQ(summary.error().code, ErrorCode::cancelled);
}

TEST(SolvePose, FindsThePoseAmongOutliers) {
  const BundleScene scene = make_scene(40, 0.2);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-0.2, 0.2);
  for (int frame : {0, 20, 39}) {
    std::vector<PoseObservation> seen;
    for (std::size_t k = 0; k < scene.points.size(); ++k) {
      Vec2d ray = (scene.truth[frame] * scene.points[k]).hnormalized();
      if (k % 5 == 0) ray += Vec2d(uniform(random), uniform(random));  // a fifth is wrong by up to 200 px
      seen.push_back({scene.points[k], ray});
    }
    const auto pose = solve_pose(seen, 1000, scene.frames[frame].cam_from_head, {});
    ASSERT_TRUE(pose.has_value());
    const Mat3d off = pose->cam_from_head.linear() * scene.truth[frame].linear().transpose();
    EXPECT_LT(vector_from_turn(off).norm(), 2e-3);
    EXPECT_LT((pose->cam_from_head.translation() - scene.truth[frame].translation()).norm(), 2e-3);
  }
  EXPECT_FALSE(solve_pose({}, 1000, Pose::Identity(), {}).has_value());
}

TEST(Bundle, AFullMatrixAndASparseOneGiveTheSamePoses) {
  BundleScene full = make_scene(100, 0.5), sparse = make_scene(100, 0.5);
  BundleOptions options;
  ASSERT_TRUE(bundle_adjust(full.frames, full.tracks, options, Progress(), {}).ok());
  options.max_dense = 0;
  ASSERT_TRUE(bundle_adjust(sparse.frames, sparse.tracks, options, Progress(), {}).ok());
  for (std::size_t i = 0; i < full.frames.size(); ++i)
    EXPECT_TRUE(full.frames[i].cam_from_head.isApprox(sparse.frames[i].cam_from_head, 1e-6)) << i;
}

}  // namespace
}  // namespace likeness
