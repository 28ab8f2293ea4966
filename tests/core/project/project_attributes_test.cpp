// Claims about a project's painted attributes: their file, what may be painted, that only the training
// becomes stale by them, and the values' file.
#include "core/project/project_attributes.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <fmt/format.h>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/project/own_names.h"
#include "core/project/staleness.h"
#include "core/scene/track.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class ProjectAttributes : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_attributes_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    ASSERT_TRUE(write_text(root_ / "clip.mp4", "the clip").ok());
    ProjectOptions options;
    options.shared.video = root_ / "clip.mp4";
    options.train.left_out = {2};
    auto made = open_or_create_project(root_ / "me.likeness", options);
    ASSERT_TRUE(made.ok()) << made.error().what;
    project_ = *made;
    Capture capture;
    capture.width = capture.height = 64, capture.crop = {0, 0, 64}, capture.frames_per_second = 25;
    for (int i = 0; i < 5; ++i)
      capture.frames.push_back({i, i / 25.0, 100, i == 4, i < 3, i == 3 ? "Blurred." : ""});
    ASSERT_TRUE(write_capture(capture_path(project_), capture).ok());
  }
  void TearDown() override { fs::remove_all(root_); }
  fs::path root_;
  Project project_;
};

TEST_F(ProjectAttributes, AreAFileThatGoesWithTheLastOne) {
  EXPECT_TRUE(read_project_attributes(project_)->empty());
  EXPECT_TRUE(attributes_hash(project_).empty());
  std::vector<std::string> before;
  for (const Stage stage : kStages) before.push_back(input_hash(project_, stage));
  PaintedAttributes attributes;
  annotate(attributes, "dimple", {1, 1, {{StrokeMark::person, 3, {{5, 5}}}}});
  ASSERT_TRUE(save_project_attributes(project_, attributes).ok());
  EXPECT_EQ(*read_project_attributes(project_), attributes);
  for (const Stage stage : kStages) {
    const bool same = input_hash(project_, stage) == before[std::size_t(stage)];
    EXPECT_EQ(same, stage != Stage::train) << stage_name(stage);
  }
  EXPECT_TRUE(is_attributes_file("attributes.json"));
  const auto aside = set_aside_attributes(project_);
  ASSERT_TRUE(aside.ok());
  EXPECT_TRUE(is_attributes_file(aside->filename().string()));
  EXPECT_EQ(*read_attributes(*aside), attributes);
  ASSERT_TRUE(save_project_attributes(project_, attributes).ok());
  EXPECT_NE(set_aside_attributes(project_)->filename(), aside->filename());
  EXPECT_FALSE(is_attributes_file("attribute.json"));
  ASSERT_TRUE(save_project_attributes(project_, attributes).ok());
  take_back(attributes, "dimple");
  ASSERT_TRUE(save_project_attributes(project_, attributes).ok());
  EXPECT_FALSE(fs::exists(attributes_path(project_)));
  for (const Stage stage : kStages) EXPECT_EQ(input_hash(project_, stage), before[std::size_t(stage)]);
}

TEST_F(ProjectAttributes, OnlyFramesThatTrainArePainted) {
  const auto why = [&](int frame, double value = 1, const char* name = "dimple") {
    const auto fine = check_annotation(project_, name, {frame, value, {}});
    return fine ? std::string("fine") : fine.error().what;
  };
  EXPECT_EQ(why(1), "fine");
  EXPECT_NE(why(4).find("held out"), std::string::npos);
  EXPECT_NE(why(3).find("nothing is learnt"), std::string::npos);
  EXPECT_NE(why(2).find("nothing is learnt"), std::string::npos) << "left out by hand";
  EXPECT_NE(why(77).find("does not hold"), std::string::npos);
  EXPECT_NE(why(1, 1.2).find("1.2"), std::string::npos);
  EXPECT_NE(why(1, 1, "jawOpen").find("action"), std::string::npos);
  EXPECT_NE(why(1, 1, "a=b").find("name"), std::string::npos);
}

TEST_F(ProjectAttributes, ValuesComeBackAndADamagedFileIsRefused) {
  AttributeCourse course{"dimple", {3, 8, 9}, {0, 0.5f, -1}, {0, 0.3f, 1}, {1, 0, 0}, 1, 2, 0.25, 1};
  const fs::path path = attribute_values_path(project_);
  ASSERT_TRUE(write_attribute_values(path, {&course, 1}).ok());
  const auto read = read_attribute_values(path);
  ASSERT_TRUE(read.ok()) << read.error().what;
  ASSERT_EQ(read->size(), 1u);
  EXPECT_EQ(read->front().name, course.name);
  EXPECT_EQ(read->front().frames, course.frames);
  EXPECT_EQ(read->front().values, course.values);
  EXPECT_EQ(read->front().doubts, course.doubts);
  EXPECT_NE(course_words(course).find("1 of 3 frames look like none"), std::string::npos);

  Avatar avatar;
  avatar.attributes.resize(2);
  avatar.attributes[0].name = "other", avatar.attributes[1].name = "dimple";
  EXPECT_EQ(frame_amounts(avatar, *read, 9), (std::vector<float>{0, -1}));
  EXPECT_EQ(frame_amounts(avatar, *read, 4), (std::vector<float>{0, 0}));
  EXPECT_TRUE(frame_amounts(Avatar(), *read, 9).empty());

  const std::string whole = *read_text(path);
  for (std::size_t length = 0; length + 2 < whole.size(); length += 7) {
    ASSERT_TRUE(write_text(path, whole.substr(0, length)).ok());
    EXPECT_FALSE(read_attribute_values(path).ok()) << length;
  }
  const auto refused = [&](const std::string& part, const std::string& by) {
    std::string text = whole;
    const std::size_t at = text.find(part);
    EXPECT_NE(at, std::string::npos) << part;
    EXPECT_TRUE(write_text(path, text.replace(at, part.size(), by)).ok());
    const auto again = read_attribute_values(path);
    return again ? std::string("nothing") : again.error().what;
  };
  EXPECT_NE(refused("\"version\": 1", "\"version\": 2").find("newer"), std::string::npos);
  EXPECT_NE(refused("\"version\": 1", "\"version\": 0").find("damaged"), std::string::npos);
  for (const char* number : {"0.5", "0.30000001192092896"})  // a value, and a doubt
    EXPECT_NE(refused(number, "1e39").find("damaged"), std::string::npos)
        << "infinite as a float: " << number;
  course.values.pop_back();
  ASSERT_TRUE(write_attribute_values(path, {&course, 1}).ok());
  EXPECT_FALSE(read_attribute_values(path).ok());
}

}  // namespace
}  // namespace likeness
