// Claims about carrying a performance from one person to another.
#include "core/drive/drive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include "core/base/rigid.h"
#include "core/drive/drive_stream.h"
#include "core/head/action_amounts.h"
#include "core/head/load_head_model.h"
#include "core/head/pose_head.h"
#include "tests/core/face/synthetic_face.h"

namespace likeness {
namespace {

std::filesystem::path ict_path() {
  return std::filesystem::path(LIKENESS_SHARED) / "head_models" / "ict_head_flame_schema.npz";
}

Articulation acted(const HeadModel& model, const std::vector<std::pair<const char*, float>>& actions) {
  Articulation out = neutral_articulation(model);
  for (const auto& [name, amount] : actions) add_action(out, *find_action(model, name), amount);
  return out;
}

// A person who nods, leans, smiles and talks; rests in the first and every 40th frame.
Track performed(const HeadModel& model, const Articulation& rest, double noise = 0) {
  std::mt19937 random(4);
  std::normal_distribution<float> normal;
  Track track;
  track.head_model_name = model.name;
  track.head_model_hash = model.hash;
  track.person.identity = Eigen::VectorXf::Zero(model.identity_count());
  track.neutral = rest;
  for (int i = 0; i < 120; ++i) {
    const double t = 2 * std::numbers::pi * i / 40;
    const float play = float(0.5 - 0.5 * std::cos(t)), slow = float(0.5 - 0.5 * std::cos(t / 3));
    TrackedFrame f;
    f.frame = i;
    f.time_s = i / 25.0;
    f.pose.articulation = rest;
    add_action(f.pose.articulation, *find_action(model, "jawOpen"), 0.6f * play);
    add_action(f.pose.articulation, *find_action(model, "mouthSmile_L"), 0.7f * slow);
    add_action(f.pose.articulation, *find_action(model, "browInnerUp_L"), 0.5f * play * slow);
    f.pose.articulation.left_eye.y() += 0.2f * float(std::sin(t)),
        f.pose.articulation.right_eye.y() += 0.2f * float(std::sin(t));
    f.pose.world_from_head =
        facing_pose(0.4 * std::sin(t), 0.2 * std::sin(2 * t), {0.02 * std::sin(t), 0.01, 0.7});
    if (noise > 0) {
      for (float& v : f.pose.articulation.expression) v += float(noise) * normal(random);
      f.pose.articulation.jaw.x() += 0.3f * float(noise) * normal(random);
    }
    track.frames.push_back(f);
  }
  return track;
}

// The performer as an avatar of their own.
DriveSubject self_of(const Track& track, const HeadModel& model) {
  DriveSubject subject = *subject_from_track(track, model);
  subject.world_from_torso = facing_pose(0.1, 0, {0, -0.2, 0.8});
  return subject;
}

double rms_second_difference(const std::vector<float>& course) {
  double sum = 0;
  for (std::size_t i = 1; i + 1 < course.size(); ++i)
    sum += std::pow(course[i - 1] - 2 * course[i] + course[i + 1], 2);
  return std::sqrt(sum / double(course.size() - 2));
}

TEST(Drive, PersonDrivenByThemselvesIsReproduced) {
  const HeadModel& model = test_head();
  const Track track = performed(model, acted(model, {{"browDown_L", 0.3f}}));
  const DriveSubject self = self_of(track, model);
  const auto driven = drive(track, self, self, {.clamp = false});
  ASSERT_TRUE(driven.ok()) << driven.error().what;
  for (std::size_t i = 0; i < driven->size(); ++i) {
    const DrivenFrame& f = (*driven)[i];
    EXPECT_LT(
        (f.pose.articulation.expression - track.frames[i].pose.articulation.expression).cwiseAbs().maxCoeff(),
        1e-5);
    EXPECT_LT((f.pose.articulation.jaw - track.frames[i].pose.articulation.jaw).norm(), 1e-5);
    EXPECT_LT((f.pose.articulation.left_eye - track.frames[i].pose.articulation.left_eye).norm(), 1e-5);
    EXPECT_LT((f.pose.world_from_head.matrix() - track.frames[i].pose.world_from_head.matrix()).norm(), 1e-9);
  }
}

TEST(Drive, DriversRestMapsToTheAvatarsRestWhateverTheirLooks) {
  const HeadModel& model = test_head();
  Track track = performed(model, acted(model, {{"browDown_L", 0.4f}, {"mouthFrown_R", 0.2f}}));
  track.frames.resize(1);  // the first frame rests
  DriveSubject driver = self_of(performed(model, track.neutral), model), avatar = driver;
  driver.world_from_head = track.frames[0].pose.world_from_head;
  avatar.neutral = acted(model, {{"mouthSmile_L", 0.25f}, {"jawOpen", 0.1f}, {"eyeLookUp_L", 0.3f}});
  avatar.seen = {{"mouthSmile_L", 0.0f, 0.1f}, {"jawOpen", 0.2f, 0.4f}, {"eyeLookUp_L", 0.0f, 0.1f}};
  avatar.world_from_head = facing_pose(0.2, -0.1, {0, 0, 0.5});
  const auto driven = drive(track, driver, avatar, {});
  ASSERT_TRUE(driven.ok());
  const DrivenFrame& f = driven->front();
  EXPECT_EQ(f.pose.articulation.expression, avatar.neutral.expression);
  EXPECT_EQ(f.pose.articulation.jaw, avatar.neutral.jaw);
  EXPECT_EQ(f.pose.articulation.left_eye, avatar.neutral.left_eye);
  EXPECT_LT((f.pose.world_from_head.matrix() - avatar.world_from_head.matrix()).norm(), 1e-12);
  EXPECT_LT((f.pose.world_from_torso.matrix() - avatar.world_from_torso.matrix()).norm(), 1e-12);
}

TEST(Drive, GainScalesOnlyItsOwnAction) {
  const HeadModel& model = test_head();
  const Track track = performed(model, neutral_articulation(model));
  const DriveSubject self = self_of(track, model);
  const ActionBasis basis = action_basis(model);
  const int jaw = action_index(basis, "jawOpen"), smile = action_index(basis, "mouthSmile_L");
  const auto once = drive(track, self, self, {.clamp = false});
  const auto twice = drive(track, self, self, {.gains = {{"jawOpen", 2.0f}}, .clamp = false});
  ASSERT_TRUE(once.ok() && twice.ok());
  for (std::size_t i = 0; i < once->size(); ++i) {
    const Eigen::VectorXf a = face_amounts(basis, (*once)[i].pose.articulation),
                          b = face_amounts(basis, (*twice)[i].pose.articulation);
    EXPECT_NEAR(b[jaw], 2 * a[jaw], 0.01);  // for a motion over 40 frames; quicker ones gain less
    EXPECT_NEAR(b[smile], a[smile], 1e-3);
  }
}

TEST(Drive, ExpressionsNeverSeenAreLimitedUnlessRequested) {
  const HeadModel& model = test_head();
  const Track track = performed(model, neutral_articulation(model));
  const DriveSubject driver = self_of(track, model);
  DriveSubject avatar = driver;
  avatar.seen = {{"jawOpen", 0.0f, 0.2f}, {"mouthSmile_L", -0.1f, 1.0f}};
  const ActionBasis basis = action_basis(model);
  const int jaw = action_index(basis, "jawOpen"), smile = action_index(basis, "mouthSmile_L");
  float most = 0, max_free = 0, max_smile = 0;
  const auto held = drive(track, driver, avatar, {.calibrate_gains = false});
  const auto free = drive(track, driver, avatar, {.calibrate_gains = false, .clamp = false});
  ASSERT_TRUE(held.ok() && free.ok());
  for (std::size_t i = 0; i < held->size(); ++i) {
    most = std::max(most, face_amounts(basis, (*held)[i].pose.articulation)[jaw]);
    max_smile = std::max(max_smile, face_amounts(basis, (*held)[i].pose.articulation)[smile]);
    max_free = std::max(max_free, face_amounts(basis, (*free)[i].pose.articulation)[jaw]);
  }
  EXPECT_LE(most, 0.2f + 0.05f + 1e-3f);
  EXPECT_GT(most, 0.2f);
  EXPECT_NEAR(max_free, 0.6, 1e-2);
  EXPECT_NEAR(max_smile, 0.7, 1e-2) << "what was seen is not touched";
}

TEST(Drive, AnotherHeadModelShowsTheSameActions) {
  if (!std::filesystem::exists(ict_path())) GTEST_SKIP() << "needs " << ict_path().string();
  const HeadModel& built_in = test_head();
  const auto ict = load_head_model(ict_path());
  ASSERT_TRUE(ict.ok()) << ict.error().what;
  const Track track = performed(*ict, acted(*ict, {{"browDown_L", 0.3f}}));
  const DriveSubject driver = self_of(track, *ict);
  DriveSubject avatar;
  avatar.model = &built_in;
  avatar.person.identity = Eigen::VectorXf::Zero(built_in.identity_count());
  avatar.neutral = acted(built_in, {{"mouthPucker", 0.1f}});
  const auto driven = drive(track, driver, avatar, {});
  ASSERT_TRUE(driven.ok()) << driven.error().what;
  const ActionBasis from = action_basis(*ict), to = action_basis(built_in);
  const Eigen::VectorXf from_rest = face_amounts(from, driver.neutral),
                        to_rest = face_amounts(to, avatar.neutral);
  for (std::size_t i = 0; i < driven->size(); i += 7) {
    const Eigen::VectorXf a = face_amounts(from, track.frames[i].pose.articulation) - from_rest,
                          b = face_amounts(to, (*driven)[i].pose.articulation) - to_rest;
    for (const char* name : {"jawOpen", "mouthSmile_L", "mouthSmile_R", "browInnerUp_L", "eyeBlink_L"})
      EXPECT_NEAR(b[action_index(to, name)], a[action_index(from, name)], 0.03) << name;
  }
}

TEST(Drive, JitterIsNotAmplifiedAndSmoothingReducesIt) {
  const HeadModel& model = test_head();
  const Track track = performed(model, neutral_articulation(model), 0.03);
  const DriveSubject driver = self_of(track, model);
  DriveSubject avatar = driver;
  avatar.neutral = acted(model, {{"mouthFrown_L", 0.2f}});
  const ActionBasis basis = action_basis(model);
  const auto plain = drive(track, driver, avatar, {.calibrate_gains = false});
  const auto smooth = drive(track, driver, avatar, {.calibrate_gains = false, .smooth = true});
  ASSERT_TRUE(plain.ok() && smooth.ok());
  for (const char* name : {"jawOpen", "mouthSmile_L", "browInnerUp_L", "mouthPucker"}) {
    const int a = action_index(basis, name);
    std::vector<float> before, after, smoothed;
    for (std::size_t i = 0; i < plain->size(); ++i) {
      before.push_back(face_amounts(basis, track.frames[i].pose.articulation)[a]);
      after.push_back(face_amounts(basis, (*plain)[i].pose.articulation)[a]);
      smoothed.push_back(face_amounts(basis, (*smooth)[i].pose.articulation)[a]);
    }
    EXPECT_LE(rms_second_difference(after), 1.01 * rms_second_difference(before)) << name;
    EXPECT_LT(rms_second_difference(smoothed), 0.7 * rms_second_difference(before)) << name;
  }
}

TEST(Drive, GainAmplifiesTheMotionButNotItsJitter) {
  const HeadModel& model = test_head();
  const Track track = performed(model, neutral_articulation(model), 0.03),
              still = performed(model, neutral_articulation(model));
  const DriveSubject self = self_of(track, model);
  const ActionBasis basis = action_basis(model);
  for (const char* name : {"jawOpen", "mouthSmile_L"}) {
    const int a = action_index(basis, name);
    const auto gained = drive(track, self, self, {.gains = {{name, 1.5f}}, .clamp = false});
    ASSERT_TRUE(gained.ok());
    std::vector<float> before, after;
    double with = 0, of = 0;
    for (std::size_t i = 0; i < gained->size(); ++i) {
      before.push_back(face_amounts(basis, track.frames[i].pose.articulation)[a]);
      after.push_back(face_amounts(basis, (*gained)[i].pose.articulation)[a]);
      const double truth = face_amounts(basis, still.frames[i].pose.articulation)[a];
      with += truth * after.back(), of += truth * truth;
    }
    EXPECT_NEAR(with / of, 1.5, 0.05) << name;
    EXPECT_LT(rms_second_difference(after), 1.1 * rms_second_difference(before)) << name;
  }
}

TEST(Drive, HeadTurnsLeaveTheShouldersStillAndLeaningIsDamped) {
  const HeadModel& model = test_head();
  Track track = performed(model, neutral_articulation(model));
  const Vec3d neck = shape_head(model, track.person).joints[kNeck].cast<double>();
  const DriveSubject self = self_of(track, model);
  for (std::size_t i = 0; i < track.frames.size(); ++i) {  // about the neck alone
    Pose turn = Pose::Identity();
    turn.linear() = rotation_about(Vec3d::UnitY(), 0.5 * std::sin(i / 6.0));
    turn.translation() = neck - turn.linear() * neck;
    track.frames[i].pose.world_from_head = self.world_from_head * turn;
  }
  const auto turned = drive(track, self, self, {});
  ASSERT_TRUE(turned.ok());
  for (const DrivenFrame& f : *turned)
    EXPECT_LT((f.pose.world_from_torso.translation() - self.world_from_torso.translation()).norm(), 1e-9);

  for (std::size_t i = 0; i < track.frames.size(); ++i)  // a step of 1 cm
    track.frames[i].pose.world_from_head =
        self.world_from_head * Pose(Eigen::Translation3d(i < 40 ? 0 : 0.01, 0, 0));
  const auto leaned = drive(track, self, self, {});
  const auto moved = [&](std::size_t i) {
    return ((*leaned)[i].pose.world_from_torso.translation() - self.world_from_torso.translation()).norm();
  };
  EXPECT_LT(moved(39), 1e-9);
  EXPECT_LT(moved(41), 0.0004);
  EXPECT_NEAR(moved(119), 0.0011, 0.0003);
  for (std::size_t i = 41; i < 119; ++i) EXPECT_GE(moved(i + 1), moved(i) - 1e-9) << "overshoot";
}

// As with a hand-held camera that wanders off.
TEST(Drive, DriftingDriverLeavesTheAvatarInThePicture) {
  const HeadModel& model = test_head();
  Track track = performed(model, neutral_articulation(model));
  const DriveSubject self = self_of(track, model);
  for (const Vec3d& way : {Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(-0.6, 0.8, 0), Vec3d(0, -1, 0)}) {
    for (std::size_t i = 0; i < track.frames.size(); ++i)
      track.frames[i].pose.world_from_head =
          self.world_from_head * Pose(Eigen::Translation3d(0.005 * double(i) * way));
    const auto driven = drive(track, self, self, {});
    ASSERT_TRUE(driven.ok());
    const Mat3d head_from_world = self.world_from_head.linear().transpose();
    double before = 0;
    for (std::size_t i = 0; i < driven->size(); ++i) {
      const DrivenFrame& f = (*driven)[i];
      const Vec3d moved =
          head_from_world * (f.pose.world_from_head.translation() - self.world_from_head.translation());
      const Vec3d body =
          head_from_world * (f.pose.world_from_torso.translation() - self.world_from_torso.translation());
      if (i <= 3) {
        EXPECT_NEAR((moved - 0.005 * double(i) * way).norm(), 0, 1e-9) << i;
      }
      EXPECT_LT(moved.norm(), 0.0901);
      EXPECT_LT(moved.y(), 0.0346);
      EXPECT_LT(body.y(), 0.0076);
      EXPECT_GE(moved.dot(way), before - 1e-9) << "turns back";
      before = moved.dot(way);
    }
    EXPECT_GT(before, 0.025);
  }
}

TEST(Drive, LostFramesAreBridged) {
  const HeadModel& model = test_head();
  const Track whole = performed(model, neutral_articulation(model));
  Track holed = whole;
  for (std::size_t i : {50u, 51u, 52u, 119u}) {
    holed.frames[i].status = FrameStatus::lost;
    holed.frames[i].pose.articulation.expression.setConstant(5);
    holed.frames[i].pose.world_from_head.translation().setConstant(9);
  }
  const DriveSubject self = self_of(whole, model);
  const auto a = drive(whole, self, self, {}), b = drive(holed, self, self, {});
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_TRUE((*b)[51].bridged);
  EXPECT_FALSE((*b)[53].bridged);
  for (std::size_t i : {50u, 51u, 52u, 119u}) {
    EXPECT_LT(
        ((*a)[i].pose.articulation.expression - (*b)[i].pose.articulation.expression).cwiseAbs().maxCoeff(),
        0.1);
    EXPECT_LT(((*a)[i].pose.world_from_head.matrix() - (*b)[i].pose.world_from_head.matrix()).norm(), 0.15);
  }
}

// Frames 50 to 59 of the film dissolve into frame 60, where the driver is elsewhere in the performance.
TEST(Drive, NothingIsBridgedOrSmoothedAcrossACut) {
  const HeadModel& model = test_head();
  const Track whole = performed(model, neutral_articulation(model));
  Track cut = whole;
  cut.shots = {{0, 49}, {60, 109}, {110, 119}};
  for (std::size_t i = 60; i < 110; ++i) cut.frames[i].pose = whole.frames[i - 45].pose;
  for (const auto& [from, to] : {std::pair{50u, 60u}, {110u, 120u}})
    for (std::size_t i = from; i < to; ++i) cut.frames[i].status = FrameStatus::lost;
  Track first = cut, second = cut;
  first.shots = {}, first.frames.resize(60);
  second.shots = {}, second.frames.erase(second.frames.begin(), second.frames.begin() + 60);
  const DriveSubject self = self_of(whole, model);
  for (const bool smooth : {false, true}) {
    const DriveOptions options{.smooth = smooth};
    const auto both = drive(cut, self, self, options), a = drive(first, self, self, options),
               b = drive(second, self, self, options);
    ASSERT_TRUE(both.ok() && a.ok() && b.ok());
    ASSERT_EQ(both->size(), cut.frames.size());
    for (std::size_t i = 0; i < both->size(); ++i) {
      const DrivenFrame& own = i < 60 ? (*a)[i] : (*b)[i - 60];
      EXPECT_EQ((*both)[i].frame, own.frame);
      EXPECT_EQ((*both)[i].pose.articulation.expression, own.pose.articulation.expression) << i;
      EXPECT_EQ((*both)[i].pose.world_from_head.matrix(), own.pose.world_from_head.matrix()) << i;
    }
  }
}

// A phone drops the frames of five seconds, in which the driver went elsewhere in the performance.
TEST(Drive, NothingIsSmoothedAcrossAPause) {
  const HeadModel& model = test_head();
  const Track whole = performed(model, neutral_articulation(model));
  Track jumps = whole;
  for (std::size_t i = 60; i < jumps.frames.size(); ++i) jumps.frames[i].pose = whole.frames[i - 45].pose;
  Track pauses = jumps, first = jumps;
  for (std::size_t i = 60; i < pauses.frames.size(); ++i) pauses.frames[i].time_s += 5;
  first.frames.resize(60);
  const DriveSubject self = self_of(whole, model);
  const DriveOptions options{.gains = {{"mouthSmile_L", 1.5f}}, .clamp = false};
  const auto jumped = drive(jumps, self, self, options), paused = drive(pauses, self, self, options),
             alone = drive(first, self, self, options);
  ASSERT_TRUE(jumped.ok() && paused.ok() && alone.ok());
  const auto face = [](const std::vector<DrivenFrame>& frames, std::size_t i) {
    return frames[i].pose.articulation.expression;
  };
  for (std::size_t i = 0; i < 60; ++i) EXPECT_EQ(face(*paused, i), face(*alone, i)) << i;
  EXPECT_NE(face(*jumped, 59), face(*alone, 59));
}

TEST(Drive, RefusesWhatCannotBeDrivenWithAReason) {
  const HeadModel& model = test_head();
  Track track = performed(model, neutral_articulation(model));
  const DriveSubject self = self_of(track, model);
  const auto unknown = drive(track, self, self, {.gains = {{"wiggleEars", 2.0f}}});
  ASSERT_FALSE(unknown.ok());
  EXPECT_NE(unknown.error().what.find("wiggleEars"), std::string::npos);
  for (TrackedFrame& frame : track.frames) frame.status = FrameStatus::lost;
  EXPECT_EQ(drive(track, self, self, {}).error().code, ErrorCode::no_face);
  track.head_model_hash = "another";
  EXPECT_EQ(drive(track, self, self, {}).error().code, ErrorCode::bad_input);
}

TEST(DriveStream, FrameByFrameMatchesTheSmoothedClip) {
  const HeadModel& model = test_head();
  const Track track = performed(model, neutral_articulation(model));
  const DriveSubject self = self_of(track, model);
  const auto clip = drive(track, self, self, {.smooth = true});
  const auto stream = DriveStream::create(self, self, {});
  ASSERT_TRUE(clip.ok() && stream.ok());
  for (std::size_t i = 0; i < track.frames.size(); ++i) {
    const DrivenFrame frame = (*stream)->next(track.frames[i]);
    EXPECT_EQ(frame.frame, int(i));
    EXPECT_LT((frame.pose.world_from_head.matrix() - (*clip)[i].pose.world_from_head.matrix()).norm(), 1e-9)
        << i;
    EXPECT_LT(
        (frame.pose.articulation.expression - (*clip)[i].pose.articulation.expression).cwiseAbs().maxCoeff(),
        1e-4)
        << i;
  }
}

TEST(DriveStream, LostFrameHoldsThePreviousOneAndGainsMayChange) {
  const HeadModel& model = test_head();
  const Track track = performed(model, neutral_articulation(model));
  const DriveSubject self = self_of(track, model);
  const auto stream = DriveStream::create(self, self, {.clamp = false});
  ASSERT_TRUE(stream.ok());
  TrackedFrame lost = track.frames[20];
  lost.status = FrameStatus::lost, lost.time_s = 0;
  const DrivenFrame none = (*stream)->next(lost);
  EXPECT_TRUE(none.bridged);
  EXPECT_EQ(none.pose.articulation.expression, self.neutral.expression);
  for (int i = 0; i < 20; ++i) (*stream)->next(track.frames[std::size_t(i)]);
  TrackedFrame open = track.frames[19];
  open.time_s = 0.8;
  const DrivenFrame before = (*stream)->next(open);
  lost.time_s = 0.84;
  const DrivenFrame held = (*stream)->next(lost);
  EXPECT_TRUE(held.bridged);
  EXPECT_EQ(held.pose.articulation.jaw, before.pose.articulation.jaw);
  EXPECT_FALSE((*stream)->set_gains({{"grin", 2.0f}}).ok());
  ASSERT_TRUE((*stream)->set_gains({{"jawOpen", 2.0f}}).ok());
  open.time_s = 0.88;
  EXPECT_GT((*stream)->next(open).pose.articulation.jaw.norm(), 1.7f * before.pose.articulation.jaw.norm());
}

}  // namespace
}  // namespace likeness
