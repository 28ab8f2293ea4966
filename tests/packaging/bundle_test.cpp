// Claims about the bundle that packaging/bundle makes of this build: it names nothing by an absolute path,
// holds all that it does not leave to the system, asks for no newer C library than it says, and brings every
// licence.
#include <gmock/gmock.h>
#include <gnu/libc-version.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "core/base/files.h"
#include "tests/support/run_program.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::vector<int> numbers_of(const std::string& version) {
  std::vector<int> numbers;
  std::istringstream parts(version);
  for (std::string part; std::getline(parts, part, '.');) numbers.push_back(std::stoi(part));
  return numbers;
}

std::vector<std::string> found_in(const std::string& text, const std::string& pattern) {
  std::vector<std::string> found;
  const std::regex wanted(pattern);
  for (std::sregex_iterator match(text.begin(), text.end(), wanted), end; match != end; ++match)
    found.push_back((*match)[1].str());
  return found;
}

class Bundle : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (run_program({"patchelf", "--version"}).exit_code != 0) return;
    std::string name = (fs::temp_directory_path() / "likeness_bundle_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    place_ = name;
    const ProgramResult made =
        run_program({LIKENESS_SOURCE "/packaging/bundle", "--folder", "--built", LIKENESS_BUILD, name});
    ASSERT_EQ(made.exit_code, 0) << made.out << made.err;
    for (const auto& entry : fs::directory_iterator(place_)) root_ = entry.path();
    for (const auto& entry : fs::recursive_directory_iterator(root_)) {
      std::ifstream file(entry.path(), std::ios::binary);
      char start[4] = {};
      if (entry.is_regular_file() && file.read(start, 4) && std::string(start, 4) == "\177ELF")
        binaries_.push_back(entry.path());
    }
  }
  static void TearDownTestSuite() {
    if (!place_.empty()) fs::remove_all(place_);
  }
  void SetUp() override {
    if (place_.empty()) GTEST_SKIP() << "patchelf is not installed";
    ASSERT_GT(binaries_.size(), 50u);
  }

  static std::string text(const fs::path& inside) {
    const auto read = read_text(root_ / inside);
    EXPECT_TRUE(read.ok()) << inside;
    return read.ok() ? *read : "";
  }
  // A program of the bundle as a stranger starts it: an environment of nothing, by a link, from elsewhere.
  static ProgramResult start(const std::string& program, const std::string& argument) {
    const fs::path link = place_ / ("link to " + program);
    fs::create_directory(link);
    if (!fs::exists(link / program)) fs::create_symlink(root_ / program, link / program);
    return run_program({"/usr/bin/env", "-i", "PATH=/usr/bin:/bin", (link / program).string(), argument});
  }
  static std::string which(const std::string& program) {
    const std::string said = run_program({"/bin/sh", "-c", "command -v " + program}).out;
    return said.substr(0, said.find('\n'));
  }
  static bool of_the_c_library(const std::string& library) {
    static const std::regex names(
        R"((ld-linux.*|lib(c|m|mvec|pthread|dl|rt|resolv|util|anl)\.so\..*|libnsl\.so\.1))");
    return std::regex_match(library, names);
  }

  static inline fs::path place_, root_;
  static inline std::vector<fs::path> binaries_;
};

TEST_F(Bundle, NothingIsFoundByAnAbsolutePath) {
  for (const fs::path& binary : binaries_) {
    const std::string dynamic = run_program({"readelf", "-dW", binary.string()}).out;
    for (const std::string& path : found_in(dynamic, R"(\((?:RPATH|RUNPATH)\)[^\[]*\[([^\]]*)\])"))
      EXPECT_TRUE(path.starts_with("$ORIGIN") && path.find(':') == std::string::npos)
          << binary << ": " << path;
    for (const std::string& needed : found_in(dynamic, R"(\(NEEDED\)[^\[]*\[([^\]]*)\])"))
      EXPECT_EQ(needed.find('/'), std::string::npos) << binary;
  }
}

TEST_F(Bundle, EveryLibraryIsInItOrIsTheCLibrary) {
  std::set<std::string> there;
  for (const fs::path& binary : binaries_) there.insert(binary.filename());
  for (const fs::path& binary : binaries_) {
    const std::string dynamic = run_program({"readelf", "-dW", binary.string()}).out;
    for (const std::string& needed : found_in(dynamic, R"(\(NEEDED\)[^\[]*\[([^\]]*)\])"))
      EXPECT_TRUE(there.contains(needed) || of_the_c_library(needed)) << needed << " of " << binary;
  }
  for (const std::string& name : there) EXPECT_FALSE(of_the_c_library(name)) << name;
}

TEST_F(Bundle, DriversAndDisplaysComeFromTheSystemWhereItHasThem) {
  for (const fs::path& binary : binaries_)
    if (std::regex_search(binary.filename().string(),
                          std::regex("^lib(X|xcb|GL[.X]|GLdispatch|EGL|OpenGL|wayland|drm|va[.-])"))) {
      EXPECT_EQ(binary.parent_path().parent_path(), root_ / "lib/if-absent") << binary;
    }
  for (const char* name : {"libstdc++.so.6", "libgcc_s.so.1"}) {
    EXPECT_TRUE(fs::exists(root_ / "lib/if-newer" / name / name));
    EXPECT_FALSE(fs::exists(root_ / "lib" / name));
  }
}

TEST_F(Bundle, ItAsksForNoNewerCLibraryThanItSays) {
  std::vector<int> most;
  for (const fs::path& binary : binaries_)
    for (const std::string& version :
         found_in(run_program({"objdump", "-p", binary.string()}).out, R"(GLIBC_([0-9.]+[0-9]))"))
      most = std::max(most, numbers_of(version));
  std::string said = text("lib/glibc");
  EXPECT_EQ(most, numbers_of(said));
  EXPECT_LE(most, numbers_of(::gnu_get_libc_version()));
}

TEST_F(Bundle, EveryLibraryBringsItsLicence) {
  // Where the bundled libraries came from is what the loader of this system says of the same programs.
  std::map<std::string, std::set<std::string>>
      names;  // by their files here, as packages may have registered them
  for (const std::string& program :
       {likeness_path(), std::string(LIKENESS_BIN "/likeness-studio"), which("colmap")}) {
    const std::regex line(R"((\S+) => (/\S+) \()");
    const std::string said = run_program({"ldd", program}).out;
    for (std::sregex_iterator match(said.begin(), said.end(), line), end; match != end; ++match) {
      const std::string file = fs::canonical((*match)[2].str());
      for (const std::string& path : {file, file.starts_with("/usr") ? file.substr(4) : "/usr" + file})
        names[path].insert((*match)[1].str());
    }
  }
  std::vector<std::string> ask{"dpkg-query", "-S"};
  for (const auto& [path, asked] : names) ask.push_back(path);
  std::set<std::string> licensed;
  std::istringstream lines(run_program(ask).out);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t colon = line.find(": ");
    const fs::path licence =
        root_ / "share/licences" / line.substr(0, std::min(line.find(':'), colon)) / "copyright";
    if (fs::exists(licence) && fs::file_size(licence) > 0) licensed.merge(names[line.substr(colon + 2)]);
  }
  for (const fs::path& binary : binaries_) {
    const std::string name = binary.filename();
    if (name.find(".so") != std::string::npos && name != "liblikeness_cuda.so") {
      EXPECT_TRUE(licensed.contains(name)) << name;
    }
  }
  for (const char* package : {"colmap", "libdlib-data", "fonts-inter", "libimgui-dev", "likeness"})
    EXPECT_GT(text(fs::path("share/licences") / package / "copyright").size(), 100u) << package;
  EXPECT_THAT(text("share/licences/SOURCES"), HasSubstr("colmap "));
  EXPECT_TRUE(fs::exists(root_ / "share/licences/common-licenses/GPL-3"));
}

TEST_F(Bundle, ItStartsFromAnywhereAndFindsItsOwn) {
  for (const char* program : {"likeness", "likeness-studio"}) {
    const ProgramResult version = start(program, "--version");
    EXPECT_EQ(version.exit_code, 0) << version.err;
    EXPECT_EQ(version.out, likeness({"--version"}).out);
  }
  const ProgramResult doctor = start("likeness", "doctor");
  EXPECT_EQ(doctor.exit_code, 0) << doctor.out << doctor.err;
  EXPECT_THAT(doctor.out, HasSubstr((root_ / "lib/likeness/colmap").string()));
  if (fs::exists(LIKENESS_SOURCE "/build/networks")) {
    EXPECT_THAT(doctor.out, HasSubstr((root_ / "share/likeness/networks/face468.onnx").string()));
  }
  for (const char* file : {"shape_predictor_68_face_landmarks.dat", "fonts/Inter-Regular.otf"})
    EXPECT_TRUE(fs::exists(root_ / "share/likeness" / file)) << file;
}

// What stands for the library holds nothing but a version: one newer than the system's is taken, and does not
// load.
TEST_F(Bundle, OfTheCompilersLibrariesTheNewerIsTaken) {
  const fs::path library = root_ / "lib/if-newer/libstdc++.so.6/libstdc++.so.6", kept = place_ / "kept";
  fs::rename(library, kept);
  ASSERT_TRUE(write_text(library, "GLIBCXX_3.4.1\n").ok());
  EXPECT_EQ(start("likeness", "--version").exit_code, 0);
  ASSERT_TRUE(write_text(library, "GLIBCXX_3.4.999\n").ok());
  const ProgramResult newer = start("likeness", "--version");
  EXPECT_NE(newer.exit_code, 0);
  EXPECT_THAT(newer.err, HasSubstr(library.string()));
  fs::rename(kept, library);
}

}  // namespace
}  // namespace likeness::test
