// Claims about tables: the same figures as text, CSV and JSON.
#include "core/base/table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/base/files.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

Table heads() {
  Table table{.name = "heads", .title = "Heads", .columns = {{"model", "model"}, {"psnr_db", "full", 2}}};
  table.columns.push_back({"steps", "steps", 0});
  table.columns.push_back({"hidden_px", "", 1});
  table.rows = {{"one, \"two\"", 31.8649, 400, 1.25}, {"three", std::optional<double>(), 1200, NAN}};
  table.notes = {"dB on held-out frames"};
  return table;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST(Table, PrintsWordsToTheLeftAndNumbersToTheRight) {
  const Table table = heads();
  EXPECT_EQ(lines_of(tables_text({&table, 1})),
            (std::vector<std::string>{"Heads", "model        full  steps", "one, \"two\"  31.86    400",
                                      "three           -   1200", "dB on held-out frames"}));
}

TEST(Table, AlignsLettersOfSeveralBytes) {
  Table table{.name = "turns", .columns = {{"step", "step"}, {"turn_deg", "turn, °"}, {"db", "dB"}}};
  table.rows = {{"größer", 0.45, std::optional(Spread{31.5, 0.25})},
                {"x", 12.0, std::optional(Spread{9, 0})}};
  EXPECT_EQ(lines_of(tables_text({&table, 1})),
            (std::vector<std::string>{"step    turn, °           dB", "größer     0.45  31.50 ±0.25",
                                      "x         12.00   9.00 ±0.00"}));
}

TEST(Table, PrintsSmallErrorsInPowersOfTen) {
  Table table{.name = "errors", .columns = {{"outputs", "outputs", -1}}};
  table.rows = {{1.64e-6}};
  EXPECT_EQ(lines_of(tables_text({&table, 1})), (std::vector<std::string>{"outputs", "1.6e-06"}));
}

TEST(Table, CsvHoldsEveryDigitAndQuotesWhatNeedsIt) {
  const Table table = heads();
  EXPECT_EQ(tables_csv({&table, 1}),
            "model,psnr_db,steps,hidden_px\n\"one, \"\"two\"\"\",31.8649,400,1.25\nthree,,1200,\n");
}

TEST(Table, JsonHoldsTheSameFiguresAndNullForNothing) {
  const Table table = heads();
  const auto json = nlohmann::json::parse(tables_json({&table, 1}));
  ASSERT_EQ(json.at("heads").size(), 2u);
  EXPECT_EQ(json["heads"][0]["model"], "one, \"two\"");
  EXPECT_EQ(json["heads"][0]["psnr_db"], 31.8649);
  EXPECT_EQ(json["heads"][0]["steps"], 400);
  EXPECT_TRUE(json["heads"][1]["psnr_db"].is_null());
  EXPECT_TRUE(json["heads"][1]["hidden_px"].is_null());
}

TEST(Table, ASpreadIsTwoColumnsInFiles) {
  Table table{.name = "t", .columns = {{"model", "model"}, {"db", "dB"}, {"wrong", "wrong"}}};
  table.rows = {{"a", std::optional(Spread{31.5, 0.25}), std::vector<int>{4, 9}},
                {"b", std::optional<Spread>(), std::vector<int>{}},
                {"c", 7.0, std::vector<int>{1}}};
  EXPECT_EQ(tables_csv({&table, 1}), "model,db,db_half_range,wrong\na,31.5,0.25,4 9\nb,,,\nc,7,,1\n");
  const auto json = nlohmann::json::parse(tables_json({&table, 1}));
  EXPECT_EQ(json["t"][0]["db_half_range"], 0.25);
  EXPECT_EQ(json["t"][0]["wrong"], (std::vector<int>{4, 9}));
  EXPECT_TRUE(json["t"][1]["db"].is_null());
  EXPECT_EQ(json["t"][2]["db"], 7);
  EXPECT_THAT(tables_text({&table, 1}), HasSubstr("none"));
}

TEST(Table, AnySpecialLetterIsReadBackFromJson) {
  Table table{.name = "t", .columns = {{"words", "words"}}};
  const std::string words = "a\"b\\c\nd\te\x01 ü";
  table.rows = {{words}};
  EXPECT_EQ(nlohmann::json::parse(tables_json({&table, 1}))["t"][0]["words"], words);
}

TEST(Table, SpreadIsMeanAndHalfTheRangeAndNothingWhereAValueIsMissing) {
  const std::vector<std::optional<double>> three{1.0, 4.0, 2.5};
  const auto spread = spread_of(three);
  ASSERT_TRUE(spread.has_value());
  EXPECT_DOUBLE_EQ(spread->mean, 2.5);
  EXPECT_DOUBLE_EQ(spread->half_range, 1.5);
  EXPECT_FALSE(spread_of(std::vector<std::optional<double>>{1.0, std::nullopt}));
  EXPECT_FALSE(spread_of(std::vector<std::optional<double>>{1.0, INFINITY}));
  EXPECT_FALSE(spread_of({}));
}

TEST(Table, SeveralStandOneAfterTheOtherAndHiddenOnesAreInFilesAlone) {
  std::vector<Table> tables{heads(), heads()};
  tables[1].name = "more", tables[1].title = "More", tables[1].printed = false;
  EXPECT_THAT(tables_text(tables), Not(HasSubstr("More")));
  const auto json = nlohmann::json::parse(tables_json(tables));
  EXPECT_EQ(json.at("heads"), json.at("more"));
  EXPECT_THAT(tables_csv(tables), HasSubstr("\n\nmodel,"));
}

TEST(Table, FilesAreWrittenWholeOrNotAtAll) {
  std::string name = (fs::temp_directory_path() / "likeness_table_XXXXXX").string();
  ASSERT_NE(::mkdtemp(name.data()), nullptr);
  const fs::path folder = fs::path(name) / "new";
  const Table table = heads();
  ASSERT_TRUE(write_tables(folder, {&table, 1}).ok());
  EXPECT_EQ(*read_text(folder / "heads.csv"), tables_csv({&table, 1}));
  EXPECT_EQ(*read_text(folder / "tables.json"), tables_json({&table, 1}));
  std::ofstream(fs::path(name) / "file") << "keep";
  EXPECT_FALSE(write_tables(fs::path(name) / "file", {&table, 1}).ok());
  EXPECT_EQ(*read_text(fs::path(name) / "file"), "keep");
  fs::remove_all(name);
}

}  // namespace
}  // namespace likeness
