// Claims about the choice of parts: good captures get every part, each rule switches at its threshold, the
// user's choice wins and is reported as theirs, and the measures are those put in.
#include "core/train/choose_parts.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/train/condition_map.h"
#include "core/train/exposure.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

// Measures of a usual clip: head and shoulders of a speaking person before a resting camera.
CaptureMeasures usual() {
  return {.size = 256,
          .frames = 300,
          .torso_followed = true,
          .torso_share = 0.25,
          .has_plate = true,
          .plate_share = 1,
          .yaw = 0.8,
          .pitch = 0.3,
          .turn = 0.3,
          .face_motion = 0.002,
          .gaze_pitch = 0.05,
          .gaze_yaw = 0.08,
          .light_drift = 0.01};
}

const AvatarPart& part(const ChosenParts& chosen, const char* name) {
  const auto found = std::ranges::find(chosen.parts, name, &AvatarPart::name);
  EXPECT_NE(found, chosen.parts.end()) << name;
  return *found;
}

TEST(ChooseParts, AUsualCaptureHasEveryPartOfADefaultTraining) {
  const ChosenParts chosen = choose_parts(usual(), {});
  const TrainOptions options;
  EXPECT_EQ(chosen.mode, options.fields.mode);
  EXPECT_EQ(chosen.sizes, options.fields.sizes);
  EXPECT_EQ(chosen.latent, options.fields.use_latent);
  EXPECT_EQ(chosen.gaze, options.fields.use_gaze);
  EXPECT_EQ(chosen.still, options.fields.use_still);
  EXPECT_TRUE(chosen.torso);
  EXPECT_TRUE(chosen.plate);
}

TEST(ChooseParts, AFaceThatOnlyTheTrackMovesIsStatic) {
  CaptureMeasures m = usual();
  m.face_motion = kStillFace;
  EXPECT_EQ(choose_parts(m, {}).mode, kDefaultMode);
  m.face_motion = std::nextafter(kStillFace, 0.0);
  const ChosenParts still = choose_parts(m, {});
  EXPECT_EQ(still.mode, FieldMode::static_);
  EXPECT_FALSE(part(still, "expression").on);
  EXPECT_FALSE(part(still, "deformation").on);
  EXPECT_FALSE(still.gaze);  // it would be an input of the field
  EXPECT_FALSE(part(still, "gaze").on);
}

TEST(ChooseParts, WithoutATorsoInThePictureThereIsNoTorsoField) {
  CaptureMeasures m = usual();
  m.torso_share = kTorsoShare;
  EXPECT_TRUE(choose_parts(m, {}).torso);
  m.torso_share = std::nextafter(kTorsoShare, 0.0);
  EXPECT_FALSE(choose_parts(m, {}).torso);
  EXPECT_FALSE(part(choose_parts(m, {}), "torso").on);
  m.torso_share = 0.4;
  m.torso_followed = false;  // what the track does not follow cannot be learnt
  EXPECT_FALSE(choose_parts(m, {}).torso);
}

TEST(ChooseParts, MovingCameraGetsARoomAndNoPlate) {
  CaptureMeasures m = usual();
  m.has_plate = false, m.plate_share = 0, m.light_drift.reset();
  EXPECT_FALSE(choose_parts(m, {}).plate);
  EXPECT_FALSE(part(choose_parts(m, {}), "background").on);
  m.has_room = true;
  EXPECT_FALSE(choose_parts(m, {}).plate);
  EXPECT_TRUE(part(choose_parts(m, {}), "background").on);
  m.has_plate = true, m.plate_share = 0.4;  // and comes to rest
  EXPECT_TRUE(choose_parts(m, {}).plate);
  EXPECT_NE(part(choose_parts(m, {}), "background").reason.find("40 %"), std::string::npos);
}

TEST(ChooseParts, ABackgroundThatWasNotLearntSaysSo) {
  CaptureMeasures m = usual();
  m.background_fault = "The background was not learnt.";
  EXPECT_TRUE(choose_parts(m, {}).plate);  // it is still the best there is
  EXPECT_NE(part(choose_parts(m, {}), "background").reason.find(m.background_fault), std::string::npos);
  m.has_plate = false, m.plate_share = 0, m.light_drift.reset();  // of a room, which is not kept
  EXPECT_FALSE(part(choose_parts(m, {}), "background").on);
  EXPECT_EQ(part(choose_parts(m, {}), "background").reason, m.background_fault);
}

TEST(ChooseParts, EyesThatDoNotTurnAreNotAnInput) {
  CaptureMeasures m = usual();
  m.gaze_yaw = std::nextafter(kSmallestGaze, 0.0), m.gaze_pitch = kSmallestGaze;
  EXPECT_TRUE(choose_parts(m, {}).gaze);
  m.gaze_pitch = m.gaze_yaw;
  EXPECT_FALSE(choose_parts(m, {}).gaze);
}

TEST(ChooseParts, HairMayFollowTheExpressionOnAHeadThatHardlyTurns) {
  CaptureMeasures m = usual();
  m.turn = kHardlyTurns;
  EXPECT_TRUE(choose_parts(m, {}).still);
  EXPECT_TRUE(part(choose_parts(m, {}), "still").on);
  m.turn = std::nextafter(kHardlyTurns, 0.0);
  EXPECT_FALSE(choose_parts(m, {}).still);
  EXPECT_FALSE(part(choose_parts(m, {}), "still").on);
  TrainingSet set = ball_set(4, 32);
  TrainOptions options;
  apply_parts(choose_parts(m, {}), set, options);
  EXPECT_FALSE(options.fields.use_still);
}

TEST(ChooseParts, UsersModeWinsAndIsReportedAsTheirs) {
  CaptureMeasures m = usual();
  for (const FieldMode mode : kFieldModes) {
    const ChosenParts chosen = choose_parts(m, {.mode = mode});
    EXPECT_EQ(chosen.mode, mode);
    EXPECT_TRUE(part(chosen, "expression").asked);
    EXPECT_EQ(part(chosen, "expression").on, mode_parts(mode).expression);
    EXPECT_EQ(part(chosen, "deformation").on, mode_parts(mode).warp);
    EXPECT_NE(part(chosen, "expression").reason.find(mode_name(mode)), std::string::npos);
  }
  m.face_motion = 0;
  EXPECT_EQ(choose_parts(m, {.mode = kDefaultMode}).mode, kDefaultMode);
  EXPECT_FALSE(part(choose_parts(m, {}), "expression").asked);
}

TEST(ChooseParts, UsersOtherChoicesAreKeptAndReported) {
  const ChosenParts chosen = choose_parts(
      usual(), {.no_latent = true, .no_occupancy = true, .refine_track = true, .landmark_weight = 0.1});
  EXPECT_FALSE(chosen.latent);
  for (const char* name : {"code", "occupancy", "refine_track", "landmark_loss"})
    EXPECT_TRUE(part(chosen, name).asked) << name;
  EXPECT_FALSE(part(chosen, "code").on);
  EXPECT_TRUE(part(chosen, "landmark_loss").on);
  // What was not requested is not listed.
  EXPECT_EQ(std::ranges::count(choose_parts(usual(), {}).parts, "occupancy", &AvatarPart::name), 0);
}

TEST(ChooseParts, EveryPartHasATitleAValueAndAReasonThatEndsLikeASentence) {
  CaptureMeasures m = usual();
  m.further_frames = 40;
  for (const bool little : {false, true}) {
    if (little) m = {.frames = 20, .torso_followed = false};
    for (const AvatarPart& p :
         choose_parts(m, {.no_occupancy = true, .refine_track = true, .landmark_weight = 1}).parts) {
      EXPECT_NE(part_title(p.name), p.name);
      EXPECT_FALSE(p.value.empty());
      EXPECT_TRUE(p.reason.ends_with('.') && std::isupper(static_cast<unsigned char>(p.reason[0])))
          << p.reason;
    }
  }
  EXPECT_EQ(part_title("nothing of the kind"), "nothing of the kind");
}

TEST(ApplyParts, TrainingUsesTheChosenParts) {
  TrainingSet set = ball_set(4, 32);
  set.has_torso = true;
  TrainOptions options;
  options.losses.landmark_weight = 0.1, options.rays.use_occupancy = false;
  ChosenParts parts;
  parts.mode = FieldMode::hyper, parts.latent = parts.gaze = false, parts.sizes.code_length = 2;
  apply_parts(parts, set, options);
  EXPECT_TRUE(set.has_torso);
  EXPECT_FALSE(set.plate.empty());
  EXPECT_TRUE(set.views[0].has_plate);
  EXPECT_EQ(options.fields.mode, FieldMode::hyper);
  EXPECT_FALSE(options.fields.use_latent);
  EXPECT_FALSE(options.fields.use_gaze);
  EXPECT_EQ(options.fields.sizes.code_length, 2);
  EXPECT_EQ(options.losses.landmark_weight, 0.1);  // the user's alone
  EXPECT_FALSE(options.rays.use_occupancy);
  parts.torso = parts.plate = false;
  set.views[3].further_clip = 2;  // has its own
  apply_parts(parts, set, options);
  EXPECT_FALSE(set.has_torso);
  EXPECT_TRUE(set.plate.empty());
  EXPECT_FALSE(set.views[0].has_plate);
  EXPECT_TRUE(set.views[3].has_plate);
}

TEST(ApplyParts, AvatarHasTheChosenSizes) {
  TrainingSet set = ball_set(6, 32);
  TrainOptions options;
  options.schedule.steps = 2, options.rays.per_step = 256;
  ChosenParts parts;
  parts.sizes = {.head_log2_entries = 12, .head_finest = 64, .code_length = 2};
  apply_parts(parts, set, options);
  const auto avatar = train_avatar(set, options, {}, Progress(), {}, {});
  ASSERT_TRUE(avatar.ok()) << avatar.error().what;
  const FieldConfig& config = avatar->head.field.config;
  EXPECT_EQ(config.position.log2_entries, 12);
  EXPECT_EQ(config.position.max_resolution, 64);
  EXPECT_EQ(config.latent_count, 2);
  options.fields.sizes.code_length = 0;
  const auto none = train_avatar(set, options, {}, Progress(), {}, {});
  ASSERT_FALSE(none.ok());
  EXPECT_NE(none.error().what.find("codes of 0"), std::string::npos);
}

TEST(MeasureCapture, FindsWhatTheViewsShow) {
  TrainingSet set = ball_set(40, 32);
  const CaptureMeasures m = measure_capture(set, shape_head(set.model, set.person));
  EXPECT_EQ(m.frames, 40);
  EXPECT_EQ(m.further_frames, 0);
  EXPECT_EQ(m.size, 32);
  EXPECT_FALSE(m.torso_followed);
  EXPECT_TRUE(m.has_plate);
  EXPECT_DOUBLE_EQ(m.plate_share, 1);
  EXPECT_NEAR(m.yaw, 1.0, 0.1);  // the ball turns by half a radian to either side
  EXPECT_LT(m.pitch, 0.1);
  EXPECT_NEAR(m.turn, 0.5 / std::sqrt(2.0), 0.03);
  ASSERT_TRUE(m.light_drift.has_value());
  EXPECT_LT(*m.light_drift, 1e-3);
  EXPECT_GT(m.face_motion, kStillFace);
  EXPECT_EQ(m.gaze_yaw, 0);
}

TEST(MeasureCapture, FlickeringLampCountsAsDriftingLight) {
  TrainingSet set = ball_set(40, 32);
  // Every second picture has a tenth less light.
  for (std::size_t v = 0; v < set.views.size(); v += 2)
    set.views[v].rgb = exposed(set.views[v].rgb, Vec3f::Constant(0.9f));
  const CaptureMeasures m = measure_capture(set, shape_head(set.model, set.person));
  ASSERT_TRUE(m.light_drift.has_value());
  EXPECT_NEAR(*m.light_drift, 0.5 * std::log(1 / 0.9), 0.003);
}

TEST(ChooseParts, WanderingLightIsEvenedOutAndSaidSo) {
  CaptureMeasures m = usual();
  m.exposures.assign(std::size_t(m.frames), Vec3f::Constant(1.1f));
  EXPECT_TRUE(choose_parts(m, {}).exposures.empty());
  m.light_drift = 2 * kEvenLight;
  const ChosenParts chosen = choose_parts(m, {});
  EXPECT_EQ(chosen.exposures.size(), m.exposures.size());
  EXPECT_TRUE(part(chosen, "light").on);
  Avatar avatar;
  EXPECT_FALSE(is_evenly_lit(avatar));
  avatar.parts = chosen.parts;
  EXPECT_TRUE(is_evenly_lit(avatar));
  m.has_plate = false;
  EXPECT_TRUE(choose_parts(m, {}).exposures.empty());
}

TEST(MeasureCapture, TheTorsoIsWhatLiesBelowTheNeck) {
  TrainingSet set = ball_set(8, 32);
  set.has_torso = true;
  const HeadShape shape = shape_head(set.model, set.person);
  const double ball_alone = measure_capture(set, shape).torso_share;
  // A body that fills the lower third of every picture.
  Image8 alpha(32, 32, 1);
  for (int y = 21; y < 32; ++y)
    for (int x = 0; x < 32; ++x) alpha.at(x, y)[0] = 255;
  for (TrainingView& view : set.views) view.alpha = TiledMask(alpha);
  const double body = measure_capture(set, shape).torso_share;
  EXPECT_LT(ball_alone, 0.05);
  EXPECT_NEAR(body, 11.0 / 32, 0.1);
  for (TrainingView& view : set.views) view.alpha = {};
  EXPECT_EQ(measure_capture(set, shape).torso_share, 0);  // not known
}

TEST(MeasureCapture, ShouldersBesideTheFaceAreTorso) {
  TrainingSet set = ball_set(8, 64);
  set.has_torso = true;
  const HeadShape shape = shape_head(set.model, set.person);
  const double chin =
      landmark_positions(set.model, pose_head(set.model, shape, neutral_articulation(set.model)))[8].y();
  const double base = neck_base(set.model, shape);
  // The person from the chin to the base of the neck: at the sides only, or in the middle only.
  const auto share = [&](bool sides) {
    for (TrainingView& view : set.views) {
      const Pose cam_from_torso = view.camera.cam_from_world * view.pose.world_from_torso;
      Image8 alpha(64, 64, 1);
      for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) {
          const Vec3d ray = ray_direction(view.camera.intrinsics, Vec2d(x + 0.5, y + 0.5));
          const Vec3d at = inverse(cam_from_torso) * (ray * cam_from_torso.translation().z());
          const bool side = std::abs(at.x()) > 0.12, middle = std::abs(at.x()) < 0.08;
          if (at.y() < chin - 0.005 && at.y() > base + 0.005 && (sides ? side : middle))
            alpha.at(x, y)[0] = 255;
        }
      view.alpha = TiledMask(alpha);
    }
    return measure_capture(set, shape).torso_share;
  };
  EXPECT_GT(share(true), 0.01);
  EXPECT_EQ(share(false), 0);
}

TEST(ArticulationSpread, IsTheMotionOfTheFaceInMetres) {
  const HeadModel model = ball_head();
  const HeadShape shape = shape_head(model, PersonShape{});
  std::vector<Articulation> list(2);
  for (Articulation& a : list) a.expression = Eigen::VectorXf::Zero(2);
  EXPECT_EQ(articulation_spread(model, shape, list).face, 0);
  // Half a unit either way of the mean, on the vertices that the expression moves.
  list[1].expression[0] = 1;
  double squares = 0;
  for (int v = 0; v < model.vertex_count(); ++v)
    squares += model.expression_basis.block<3, 1>(3 * v, 0).squaredNorm() / double(model.vertex_count());
  EXPECT_NEAR(articulation_spread(model, shape, list).face, 0.5 * std::sqrt(squares), 1e-6);
  list[1].left_eye.y() = list[1].right_eye.y() = 0.4f;
  EXPECT_NEAR(articulation_spread(model, shape, list).gaze_yaw, 0.2, 1e-6);
  EXPECT_EQ(articulation_spread(model, shape, list).gaze_pitch, 0);
}

}  // namespace
}  // namespace likeness
