// Claims about cameras.json.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/base/files.h"
#include "core/camera/camera.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

struct Folder {
  fs::path path = fs::temp_directory_path() / ("likeness_cameras_" + std::to_string(::getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
};

Camera some_camera(int frame) {
  Camera camera{frame, {}, Pose::Identity()};
  camera.intrinsics.width = 1080, camera.intrinsics.height = 1920;
  camera.intrinsics.fx = 1375.0 / 3, camera.intrinsics.fy = 1374.49, camera.intrinsics.cx = 554.558;
  camera.intrinsics.cy = 965.268, camera.intrinsics.k1 = 0.1 / 3, camera.intrinsics.p2 = -1e-5;
  camera.cam_from_world = Eigen::Translation3d(0.1 * frame, -2.0 / 7, 3) *
                          Eigen::AngleAxisd(0.3 + 0.01 * frame, Vec3d(1, 2, -1).normalized());
  return camera;
}

TEST(CamerasFile, KeepsEveryNumberBitForBit) {
  Folder folder;
  CameraSet set;
  set.kind = CameraKind::walking;
  set.scale = CameraScale::arbitrary;
  set.reprojection_px = 1.0 / 3;
  for (int frame : {0, 1, 5}) set.cameras.push_back(some_camera(frame));
  ASSERT_TRUE(write_cameras(folder.path / "cameras.json", set).ok());
  const auto read = read_cameras(folder.path / "cameras.json");
  ASSERT_TRUE(read.ok()) << read.error().what;
  EXPECT_FALSE(read->rests());
  EXPECT_EQ(read->scale, CameraScale::arbitrary);
  EXPECT_EQ(read->reprojection_px, set.reprojection_px);
  ASSERT_EQ(read->cameras.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const Camera &a = set.cameras[i], &b = read->cameras[i];
    EXPECT_EQ(a.frame, b.frame);
    EXPECT_EQ(a.cam_from_world.matrix(), b.cam_from_world.matrix());
    EXPECT_EQ(a.intrinsics.fx, b.intrinsics.fx);
    EXPECT_EQ(a.intrinsics.k1, b.intrinsics.k1);
    EXPECT_EQ(a.intrinsics.p2, b.intrinsics.p2);
    EXPECT_EQ(a.intrinsics.cy, b.intrinsics.cy);
    EXPECT_EQ(a.intrinsics.height, b.intrinsics.height);
  }
}

TEST(CamerasFile, ReadsAFileWithoutOptionalFields) {
  Folder folder;
  std::ofstream(folder.path / "bare.json")
      << R"({"cameras":[{"frame":3,"width":64,"height":48,"fx":70,"fy":71,"cx":32,"cy":24,)"
      << R"("cam_from_world":[1,0,0,0.5, 0,1,0,0, 0,0,1,2]}]})";
  const auto read = read_cameras(folder.path / "bare.json");
  ASSERT_TRUE(read.ok()) << read.error().what;
  EXPECT_FALSE(read->rests());
  EXPECT_EQ(read->cameras[0].cam_from_world.translation(), Vec3d(0.5, 0, 2));
}

TEST(CamerasFile, SaysWhatIsWrongAndWhatToDo) {
  Folder folder;
  const auto fault_of = [&](const std::string& text) {
    std::ofstream(folder.path / "bad.json") << text;
    const auto read = read_cameras(folder.path / "bad.json");
    EXPECT_FALSE(read.ok()) << text;
    if (read.ok()) return std::string();
    EXPECT_FALSE(read.error().fix.empty());
    EXPECT_THAT(read.error().where, testing::HasSubstr("bad.json"));
    return read.error().what;
  };
  const std::string head =
      R"({"cameras":[{"frame":0,"width":64,"height":48,"fx":70,"fy":70,"cx":32,"cy":24,)";
  EXPECT_THAT(fault_of("{\"cameras\":[{"), testing::HasSubstr("cameras.json"));
  EXPECT_THAT(fault_of("{\"cameras\":[]}"), testing::HasSubstr("no camera"));
  EXPECT_THAT(fault_of(head + "\"cam_from_world\":[1,0,0]}]}"), testing::HasSubstr("12 numbers"));
  EXPECT_THAT(fault_of(head + "\"cam_from_world\":[2,0,0,0, 0,1,0,0, 0,0,1,0]}]}"),
              testing::HasSubstr("rotation"));
  // A lens so short that what is divided by it loses all digits.
  std::string short_lens = head + "\"cam_from_world\":[1,0,0,0, 0,1,0,0, 0,0,1,0]}]}";
  short_lens.replace(short_lens.find("\"fx\":70"), 7, "\"fx\":1e-300");
  EXPECT_THAT(fault_of(short_lens), testing::HasSubstr("1e-300"));
  EXPECT_THAT(fault_of(R"({"version":99,"cameras":[]})"), testing::HasSubstr("version 99"));
  EXPECT_THAT(fault_of(R"({"cameras":[{"frame":0}]})"), testing::HasSubstr("width"));
}

TEST(CamerasFile, MissingFileIsNotFound) {
  const auto read = read_cameras("/nonexistent/cameras.json");
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace likeness
