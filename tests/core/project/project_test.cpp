// Claims about the project file: what it remembers, what it refuses, and that two processes do not share it.
#include "core/project/project.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>

#include "core/base/files.h"
#include "core/project/run_stages.h"
#include "core/project/staleness.h"

namespace {
int failing_locks = 0;  // the errno that flock answers; 0: it does its work
}

// In the C library's place, for this whole program.
extern "C" int flock(int descriptor, int operation) noexcept {
  if (failing_locks == 0) return int(::syscall(SYS_flock, descriptor, operation));
  errno = failing_locks;
  return -1;
}

namespace likeness {
namespace {

namespace fs = std::filesystem;

class ProjectFolder : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_project_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
  }
  void TearDown() override { fs::remove_all(root_); }

  fs::path root_;
};

TEST_F(ProjectFolder, ALandmarkLossMakesTheTrainingAnotherOne) {
  Project project;
  project.folder = root_ / "p";
  project.options.shared.video = root_ / "clip.mp4";
  const std::string without = input_hash(project, Stage::train), fitted = input_hash(project, Stage::fit);
  project.options.train.landmark_loss = 0.1;
  EXPECT_NE(input_hash(project, Stage::train), without);
  EXPECT_EQ(input_hash(project, Stage::fit), fitted);
  project.options.train.landmark_loss = 0;
  EXPECT_EQ(input_hash(project, Stage::train), without);
}

TEST_F(ProjectFolder, RemembersOptionsAndStages) {
  ProjectOptions options;
  options.shared.video = root_ / "clip.mp4";
  options.import.size = 512;
  options.train.steps = 123;
  options.train.full_budget_s = 600;
  options.shared.seed = 7;
  options.align.lens_mm = 51;
  options.train.use_latent = false;
  options.train.mode = FieldMode::warp;
  options.train.landmark_loss = 0.1;
  auto made = open_or_create_project(root_ / "p", options);
  ASSERT_TRUE(made.ok()) << made.error().what;
  made->record(Stage::fit) = {StageState::done, "0123", 4.5, "found", {"a warning"}};
  ASSERT_TRUE(save_project(*made).ok());

  const auto opened = open_project(root_ / "p");
  ASSERT_TRUE(opened.ok()) << opened.error().what;
  EXPECT_EQ(opened->options.shared.video, options.shared.video);
  EXPECT_EQ(opened->options.import.size, 512);
  EXPECT_EQ(opened->options.train.steps, 123u);
  EXPECT_EQ(opened->options.train.full_budget_s, 600);
  EXPECT_EQ(opened->options.align.lens_mm, 51);
  EXPECT_EQ(opened->options.shared.seed, 7u);
  EXPECT_FALSE(opened->options.train.use_latent);
  EXPECT_EQ(opened->options.train.mode, FieldMode::warp);
  EXPECT_EQ(opened->options.train.landmark_loss, 0.1);
  const StageRecord& record = opened->record(Stage::fit);
  EXPECT_EQ(record.state, StageState::done);
  EXPECT_EQ(record.input_hash, "0123");
  EXPECT_EQ(record.seconds, 4.5);
  EXPECT_EQ(record.warnings, std::vector<std::string>{"a warning"});
  EXPECT_EQ(opened->record(Stage::train).state, StageState::to_do);
}

TEST_F(ProjectFolder, RemembersWhoAgreed) {
  auto made = open_or_create_project(root_ / "p", {});
  ASSERT_TRUE(made.ok()) << made.error().what;
  EXPECT_EQ(made->consent, Consent::not_asked);
  for (const Consent answer : {Consent::own, Consent::given, Consent::no_real_person}) {
    made->consent = answer;
    ASSERT_TRUE(save_project(*made).ok());
    // Another run with other options keeps the answer.
    const auto opened = open_or_create_project(root_ / "p", {.shared = {.seed = 3}});
    ASSERT_TRUE(opened.ok());
    EXPECT_EQ(opened->consent, answer);
  }
}

TEST_F(ProjectFolder, AProjectFromBeforeTheQuestionOpens) {
  ASSERT_TRUE(open_or_create_project(root_ / "p", {}).ok());
  std::string text = *read_text(root_ / "p" / "project.json");
  const std::size_t line = text.find("\"consent\"");
  ASSERT_NE(line, std::string::npos);
  text.erase(line, text.find('\n', line) - line);
  ASSERT_TRUE(write_text(root_ / "p" / "project.json", text).ok());
  const auto opened = open_project(root_ / "p");
  ASSERT_TRUE(opened.ok()) << opened.error().what;
  EXPECT_EQ(opened->consent, Consent::not_asked);
}

TEST_F(ProjectFolder, TheSwitchesOfAnOlderProjectAreItsMode) {
  ASSERT_TRUE(open_or_create_project(root_ / "p", {}).ok());
  const std::string text = *read_text(root_ / "p" / "project.json");
  const auto replaced = [](std::string in, const std::string& what, const std::string& with) {
    const std::size_t at = in.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return in.replace(at, what.size(), with);
  };
  const std::string unasked = replaced(text, "\"mode_asked\": false", "\"kept\": false");
  const std::string older = replaced(unasked, "\"version\": 2", "\"version\": 1");
  const std::string mode = "\"mode\": \"warp+hyper\"";
  const std::pair<const char*, FieldMode> switches[] = {
      {"\"use_ambient\": true, \"use_warp\": true", FieldMode::warp_hyper},
      {"\"use_ambient\": true, \"use_warp\": false", FieldMode::hyper},
      {"\"use_ambient\": false, \"use_warp\": true", FieldMode::warp},
      {"\"use_ambient\": false, \"use_warp\": false", FieldMode::concat},
      {"\"use_ambient\": true", FieldMode::warp_hyper}};
  for (const auto& [given, expected] : switches) {
    ASSERT_TRUE(write_text(root_ / "p" / "project.json", replaced(older, mode, given)).ok());
    const auto opened = open_project(root_ / "p");
    ASSERT_TRUE(opened.ok()) << given << ": " << opened.error().what;
    // The default was nobody's wish: it is chosen from the capture now.
    EXPECT_EQ(opened->options.train.mode.value_or(kDefaultMode), expected) << given;
    EXPECT_EQ(opened->options.train.mode.has_value(), expected != kDefaultMode) << given;
  }
  ASSERT_TRUE(write_text(root_ / "p" / "project.json", replaced(text, mode, "\"mode\": \"guess\"")).ok());
  EXPECT_FALSE(open_project(root_ / "p").ok());
}

TEST_F(ProjectFolder, AModeThatIsAskedForIsAnotherTrainingThanOneThatIsChosen) {
  auto chosen = open_or_create_project(root_ / "p", {});
  ASSERT_TRUE(chosen.ok()) << chosen.error().what;
  EXPECT_FALSE(chosen->options.train.mode.has_value());
  ProjectOptions options = chosen->options;
  options.train.mode = kDefaultMode;  // which the capture may not be given by itself
  auto asked = open_or_create_project(root_ / "p", options);
  ASSERT_TRUE(asked.ok()) << asked.error().what;
  EXPECT_NE(input_hash(*chosen, Stage::train), input_hash(*asked, Stage::train));
  const auto opened = open_project(root_ / "p");
  ASSERT_TRUE(opened.ok()) << opened.error().what;
  EXPECT_EQ(opened->options.train.mode, kDefaultMode);
  // A project of before, in which the default stands without anybody's wish, is trained as it was.
  std::string text = *read_text(root_ / "p" / "project.json");
  const std::string wish = "\"mode_asked\": true";
  text.replace(text.find(wish), wish.size(), "\"kept\": true");
  ASSERT_TRUE(write_text(root_ / "p" / "project.json", text).ok());
  const auto before = open_project(root_ / "p");
  ASSERT_TRUE(before.ok()) << before.error().what;
  EXPECT_EQ(input_hash(*chosen, Stage::train), input_hash(*before, Stage::train));
}

TEST_F(ProjectFolder, AShapeThatIsGivenIsAnInputOfTheFit) {
  auto project = open_or_create_project(root_ / "p", {});
  ASSERT_TRUE(project.ok()) << project.error().what;
  const std::string fitted = input_hash(*project, Stage::fit), imported = input_hash(*project, Stage::import);
  ASSERT_TRUE(write_text(root_ / "identity.npy", "one").ok());
  project->options.fit.identity = root_ / "identity.npy";
  const std::string one = input_hash(*project, Stage::fit);
  EXPECT_NE(one, fitted);
  EXPECT_EQ(input_hash(*project, Stage::import), imported);
  ASSERT_TRUE(write_text(root_ / "identity.npy", "another").ok());  // by content, not by name
  EXPECT_NE(input_hash(*project, Stage::fit), one);
  ASSERT_TRUE(save_project(*project).ok());
  const auto opened = open_project(root_ / "p");
  ASSERT_TRUE(opened.ok()) << opened.error().what;
  EXPECT_EQ(opened->options.fit.identity, root_ / "identity.npy");
  project->options.fit.identity.clear();
  EXPECT_EQ(input_hash(*project, Stage::fit), fitted);
}

TEST_F(ProjectFolder, APathThatIsNoTextStaysAsItIs) {
  ProjectOptions options;
  options.shared.video = root_ / "clip\xff.mp4";
  const auto made = open_or_create_project(root_ / "p", options);
  ASSERT_TRUE(made.ok()) << made.error().what;
  const auto opened = open_project(root_ / "p");
  ASSERT_TRUE(opened.ok()) << opened.error().what;
  EXPECT_EQ(opened->options.shared.video.native(), options.shared.video.native());
}

TEST_F(ProjectFolder, ADamagedOrNewerFileIsRefusedWithARemedy) {
  for (const char* text : {"{", "[]", "{\"version\": 1}", "{\"version\": 1000}"}) {
    ASSERT_TRUE(write_text(root_ / "p" / "project.json", text).ok());
    const auto opened = open_project(root_ / "p");
    ASSERT_FALSE(opened.ok()) << text;
    EXPECT_EQ(opened.error().code, ErrorCode::bad_input) << text;
    EXPECT_FALSE(opened.error().fix.empty()) << text;
  }
}

TEST_F(ProjectFolder, AFolderOfOtherFilesIsLeftAlone) {
  fs::create_directories(root_ / "photos");
  std::ofstream(root_ / "photos" / "a.txt") << "a";
  const auto made = open_or_create_project(root_ / "photos", {});
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(std::distance(fs::directory_iterator(root_ / "photos"), fs::directory_iterator()), 1);
}

TEST_F(ProjectFolder, OptionsDoNotChangeWhileAnotherWorksOnIt) {
  ProjectOptions options;
  options.shared.seed = 1;
  const auto made = open_or_create_project(root_ / "p", options);
  ASSERT_TRUE(made.ok()) << made.error().what;
  const auto lock = ProjectLock::acquire(*made);
  ASSERT_TRUE(lock.ok()) << lock.error().what;
  options.shared.seed = 2;
  const auto second = open_or_create_project(root_ / "p", options);
  ASSERT_FALSE(second.ok());
  EXPECT_FALSE(second.error().fix.empty());
  const auto opened = open_project(root_ / "p");
  ASSERT_TRUE(opened.ok());
  EXPECT_EQ(opened->options.shared.seed, 1u);
}

// Of a share without a lock service.
TEST_F(ProjectFolder, WithoutLocksWorkGoesOnWithANote) {
  auto made = open_or_create_project(root_ / "p", {.shared = {.video = root_ / "none.mp4"}});
  ASSERT_TRUE(made.ok());
  EXPECT_EQ(ProjectLock::acquire(*made)->note(), "");
  for (const int failure : {ENOLCK, EOPNOTSUPP, ENOSYS}) {
    failing_locks = failure;
    const auto lock = ProjectLock::acquire(*made);
    const auto opened = open_or_create_project(root_ / "p", made->options);
    const auto run = run_stages(*made, Stage::import, Progress(), {}, {});
    failing_locks = 0;
    ASSERT_TRUE(lock.ok()) << lock.error().what;
    EXPECT_THAT(lock->note(), testing::HasSubstr("keeps no locks"));
    EXPECT_TRUE(opened.ok());
    ASSERT_FALSE(run.ok());
    EXPECT_EQ(run.error().code, ErrorCode::not_found) << "the clip is what is missing, not the lock";
    EXPECT_THAT(made->record(Stage::import).warnings,
                testing::Contains(testing::HasSubstr("no second Likeness")));
  }
}

TEST_F(ProjectFolder, AChangeKeepsWhatOthersDidMeanwhile) {
  auto made = open_or_create_project(root_ / "p", {.shared = {.seed = 1}});
  ASSERT_TRUE(made.ok()) << made.error().what;
  Project other = *made;
  other.record(Stage::align).state = StageState::done;
  ASSERT_TRUE(save_project(other).ok());
  const auto asked = [](Project& project) { project.options.shared.seed = 2; };
  const auto changed = change_project(root_ / "p", asked);
  ASSERT_TRUE(changed.ok()) << changed.error().what;
  const auto opened = open_project(root_ / "p");
  ASSERT_TRUE(opened.ok());
  for (const Project& project : {*changed, *opened}) {
    EXPECT_EQ(project.options.shared.seed, 2u);
    EXPECT_EQ(project.record(Stage::align).state, StageState::done);
  }
  const auto lock = ProjectLock::acquire(*made);
  ASSERT_TRUE(lock.ok());
  EXPECT_FALSE(change_project(root_ / "p", asked).ok());
  EXPECT_EQ(change_project(root_ / "none", asked).ok(), false);
}

}  // namespace
}  // namespace likeness
