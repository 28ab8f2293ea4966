// Claims about project.json files of earlier versions, kept in data/: they open as they did, and nothing in
// them is stale. In a kept file @FOLDER@ stands for the folder of the clip and of what else it names.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <string>

#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/project/staleness.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class KeptProjects : public testing::Test {
 protected:
  // The files whose content the kept hashes were taken of.
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_kept_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    if (const char* set = ::getenv("LIKENESS_NETWORKS")) networks_before_ = set;
    ::setenv("LIKENESS_NETWORKS", (root_ / "no networks").c_str(), 1);
    for (const auto& [file, text] : {std::pair("clip.mp4", "the clip"),
                                     {"head.npz", "a head model"},
                                     {"landmarks.dat", "a landmark model"},
                                     {"matting.onnx", "a network"},
                                     {"identity.npy", "a shape"},
                                     {"maps/000360.npy", "a map"}})
      ASSERT_TRUE(write_text(root_ / file, text).ok());
    for (const char* file : {"capture.json", "cameras.json", "track.json", "frames/000000.png",
                             "masks/000000.png", "plate.png", "avatar.bin"})
      ASSERT_TRUE(write_text(root_ / "p" / file, file).ok());
  }
  void TearDown() override {
    networks_before_.empty() ? ::unsetenv("LIKENESS_NETWORKS")
                             : ::setenv("LIKENESS_NETWORKS", networks_before_.c_str(), 1);
    fs::remove_all(root_);
  }

  // A kept file as it would stand in this folder.
  std::string text_of(const std::string& kept) const {
    const auto text = read_text(fs::path(LIKENESS_SOURCE) / "tests/core/project/data" / (kept + ".json"));
    EXPECT_TRUE(text.ok()) << text.error().what;
    std::string here = text ? *text : "";
    const std::string folder = "@FOLDER@";
    for (std::size_t at = 0; (at = here.find(folder, at)) != std::string::npos;)
      here.replace(at, folder.size(), root_.string());
    return here;
  }

  Project open(const std::string& text) const {
    EXPECT_TRUE(write_text(root_ / "p" / "project.json", text).ok());
    const auto opened = open_project(root_ / "p");
    EXPECT_TRUE(opened.ok()) << opened.error().what;
    return opened ? *opened : Project{};
  }

  // The hashes in the file are those that the version computed which wrote it.
  static void expect_current(const Project& project) {
    for (const Stage stage : kStages) {
      EXPECT_EQ(project.record(stage).input_hash.size(), 32u) << stage_name(stage);
      EXPECT_EQ(input_hash(project, stage), project.record(stage).input_hash) << stage_name(stage);
      EXPECT_EQ(project.record(stage).state, StageState::done);
    }
  }

  // Every choice of version2_all.json, none of them the default.
  ProjectOptions all_choices() const {
    ProjectOptions o;
    o.shared = {root_ / "clip.mp4", root_ / "head.npz", root_ / "landmarks.dat", 7};
    o.import = {512, Split::views};
    o.align = {CameraKind::resting, 51.5};
    o.fit = {root_ / "identity.npy", root_ / "maps", {{4, 9}, {20, 22}}, {2, 9}};
    o.matte = {root_ / "matting.onnx"};
    o.train = {.budget_s = 52.5,
               .full_budget_s = 600,
               .steps = 1200,
               .checkpoint_every_s = 5,
               .mode = FieldMode::concat,
               .use_latent = false,
               .use_occupancy = false,
               .refine_track = true,
               .landmark_loss = 0.1,
               .use_proxies = false,
               .left_out = {3, 5}};
    return o;
  }

  fs::path root_;
  std::string networks_before_;
};

TEST_F(KeptProjects, OfTheUsualOptionsIsCurrentAndWrittenTheSame) {
  const std::string text = text_of("version2_plain");
  const Project project = open(text);
  EXPECT_EQ(project.options, (ProjectOptions{.shared = {.video = root_ / "clip.mp4"}}));
  expect_current(project);
  EXPECT_EQ(first_track_hash(project), project.record(Stage::fit).track_inputs);
  ASSERT_TRUE(save_project(project).ok());
  // But for choices that there were not yet.
  auto kept = nlohmann::json::parse(text);
  kept["options"]["person_network"] = "";
  kept["options"]["from_s"] = kept["options"]["to_s"] = 0.0;
  kept["options"]["inside_deg"] = 10.0, kept["options"]["beyond_deg"] = 20.0;
  kept["options"]["use_proxies"] = true;
  EXPECT_EQ(nlohmann::json::parse(*read_text(root_ / "p" / "project.json")), kept);
}

TEST_F(KeptProjects, OfOtherOptionsIsCurrentAndWrittenTheSame) {
  const std::string text = text_of("version2_all");
  const Project project = open(text);
  EXPECT_EQ(project.options, all_choices());
  EXPECT_EQ(project.consent, Consent::given);
  EXPECT_EQ(project.further_clips, std::vector<int>{2});
  expect_current(project);
  EXPECT_EQ(first_track_hash(project), project.record(Stage::fit).track_inputs);
  ASSERT_TRUE(save_project(project).ok());
  // Spans that touch are stored as one.
  auto written = nlohmann::json::parse(*read_text(root_ / "p" / "project.json")),
       kept = nlohmann::json::parse(text);
  EXPECT_EQ(written["options"]["refits"], nlohmann::json::parse("[[4, 9], [20, 22]]"));
  kept["options"]["refits"] = written["options"]["refits"];
  // There were no such choices.
  kept["options"]["person_network"] = "";
  kept["options"]["from_s"] = kept["options"]["to_s"] = 0.0;
  kept["options"]["inside_deg"] = 10.0, kept["options"]["beyond_deg"] = 20.0;
  EXPECT_EQ(written, kept);
}

TEST_F(KeptProjects, OfVersionOneIsCurrentAndItsSwitchesAreTheMode) {
  const Project project = open(text_of("version1"));
  ProjectOptions expected;
  expected.shared = {root_ / "clip.mp4", root_ / "head.npz", {}, 7};
  expected.import.size = 512;
  expected.align.camera = CameraKind::resting;
  expected.matte.matting_network = root_ / "matting.onnx";
  expected.train.budget_s = 120;
  expected.train.mode = FieldMode::warp;
  expected.train.left_out = {3, 5};
  EXPECT_EQ(project.options, expected);
  EXPECT_EQ(project.consent, Consent::own);
  EXPECT_EQ(project.record(Stage::align).message, "The camera rests.");
  expect_current(project);
  ASSERT_TRUE(save_project(project).ok());
  const auto again = open_project(root_ / "p");
  ASSERT_TRUE(again.ok()) << again.error().what;
  EXPECT_EQ(again->options, expected);
  expect_current(*again);
}

TEST_F(KeptProjects, WithKeysOfALaterVersionOpens) {
  auto later = nlohmann::json::parse(text_of("version2_all"));
  later["options"]["sharpness"] = {{"amount", 1}};
  later["colour"] = "blue";
  const Project project = open(later.dump());
  EXPECT_EQ(project.options, all_choices());
  expect_current(project);
}

}  // namespace
}  // namespace likeness
