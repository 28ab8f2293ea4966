// Claims about rows that a study keeps: they are read again for the same inputs only.
#include "core/lab/study/finished_rows.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>

#include "core/base/files.h"

namespace likeness {
namespace {

TEST(FinishedRows, AreKnownAgainByTheirInputs) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("likeness_row_" + std::to_string(getpid()) + ".json");
  EXPECT_FALSE(read_finished(path, "a").has_value());
  ASSERT_TRUE(write_finished(path, "a", {{"psnr_db", 31.5}, {"ssim", finite_or_null(std::nan(""))}}).ok());
  const auto row = read_finished(path, "a");
  ASSERT_TRUE(row.has_value());
  EXPECT_EQ(optional_number(row->at("psnr_db")), 31.5);
  EXPECT_FALSE(optional_number(row->at("ssim")).has_value());
  EXPECT_TRUE(std::isnan(number_or_nan(row->at("ssim"))));
  EXPECT_FALSE(read_finished(path, "b").has_value());
  for (const char* damaged : {"", "{", "[1]", "{\"inputs\": 3}"}) {
    ASSERT_TRUE(write_text(path, damaged).ok());
    EXPECT_FALSE(read_finished(path, "a").has_value()) << damaged;
  }
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace likeness
