// Claims about what the program was handed as input and outputs: none of it ends the work, and nothing that
// was asked for is lost without a word.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "core/base/files.h"
#include "tests/core/export/tiny_project.h"
#include "tests/support/run_program.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

// With the shell's redirections.
ProgramResult redirected(const std::string& arguments, const std::string& redirections) {
  return run_program({"/bin/sh", "-c", likeness_path() + " " + arguments + " " + redirections});
}

TEST(StandardStreams, OutputThatCannotBeWrittenFailsTheCommand) {
  for (const char* command : {"demo --list", "doctor", "--help", "--version", "demo --help"}) {
    const ProgramResult full = redirected(command, ">/dev/full");
    EXPECT_EQ(full.exit_code, 1) << command;
    EXPECT_THAT(full.err, HasSubstr("could not be written")) << command;
  }
}

TEST(StandardStreams, WorkGoesOnWithoutThem) {
  const TinyProject project;
  const std::string render = "render '" + project.folder().string() + "' --size 32 --frames 1 --out '";
  int number = 0;
  for (const char* redirection : {"2>&-", "2>/dev/full", ">&- 2>&-", "<&- >&- 2>&-", "2>&1 | true"}) {
    const fs::path out = project.root / ("film-" + std::to_string(number++) + ".png");
    EXPECT_EQ(redirected(render + out.string() + "'", redirection).exit_code, 0) << redirection;
    EXPECT_TRUE(fs::exists(out)) << redirection;
  }
}

TEST(StandardStreams, NamesCommandNoTerminal) {
  const ProgramResult asked = likeness({"check", "a\x1b[31mb\x07.mp4"});
  EXPECT_EQ(asked.exit_code, 1);
  EXPECT_THAT(asked.err, HasSubstr("a?[31mb?.mp4"));
  EXPECT_THAT(asked.err, Not(HasSubstr("\x1b")));
}

// Opening one waits for somebody to write into it, where no signal is heeded.
TEST(StandardStreams, APipeIsNoClip) {
  const TinyProject project;
  const fs::path pipe = project.root / "pipe.mp4";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const ProgramResult& asked :
       {likeness({"check", pipe.string()}),
        likeness({"build", pipe.string(), "--project", (project.root / "new.likeness").string()}),
        likeness({"track", pipe.string(), "--out", (project.root / "track.json").string()}),
        likeness({"render", project.folder().string(), "--performance", pipe.string(), "--out",
                  (project.root / "o.png").string()})}) {
    EXPECT_EQ(asked.exit_code, 1);
    EXPECT_THAT(asked.err, HasSubstr("pipe or a device"));
  }
}

TEST(StandardStreams, ANameThatBeginsWithADashIsTold) {
  const ProgramResult asked = likeness({"check", "-clip.mp4"});
  EXPECT_EQ(asked.exit_code, 2);
  EXPECT_THAT(asked.err, HasSubstr("-clip.mp4 looks like an option; write ./-clip.mp4"));
  EXPECT_THAT(likeness({"check", "--nothing", "-0.5", "--out=a.mp4"}).err, Not(HasSubstr("looks like")));
}

// Files in a folder and below.
std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (!entry.is_directory()) names.push_back(entry.path().filename().string());
  return names;
}

TEST(StandardStreams, ALimitOnTheSizeOfFilesIsAnErrorWithARemedyAndLeavesNothing) {
  const TinyProject project;
  fs::create_directories(project.root / "out");
  for (const std::string name : {"film.mp4", "pictures/"}) {
    const std::string command = "ulimit -f 1; " + likeness_path() + " render '" + project.folder().string() +
                                "' --size 96 --frames 3 --out '" + (project.root / "out" / name).string() +
                                "'";
    const ProgramResult asked = run_program({"/bin/sh", "-c", command});
    EXPECT_EQ(asked.exit_code, 1) << name << asked.err;
    EXPECT_THAT(asked.err, HasSubstr("ulimit -f")) << name;
    EXPECT_THAT(names_in(project.root / "out"), testing::IsEmpty()) << name;
  }
}

// The first signal asks for an end in order, the second for one at once.
TEST(StandardStreams, ASecondSignalLeavesNothingHalfWritten) {
  const TinyProject project;
  for (const std::string name : {"film.mp4", "pictures/"}) {
    const fs::path out = project.root / ("at " + name).substr(0, 6);
    fs::create_directories(out);
    const pid_t child =
        start_program({likeness_path(), "render", project.folder().string(), "--size", "512", "--frames",
                       "9000", "--camera", "orbit", "--out", (out / name).string()},
                      project.root);
    for (int i = 0; i < 2000 && names_in(out).empty(); ++i) ::usleep(5000);
    ASSERT_THAT(names_in(out), Not(testing::IsEmpty())) << name;
    ::kill(child, SIGTERM);
    ::usleep(400000);  // two in the same moment are one
    ::kill(child, SIGTERM);
    const int code = wait_program(child);
    EXPECT_TRUE(code == 130 || code == 128 + SIGTERM) << code;
    EXPECT_THAT(names_in(out), testing::IsEmpty()) << name;
  }
}

TEST(StandardStreams, NoTrackReplacesWhatAProjectKeeps) {
  const TinyProject project;
  for (const char* name : {"project.json", "avatar.bin", "track.json"}) {
    const ProgramResult asked = likeness({"track", "no.mp4", "--out", (project.folder() / name).string()});
    EXPECT_EQ(asked.exit_code, 1) << name;
    EXPECT_THAT(asked.err, HasSubstr("--out names what a project keeps")) << name;
  }
}

}  // namespace
}  // namespace likeness::test
