// Claims about the report of the models: tables hold every training, the page is whole and stands alone.
#include "core/study/modes_report.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/base/files.h"
#include "core/image/files.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class ModesReport : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("likeness_modes_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    study_ = {.clip = "a <clip> & more.mp4", .size = 16, .training_frames = 30, .threads = 2};
    study_.frames = {90, 91, 92}, study_.shown = {90, 92};
    study_.truths = {"truth-90.png", "truth-92.png"};
    double db = 20;
    for (const ModelKind& kind :
         {ModelKind{FieldMode::concat, Encoder::grid}, ModelKind{FieldMode::concat, Encoder::mlp}}) {
      ModelRow row{kind, {}, {}};
      for (const std::uint64_t seed : {0u, 1u}) {
        ModelScore s{.seed = seed, .steps = 50, .parameters = 12345, .frames = 3};
        s.psnr_person_db = s.psnr_head_db = s.psnr_face_db = db++;
        s.landmark_error_px = std::nan("");
        s.frame_ms = 40, s.train_seconds = 9;
        s.marks = {{3, 20, std::nullopt, 15}, {9, 50, std::nullopt, db}};
        row.scores.push_back(s);
      }
      row.pictures = {model_name(kind) + "-90.png", model_name(kind) + "-92.png"};
      study_.rows.push_back(row);
      for (const std::string& name : row.pictures)
        ASSERT_TRUE(write_image(folder_ / name, Image8(16, 16, 3, 99)).ok());
    }
    for (const std::string& name : study_.truths)
      ASSERT_TRUE(write_image(folder_ / name, Image8(16, 16, 3, 200)).ok());
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_;
  ModesStudy study_;
};

std::size_t count_of(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

// Every element that is opened is closed in its turn; returns the first that is not, or nothing.
std::string first_unbalanced(const std::string& html) {
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const std::size_t end = html.find('>', at);
    if (end == std::string::npos) return "an open tag";
    std::string name = html.substr(at + 1, end - at - 1);
    name = name.substr(0, name.find(' '));
    if (name == "!DOCTYPE" || name == "meta" || name == "img") continue;
    if (name.front() != '/') {
      open.push_back(name);
      continue;
    }
    if (open.empty() || open.back() != name.substr(1)) return name;
    open.pop_back();
  }
  return open.empty() ? "" : open.back();
}

TEST_F(ModesReport, ThePageIsWholeAndHoldsEveryPicture) {
  ASSERT_TRUE(write_modes_report(study_, folder_).ok());
  const std::string html = *read_text(folder_ / "report.html");
  EXPECT_EQ(first_unbalanced(html), "");
  // Two plots, and for both shown frames the truth and both models.
  EXPECT_EQ(count_of(html, "<img "), 2u + 2u * 3u);
  EXPECT_EQ(count_of(html, "src=\"data:image/png;base64,iVBORw0KGgo"), 8u);  // PNG's signature
  EXPECT_EQ(count_of(html, "src="), 8u);                                     // and nothing from outside
  EXPECT_EQ(count_of(html, "href="), 0u);
  EXPECT_NE(html.find("a &lt;clip&gt; &amp; more.mp4"), std::string::npos);
  EXPECT_NE(html.find("20.50 &plusmn;0.50"), std::string::npos);
  EXPECT_EQ(count_of(html, "<td>-</td>"), 2u * 4u);  // full, SSIM, GMSD and landmarks are not known here
}

TEST_F(ModesReport, TablesHoldEveryTraining) {
  std::istringstream csv(modes_csv(study_));
  std::string header, line;
  ASSERT_TRUE(std::getline(csv, header));
  int lines = 0;
  for (; std::getline(csv, line); ++lines) EXPECT_EQ(count_of(line, ","), count_of(header, ",")) << line;
  EXPECT_EQ(lines, 4);
  const auto json = nlohmann::json::parse(modes_json(study_));
  EXPECT_EQ(json.at("rows").at(1).at("encoder"), "mlp");
  EXPECT_EQ(json.at("rows").at(1).at("scores").at(1).at("seed"), 1);
  EXPECT_TRUE(json.at("rows").at(0).at("scores").at(0).at("lmk_error_px").is_null());
  EXPECT_EQ(json.at("rows").at(0).at("scores").at(0).at("marks").size(), 2u);
}

TEST_F(ModesReport, PlotsHaveASeriesAModel) {
  const Plot seconds = quality_over_seconds(study_), speed = quality_over_speed(study_);
  ASSERT_EQ(seconds.series.size(), 2u);
  EXPECT_EQ(seconds.series[0].points.size(), 2u);
  EXPECT_EQ(speed.series[1].points.at(0), Vec2d(25, 22.5));
}

TEST_F(ModesReport, AMissingPictureIsSaid) {
  fs::remove(folder_ / study_.truths[0]);
  EXPECT_FALSE(write_modes_report(study_, folder_).ok());
}

TEST(ModelKinds, HoldEveryModeOnceAnEncoder) {
  EXPECT_EQ(model_kinds().size(), 9u);
  EXPECT_EQ(std::ranges::count(model_kinds(), ModelKind{FieldMode::warp_hyper, Encoder::mlp}), 0);
  EXPECT_EQ(model_name({FieldMode::warp_hyper, Encoder::grid}), "warp+hyper, grid");
}

}  // namespace
}  // namespace likeness
