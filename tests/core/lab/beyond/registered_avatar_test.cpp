// Claims about posing an avatar by the truth: whatever frame, size and lens a track was made in, the avatar's
// face lies where the true one is seen.
#include "core/lab/beyond/registered_avatar.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/scene/head_regions.h"
#include "tests/core/lab/truth/acted_track.h"

namespace likeness {
namespace {

constexpr double kRadian = std::numbers::pi / 180;
constexpr int kFrames = 40, kHeldOut = 36;  // the first of those that are

Pose moved_by(const Mat3d& turn, const Vec3d& shift) {
  Pose pose = Pose::Identity();
  pose.linear() = turn, pose.translation() = shift;
  return pose;
}

// How a track's head, lens and metre differ from the true ones: nobody can tell them from pictures.
struct Differing {
  double scale = 1.15;  // true metres / the track's
  double lens = 1.05;   // the track's focal length / the true one: all is as much farther away
  Mat3d turn = rotation_about(Vec3d(1, 2, -1).normalized(), 9 * kRadian);  // true_head_from_head
  Vec3d place = Vec3d(0.012, -0.02, 0.03);                                 // m, of the track's head frame
  Pose torso = moved_by(rotation_about(Vec3d::UnitY(), 6 * kRadian),
                        Vec3d(0.02, -0.05, 0.01));  // true_torso_from_torso, true metres
};

std::vector<int> face_vertices_of(const HeadModel& model) {
  const HeadRegions regions = head_regions(model);
  std::vector<std::uint8_t> skin(regions.face.size());
  for (std::size_t f = 0; f < skin.size(); ++f) skin[f] = regions.face[f] && regions.skin[f];
  return region_vertices(model, skin);
}

// The truth, and a track of the same performance as it would be with these differences.
struct TrackedDemo {
  TrackTruth truth = acted_truth(kFrames);
  std::vector<Vec3f> true_vertices = shape_head(truth.model, truth.track.person).vertices;
  Track track;
  CameraSet cameras;
  Capture capture;
  Avatar avatar;

  explicit TrackedDemo(const Differing& d) {
    for (std::size_t i = 0; i < truth.track.frames.size(); ++i) {
      AvatarPose& pose = truth.track.frames[i].pose;
      pose.world_from_torso = pose.world_from_head;
      pose.world_from_torso.linear() =
          pose.world_from_head.linear() * rotation_about(Vec3d::UnitZ(), 0.05 * std::sin(0.3 * double(i)));
    }
    track = truth.track;
    const std::vector<Vec3f> own = own_vertices(d);
    track.person.offsets.resize(own.size());
    for (std::size_t v = 0; v < own.size(); ++v) track.person.offsets[v] = own[v] - truth.model.vertices[v];
    const Vec3d middle = middle_of_face();
    for (std::size_t i = 0; i < track.frames.size(); ++i) {
      const AvatarPose& known = truth.track.frames[i].pose;
      AvatarPose& pose = track.frames[i].pose;
      // The longer lens shows it in the same place.
      const Vec3d beyond(0, 0, (d.lens - 1) * (known.world_from_head * middle).z());
      pose.world_from_head.linear() = known.world_from_head.linear() * d.turn;
      pose.world_from_head.translation() =
          (known.world_from_head.translation() + beyond) / d.scale - pose.world_from_head.linear() * d.place;
      pose.world_from_torso = known.world_from_torso * d.torso;
      pose.world_from_torso.translation() = (pose.world_from_torso.translation() + beyond) / d.scale;
    }
    cameras = truth.cameras;
    cameras.cameras[0].intrinsics.fx *= d.lens, cameras.cameras[0].intrinsics.fy *= d.lens;
    capture.crop = {60, 40, 400}, capture.size = 200;
    for (int i = 0; i < kFrames; ++i)
      capture.frames.push_back({.frame = i, .held_out = i >= kHeldOut, .used = i < kHeldOut});
  }

  std::vector<Vec3f> own_vertices(const Differing& d) const {
    std::vector<Vec3f> own;
    for (const Vec3f& v : true_vertices)
      own.push_back((d.turn.transpose() * v.cast<double>() / d.scale + d.place).cast<float>());
    return own;
  }
  Vec3d middle_of_face() const {
    const std::vector<int> face = face_vertices_of(truth.model);
    Vec3d sum = Vec3d::Zero();
    for (const int v : face) sum += true_vertices[std::size_t(v)].cast<double>() / double(face.size());
    return sum;
  }
  Result<Registration> registered() const {
    return register_to_truth(capture, cameras, track, truth.model, truth);
  }
  // The true face at rest, looking at the camera, which is moved round it.
  Shot shot_from(double yaw_deg) const {
    Shot shot;
    shot.camera = truth.cameras.cameras[0];
    shot.world_from_head.linear() = Vec3d(1, -1, -1).asDiagonal();
    shot.world_from_head.translation() = Vec3d(0.01, -0.02, 0.62);
    const Vec3d centre = shot.world_from_head.translation();
    const Mat3d round = rotation_about(-Vec3d::UnitY(), yaw_deg * kRadian);
    shot.camera.cam_from_world = inverse(moved_by(round, centre - round * centre));
    shot.articulation = neutral_articulation(truth.model);
    return shot;
  }
  // How far the avatar's face is from where the true one is seen, px of the project's pictures: these
  // vertices' furthest.
  double furthest_px(const Registration& r, const Shot& shot, const std::vector<int>& vertices) const {
    const SquareCrop& c = capture.crop;
    const Intrinsics seen = crop_intrinsics(shot.camera.intrinsics, c.x, c.y, c.side, capture.size);
    const PosedShot posed = pose_as(r, avatar, shot);
    const std::vector<Vec3f> own = shape_head(truth.model, track.person).vertices;
    double furthest = 0;
    for (const int v : vertices) {
      const Vec3d known =
          shot.camera.cam_from_world * shot.world_from_head * true_vertices[std::size_t(v)].cast<double>();
      const Vec3d shown =
          posed.camera.cam_from_world * posed.pose.world_from_head * own[std::size_t(v)].cast<double>();
      furthest = std::max(
          furthest, (project<double>(posed.camera.intrinsics, shown) - project<double>(seen, known)).norm());
    }
    return furthest;
  }
};

TEST(RegisterToTruth, FindsSizeTurnAndDistanceThatWerePutIn) {
  const Differing d;
  const TrackedDemo demo(d);
  const auto r = demo.registered();
  ASSERT_TRUE(r.ok()) << r.error().what;
  EXPECT_NEAR(r->scale, d.scale, 1e-4);
  EXPECT_NEAR(r->lens, d.lens, 1e-9);
  EXPECT_NEAR(r->farther, 1, 1e-4);
  EXPECT_LT(rotation_angle(r->true_head_from_head.transpose() * d.turn), 1e-4);
  EXPECT_LT((r->true_face - demo.middle_of_face()).norm(), 1e-5);
  EXPECT_TRUE(r->true_torso_from_torso.isApprox(d.torso, 1e-4));
  EXPECT_NEAR(r->picture.fx, 700 * d.lens / 2, 1e-9);
  EXPECT_NEAR(r->picture.cx, (256 - 60) / 2, 1e-9);
  EXPECT_NEAR(r->picture.cy, (256 - 40) / 2, 1e-9);
}

// The other lens leaves what a perspective from five percent farther away differs by: the face is 50 px wide.
TEST(PoseAs, LaysTheAvatarsFaceOverTheTruePictureFromTheFrontAndFromTheSide) {
  const TrackedDemo demo({});
  const auto r = demo.registered();
  ASSERT_TRUE(r.ok()) << r.error().what;
  const std::vector<int> face = face_vertices_of(demo.truth.model);
  for (const double yaw : {0.0, 30.0, -30.0}) EXPECT_LT(demo.furthest_px(*r, demo.shot_from(yaw), face), 0.5);
  // With the true lens nothing is left.
  Differing same;
  same.lens = 1;
  const TrackedDemo exact(same);
  const auto registered = exact.registered();
  ASSERT_TRUE(registered.ok()) << registered.error().what;
  for (const double yaw : {0.0, 30.0, -30.0})
    EXPECT_LT(exact.furthest_px(*registered, exact.shot_from(yaw), face), 0.02);
}

TEST(PoseAs, OfAFrameOfTheFilmIsItsPoseInTheTrack) {
  const TrackedDemo demo({});
  const auto r = demo.registered();
  ASSERT_TRUE(r.ok()) << r.error().what;
  for (const int frame : {3, 17, kHeldOut + 2}) {
    const AvatarPose &known = demo.truth.track.frames[std::size_t(frame)].pose,
                     &own = demo.track.frames[std::size_t(frame)].pose;
    Shot shot = demo.shot_from(0);
    shot.world_from_head = known.world_from_head, shot.world_from_torso = known.world_from_torso;
    const PosedShot posed = pose_as(*r, demo.avatar, shot);
    EXPECT_TRUE(posed.pose.world_from_head.isApprox(own.world_from_head, 1e-4)) << frame;
    EXPECT_TRUE(posed.pose.world_from_torso.isApprox(own.world_from_torso, 1e-4)) << frame;
  }
}

// A fitted face lies on its picture where it is right; a wrong cheek must not pull the rest aside.
TEST(PoseAs, AFaceThatWasFittedAskewStaysOnItsPicture) {
  Differing same;
  same.lens = 1;
  TrackedDemo demo(same);
  const std::vector<int> face = face_vertices_of(demo.truth.model);
  std::vector<int> right_ones;
  for (const int v : face) {
    const Vec3f& at = demo.true_vertices[std::size_t(v)];
    if (at.x() > 0.02f)
      demo.track.person.offsets[std::size_t(v)] += (same.turn.transpose() * Vec3d(0.01, 0, 0)).cast<float>();
    else
      right_ones.push_back(v);
  }
  const auto r = demo.registered();
  ASSERT_TRUE(r.ok()) << r.error().what;
  EXPECT_GT((r->true_face - demo.middle_of_face()).norm(), 0.002) << "nothing was to be made up for";
  EXPECT_LT(demo.furthest_px(*r, demo.shot_from(0), right_ones), 0.5);
}

TEST(PoseAs, ThePerformanceIsOnTopOfTheAvatarsOwnRest) {
  TrackedDemo demo({});
  const HeadModel& model = demo.truth.model;
  demo.avatar.neutral = neutral_articulation(model);
  for (const char* action : {"jawOpen", "mouthSmile_L"})
    add_action(demo.avatar.neutral, *find_action(model, action), 0.2f);
  const auto r = demo.registered();
  ASSERT_TRUE(r.ok()) << r.error().what;
  Shot shot = demo.shot_from(0);
  add_action(shot.articulation, *find_action(model, "jawOpen"), 0.5f);
  shot.articulation.left_eye = Vec3f(0.1f, 0, 0);
  Articulation expected = demo.avatar.neutral;
  add_action(expected, *find_action(model, "jawOpen"), 0.5f);
  const Articulation face = pose_as(*r, demo.avatar, shot).pose.articulation;
  EXPECT_TRUE(face.expression.isApprox(expected.expression));
  EXPECT_TRUE(face.jaw.isApprox(expected.jaw));
  EXPECT_EQ(face.left_eye, shot.articulation.left_eye);
}

TEST(RegisterToTruth, HeldOutAndLostFramesDoNotCount) {
  TrackedDemo demo({});
  const auto before = demo.registered();
  for (TrackedFrame& frame : demo.track.frames) {
    if (frame.frame >= kHeldOut || frame.frame == 4) frame.pose.world_from_head.translation().x() += 0.1;
    if (frame.frame == 4) frame.status = FrameStatus::lost;
  }
  const auto after = demo.registered();
  ASSERT_TRUE(before.ok() && after.ok());
  EXPECT_NEAR(before->farther, after->farther, 1e-5);
  EXPECT_LT((before->true_face - after->true_face).norm(), 1e-5);
}

TEST(RegisterToTruth, ATrackThatLostThePersonIsRefused) {
  TrackedDemo demo({});
  for (TrackedFrame& frame : demo.track.frames) frame.status = FrameStatus::lost;
  const auto r = demo.registered();
  ASSERT_FALSE(r.ok());
  EXPECT_FALSE(r.error().fix.empty());
}

}  // namespace
}  // namespace likeness
