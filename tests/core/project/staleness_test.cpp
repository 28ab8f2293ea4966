// Claims about what makes a stage's result stale: every option, one by one, and nothing else.
#include "core/project/staleness.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/project/option_table.h"
#include "core/project/stage_inputs.h"
#include "core/project/training_options.h"
#include "core/train/checkpoint.h"
#include "core/video/decode.h"
#include "tests/core/project/other_choice.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

// A project whose stages have all come to their end.
class Staleness : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_staleness_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    if (const char* set = ::getenv("LIKENESS_NETWORKS")) networks_before_ = set;
    ASSERT_TRUE(write_text(root_ / "networks" / "README", "none installed").ok());
    ::setenv("LIKENESS_NETWORKS", (root_ / "networks").c_str(), 1);
    ASSERT_TRUE(write_text(root_ / "clip.mp4", "the clip").ok());
    ASSERT_TRUE(write_text(root_ / "other", "another file").ok());
    const auto made =
        open_or_create_project(root_ / "me.likeness", {.shared = {.video = root_ / "clip.mp4"}});
    ASSERT_TRUE(made.ok()) << made.error().what;
    project_ = *made;
    for (const char* file : {"capture.json", "cameras.json", "track.json", "frames/000000.png",
                             "masks/000000.png", "plate.png", "avatar.bin"})
      ASSERT_TRUE(write_text(project_.folder / file, file).ok());
    finish();
  }
  void TearDown() override {
    networks_before_.empty() ? ::unsetenv("LIKENESS_NETWORKS")
                             : ::setenv("LIKENESS_NETWORKS", networks_before_.c_str(), 1);
    fs::remove_all(root_);
  }

  void finish() {
    for (const Stage stage : kStages) {
      project_.record(stage).state = StageState::done;
      project_.record(stage).input_hash = input_hash(project_, stage);
    }
  }

  fs::path root_;
  std::string networks_before_;
  Project project_;
};

std::vector<Stage> to_do(const Project& project) {
  const Freshness fresh = read_freshness(project);
  std::vector<Stage> stages;
  for (const Stage stage : kStages)
    if (!fresh.current[std::size_t(stage)]) stages.push_back(stage);
  return stages;
}

std::string names(const std::vector<Stage>& stages) {
  std::string text;
  for (const Stage stage : stages) text.append(stage_name(stage)).append(" ");
  return text;
}

// What builds on these is stale with them; the cameras are found in the clip itself, not in the import.
bool builds_on(const std::vector<Stage>& stale, Stage stage) {
  return std::ranges::any_of(stale, [&](Stage s) {
    return s == stage || (s < stage && !(s == Stage::import && stage == Stage::align));
  });
}

TEST_F(Staleness, EachOptionMakesTheStagesStaleThatItsRowNames) {
  ASSERT_EQ(names(to_do(project_)), "");
  for (const OptionRow& row : option_table()) {
    Project changed = project_;
    test::choose_other(row, changed.options, root_ / "other");
    EXPECT_EQ(names(to_do(changed)), names(row.stale)) << row.key;
    const Freshness fresh = read_freshness(changed);
    for (const Stage stage : kStages)
      EXPECT_EQ(fresh.stale[std::size_t(stage)], builds_on(row.stale, stage))
          << row.key << ": " << stage_name(stage);
  }
}

// The training is another one, though the mode is the same.
TEST_F(Staleness, AModeThatIsAskedForMakesTheTrainingStale) {
  project_.options.train.mode = kDefaultMode;
  EXPECT_EQ(names(to_do(project_)), "train ");
}

TEST_F(Staleness, NoOptionOfAProjectIsForgottenHere) {
  const auto text = read_text(project_.folder / "project.json");
  ASSERT_TRUE(text.ok()) << text.error().what;
  const nlohmann::json file = nlohmann::json::parse(*text);
  for (const auto& option : file.at("options").items())
    EXPECT_EQ(std::ranges::count(option_table(), option.key(), &OptionRow::key),
              option.key() == "mode_asked" ? 0 : 1)
        << option.key();
}

TEST_F(Staleness, ACheckpointGoesOnUnlessAnOptionChangesWhatIsLearnt) {
  const std::vector<std::string> another{"mode",         "landmark_loss", "use_latent",
                                         "refine_track", "use_occupancy", "seed"};
  const auto fingerprint = [](const ProjectOptions& options) {
    return training_fingerprint({}, training_options(stage_inputs(options).train));
  };
  for (const OptionRow& row : option_table()) {
    ProjectOptions changed = project_.options;
    test::choose_other(row, changed, root_ / "other");
    const bool goes_on = fingerprint(changed) == fingerprint(project_.options);
    EXPECT_EQ(!goes_on, std::ranges::count(another, row.key) == 1) << row.key;
    EXPECT_TRUE(goes_on || std::ranges::count(row.stale, Stage::train)) << row.key;
  }
}

TEST_F(Staleness, AnotherLandmarkModelMakesImportAndAlignStale) {
  project_.options.shared.landmark_model = root_ / "model.dat";
  ASSERT_TRUE(write_text(root_ / "model.dat", "one").ok());
  finish();
  ASSERT_EQ(names(to_do(project_)), "");
  ASSERT_TRUE(write_text(root_ / "model.dat", "another").ok());  // under the same name
  EXPECT_EQ(names(to_do(project_)), "import align fit ");
  ASSERT_TRUE(write_text(root_ / "moved.dat", "one").ok());  // the same one under another
  project_.options.shared.landmark_model = root_ / "moved.dat";
  EXPECT_EQ(names(to_do(project_)), "");
}

// The face network is asked first where nothing is chosen; only the files' being there and their content
// count.
TEST_F(Staleness, AFaceNetworkThatComesOrGoesMakesWhatFindsFacesStale) {
  for (const char* name : {"face_detector.onnx", "face468.onnx"})
    ASSERT_TRUE(write_text(root_ / "networks" / name, "one").ok());
  EXPECT_EQ(names(to_do(project_)), "");  // one is missing: dlib, as before
  ASSERT_TRUE(write_text(root_ / "networks" / "iris.onnx", "one").ok());
  EXPECT_EQ(names(to_do(project_)), "import align fit ");
  project_.options.shared.landmark_model = "dlib";
  EXPECT_EQ(names(to_do(project_)), "");
  project_.options.shared.landmark_model = "network";
  finish();
  project_.options.shared.landmark_model.clear();
  EXPECT_EQ(names(to_do(project_)), "");  // the same by its name
  ASSERT_TRUE(write_text(root_ / "networks" / "iris.onnx", "another").ok());
  EXPECT_EQ(names(to_do(project_)), "import align fit ");
}

TEST_F(Staleness, TheWordsForALandmarkModelAreRemembered) {
  for (const char* word : {"network", "dlib"}) {
    ProjectOptions options = project_.options;
    options.shared.landmark_model = word;
    ASSERT_TRUE(open_or_create_project(project_.folder, options).ok());
    const auto opened = open_project(project_.folder);
    ASSERT_TRUE(opened.ok()) << opened.error().what;
    EXPECT_EQ(opened->options.shared.landmark_model, word);
  }
}

TEST_F(Staleness, APersonNetworkThatComesOrGoesMakesAlignAndMatteStale) {
  const auto install = [&](const char* content) {
    EXPECT_TRUE(write_text(root_ / "networks" / "person.onnx", content).ok());
  };
  install("one");
  EXPECT_EQ(names(to_do(project_)), "align matte ");
  project_.options.shared.person_network = "none";
  EXPECT_EQ(names(to_do(project_)), "");  // as before there was one
  project_.options.shared.person_network.clear();
  finish();
  install("another");
  EXPECT_EQ(names(to_do(project_)), "align matte ");
  fs::remove(root_ / "networks" / "person.onnx");
  EXPECT_EQ(names(to_do(project_)), "align matte ");
  ASSERT_TRUE(write_text(root_ / "one.onnx", "one").ok());
  project_.options.shared.person_network = root_ / "one.onnx";  // the same one by its name
  EXPECT_EQ(names(to_do(project_)), "");
}

// Where nobody is looked for, or a matting network is heard instead, it decides nothing.
TEST_F(Staleness, APersonNetworkIsReadOnlyByStagesThatHearIt) {
  project_.options.import.split = Split::views;
  finish();
  ASSERT_TRUE(write_text(root_ / "networks" / "person.onnx", "one").ok());
  EXPECT_EQ(names(to_do(project_)), "import align matte ");
  fs::remove(root_ / "networks" / "person.onnx");
  project_.options.align.camera = CameraKind::resting;
  project_.options.matte.matting_network = root_ / "other";
  finish();
  ASSERT_TRUE(write_text(root_ / "networks" / "person.onnx", "one").ok());
  EXPECT_EQ(names(to_do(project_)), "");
}

TEST_F(Staleness, NoPersonNetworkIsRememberedAsAWord) {
  ProjectOptions options = project_.options;
  options.shared.person_network = "none";
  const auto project = open_or_create_project(project_.folder, options);
  ASSERT_TRUE(project.ok()) << project.error().what;
  const auto opened = open_project(project_.folder);
  ASSERT_TRUE(opened.ok()) << opened.error().what;
  EXPECT_EQ(opened->options.shared.person_network, "none");
}

TEST_F(Staleness, TheRangeOfSidesIsReadByTheSplitThatGoesByIt) {
  project_.options.import.sides = {7, 15};
  EXPECT_EQ(names(to_do(project_)), "");
  project_.options.import.split = Split::sides;
  finish();
  project_.options.import.sides.inside_deg = 8;
  EXPECT_EQ(names(to_do(project_)), "import align ");
  project_.options.import.sides = {7, 16};
  EXPECT_EQ(names(to_do(project_)), "import align ");
  project_.options.align.camera = CameraKind::resting;  // which needs no frames to tell it anything
  finish();
  project_.options.import.sides.beyond_deg = 15;
  EXPECT_EQ(names(to_do(project_)), "import ");
}

TEST_F(Staleness, ARestingCameraIsReadByTheImportThatHoldsOutViews) {
  project_.options.import.split = Split::views;
  finish();
  project_.options.align.camera = CameraKind::resting;
  EXPECT_EQ(names(to_do(project_)), "import align ");
}

// What such projects were hashed from before the landmark model was named.
TEST_F(Staleness, AProjectThatNamesNoLandmarkModelIsNotStaleByAnUpdate) {
  const auto content = [&](const char* file) { return *hash_file(project_.folder / file); };
  const std::string clip = *hash_video(project_.options.shared.video), capture = content("capture.json"),
                    cameras = content("cameras.json"), track = content("track.json"),
                    plate = content("plate.png");
  EXPECT_EQ(input_hash(project_, Stage::import), hash_text(fmt::format("import 2\n{} 256", clip)));
  EXPECT_EQ(input_hash(project_, Stage::align), hash_text(fmt::format("align 6\n{} 0", clip)));
  EXPECT_EQ(input_hash(project_, Stage::fit),
            hash_text(fmt::format("fit 11\n{} {} none none", capture, cameras)));
  EXPECT_EQ(input_hash(project_, Stage::matte),
            hash_text(fmt::format("matte 4\n{} {} {} none", capture, cameras, track)));
  EXPECT_EQ(input_hash(project_, Stage::train),
            hash_text(fmt::format("train 8\n{} {} {} absent {} 0 0 true true true true false",
                                  project_.record(Stage::matte).input_hash, track, plate, 300.0)));
  ProjectOptions& o = project_.options;
  o.import.split = Split::views, o.align.camera = CameraKind::resting, o.align.lens_mm = 51,
  o.shared.seed = 3, o.train.use_latent = false;
  o.fit.refits = {{20, 22}, {4, 6}, {7, 9}}, o.train.left_out = {3, 5}, o.train.landmark_loss = 0.1;
  EXPECT_EQ(input_hash(project_, Stage::import),
            hash_text(fmt::format("import 2\n{} 256 views rests", clip)));
  EXPECT_EQ(input_hash(project_, Stage::align),
            hash_text(fmt::format("align 6\n{} 3 rests {} mm", clip, 51.0)));
  EXPECT_EQ(input_hash(project_, Stage::fit),
            hash_text(fmt::format("fit 11\n{} {} none none again 1: 4-9 20-22", capture, cameras)));
  EXPECT_EQ(input_hash(project_, Stage::train),
            hash_text(fmt::format("train 8\n{} {} {} absent {} 0 3 true false true true false landmarks {} "
                                  "left out 3,5",
                                  project_.record(Stage::matte).input_hash, track, plate, 300.0, 0.1)));
}

TEST_F(Staleness, TheFirstTrackKnowsNeitherSpansNorMaps) {
  const std::string first = first_track_hash(project_);
  EXPECT_EQ(first, input_hash(project_, Stage::fit));
  project_.options.fit.refits = {{4, 6}};
  project_.options.fit.displacement = root_;
  EXPECT_EQ(first_track_hash(project_), first);
  project_.options.fit.identity = root_ / "other";
  EXPECT_NE(first_track_hash(project_), first);
}

}  // namespace
}  // namespace likeness
