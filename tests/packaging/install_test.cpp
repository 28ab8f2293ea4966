// Claims about what is installed: the programs run from where they are put, and the desktop finds them, their
// icon, their kinds of files and their manual.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <regex>

#include "core/base/files.h"
#include "tests/support/run_program.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Install : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string name = (fs::temp_directory_path() / "likeness_install_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    const ProgramResult installed = run_program({"cmake", "--install", LIKENESS_BUILD, "--prefix", name});
    ASSERT_EQ(installed.exit_code, 0) << installed.err;
  }
  static void TearDownTestSuite() { fs::remove_all(root_); }

  static std::string text(const fs::path& inside) {
    const auto read = read_text(root_ / "share" / inside);
    EXPECT_TRUE(read.ok()) << inside;
    return read.ok() ? *read : "";
  }
  // The value of KEY=VALUE in the desktop entry.
  static std::string entry(const std::string& key) {
    const std::string file = text("applications/likeness-studio.desktop");
    std::smatch found;
    return std::regex_search(file, found, std::regex("(?:^|\n)" + key + "=([^\n]*)")) ? found[1].str() : "";
  }

  static inline fs::path root_;
};

TEST_F(Install, TheProgramsRunFromWhereTheyWerePut) {
  const ProgramResult version = run_program({(root_ / "bin" / "likeness-studio").string(), "--version"});
  EXPECT_EQ(version.exit_code, 0) << version.err;
  EXPECT_EQ(version.out, run_program({(root_ / "bin" / "likeness").string(), "--version"}).out);
  // Networks lie elsewhere here and there.
  const auto doctor = [](const std::string& program) {
    return run_program({"/usr/bin/env", "LIKENESS_NETWORKS=/nowhere", program, "doctor"}).out;
  };
  EXPECT_EQ(doctor((root_ / "bin" / "likeness").string()), doctor(likeness_path()));
}

TEST_F(Install, NetworksThatWereMadeComeAlong) {
  const fs::path made = LIKENESS_SOURCE "/build/networks", installed = root_ / "share/likeness/networks";
  if (!fs::exists(made)) GTEST_SKIP() << "packaging/networks has made no networks in this checkout";
  const std::string doctor = run_program({"/usr/bin/env", "-u", "LIKENESS_NETWORKS",
                                          (root_ / "bin" / "likeness").string(), "doctor"})
                                 .out;
  for (const char* name : {"person.onnx", "face468.onnx", "iris.onnx", "face_detector.onnx"}) {
    EXPECT_TRUE(fs::exists(installed / name)) << name;
    EXPECT_THAT(doctor, HasSubstr((installed / name).string()));
  }
  EXPECT_TRUE(fs::exists(installed / "ORIGIN"));
}

TEST_F(Install, TheDesktopEntryNamesWhatIsInstalled) {
  const std::string program = entry("Exec").substr(0, entry("Exec").find(' '));
  EXPECT_TRUE(fs::exists(root_ / "bin" / program)) << program;
  const fs::path icon = root_ / "share/icons/hicolor/scalable/apps" / (entry("Icon") + ".svg");
  EXPECT_TRUE(fs::exists(icon)) << icon;
  EXPECT_THAT(text("mime/packages/likeness.xml"), HasSubstr("<icon name=\"" + entry("Icon") + "\"/>"));
  for (const char* needed : {"Type", "Name", "Comment", "Categories"}) EXPECT_NE(entry(needed), "") << needed;
  const ProgramResult checked =
      run_program({"desktop-file-validate", (root_ / "share/applications/likeness-studio.desktop").string()});
  if (checked.exit_code != 127) {
    EXPECT_EQ(checked.out + checked.err, "");
  }
}

TEST_F(Install, TheMimeTypeIsTheProjectsAndTheStudioOpensIt) {
  const std::string kinds = text("mime/packages/likeness.xml");
  EXPECT_THAT(kinds, HasSubstr("<glob pattern=\"*.likeness\"/>"));
  std::smatch type;
  ASSERT_TRUE(std::regex_search(kinds, type, std::regex("mime-type type=\"([^\"]+project)\"")));
  EXPECT_THAT(entry("MimeType"), HasSubstr(type[1].str() + ";"));
  // Not every folder of the desktop, nor every program's project.json.
  EXPECT_THAT(entry("MimeType"), testing::Not(HasSubstr("inode/directory")));
  EXPECT_THAT(kinds, testing::Not(HasSubstr("project.json\"/>")));
}

TEST_F(Install, AnAvatarIsKnownByWhatIsInIt) {
  const fs::path types = root_ / "share/mime";
  if (run_program({"update-mime-database", types.string()}).exit_code == 127)
    GTEST_SKIP() << "update-mime-database is not installed";
  EXPECT_THAT(entry("MimeType"), HasSubstr("application/x-likeness-avatar;"));
  EXPECT_THAT(text("mime/magic"), HasSubstr("LKNSAVTR"));
  EXPECT_THAT(text("mime/globs2"), HasSubstr("application/x-likeness-project:*.likeness"));
}

TEST_F(Install, ManualPagesAreThoseTheProgramsPrint) {
  for (const char* program : {"likeness", "likeness-studio"}) {
    const fs::path page = root_ / "share/man/man1" / (std::string(program) + ".1.gz");
    const ProgramResult unpacked = run_program({"gzip", "-dc", page.string()});
    ASSERT_EQ(unpacked.exit_code, 0) << unpacked.err;
    EXPECT_EQ(unpacked.out, run_program({std::string(LIKENESS_BIN) + "/" + program, "--man"}).out);
  }
}

TEST_F(Install, LicencesComeAlong) {
  const std::string copyright = text("doc/likeness/copyright");
  for (const char* part : {"Apache-2.0", "Dear ImGui", "Ceres", "libdlib-data", "research", "MediaPipe"})
    EXPECT_THAT(copyright, HasSubstr(part));
}

}  // namespace
}  // namespace likeness::test
