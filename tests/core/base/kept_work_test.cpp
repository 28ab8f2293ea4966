// Claims about work kept piece by piece: what a killed process kept is found again, to the bit, and nothing
// else.
#include "core/base/kept_work.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <string>

#include "core/base/files.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class KeptWorkFile : public testing::Test {
 protected:
  void TearDown() override { fs::remove_all(folder_); }
  const fs::path folder_ = fs::temp_directory_path() / ("likeness_kept_" + std::to_string(::getpid()));
  const fs::path file_ = folder_ / "inner" / "work.kept";
};

const std::string kMany(100'000, 'x');
const std::string kOdd("\0\n\xff piece", 10);

TEST_F(KeptWorkFile, PiecesOutliveAKill) {
  const pid_t child = ::fork();
  if (child == 0) {
    KeptWork work(file_, "a");
    work.keep("first", kOdd);
    work.keep("second", kMany);
    work.keep("empty", "");
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  KeptWork work(file_, "a");
  EXPECT_EQ(work.find("first"), kOdd);
  EXPECT_EQ(work.find("second"), kMany);
  EXPECT_EQ(work.find("empty"), "");
  EXPECT_EQ(work.find("third"), std::nullopt);
  EXPECT_LT(fs::file_size(file_), kMany.size() / 10);
  work.keep("third", kMany);
  EXPECT_EQ(KeptWork(file_, "a").find("third"), kMany);
}

TEST_F(KeptWorkFile, AreOfTheseInputsAlone) {
  KeptWork(file_, "a").keep("first", kOdd);
  EXPECT_EQ(KeptWork(file_, "b").find("first"), std::nullopt);
  EXPECT_EQ(KeptWork(file_, "a").find("first"), std::nullopt) << "what was begun anew is gone";
}

TEST_F(KeptWorkFile, WhatIsCutOrAlteredIsDroppedWithAllThatFollows) {
  {
    KeptWork work(file_, "a");
    for (const char* name : {"first", "second", "third"}) work.keep(name, kMany);
  }
  const auto whole = read_file(file_).value();
  for (std::size_t size = whole.size(); size-- > 0;) {
    if (size % 37 != 0 && size + 40 < whole.size()) continue;
    ASSERT_TRUE(write_file(file_, std::span(whole).first(size)).ok());
    const KeptWork work(file_, "a");
    EXPECT_EQ(work.find("third"), std::nullopt) << size;
    for (const char* name : {"first", "second"}) EXPECT_EQ(work.find(name).value_or(kMany), kMany) << size;
  }
  auto altered = whole;
  altered[altered.size() / 2] ^= std::byte(1);
  ASSERT_TRUE(write_file(file_, altered).ok());
  KeptWork work(file_, "a");
  EXPECT_EQ(work.find("first"), kMany);
  EXPECT_EQ(work.find("second"), std::nullopt);
  EXPECT_EQ(work.find("third"), std::nullopt);
  work.keep("second", kOdd);
  EXPECT_EQ(KeptWork(file_, "a").find("second"), kOdd);
}

TEST_F(KeptWorkFile, FinishedWorkLeavesNothing) {
  KeptWork work(file_, "a");
  work.keep("first", kOdd);
  work.finish();
  EXPECT_FALSE(path_exists(file_.parent_path()));
  work.keep("second", kOdd);  // to nobody
  EXPECT_EQ(work.find("second"), std::nullopt);
}

// A link in its place leads to somebody else's file.
TEST_F(KeptWorkFile, WhatCannotBeWrittenIsNotKept) {
  fs::create_directories(file_.parent_path());
  ASSERT_TRUE(write_text(folder_ / "other", "other").ok());
  fs::create_symlink(folder_ / "other", file_);
  KeptWork work(file_, "a");
  work.keep("first", kOdd);
  EXPECT_EQ(work.find("first"), std::nullopt);
  EXPECT_EQ(read_text(folder_ / "other").value(), "other");
}

}  // namespace
}  // namespace likeness
