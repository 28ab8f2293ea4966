// Claims about the table of choices: each row is kept in project.json, refused by name where it is wrong, and
// whole enough for the command line and the studio.
#include "core/project/option_table.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/project/option_text.h"
#include "core/project/project.h"
#include "tests/core/project/other_choice.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class OptionTable : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_options_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    const auto made = open_or_create_project(root_ / "p", {.shared = {.video = root_ / "clip.mp4"}});
    ASSERT_TRUE(made.ok()) << made.error().what;
    project_ = *made;
    stored_ = json::parse(*read_text(root_ / "p" / "project.json"));
  }
  void TearDown() override { fs::remove_all(root_); }

  // The project with another object of options in its file.
  Result<Project> opened_with(const json& options) {
    json changed = stored_;
    changed["options"] = options;
    EXPECT_TRUE(write_text(root_ / "p" / "project.json", changed.dump()).ok());
    return open_project(root_ / "p");
  }

  void expect_refused(const OptionRow& row, const json& value, const std::string& named) {
    json options = stored_["options"];
    options[row.key] = value;
    const auto opened = opened_with(options);
    ASSERT_FALSE(opened.ok()) << row.key << " = " << value;
    EXPECT_EQ(opened.error().code, ErrorCode::bad_input);
    EXPECT_NE(opened.error().what.find(std::string("its ") + row.key + " is " + value.dump() + ","),
              std::string::npos)
        << opened.error().what;
    EXPECT_NE(opened.error().what.find(named), std::string::npos) << opened.error().what;
    EXPECT_NE(opened.error().fix.find("likeness repair"), std::string::npos) << opened.error().fix;
  }

  fs::path root_;
  Project project_;
  json stored_;
};

bool is_number(const OptionRow& row) {
  return std::holds_alternative<OptionMember<int>>(row.member) ||
         std::holds_alternative<OptionMember<double>>(row.member) ||
         std::holds_alternative<OptionMember<std::uint64_t>>(row.member);
}

double number_of(const OptionRow& row, const ProjectOptions& options) {
  return with_option(row, options, [](const auto& value) -> double {
    if constexpr (std::is_arithmetic_v<std::remove_cvref_t<decltype(value)>>) return double(value);
    return NAN;
  });
}

TEST_F(OptionTable, HasEachKeyOfProjectJsonOnce) {
  std::set<std::string> keys, flags;
  for (const OptionRow& row : option_table()) {
    EXPECT_TRUE(keys.insert(row.key).second) << row.key;
    if (*row.flag == '\0') continue;
    EXPECT_TRUE(flags.insert(row.flag).second) << row.flag;
  }
  EXPECT_TRUE(keys.insert("mode_asked").second);  // the mode's second key
  std::set<std::string> stored;
  for (const auto& [key, value] : stored_["options"].items()) stored.insert(key);
  EXPECT_EQ(stored, keys);
}

TEST_F(OptionTable, EachChoiceIsKeptInProjectJsonUnderItsKey) {
  ProjectOptions all = project_.options;
  for (const OptionRow& row : option_table()) {
    Project one = project_;
    test::choose_other(row, one.options, root_ / "other");
    test::choose_other(row, all, root_ / "other");
    ASSERT_NE(one.options, project_.options) << row.key;
    ASSERT_TRUE(save_project(one).ok());
    const json written = json::parse(*read_text(root_ / "p" / "project.json"));
    for (const auto& [key, value] : written["options"].items())
      EXPECT_EQ(value != stored_["options"][key],
                key == row.key || (key == "mode_asked" && std::string(row.key) == "mode"))
          << row.key << ": " << key;
    const auto opened = open_project(root_ / "p");
    ASSERT_TRUE(opened.ok()) << opened.error().what;
    EXPECT_EQ(opened->options, one.options) << row.key;
    ProjectOptions copied = project_.options;
    copy_option(row, one.options, copied);
    EXPECT_EQ(copied, one.options) << row.key;
  }
  project_.options = all;
  ASSERT_TRUE(save_project(project_).ok());
  const auto opened = open_project(root_ / "p");
  ASSERT_TRUE(opened.ok()) << opened.error().what;
  EXPECT_EQ(opened->options, all);
}

TEST_F(OptionTable, AMissingKeyIsTheDefaultOrDamage) {
  for (const OptionRow& row : option_table()) {
    json options = stored_["options"];
    options.erase(row.key);
    const auto opened = opened_with(options);
    EXPECT_EQ(opened.ok(), !row.in_every_project) << row.key;
    if (opened)
      EXPECT_EQ(opened->options, project_.options) << row.key;
    else
      EXPECT_NE(opened.error().what.find(std::string("its ") + row.key + " is missing"), std::string::npos)
          << opened.error().what;
  }
  EXPECT_FALSE(opened_with(json::array()).ok());
}

TEST_F(OptionTable, AValueOfAnotherKindIsRefusedByName) {
  for (const OptionRow& row : option_table()) expect_refused(row, {{"a", 1}}, option_domain(row));
  expect_refused(option_row("split"), "tale", "tail, views, random30 or sides");
  expect_refused(option_row("mode"), "guess", "static, concat, hyper, warp or warp+hyper");
  expect_refused(option_row("use_latent"), 1, "true or false");
  expect_refused(option_row("video"), 7, "a path");
  expect_refused(option_row("left_out"), "3", "a list of frames");
  expect_refused(option_row("refits"), json::array({4}), "spans");
}

TEST_F(OptionTable, ANumberOutsideItsRangeIsRefusedByName) {
  for (const OptionRow& row : option_table()) {
    if (!is_number(row)) continue;
    const auto& [low, high, or_zero] = row.range;
    EXPECT_TRUE(is_in_range(row, number_of(row, {}))) << row.key << ": its default";
    EXPECT_TRUE(is_in_range(row, low)) << row.key;
    const double below = low > 0 ? low / 2 : -1;
    EXPECT_FALSE(is_in_range(row, below)) << row.key;
    EXPECT_FALSE(is_in_range(row, NAN)) << row.key;
    EXPECT_FALSE(is_in_range(row, INFINITY)) << row.key;
    EXPECT_EQ(is_in_range(row, 0), or_zero || low == 0) << row.key;
    expect_refused(row, below, option_domain(row));
    if (std::isinf(high)) continue;
    EXPECT_TRUE(is_in_range(row, high)) << row.key;
    expect_refused(row, 2 * high, option_domain(row));
    json options = stored_["options"];
    options[row.key] = high;
    const auto opened = opened_with(options);
    ASSERT_TRUE(opened.ok()) << opened.error().what;
    EXPECT_EQ(number_of(row, opened->options), high) << row.key;
  }
  expect_refused(option_row("steps"), 1e300, "steps");
}

TEST_F(OptionTable, EachFlagHasWordsAndAVerb) {
  for (const OptionRow& row : option_table()) {
    const auto& [build, import, align, fit, train] = row.verbs;
    const bool has_flag = *row.flag != '\0';
    EXPECT_EQ(build || import || align || fit || train, has_flag) << row.key;
    EXPECT_EQ(*row.help != '\0', has_flag) << row.key;
    EXPECT_EQ(std::string_view(row.flag).starts_with("--"), has_flag) << row.key;
  }
}

TEST_F(OptionTable, WhatIsOfferedCanBeChosen) {
  int fields = 0;
  for (const OptionRow& row : option_table()) {
    for (const int choice : row.choices) EXPECT_TRUE(is_in_range(row, choice)) << row.key;
    EXPECT_EQ(row.studio.offered.empty(), *row.studio.label == '\0') << row.key;
    if (row.studio.offered.empty()) continue;
    ++fields;
    EXPECT_NE(*row.studio.hint, '\0') << row.key;
    EXPECT_NE(*row.studio.unit, '\0') << row.key;
    EXPECT_TRUE(std::ranges::count(row.studio.offered, number_of(row, {}))) << row.key << ": its default";
    for (const double value : row.studio.offered) {
      EXPECT_TRUE(is_in_range(row, value)) << row.key;
      EXPECT_TRUE(row.choices.empty() || std::ranges::count(row.choices, int(value))) << row.key;
    }
  }
  EXPECT_EQ(fields, 2);
}

TEST_F(OptionTable, WhatIsKeptWithTheClipIsTakenBackByItsWord) {
  int kept = 0;
  for (const OptionRow& row : option_table()) {
    if (!row.kept_with_clip) continue;
    ++kept;
    ProjectOptions options = project_.options;
    test::choose_other(row, options, root_ / "other");
    ASSERT_NE(options, project_.options) << row.key;
    ASSERT_TRUE(read_option_words(row, row.taken_back, options).ok()) << row.key;
    EXPECT_EQ(options, project_.options) << row.key;
  }
  EXPECT_EQ(kept, 5);
  EXPECT_STREQ(option_row("rest_frames").taken_back, "auto");
  EXPECT_STREQ(option_row("left_out").taken_back, "none");
}

TEST_F(OptionTable, FramesAndSpansAreReadFromWords) {
  ProjectOptions options;
  const OptionRow &left_out = option_row("left_out"), &refits = option_row("refits");
  ASSERT_TRUE(read_option_words(left_out, "12,40-42,41", options).ok());
  EXPECT_EQ(options.train.left_out, (std::vector<int>{12, 40, 41, 42}));
  ASSERT_TRUE(read_option_words(left_out, "7", options).ok());  // instead of those before
  EXPECT_EQ(options.train.left_out, std::vector<int>{7});
  ASSERT_TRUE(read_option_words(refits, "190-204", options).ok());
  ASSERT_TRUE(read_option_words(refits, "12,40-60", options).ok());  // beside those before
  EXPECT_EQ(options.fit.refits, (std::vector<RefitSpan>{{12, 12}, {40, 60}, {190, 204}}));
  ASSERT_TRUE(read_option_words(option_row("identity"), "/a/shape.npy", options).ok());
  EXPECT_EQ(options.fit.identity, "/a/shape.npy");
  const ProjectOptions before = options;
  for (const OptionRow* row : {&left_out, &refits})
    for (const char* wrong : {"", "a", "3-", "5-3", "1,,2", "1,", "-4", "1 2", "99999999"}) {
      const auto read = read_option_words(*row, wrong, options);
      ASSERT_FALSE(read.ok()) << wrong;
      EXPECT_NE(read.error().what.find(wrong), std::string::npos);
      EXPECT_NE(read.error().fix.find(row->flag), std::string::npos) << read.error().fix;
      EXPECT_EQ(options, before) << wrong;
    }
}

}  // namespace
}  // namespace likeness
