// Claims about comparing cameras: a similarity is no error, what is left is, and each kind has its number.
#include "core/lab/truth/camera_truth.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "core/base/rigid.h"
#include "core/image/files.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr double kDegree = std::numbers::pi / 180;

// Cameras on an arc that rises and sinks, looking at the origin.
CameraSet arc(int count) {
  CameraSet set;
  set.kind = CameraKind::walking;
  for (int i = 0; i < count; ++i) {
    const double yaw = (-40 + 80.0 * i / (count - 1)) * kDegree;
    Camera camera{i, {640, 480, 700, 700, 320, 240}, Pose::Identity()};
    const Vec3d eye(2 * std::sin(yaw), 0.3 * std::sin(3 * yaw), -2 * std::cos(yaw));
    const Vec3d z = -eye.normalized(), x = Vec3d(0, 1, 0).cross(z).normalized();
    camera.cam_from_world.linear().row(0) = x;
    camera.cam_from_world.linear().row(1) = z.cross(x);
    camera.cam_from_world.linear().row(2) = z;
    camera.cam_from_world.translation() = -(camera.cam_from_world.linear() * eye);
    set.cameras.push_back(camera);
  }
  return set;
}

// The same cameras in a world that is turned, shifted and 3.5 times as large.
CameraSet elsewhere(CameraSet set) {
  Pose world_from_other = Pose::Identity();
  world_from_other.linear() = rotation_about(Vec3d(1, 2, 3).normalized(), 0.7);
  world_from_other.translation() = Vec3d(0.4, -2, 1);
  for (Camera& camera : set.cameras) {
    camera.cam_from_world = camera.cam_from_world * world_from_other;
    camera.cam_from_world.translation() *= 3.5;
  }
  return set;
}

class InFolder : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("likeness_camera_truth_" + std::to_string(::getpid()));
    fs::create_directories(folder_ / "images");
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST(CompareCameras, ASimilarityIsNoError) {
  const CameraSet truth = arc(20);
  const auto errors = compare_cameras(elsewhere(truth), truth);
  ASSERT_TRUE(errors.has_value());
  EXPECT_EQ(errors->found, 20);
  EXPECT_LT(errors->position_max_percent, 1e-6);
  EXPECT_LT(errors->turn_max_deg, 1e-5);
  EXPECT_NEAR(errors->focal_percent, 0, 1e-9);
}

TEST(CompareCameras, ASharedTurnIsMeasuredApartFromEachCamerasOwn) {
  const CameraSet truth = arc(21);
  CameraSet found = elsewhere(truth);
  const Mat3d shared = rotation_about(Vec3d::UnitX(), 0.5 * kDegree);
  for (Camera& camera : found.cameras) {
    const Vec3d eye = inverse(camera.cam_from_world).translation();
    const double own = 0.2 * kDegree * (camera.frame % 2 ? 1 : -1);
    camera.cam_from_world.linear() =
        rotation_about(Vec3d::UnitY(), own) * shared * camera.cam_from_world.linear();
    camera.cam_from_world.translation() = -(camera.cam_from_world.linear() * eye);
    camera.intrinsics.fx *= 1.02;
  }
  const auto errors = compare_cameras(found, truth);
  ASSERT_TRUE(errors.has_value());
  EXPECT_LT(errors->position_max_percent, 1e-6);
  EXPECT_NEAR(errors->turn_median_deg, std::hypot(0.5, 0.2), 1e-2);
  EXPECT_NEAR(errors->shared_turn_deg, 0.5, 0.02);
  EXPECT_NEAR(errors->own_turn_median_deg, 0.2, 0.02);
  EXPECT_NEAR(errors->focal_percent, 2, 1e-6);
}

TEST(CompareCameras, LostCamerasAreCountedAndARestingOneIsNoPath) {
  const CameraSet truth = arc(12);
  CameraSet found = truth;
  found.cameras.erase(found.cameras.begin() + 3, found.cameras.begin() + 7);
  const auto errors = compare_cameras(found, truth);
  ASSERT_TRUE(errors.has_value());
  EXPECT_EQ(errors->wanted, 12);
  EXPECT_EQ(errors->found, 8);
  CameraSet resting;
  resting.cameras.push_back({-1, truth.cameras[0].intrinsics, Pose::Identity()});
  EXPECT_FALSE(compare_cameras(resting, truth).has_value());
}

TEST_F(InFolder, ADemosTruthIsItsMovingPart) {
  CameraSet set = arc(10);
  for (int frame = 10; frame < 30; ++frame) {
    set.cameras.push_back(set.cameras[9]);
    set.cameras.back().frame = frame;
  }
  ASSERT_TRUE(write_cameras(folder_ / "cameras_truth.json", set));
  const auto truth = read_camera_truth(folder_);
  ASSERT_TRUE(truth.ok()) << truth.error().what;
  EXPECT_FALSE(truth->photographs);
  EXPECT_EQ(truth->input, folder_ / "demo.mp4");
  EXPECT_EQ(truth->cameras.cameras.size(), 9u);
}

TEST_F(InFolder, ARestingDemoAndAnEmptyFolderSayWhatToDo) {
  CameraSet set;
  set.cameras.push_back({-1, {64, 64, 90, 90, 32, 32}, Pose::Identity()});
  ASSERT_TRUE(write_cameras(folder_ / "cameras_truth.json", set));
  const auto resting = read_camera_truth(folder_);
  ASSERT_FALSE(resting.ok());
  EXPECT_NE(resting.error().fix.find("--moving-share"), std::string::npos);
  const auto nothing = read_camera_truth(folder_ / "images");
  ASSERT_FALSE(nothing.ok());
  EXPECT_EQ(nothing.error().code, ErrorCode::not_found);
}

TEST_F(InFolder, APublishedSolutionIsMatchedByFileNames) {
  // Two of the photographs were never solved, and the solution is in another order than the names.
  const CameraSet cameras = arc(5);
  for (const char* name : {"a.png", "b.png", "c.png", "d.png", "e.png", "f.png", "g.png"})
    ASSERT_TRUE(write_image(folder_ / "images" / name, Image8(8, 6, 3, 100)));
  std::ofstream out(folder_ / "transforms.json");
  out.precision(17);
  out << "{\"fl_x\": 700, \"frames\": [";
  const char* names[] = {"g.png", "b.png", "e.png", "c.png", "f.png"};
  for (int i = 0; i < 5; ++i) {
    Pose world_from_cam = inverse(cameras.cameras[std::size_t(i)].cam_from_world);
    world_from_cam.linear().col(1) *= -1;
    world_from_cam.linear().col(2) *= -1;
    out << (i ? "," : "") << "{\"file_path\": \"images/" << names[i] << "\", \"transform_matrix\": [";
    for (int row = 0; row < 4; ++row) {
      out << (row ? ",[" : "[");
      for (int column = 0; column < 4; ++column)
        out << (column ? "," : "") << world_from_cam.matrix()(row, column);
      out << "]";
    }
    out << "]}";
  }
  out << "]}";
  out.close();
  const auto truth = read_camera_truth(folder_);
  ASSERT_TRUE(truth.ok()) << truth.error().what;
  EXPECT_TRUE(truth->photographs);
  EXPECT_EQ(truth->input, folder_ / "images");
  ASSERT_EQ(truth->cameras.cameras.size(), 5u);
  const int frames[] = {1, 2, 4, 5, 6}, source[] = {1, 3, 2, 4, 0};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(truth->cameras.cameras[i].frame, frames[i]);
    EXPECT_TRUE(truth->cameras.cameras[i].cam_from_world.isApprox(
        cameras.cameras[std::size_t(source[i])].cam_from_world, 1e-9));
  }
}

}  // namespace
}  // namespace likeness
