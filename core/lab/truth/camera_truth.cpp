// Reading known cameras, aligning, comparing: see camera_truth.h.
#include "core/lab/truth/camera_truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/base/align_points.h"
#include "core/base/files.h"
#include "core/base/json_text.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/camera/resect.h"
#include "core/lab/truth/spent_seconds.h"
#include "core/synth/demo_camera.h"
#include "core/video/photos.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr double kDegrees = 180 / std::numbers::pi;

double angle_deg(const Mat3d& rotation) { return rotation_angle(rotation) * kDegrees; }

Error no_truth(const fs::path& folder) {
  return {ErrorCode::not_found, fmt::format("There are no known cameras in \"{}\".", folder.string()),
          "Give a folder of `likeness demo`, or one with photographs and their transforms.json.",
          folder.string()};
}

// Keeps the frames up to the last move: after it the camera rests.
void keep_moving_part(CameraSet& set) {
  std::vector<Camera>& cameras = set.cameras;
  const auto moved = [](const Camera& a, const Camera& b) {
    return !a.cam_from_world.isApprox(b.cam_from_world, 1e-9);
  };
  std::size_t end = 0;
  for (std::size_t i = 1; i < cameras.size(); ++i)
    if (moved(cameras[i - 1], cameras[i])) end = i;
  cameras.resize(end);
}

Result<CameraTruth> read_demo_cameras(const fs::path& folder) {
  CameraTruth truth;
  auto cameras = read_cameras(folder / "cameras_truth.json");
  if (!cameras) return cameras.error();
  auto demo = read_demo_truth(folder / "cameras_truth.json");
  if (!demo) return demo.error();
  truth.input = folder / "demo.mp4";
  truth.cameras = std::move(*cameras);
  truth.shots = std::move(demo->shots);
  truth.kind = truth.cameras.kind;
  if (demo->camera != DemoCamera::guided) return truth;
  truth.kind = CameraKind::walking;
  keep_moving_part(truth.cameras);
  if (truth.cameras.cameras.size() < 3)
    return Error{ErrorCode::bad_input, "The camera rests throughout this demo: there is no path to measure.",
                 "Make one whose camera moves: likeness demo FOLDER --moving-share 0.35", folder.string()};
  return truth;
}

Result<CameraTruth> read_published_truth(const fs::path& folder) {
  const auto text = read_text(folder / "transforms.json");
  if (!text) return text.error();
  CameraTruth truth;
  truth.photographs = true;
  truth.kind = CameraKind::walking;
  truth.cameras.kind = CameraKind::walking;
  truth.cameras.scale = CameraScale::arbitrary;
  try {
    const auto json = parse_json(*text);
    const auto& frames = json.at("frames");
    if (frames.empty()) return no_truth(folder);
    truth.input = folder / fs::path(frames.front().at("file_path").get<std::string>()).parent_path();
    const auto photos = list_photos(truth.input);
    if (!photos) return photos.error();
    std::map<std::string, int> order;
    for (std::size_t i = 0; i < photos->size(); ++i) order[(*photos)[i].filename().string()] = int(i);
    for (const auto& frame : frames) {
      const auto place = order.find(fs::path(frame.at("file_path").get<std::string>()).filename().string());
      if (place == order.end()) continue;  // solved once, but not among these photographs
      Camera camera;
      camera.frame = place->second;
      camera.intrinsics.fx = json.value("fl_x", 0.0);
      camera.intrinsics.fy = json.value("fl_y", camera.intrinsics.fx);
      Pose world_from_cam = Pose::Identity();
      for (int i = 0; i < 12; ++i)
        world_from_cam.matrix()(i / 4, i % 4) =
            frame.at("transform_matrix").at(i / 4).at(i % 4).get<double>();
      world_from_cam.linear().col(1) *= -1;  // to OpenCV's axes
      world_from_cam.linear().col(2) *= -1;
      camera.cam_from_world = inverse(world_from_cam);
      truth.cameras.cameras.push_back(camera);
    }
  } catch (const nlohmann::json::exception& fault) {
    return Error{ErrorCode::bad_input, fmt::format("Not a transforms.json: {}.", fault.what()),
                 "Restore the file from where the photographs came from.",
                 (folder / "transforms.json").string()};
  }
  std::ranges::sort(truth.cameras.cameras, {}, &Camera::frame);
  if (truth.cameras.cameras.size() < 3) return no_truth(folder);
  return truth;
}

}  // namespace

Result<CameraTruth> read_camera_truth(const fs::path& folder) {
  std::error_code ignored;
  if (fs::exists(folder / "cameras_truth.json", ignored)) return read_demo_cameras(folder);
  if (fs::exists(folder / "transforms.json", ignored)) return read_published_truth(folder);
  return no_truth(folder);
}

std::optional<CameraErrors> compare_cameras(const CameraSet& found, const CameraSet& truth) {
  CameraErrors errors;
  errors.wanted = int(truth.cameras.size());
  std::vector<std::pair<const Camera*, const Camera*>> pairs;  // found, true
  if (!found.rests())
    for (const Camera& camera : truth.cameras)
      if (const Camera* ours = find_camera(found, camera.frame)) pairs.emplace_back(ours, &camera);
  errors.found = int(pairs.size());
  if (pairs.size() < 3) return std::nullopt;
  Eigen::Matrix3Xd from(3, pairs.size()), to(3, pairs.size()), path(3, truth.cameras.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    from.col(long(i)) = inverse(pairs[i].first->cam_from_world).translation();
    to.col(long(i)) = inverse(pairs[i].second->cam_from_world).translation();
  }
  for (std::size_t i = 0; i < truth.cameras.size(); ++i)
    path.col(long(i)) = inverse(truth.cameras[i].cam_from_world).translation();
  const double extent = (path.rowwise().maxCoeff() - path.rowwise().minCoeff()).norm();
  const Eigen::Matrix4d similarity = similarity_between(from, to);
  const double scale = similarity.block<3, 1>(0, 0).norm();
  if (!(extent > 0) || !(scale > 0)) return std::nullopt;
  const Mat3d turn = similarity.topLeftCorner<3, 3>() / scale;

  std::vector<double> position, turned, own, focal;
  std::vector<Pose> differences;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Vec3d moved = (similarity * from.col(long(i)).homogeneous()).head<3>();
    position.push_back(100 * (moved - to.col(long(i))).norm() / extent);
    Pose difference = Pose::Identity();
    difference.linear() = pairs[i].first->cam_from_world.linear() * turn.transpose() *
                          pairs[i].second->cam_from_world.linear().transpose();
    turned.push_back(angle_deg(difference.linear()));
    differences.push_back(difference);
    if (pairs[i].second->intrinsics.fx > 0)
      focal.push_back(100 * (pairs[i].first->intrinsics.fx / pairs[i].second->intrinsics.fx - 1));
  }
  const Mat3d shared = mean_pose(differences).linear();
  for (const Pose& difference : differences)
    own.push_back(angle_deg(Mat3d(shared.transpose() * difference.linear())));
  errors.position_max_percent = *std::ranges::max_element(position);
  errors.turn_max_deg = *std::ranges::max_element(turned);
  errors.position_median_percent = median(std::move(position));
  errors.turn_median_deg = median(std::move(turned));
  errors.shared_turn_deg = angle_deg(shared);
  errors.own_turn_median_deg = median(std::move(own));
  if (!focal.empty()) errors.focal_percent = median(std::move(focal));
  return errors;
}

Result<std::vector<CameraRow>> study_cameras(const CameraTruth& truth, const std::vector<NamedMask>& masks,
                                             const fs::path& work, const AlignOptions& options,
                                             const Progress& progress, std::stop_token stop) {
  std::vector<CameraRow> rows;
  for (std::size_t i = 0; i < masks.size(); ++i) {
    const Progress part = progress.stage(double(i) / double(masks.size()),
                                         double(i + 1) / double(masks.size()), "masks: " + masks[i].name);
    const SpentSeconds start = spent_seconds();
    const auto align = truth.photographs ? align_photos : align_clip;
    const auto aligned = align(truth.input, masks[i].person, work / masks[i].name, options, part, stop);
    if (!aligned && aligned.error().code != ErrorCode::failed) return aligned.error();
    CameraRow row;
    row.masks = masks[i].name;
    const SpentSeconds spent = spent_since(start);
    row.seconds = spent.wall, row.processor_seconds = spent.processor;
    if (aligned) {
      row.kind = aligned->cameras.kind;
      row.views = compare_views(aligned->cameras, truth.cameras, truth.shots);
      if (truth.kind == CameraKind::walking) row.errors = compare_cameras(aligned->cameras, truth.cameras);
    }
    row.outcome = aligned ? aligned->evidence : aligned.error().what + " " + aligned.error().fix;
    rows.push_back(std::move(row));
  }
  progress.report(1);
  return rows;
}

}  // namespace likeness
