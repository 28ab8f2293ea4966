// Claims about atomic files.
#include "core/base/files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>

namespace likeness {
namespace {

namespace fs = std::filesystem;

class Files : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("likeness_files_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST_F(Files, TextReadsBackAsWritten) {
  const std::string text("one\0two\n", 8);
  ASSERT_TRUE(write_text(folder_ / "deep" / "a.txt", text).ok());
  EXPECT_EQ(read_text(folder_ / "deep" / "a.txt").value(), text);
}

TEST_F(Files, WritingLeavesNoTemporaryFile) {
  ASSERT_TRUE(write_text(folder_ / "a.txt", "1").ok());
  ASSERT_TRUE(write_text(folder_ / "a.txt", "2").ok());
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(Files, AFailedWriteKeepsTheOldFileAndSaysWhy) {
  fs::create_directories(folder_ / "a.txt");  // a folder in the way makes the rename fail, even for root
  std::ofstream(folder_ / "a.txt" / "old") << "old";
  const auto written = write_text(folder_ / "a.txt", "new");
  ASSERT_FALSE(written.ok());
  EXPECT_NE(written.error().what.find("a.txt"), std::string::npos);
  EXPECT_FALSE(written.error().fix.empty());
  EXPECT_TRUE(fs::exists(folder_ / "a.txt" / "old"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(Files, FileInPlaceOfAFolderIsAnErrorWithARemedy) {
  std::ofstream(folder_ / "file") << "x";
  const auto made = make_writable_folder(folder_ / "file");
  ASSERT_FALSE(made.ok());
  EXPECT_FALSE(made.error().fix.empty());
}

TEST_F(Files, AFullDiskIsNamedAsSuch) {
  const Error error = file_error("/somewhere/avatar.bin", "write", ENOSPC);
  EXPECT_EQ(error.code, ErrorCode::no_space);
  EXPECT_NE(error.fix.find("disk space"), std::string::npos);
}

TEST_F(Files, AMissingFileIsNotFound) {
  EXPECT_EQ(read_file(folder_ / "absent").error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace likeness
