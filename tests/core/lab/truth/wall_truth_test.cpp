// Claims about comparing backgrounds, and about a project's plate beside the truth of a demo.
#include "core/lab/truth/wall_truth.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "core/camera/camera.h"
#include "core/capture/capture.h"
#include "core/image/files.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

// A picture with something in every pixel; never too bright to be made brighter.
Image8 wall(int width, int height) {
  Image8 picture(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) picture.at(x, y)[c] = std::uint8_t(40 + (5 * x + 9 * y + 31 * c) % 120);
  return picture;
}

TEST(CompareWalls, OnlyKnownPixelsCount) {
  const Image8 truth = wall(40, 30);
  Image8 found = truth, known(40, 30, 1, 255);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 10; ++x) *known.at(x, y) = 0, found.at(x, y)[1] = 255;
  const WallErrors errors = compare_walls(found, known, truth);
  EXPECT_DOUBLE_EQ(errors.known_share, 0.75);
  EXPECT_GT(*errors.psnr_db, 55);
  EXPECT_LT(*compare_walls(found, {}, truth).psnr_db, 20);
  EXPECT_FALSE(compare_walls(found, Image8(40, 30, 1, 0), truth).psnr_db.has_value());
}

TEST(CompareWalls, AnotherExposureIsApartFromAnotherPicture) {
  const Image8 truth = wall(40, 30);
  Image8 darker = truth;
  for (std::uint8_t& value : darker.data) value = std::uint8_t(value * 0.8 + 0.5);  // 0.8^2.2 of the light
  const WallErrors errors = compare_walls(darker, {}, truth);
  EXPECT_LT(*errors.psnr_db, 26);
  EXPECT_GT(*errors.psnr_own_light_db, *errors.psnr_db + 10);
  Image8 moved(40, 30, 3);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x) std::copy_n(truth.at((x + 3) % 40, y), 3, moved.at(x, y));
  const WallErrors elsewhere = compare_walls(moved, {}, truth);
  EXPECT_LT(*elsewhere.psnr_own_light_db, *elsewhere.psnr_db + 1);
}

// A project of a resting camera, whose plate is the truth but for one patch.
TEST(StudyWalls, APlateIsComparedInTheProjectsCrop) {
  const fs::path folder = fs::temp_directory_path() / ("likeness_wall_truth_" + std::to_string(::getpid()));
  fs::remove_all(folder);
  const fs::path demo = folder / "demo";
  Project project;
  project.folder = folder / "p.likeness";
  fs::create_directories(project.folder);
  fs::create_directories(demo / "wall_truth");
  fs::create_directories(demo / "masks_truth");
  Capture capture;
  capture.width = 80, capture.height = 60;
  capture.crop = {20, 10, 40};
  capture.size = 40;
  ASSERT_TRUE(write_capture(capture_path(project), capture).ok());
  CameraSet cameras;
  cameras.cameras.push_back({-1, {80, 60, 90, 90, 40, 30}, Pose::Identity()});
  ASSERT_TRUE(write_cameras(cameras_path(project), cameras).ok());
  const Image8 truth = wall(80, 60);
  Image8 plate = crop(truth, 20, 10, 40, 40), mask(80, 60, 1, 0);
  for (int y = 20; y < 30; ++y)  // source pixels 40..49, 30..39
    for (int x = 20; x < 30; ++x) plate.at(x, y)[0] = std::uint8_t(plate.at(x, y)[0] + 60);
  for (int y = 30; y < 40; ++y)
    for (int x = 40; x < 50; ++x) *mask.at(x, y) = 255;
  ASSERT_TRUE(write_image(plate_path(project), plate).ok());
  EXPECT_FALSE(study_walls(project, demo, Progress(), {}).ok());  // the demo says nothing
  for (const char* name : {"000000.png", "000010.png"}) {
    ASSERT_TRUE(write_image(demo / "wall_truth" / name, truth).ok());
    ASSERT_TRUE(write_image(demo / "masks_truth" / name, mask).ok());
  }
  const auto rows = study_walls(project, demo, Progress(), {});
  ASSERT_TRUE(rows.ok()) << rows.error().what;
  ASSERT_EQ(rows->size(), 2u);
  EXPECT_EQ((*rows)[0].pictures, 2);
  EXPECT_DOUBLE_EQ((*rows)[0].known_share, 1);
  EXPECT_NEAR((*rows)[1].known_share, 100.0 / 1600, 1e-9);
  // One channel of a sixteenth of the pixels is 60 levels off: 10 log10(3 * 16 * (255 / 60)^2).
  EXPECT_NEAR(*(*rows)[0].psnr_db, 29.4, 0.2);
  EXPECT_NEAR(*(*rows)[1].psnr_db, 17.3, 0.2);
  // A wall of one channel, and a mask of three, are no demo's.
  ASSERT_TRUE(write_image(demo / "wall_truth" / "000010.png", mask).ok());
  EXPECT_EQ(study_walls(project, demo, Progress(), {}).error().code, ErrorCode::bad_input);
  ASSERT_TRUE(write_image(demo / "wall_truth" / "000010.png", truth).ok());
  ASSERT_TRUE(write_image(demo / "masks_truth" / "000010.png", truth).ok());
  EXPECT_EQ(study_walls(project, demo, Progress(), {}).error().code, ErrorCode::bad_input);
  std::stop_source source;
  source.request_stop();
  EXPECT_EQ(study_walls(project, demo, Progress(), source.get_token()).error().code, ErrorCode::cancelled);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace likeness
