// Claims about cameras of real photographs, against a published solution; skipped where the capture is
// absent.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "core/camera/process.h"
#include "core/lab/truth/camera_truth.h"
#include "core/matte/coarse_mask.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

TEST(PublishedCameras, AreFoundFromThePhotographsOfAPhone) {
  const fs::path fox = fs::path(LIKENESS_SHARED) / "captures" / "fox";
  if (!fs::exists(fox / "transforms.json")) GTEST_SKIP() << "no capture at " << fox;
  if (!find_program("colmap")) GTEST_SKIP() << "colmap is not installed";
  const auto truth = read_camera_truth(fox);
  ASSERT_TRUE(truth.ok()) << truth.error().what;
  EXPECT_EQ(truth->cameras.cameras.size(), 50u);
  const auto person = coarse_person_mask({}, Pictures::single);
  ASSERT_TRUE(person.ok()) << person.error().what;
  const fs::path work = fs::temp_directory_path() / ("likeness_fox_" + std::to_string(::getpid()));
  const auto rows = study_cameras(*truth, {{"person", *person}}, work, {}, {}, {});
  fs::remove_all(work);
  ASSERT_TRUE(rows.ok()) << rows.error().what;
  ASSERT_TRUE(rows->front().errors.has_value()) << rows->front().outcome;
  const CameraErrors& errors = *rows->front().errors;
  EXPECT_EQ(errors.found, 50);
  EXPECT_LE(errors.turn_median_deg, 0.15);
  EXPECT_LE(errors.position_median_percent, 0.1);
  EXPECT_LE(errors.position_max_percent, 1);
  EXPECT_NEAR(errors.focal_percent, 0, 0.5);
  EXPECT_GT(rows->front().processor_seconds, 1);  // the programs it ran are counted
}

}  // namespace
}  // namespace likeness
