// Size and place by the faces, turns by the poses, the torso by what lies between both tracks.
#include "core/lab/beyond/registered_avatar.h"

#include <vector>

#include "core/base/align_points.h"
#include "core/base/mean_rotation.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/head/pose_head.h"
#include "core/scene/head_regions.h"

namespace likeness {
namespace {

Eigen::Matrix3Xd face_points(const HeadModel& model, const PersonShape& person, const Articulation& rest) {
  const HeadRegions regions = head_regions(model);
  std::vector<std::uint8_t> skin(regions.face.size());
  for (std::size_t f = 0; f < skin.size(); ++f) skin[f] = regions.face[f] && regions.skin[f];
  const std::vector<int> vertices = region_vertices(model, skin);
  const std::vector<Vec3f> posed = pose_head(model, shape_head(model, person), rest);
  Eigen::Matrix3Xd points(3, Eigen::Index(vertices.size()));
  for (std::size_t k = 0; k < vertices.size(); ++k)
    points.col(Eigen::Index(k)) = posed[std::size_t(vertices[k])].cast<double>();
  return points;
}

// Where the avatar's face is for its own camera to see it where the true one sees the true face: a longer
// lens wants it as much farther along its axis, another size as much farther along the line of sight.
Vec3d place_of_face(const Registration& r, const Vec3d& true_face_in_cam) {
  return r.farther * Vec3d(true_face_in_cam.x(), true_face_in_cam.y(), r.lens * true_face_in_cam.z());
}
Vec3d true_place_of_face(const Registration& r, const Vec3d& face_in_cam) {
  return Vec3d(face_in_cam.x(), face_in_cam.y(), face_in_cam.z() / r.lens) / r.farther;
}

// The way from where the true camera sees the true face to there, in true metres.
Vec3d beyond_true_face(const Registration& r, const Pose& cam_from_true_head) {
  const Vec3d at = cam_from_true_head * r.true_face;
  return place_of_face(r, at) - at;
}

}  // namespace

Result<Registration> register_to_truth(const Capture& capture, const CameraSet& cameras, const Track& track,
                                       const HeadModel& model, const TrackTruth& truth) {
  const std::set<int> held_out = held_out_frames(capture);
  const auto compared = compare_with_truth(track, model, truth, held_out);
  if (!compared) return compared.error();
  Registration r;
  r.true_head_from_head = compared->alignment.truth_head_from_head.linear();
  const bool calibrated = track.neutral.expression.size() == model.expression_count();
  const Eigen::Matrix3Xd own =
      face_points(model, track.person, calibrated ? track.neutral : neutral_articulation(model));
  const Eigen::Matrix3Xd known =
      face_points(truth.model, truth.track.person, neutral_articulation(truth.model));
  r.scale = similarity_between(own, known).topLeftCorner<3, 3>().col(0).norm();
  r.face = own.rowwise().mean(), r.true_face = known.rowwise().mean();

  const Camera* found = find_camera(cameras, track.frames.front().frame);
  const Camera* filmed = find_camera(truth.cameras, track.frames.front().frame);
  if (found == nullptr || filmed == nullptr)
    return Error{ErrorCode::failed, "There is no camera of the first tracked frame.", "", "study beyond"};
  r.lens = found->intrinsics.fx / filmed->intrinsics.fx;

  struct Pair {
    Pose true_head, true_torso, head, torso;  // seen from the camera; own ones in true metres
  };
  std::vector<Pair> pairs;
  std::vector<double> farther;
  for (const TrackedFrame& frame : track.frames) {
    const TrackedFrame* there = find_tracked(truth.track, frame.frame);
    const Camera* camera = find_camera(truth.cameras, frame.frame);
    if (!there || !camera || frame.status == FrameStatus::lost || held_out.contains(frame.frame)) continue;
    const Pose& seen = camera->cam_from_world;
    Pair pair{seen * there->pose.world_from_head, seen * there->pose.world_from_torso,
              seen * frame.pose.world_from_head, seen * frame.pose.world_from_torso};
    pair.head.translation() *= r.scale, pair.torso.translation() *= r.scale;
    farther.push_back(true_place_of_face(r, pair.head * Vec3d(r.scale * r.face)).norm() /
                      (pair.true_head * r.true_face).norm());
    pairs.push_back(pair);
  }
  r.farther = median(std::move(farther));
  // What is left across the view: the fitted face is not quite the true one, but lies on its picture.
  Vec3d across = Vec3d::Zero();
  for (const Pair& pair : pairs) {
    const Vec3d at = pair.true_head * r.true_face;
    const Vec3d left = true_place_of_face(r, pair.head * Vec3d(r.scale * r.face)) - at;
    across += pair.true_head.linear().transpose() * (left - left.dot(at) / at.squaredNorm() * at) /
              double(pairs.size());
  }
  r.true_face += across;
  std::vector<Mat3d> turns;
  Vec3d shift = Vec3d::Zero();
  for (Pair& pair : pairs) {
    pair.torso.translation() -= beyond_true_face(r, pair.true_head);
    const Pose between = inverse(pair.true_torso) * pair.torso;
    turns.push_back(between.linear());
    shift += between.translation() / double(pairs.size());
  }
  r.true_torso_from_torso.linear() = mean_rotation(turns);
  r.true_torso_from_torso.translation() = shift;

  const SquareCrop& c = capture.crop;
  r.picture = crop_intrinsics(found->intrinsics, c.x, c.y, c.side, capture.size);
  return r;
}

PosedShot pose_as(const Registration& r, const Avatar& avatar, const Shot& shot) {
  const Pose cam_from_true_head = shot.camera.cam_from_world * shot.world_from_head,
             cam_from_true_torso = shot.camera.cam_from_world * shot.world_from_torso;
  const Vec3d beyond = beyond_true_face(r, cam_from_true_head);
  Pose head = Pose::Identity(), torso = cam_from_true_torso * r.true_torso_from_torso;
  head.linear() = cam_from_true_head.linear() * r.true_head_from_head;
  head.translation() = (cam_from_true_head * r.true_face + beyond) / r.scale - head.linear() * r.face;
  torso.translation() = (torso.translation() + beyond) / r.scale;
  PosedShot posed;
  posed.camera = {-1, r.picture, Pose::Identity()};
  posed.pose.world_from_head = head, posed.pose.world_from_torso = torso;
  posed.pose.articulation = shot.articulation;
  Articulation& face = posed.pose.articulation;
  if (avatar.neutral.expression.size() == face.expression.size())
    face.expression += avatar.neutral.expression;
  face.jaw += avatar.neutral.jaw;
  return posed;
}

}  // namespace likeness
