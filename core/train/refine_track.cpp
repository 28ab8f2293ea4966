// Correcting the training frames' tracks through the field.
#include "core/train/refine_track.h"

#include <algorithm>

#include "core/base/parallel.h"

namespace likeness {
namespace {

Image8 within_matte(Image8 region, const TrainingView& view) {
  for (int y = 0; y < region.height && !view.alpha.empty(); ++y)
    for (int x = 0; x < region.width; ++x)
      if (view.alpha.at(x, y) <= 127) *region.at(x, y) = 0;
  return region;
}

Eigen::VectorXd bounds(const RefineOptions& options, Eigen::Index count) {
  Eigen::VectorXd most = Eigen::VectorXd::Constant(count, options.largest_component);
  most.head<3>().setConstant(options.largest_turn);
  most.segment<3>(3).setConstant(options.largest_shift);
  return most;
}

}  // namespace

Image8 head_box(const TrainingView& view, const AvatarRig& rig) {
  const auto landmarks =
      landmark_positions(*rig.model, pose_head(*rig.model, rig.shape, view.pose.articulation));
  const Pose cam_from_head = view.camera.cam_from_world * view.pose.world_from_head;
  Vec2d low = Vec2d::Constant(1e9), high = -low;
  Image8 region(view.rgb.width, view.rgb.height, 1);
  for (const Vec3f& landmark : landmarks) {
    const Vec3d p = cam_from_head * landmark.cast<double>();
    if (p.z() < 1e-3) return region;
    const Vec2d pixel = project(view.camera.intrinsics, p);
    low = low.cwiseMin(pixel), high = high.cwiseMax(pixel);
  }
  const Vec2d size = high - low;
  low.x() -= 0.2 * size.x(), high.x() += 0.2 * size.x(), low.y() -= 0.6 * size.y();
  for (int y = std::max(0, int(low.y())); y < std::min(region.height, int(high.y())); ++y)
    for (int x = std::max(0, int(low.x())); x < std::min(region.width, int(high.x())); ++x)
      *region.at(x, y) = 255;
  return region;
}

std::vector<AvatarPose> corrected_poses(const TrainingSet& set, const ConditionMap& map,
                                        const std::vector<Eigen::VectorXd>& corrections) {
  std::vector<AvatarPose> poses;
  for (std::size_t v = 0; v < set.views.size(); ++v)
    poses.push_back(
        changed_pose(set.views[v].pose, map, corrections.empty() ? Eigen::VectorXd() : corrections[v]));
  return poses;
}

std::vector<AvatarPose> pictured_poses(const TrainingSet& set, const ConditionMap& map,
                                       const std::vector<Eigen::VectorXd>& corrections) {
  std::vector<AvatarPose> poses = corrected_poses(set, map, corrections);
  for (const TrainingView& proxy : set.proxies) poses.push_back(proxy.pose);
  return poses;
}

std::vector<Eigen::VectorXd> refine_track(const TrainingSet& set, const Avatar& avatar, const AvatarRig& rig,
                                          const std::vector<Eigen::VectorXd>& corrections,
                                          const RefineOptions& options, std::stop_token stop) {
  std::vector<Eigen::VectorXd> refined(own_views(set).size());
  parallel_for(refined.size(), [&](std::size_t v) {
    if (stop.stop_requested()) return;
    const TrainingView& view = set.views[v];
    const Image8 region = within_matte(head_box(view, rig), view);
    const Image8 plate = plate_picture(set, view).rgb;
    const FieldFitOptions fit{options.pixels, 1, options.components, options.seed + v};
    refined[v] = fit_to_field(avatar, rig, view.camera, {&view.rgb, &plate, &region}, view.pose,
                              corrections.empty() ? Eigen::VectorXd() : corrections[v], fit)
                     .change;
  });
  if (stop.stop_requested() || refined.empty()) return corrections;
  const Eigen::VectorXd most = bounds(options, refined.front().size());
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(most.size());
  for (Eigen::VectorXd& change : refined) {
    change = change.cwiseMin(most).cwiseMax(-most);
    mean += change / double(refined.size());
  }
  for (Eigen::VectorXd& change : refined) change -= mean;
  for (std::size_t v = refined.size(); v < set.views.size(); ++v) {
    Eigen::VectorXd& kept = refined.emplace_back(Eigen::VectorXd::Zero(most.size()));
    if (!corrections.empty()) kept.head<kPoseChange>() = corrections[v].head<kPoseChange>();
  }
  return refined;
}

}  // namespace likeness
