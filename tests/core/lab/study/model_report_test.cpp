// Claims about the report of the models: tables hold every training, the page is whole and stands alone.
#include "core/lab/study/model_report.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/base/files.h"
#include "core/image/files.h"
#include "core/lab/study/study_summary.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class ModelReport : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("likeness_models_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    study_ = {.clip = "a <clip> & more.mp4", .size = 16, .training_frames = 30, .threads = 2};
    study_.frames = {90, 91, 92}, study_.shown = {90, 92};
    study_.truths = {"truth-90.png", "truth-92.png"};
    double db = 20;
    study_.full_size = 32;
    study_.parts = {{"torso", true, false, "a field of its own", "12 % of the picture"}};
    study_.tables = {study_tables().front()};
    for (const ModelSpec& spec : study_models()) {
      if (spec.name != kDefaultModel && spec.name != "concat-mlp" && spec.name != kLongBaseline) continue;
      ModelRow row{spec, {}, {}};
      for (const std::uint64_t seed : {0u, 1u}) {
        ModelScore s{.seed = seed, .steps = 50, .parameters = 12345, .frames = 3};
        s.psnr_person_db = s.psnr_head_db = s.psnr_face_db = db++;
        s.landmark_error_px = std::nan("");
        s.frame_seconds = spec.kind == ModelKind::grid ? 0.04 : 4, s.train_seconds = 9 * spec.share;
        if (spec.costs) s.sizes = {{16, s.frame_seconds}, {32, 5 * s.frame_seconds}};
        if (spec.name == kDefaultModel)
          s.qualities = {{"final", std::nullopt, 20, 0.04},
                         {"preview", std::nullopt, 19, 0.02},
                         {"worse", std::nullopt, 18, 0.03}};
        s.marks = {{3, 20, std::nullopt, 15}, {9, 50, std::nullopt, db}};
        row.scores.push_back(s);
      }
      row.pictures = {spec.name + "-90.png", spec.name + "-92.png"};
      study_.rows.push_back(row);
      for (const std::string& name : row.pictures)
        ASSERT_TRUE(write_image(folder_ / name, Image8(16, 16, 3, 99)).ok());
    }
    for (const std::string& name : study_.truths)
      ASSERT_TRUE(write_image(folder_ / name, Image8(16, 16, 3, 200)).ok());
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_;
  ModelStudy study_;
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

TEST_F(ModelReport, ThePageIsWholeAndHoldsEveryPicture) {
  ASSERT_TRUE(write_model_report(study_, folder_).ok());
  const std::string html = *read_text(folder_ / "report.html");
  EXPECT_EQ(first_unbalanced(html), "");
  // Five plots, and for both shown frames the truth and three models.
  EXPECT_EQ(study_plots(study_).size(), 5u);
  EXPECT_EQ(count_of(html, "<img "), 5u + 2u * 4u);
  EXPECT_EQ(count_of(html, "src=\"data:image/png;base64,iVBORw0KGgo"), 13u);  // PNG's signature
  EXPECT_EQ(count_of(html, "src="), 13u);                                     // and nothing from outside
  EXPECT_EQ(count_of(html, "href="), 0u);
  EXPECT_NE(html.find("a &lt;clip&gt; &amp; more.mp4"), std::string::npos);
  EXPECT_NE(html.find("20.50 &plusmn;0.50"), std::string::npos);
  EXPECT_NE(html.find("12 % of the picture"), std::string::npos);
  EXPECT_EQ(html.find("<th>SSIM</th>"), std::string::npos);  // of no model
  EXPECT_NE(html.find("<th>landmarks, px</th>"), std::string::npos);
}

TEST_F(ModelReport, TablesHoldEveryTraining) {
  std::istringstream csv(models_csv(study_));
  std::string header, line;
  ASSERT_TRUE(std::getline(csv, header));
  int lines = 0;
  for (; std::getline(csv, line); ++lines) EXPECT_EQ(count_of(line, ","), count_of(header, ",")) << line;
  EXPECT_EQ(lines, 6);
  const auto json = nlohmann::json::parse(models_json(study_));
  EXPECT_EQ(json.at("rows").at(1).at("kind"), "mlp");
  EXPECT_EQ(json.at("rows").at(1).at("scores").at(1).at("seed"), 1);
  EXPECT_TRUE(json.at("rows").at(0).at("scores").at(0).at("lmk_error_px").is_null());
  EXPECT_EQ(json.at("rows").at(0).at("scores").at(0).at("marks").size(), 2u);
}

TEST_F(ModelReport, ATableHasARowForEachModelWithMeanAndSpread) {
  study_.rows.back().failed = "too few rays", study_.rows.back().scores.clear();
  const std::vector<Table> tables = models_tables(study_);
  ASSERT_GE(tables.size(), 2u);
  EXPECT_EQ(tables[0].name, "models");
  EXPECT_EQ(tables[0].rows.size(), 2u);  // the long baseline stands in another
  const std::string text = tables_text(tables);
  EXPECT_NE(text.find("20.50 ±0.50"), std::string::npos) << text;
  EXPECT_NE(text.find("preview"), std::string::npos) << text;  // what its pictures cost
  study_.tables = {study_tables()[1]};
  const Table time = models_tables(study_).front();
  ASSERT_EQ(time.notes.size(), 1u);
  EXPECT_EQ(time.notes[0], std::string(kLongBaseline) + " not trained: too few rays");
}

// What a window shows of it is read back from the folder.
TEST_F(ModelReport, ItsSummaryIsReadBack) {
  const auto none = read_study_summary(folder_);
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().code, ErrorCode::not_found);
  ASSERT_TRUE(write_model_report(study_, folder_).ok());
  const auto summary = read_study_summary(folder_);
  ASSERT_TRUE(summary.ok()) << summary.error().what;
  EXPECT_EQ(summary->clip, study_.clip);
  EXPECT_EQ(summary->frames, 3);
  EXPECT_EQ(summary->page, folder_ / "report.html");
  ASSERT_EQ(summary->tables.size(), 1u);
  EXPECT_EQ(summary->tables[0].title, study_.tables[0].title);
  ASSERT_EQ(summary->tables[0].rows.size(), 2u);  // of that table's models, two were trained
  const SummaryRow& row = summary->tables[0].rows[0];
  const ModelRow* own = find_row(study_, row.name);
  ASSERT_NE(own, nullptr);
  EXPECT_EQ(row.seeds, 2);
  EXPECT_FALSE(row.psnr_db.has_value());
  EXPECT_DOUBLE_EQ(*row.head_db, (own->scores[0].psnr_head_db + own->scores[1].psnr_head_db) / 2);
  EXPECT_DOUBLE_EQ(*row.head_spread_db, 0.5);
  EXPECT_DOUBLE_EQ(row.train_seconds, own->scores[0].train_seconds);
  EXPECT_NEAR(row.frames_per_second, 1 / own->scores[0].frame_seconds, 1e-9);
  ASSERT_EQ(summary->plots.size(), study_plots(study_).size());
  for (const SummaryPlot& plot : summary->plots) EXPECT_TRUE(fs::exists(plot.file)) << plot.file;
  // A damaged one says what to do.
  ASSERT_TRUE(write_text(folder_ / "results.json", "{").ok());
  const auto damaged = read_study_summary(folder_);
  ASSERT_FALSE(damaged.ok());
  EXPECT_EQ(damaged.error().code, ErrorCode::bad_input);
  EXPECT_FALSE(damaged.error().fix.empty());
}

TEST_F(ModelReport, TheStepsItTookCanBeTakenAgain) {
  ASSERT_TRUE(write_model_report(study_, folder_).ok());
  const auto steps = read_study_steps(folder_ / "results.json");
  ASSERT_TRUE(steps.ok()) << steps.error().what;
  EXPECT_EQ(steps->size(), 6u);
  EXPECT_EQ(steps->at({kLongBaseline, 1}), 50u);
  ASSERT_TRUE(write_text(folder_ / "other.json", "{\"format\": \"another\"}").ok());
  EXPECT_FALSE(read_study_steps(folder_ / "other.json").ok());
  EXPECT_FALSE(read_study_steps(folder_ / "absent.json").ok());
}

TEST_F(ModelReport, RatiosAreOfTheRowsTheyName) {
  // Heads of 20.5, 22.5 and 24.5 dB: ours does not reach the baseline's long training.
  const auto r = study_ratios(study_);
  ASSERT_TRUE(r);
  EXPECT_DOUBLE_EQ(r->equal_time_db, -2);
  EXPECT_DOUBLE_EQ(r->equal_seconds, 9);
  EXPECT_DOUBLE_EQ(r->times_longer, kBaselineShare);
  EXPECT_EQ(r->sooner, "");
  EXPECT_DOUBLE_EQ(r->times_faster, 100);
  EXPECT_DOUBLE_EQ(r->times_faster_full.value_or(0), 100);
  for (ModelScore& s : study_.rows[0].scores) s.psnr_head_db += 10;
  const auto better = study_ratios(study_);
  EXPECT_EQ(better->sooner, kDefaultModel);
  EXPECT_DOUBLE_EQ(better->times_sooner, kBaselineShare);
  study_.rows.pop_back();
  EXPECT_FALSE(study_ratios(study_));
}

TEST_F(ModelReport, AModelThatCouldNotBeTrainedIsNamedWithItsReason) {
  ModelRow failed{study_models().front(), {}, {}};
  failed.failed = "No <ray> meets the head.";
  study_.tables.front().models.push_back(failed.spec.name);
  study_.rows.push_back(failed);
  ASSERT_TRUE(write_model_report(study_, folder_).ok());
  const auto page = read_text(folder_ / "report.html");
  ASSERT_TRUE(page.ok());
  EXPECT_NE(page->find("Not trained: No &lt;ray&gt; meets the head."), std::string::npos);
  const auto summary = read_study_summary(folder_);
  ASSERT_TRUE(summary.ok()) << summary.error().what;
  const auto& rows = summary->tables.front().rows;
  const auto row = std::ranges::find(rows, failed.spec.name, &SummaryRow::name);
  ASSERT_NE(row, rows.end());
  EXPECT_EQ(row->failed, failed.failed);
  EXPECT_FALSE(row->head_db);
  EXPECT_TRUE(study_ratios(study_)) << "the other rows stay comparable";
}

TEST_F(ModelReport, TheFrontLeavesOutWhatIsBothSlowerAndWorse) {
  const auto plots = study_plots(study_);
  const auto front = std::ranges::find(plots, "qualities.png", &StudyPlot::file);
  ASSERT_NE(front, plots.end());
  EXPECT_EQ(front->plot.series.at(0).points, (std::vector<Vec2d>{{50, 19}, {25, 20}}));
  const auto seconds = std::ranges::find(plots, "psnr_over_seconds.png", &StudyPlot::file);
  ASSERT_NE(seconds, plots.end());
  EXPECT_EQ(seconds->plot.series.size(), 3u);
  EXPECT_EQ(seconds->plot.series[0].points.size(), 2u);
}

TEST_F(ModelReport, AMissingPictureIsSaid) {
  fs::remove(folder_ / study_.truths[0]);
  EXPECT_FALSE(write_model_report(study_, folder_).ok());
}

TEST(StudyTables, NameModelsThatThereAre) {
  for (const StudyTable& table : study_tables())
    for (const auto* names : {&table.models, &table.more})
      for (const std::string& name : *names)
        EXPECT_EQ(std::ranges::count(study_models(), name, &ModelSpec::name), 1) << name;
  for (const ModelSpec& spec : study_models())
    EXPECT_TRUE(std::ranges::any_of(study_tables(), [&](const StudyTable& t) {
      return std::ranges::count(t.models, spec.name) + std::ranges::count(t.more, spec.name) == 1;
    })) << spec.name;
}

}  // namespace
}  // namespace likeness
