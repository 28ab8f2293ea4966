// Claims about core/base/program_files.h: what lies beside a program is found from wherever it was unpacked.
#include "core/base/program_files.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include "core/base/files.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;

TEST(ProgramFiles, TheRunningProgramIsThisTest) {
  const fs::path program = program_file();
  EXPECT_TRUE(program.is_absolute());
  EXPECT_EQ(program.filename(), "basics_test");
  EXPECT_TRUE(fs::is_regular_file(program));
}

TEST(ProgramFiles, WhatLiesBesideAProgramIsFoundAndNothingElse) {
  std::string name = (fs::temp_directory_path() / "likeness_beside_XXXXXX").string();
  ASSERT_NE(::mkdtemp(name.data()), nullptr);
  const fs::path prefix = name, program = prefix / "bin" / "likeness", inside = "share/likeness/letters";
  fs::create_directories(prefix / "share/likeness");
  EXPECT_EQ(bundled_file(inside, program), std::nullopt);
  ASSERT_TRUE(write_text(prefix / inside, "abc").ok());
  EXPECT_EQ(bundled_file(inside, program), prefix / inside);
  EXPECT_EQ(bundled_file("share/likeness", program), std::nullopt);  // a folder is not a file
  EXPECT_EQ(bundled_file(inside, ""), std::nullopt);                 // a system that does not report it
  fs::remove_all(prefix);
}

}  // namespace
}  // namespace likeness::test
