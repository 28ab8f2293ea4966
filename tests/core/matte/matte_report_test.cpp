// Claims about what the matte stage says of itself: kept whole, refused where it cannot be, and judged by
// limits that neither a plain wall nor a picture full of contrast confuses.
#include "core/matte/matte_report.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "core/base/files.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class MatteReportFile : public testing::Test {
 protected:
  MatteReportFile() : path_(fs::temp_directory_path() / ("likeness_report_" + std::to_string(::getpid()))) {}
  ~MatteReportFile() override { fs::remove(path_); }
  fs::path path_;
};

TEST_F(MatteReportFile, RoundTrips) {
  MatteReport report;
  report.prior = MaskPrior::person_network, report.frames = 90, report.prior_frames = 81;
  report.plate_look_back = {70, 0.125};
  report.has_mosaic = true;
  report.plate = BackgroundFit{12, true, 31.5, 14.25};
  report.room = BackgroundFit{7, false, 5.4, 12};
  ASSERT_TRUE(write_matte_report(path_, report));
  const auto read = read_matte_report(path_);
  ASSERT_TRUE(read) << read.error().what;
  ASSERT_TRUE(read->has_value());
  const MatteReport& back = **read;
  EXPECT_EQ(back.prior, report.prior);
  EXPECT_EQ(back.frames, 90);
  EXPECT_EQ(back.prior_frames, 81);
  EXPECT_EQ(back.plate_look_back.frames, 70);
  EXPECT_DOUBLE_EQ(back.plate_look_back.differing, 0.125);
  EXPECT_TRUE(back.has_mosaic);
  ASSERT_TRUE(back.plate && back.room);
  EXPECT_DOUBLE_EQ(back.plate->psnr_db, 31.5);
  EXPECT_DOUBLE_EQ(back.plate->constant_db, 14.25);
  EXPECT_FALSE(back.room->held_out);
}

TEST_F(MatteReportFile, AMissingFileIsNoReportAndADamagedOneIsRefused) {
  const auto missing = read_matte_report(path_);
  ASSERT_TRUE(missing);
  EXPECT_FALSE(missing->has_value());
  MatteReport report;
  report.frames = 3, report.prior_frames = 4;  // in more frames than there are
  ASSERT_TRUE(write_matte_report(path_, report));
  EXPECT_FALSE(read_matte_report(path_));
  ASSERT_TRUE(write_text(path_, R"({"format":"likeness-matte-report","version":2})"));
  EXPECT_FALSE(read_matte_report(path_));
  ASSERT_TRUE(write_text(path_, "{"));
  EXPECT_FALSE(read_matte_report(path_));
}

TEST(BackgroundFit, IsJudgedBesideOneColourAFrame) {
  const auto learnt = [](double psnr, double constant) { return is_learnt({10, true, psnr, constant}); };
  EXPECT_FALSE(learnt(5.4, 12));            // another picture
  EXPECT_FALSE(learnt(15, 9));              // of much contrast, and still another picture
  EXPECT_TRUE(learnt(21, 16.8));            // a cluttered room, a little soft
  EXPECT_FALSE(learnt(18.3, 16.8));         // hardly more than a single colour
  EXPECT_FALSE(learnt(21, 24));             // less than a single colour
  EXPECT_TRUE(learnt(27, 40));              // a plain wall in light that drifts
  EXPECT_TRUE(is_learnt({0, true, 0, 0}));  // the person fills every frame
}

TEST(BackgroundFit, OnlyWhatStandsBehindTheAvatarIsItsFault) {
  MatteReport report;
  EXPECT_EQ(background_fault(report), "");
  report.room = BackgroundFit{10, true, 5.4, 12};
  EXPECT_NE(background_fault(report).find("5.4 dB"), std::string::npos);
  EXPECT_NE(background_fault(report).find("plain colour"), std::string::npos);
  report.plate = BackgroundFit{10, true, 32, 12};  // before which the camera rests later
  EXPECT_EQ(background_fault(report), "");
  EXPECT_NE(room_fault(report), "");
  report.plate->psnr_db = 9;
  EXPECT_NE(background_fault(report).find("9.0 dB"), std::string::npos);
}

TEST(PlateLookBack, SaysWhatToDoOfEachKindOfCamera) {
  MatteReport report;
  report.plate_look_back = {40, 0.2};
  EXPECT_EQ(look_back_warning(report, CameraKind::resting), "");
  report.plate_look_back.differing = 0.6;
  EXPECT_NE(look_back_warning(report, CameraKind::resting).find("--camera-kind handheld"), std::string::npos);
  EXPECT_NE(look_back_warning(report, CameraKind::handheld).find("--camera-kind walking"), std::string::npos);
  EXPECT_NE(look_back_warning(report, CameraKind::walking).find("60 %"), std::string::npos);
}

}  // namespace
}  // namespace likeness
