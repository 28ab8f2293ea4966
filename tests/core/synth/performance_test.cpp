// Claims about the demo's performance: who moves when, how far, and how smoothly.
#include "core/synth/performance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/rigid.h"
#include "core/head/builtin_head.h"

namespace likeness {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

struct Rehearsal {
  HeadModel model = make_builtin_head();
  HeadShape shape = shape_head(model, Eigen::VectorXf::Zero(model.identity_count()));
  DemoOptions options;
  std::vector<Shot> shots;

  explicit Rehearsal(int frames) {
    options.frames = frames;
    for (int i = 0; i < frames; ++i) shots.push_back(perform(model, shape, options, i));
  }
};

const Rehearsal& rehearsal() {
  static const Rehearsal instance(240);
  return instance;
}

double angle_between(const Pose& a, const Pose& b) {
  return rotation_angle(a.linear().transpose() * b.linear());
}

double yaw_of(const Mat3d& r) { return std::atan2(r(0, 2), r(2, 2)); }

TEST(Perform, HeadRestsWhileTheCameraMovesAndTheCameraRestsWhileTheHeadMoves) {
  const auto& shots = rehearsal().shots;
  const int moving = moving_frames(rehearsal().options);
  ASSERT_GT(moving, 60);
  for (int i = 0; i < int(shots.size()); ++i) {
    const Shot& s = shots[std::size_t(i)];
    if (i < moving) {
      EXPECT_TRUE(s.world_from_head.isApprox(Pose::Identity())) << i;
    } else {
      EXPECT_TRUE(s.camera.cam_from_world.isApprox(shots.back().camera.cam_from_world)) << i;
    }
  }
}

TEST(Perform, CameraAndHeadEachCoverThirtyDegreesToBothSides) {
  double camera_low = 0, camera_high = 0, head_low = 0, head_high = 0, pitch_low = 0, pitch_high = 0;
  for (const Shot& s : rehearsal().shots) {
    const Vec3d lens = inverse(s.camera.cam_from_world).translation();
    camera_low = std::min(camera_low, std::atan2(lens.x(), lens.z()));
    camera_high = std::max(camera_high, std::atan2(lens.x(), lens.z()));
    const double yaw = yaw_of(s.world_from_head.linear());
    const double pitch = std::asin(-s.world_from_head.linear()(1, 2));
    head_low = std::min(head_low, yaw);
    head_high = std::max(head_high, yaw);
    pitch_low = std::min(pitch_low, pitch);
    pitch_high = std::max(pitch_high, pitch);
  }
  EXPECT_LT(camera_low, -27 * kDegree);
  EXPECT_GT(camera_high, 27 * kDegree);
  EXPECT_LT(head_low, -28 * kDegree);
  EXPECT_GT(head_high, 28 * kDegree);
  EXPECT_LT(pitch_low, -8 * kDegree);
  EXPECT_GT(pitch_high, 8 * kDegree);
}

TEST(Perform, NothingJumpsFromFrameToFrame) {
  const auto& shots = rehearsal().shots;
  for (std::size_t i = 1; i < shots.size(); ++i) {
    EXPECT_LT(angle_between(shots[i - 1].world_from_head, shots[i].world_from_head), 4 * kDegree) << i;
    EXPECT_LT(angle_between(shots[i - 1].camera.cam_from_world, shots[i].camera.cam_from_world), 4 * kDegree)
        << i;
    const Vec3d step = inverse(shots[i].camera.cam_from_world).translation() -
                       inverse(shots[i - 1].camera.cam_from_world).translation();
    EXPECT_LT(step.norm(), 0.04) << i;
  }
}

TEST(Perform, TorsoMovesOnlySlightly) {
  for (const Shot& s : rehearsal().shots) {
    EXPECT_LT(angle_between(s.world_from_torso, Pose::Identity()), 2 * kDegree);
    EXPECT_LT((s.world_from_torso * Vec3d(0.15, -0.2, 0) - Vec3d(0.15, -0.2, 0)).norm(), 0.012);
  }
}

TEST(Perform, EveryClipHoweverShortOpensTheMouthSmilesAndBlinks) {
  for (const int frames : {48, 240}) {
    const Rehearsal r(frames);
    const auto strongest = [&](const std::string& name) {
      const auto& names = r.model.expression_names;
      const auto found = std::find(names.begin(), names.end(), name);
      if (found == names.end()) return -1.0;
      double most = 0;
      for (const Shot& s : r.shots)
        most = std::max(most, double(s.articulation.expression[found - names.begin()]));
      return most;
    };
    double jaw = 0;
    for (const Shot& s : r.shots) jaw = std::max(jaw, double(s.articulation.jaw.norm()));
    EXPECT_GT(std::max(jaw / 0.2, strongest("jawOpen")), 0.5) << frames;
    EXPECT_GT(strongest("mouthSmile_L"), 0.6) << frames;
    EXPECT_GT(strongest("browInnerUp_L"), 0.5) << frames;
    EXPECT_TRUE(frames < 100 || strongest("eyeBlink_L") > 0.8);
  }
}

// Both the training part and the held-out last tenth contain it, for every person.
TEST(Perform, EveryPersonPlaysEverythingBeforeAndWithinTheLastTenth) {
  const Rehearsal& base = rehearsal();
  const HeadModel& model = base.model;
  for (int person = 0; person < 6; ++person) {
    DemoOptions options;
    options.frames = 240;
    options.person = person;
    for (const bool last : {false, true}) {
      const int begin = last ? 216 : moving_frames(options), end = last ? 240 : 216;
      const auto range = [&](const auto& value) {
        double low = 1e9, high = -1e9;
        for (int i = begin; i < end; ++i) {
          const double x = value(perform(model, base.shape, options, i));
          low = std::min(low, x), high = std::max(high, x);
        }
        return high - low;
      };
      const auto strength = [&](const char* name) {
        const auto& names = model.expression_names;
        const auto index = std::find(names.begin(), names.end(), name) - names.begin();
        return range([&](const Shot& s) { return double(s.articulation.expression[index]); });
      };
      for (const char* name :
           {"mouthSmile_L", "mouthSmile_R", "mouthPucker", "browInnerUp_L", "browInnerUp_R"})
        EXPECT_GT(strength(name), 0.6) << name << ' ' << person << last;
      EXPECT_GT(strength("eyeBlink_L"), 0.8) << person << last;
      EXPECT_GT(range([](const Shot& s) { return double(s.articulation.jaw.x()); }), 0.2) << person << last;
      EXPECT_GT(range([](const Shot& s) { return yaw_of(s.world_from_head.linear()); }), 12 * kDegree)
          << person << last;
      EXPECT_GT(range([](const Shot& s) { return std::asin(-s.world_from_head.linear()(1, 2)); }),
                6 * kDegree)
          << person << last;
    }
  }
}

TEST(Perform, EyesMeetTheLensWhileTheHeadRests) {
  const Rehearsal& r = rehearsal();
  const Vec3d centre = r.shape.joints[kLeftEye].cast<double>();
  for (int i = 0; i < moving_frames(r.options); ++i) {
    const Shot& s = r.shots[std::size_t(i)];
    const Vec3f v = s.articulation.left_eye;
    const Vec3d gaze = rotation_about(v.cast<double>().normalized(), v.norm()) * Vec3d::UnitZ();
    const Vec3d lens = inverse(s.world_from_head) * inverse(s.camera.cam_from_world).translation();
    // Further aside than 30 degrees the eyes do not follow.
    EXPECT_LT(std::acos(std::min(1.0, gaze.dot((lens - centre).normalized()))), 8 * kDegree) << i;
  }
}

// The shots of a resting camera, whose performance turns the head all the time.
std::vector<Shot> performed(DemoOptions options) {
  const Rehearsal& r = rehearsal();
  options.camera = DemoCamera::resting;
  std::vector<Shot> shots;
  for (int i = 0; i < options.frames; ++i) shots.push_back(perform(r.model, r.shape, options, i));
  return shots;
}

double widest_turn_deg(const std::vector<Shot>& shots) {
  double widest = 0;
  for (const Shot& s : shots)
    widest = std::max(widest, angle_between(s.world_from_head, Pose::Identity()) / kDegree);
  return widest;
}

TEST(Perform, AHeadThatIsHeldTurnsNoFurtherAndStillTurns) {
  DemoOptions options;
  for (const int seed : {0, 3})
    for (const double most : {5.0, 12.0}) {
      options.seed = seed, options.head_within_deg = most;
      const double widest = widest_turn_deg(performed(options));
      EXPECT_LE(widest, most) << seed;
      EXPECT_GT(widest, 0.8 * most) << seed;
    }
}

TEST(Perform, ThePlainPerformanceStaysWithinTheWidestTurn) {
  for (const int frames : {60, 240, 900}) {
    DemoOptions options;
    options.frames = frames;
    const double widest = widest_turn_deg(performed(options));
    EXPECT_LE(widest, kWidestTurn_deg) << frames;
    EXPECT_GT(widest, 0.9 * kWidestTurn_deg) << frames;
  }
}

TEST(Perform, AShareOfTheActionsIsThatMuchOfEachAtMost) {
  DemoOptions options;
  const std::vector<Shot> whole = performed(options);
  options.action_share = 0.4;
  const std::vector<Shot> faint = performed(options);
  double most = 0, most_jaw = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const Articulation &a = whole[i].articulation, &b = faint[i].articulation;
    for (int k = 0; k < a.expression.size(); ++k) {
      // Where the whole one was clamped, the share is of what was asked for.
      const float usual = a.expression[k] >= rehearsal().model.expression_max[k] ? 1e9f : a.expression[k];
      ASSERT_LE(b.expression[k], 0.4f * usual + 1e-5f)
          << i << ' ' << rehearsal().model.expression_names[std::size_t(k)];
      most = std::max(most, double(b.expression[k]));
    }
    ASSERT_LE(b.jaw.norm(), 0.4f * a.jaw.norm() + 1e-5f) << i;
    most_jaw = std::max(most_jaw, double(b.jaw.norm()));
    // Eyes and head do what they did.
    ASSERT_EQ(a.left_eye, b.left_eye);
    ASSERT_TRUE(whole[i].world_from_head.isApprox(faint[i].world_from_head, 0));
  }
  EXPECT_GT(most, 0.3);
  EXPECT_LE(most, 0.4 + 1e-5);
  EXPECT_GT(most_jaw, 0.03);
}

// The whole of it is what was performed before there was a choice: no bit changes.
TEST(Perform, TheWholePerformanceIsTheUsualOneToTheBit) {
  DemoOptions asked;
  asked.head_within_deg = 90, asked.action_share = 1;
  const std::vector<Shot> whole = performed(asked), usual = performed({});
  for (std::size_t i = 0; i < usual.size(); ++i) {
    const Shot &a = usual[i], &b = whole[i];
    ASSERT_EQ(a.world_from_head.matrix(), b.world_from_head.matrix()) << i;
    ASSERT_EQ(a.world_from_torso.matrix(), b.world_from_torso.matrix()) << i;
    ASSERT_EQ(a.articulation.expression, b.articulation.expression) << i;
    ASSERT_EQ(a.articulation.jaw, b.articulation.jaw) << i;
  }
}

}  // namespace
}  // namespace likeness
