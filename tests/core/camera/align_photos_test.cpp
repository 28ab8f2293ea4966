// Claims about cameras of real photographs, against a published solution; skipped where the capture is
// absent.
#include <gtest/gtest.h>
#include <unistd.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "core/camera/align.h"
#include "core/camera/process.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

// NeRF's convention: world from camera, camera axes x right, y up, z backwards.
std::map<std::string, Pose> published_poses(const fs::path& file) {
  const auto json = nlohmann::json::parse(std::ifstream(file));
  std::map<std::string, Pose> poses;
  for (const auto& frame : json.at("frames")) {
    Pose world_from_cam = Pose::Identity();
    for (int i = 0; i < 12; ++i)
      world_from_cam.matrix()(i / 4, i % 4) = frame.at("transform_matrix")[i / 4][i % 4].get<double>();
    world_from_cam.linear().col(1) *= -1;
    world_from_cam.linear().col(2) *= -1;
    poses[fs::path(frame.at("file_path").get<std::string>()).filename().string()] = world_from_cam.inverse();
  }
  return poses;
}

TEST(AlignPhotos, AgreesWithThePublishedSolutionOfAPhoneCapture) {
  const fs::path fox = fs::path(LIKENESS_SHARED) / "captures" / "fox";
  if (!fs::exists(fox / "transforms.json")) GTEST_SKIP() << "no capture at " << fox;
  if (!find_program("colmap")) GTEST_SKIP() << "colmap is not installed";
  const fs::path work = fs::temp_directory_path() / ("likeness_fox_" + std::to_string(::getpid()));
  const auto result = align_photos(fox / "images", {}, work, {}, {}, {});
  fs::remove_all(work);
  ASSERT_TRUE(result.ok()) << result.error().what;
  EXPECT_EQ(result->registered, result->frames);
  EXPECT_LT(result->cameras.reprojection_px, 3.0);

  const auto published = published_poses(fox / "transforms.json");
  std::vector<std::pair<Pose, Pose>> pairs;  // ours, theirs
  for (const auto& camera : result->cameras.cameras)
    if (const auto it = published.find(result->photos.at(std::size_t(camera.frame))); it != published.end())
      pairs.emplace_back(camera.cam_from_world, it->second);
  ASSERT_GE(pairs.size(), 45u);
  Eigen::Matrix3Xd ours(3, pairs.size()), theirs(3, pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    ours.col(long(i)) = pairs[i].first.inverse().translation();
    theirs.col(long(i)) = pairs[i].second.inverse().translation();
  }
  const Eigen::Matrix4d similarity = Eigen::umeyama(ours, theirs, true);
  const double extent = (theirs.rowwise().maxCoeff() - theirs.rowwise().minCoeff()).norm();
  std::vector<double> position, turn_deg;
  const Mat3d rotation = similarity.topLeftCorner<3, 3>() / similarity.block<3, 1>(0, 0).norm();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Vec3d moved = (similarity * ours.col(long(i)).homogeneous()).head<3>();
    position.push_back((moved - theirs.col(long(i))).norm() / extent);
    const Mat3d difference =
        pairs[i].first.linear() * rotation.transpose() * pairs[i].second.linear().transpose();
    turn_deg.push_back(Eigen::AngleAxisd(difference).angle() * 180 / M_PI);
  }
  std::sort(position.begin(), position.end());
  std::sort(turn_deg.begin(), turn_deg.end());
  RecordProperty("position_median", std::to_string(position[position.size() / 2]));
  std::printf("position median %.5f max %.5f of the extent; rotation median %.3f max %.3f degrees; fx %.1f\n",
              position[position.size() / 2], position.back(), turn_deg[turn_deg.size() / 2], turn_deg.back(),
              result->cameras.cameras[0].intrinsics.fx);
  EXPECT_LT(position[position.size() / 2], 0.005);
  EXPECT_LT(turn_deg[turn_deg.size() / 2], 1.0);
  EXPECT_NEAR(result->cameras.cameras[0].intrinsics.fx, 1375.52, 1375.52 * 0.01);
}

}  // namespace
}  // namespace likeness
