// Claims about atomic files.
#include "core/base/files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>

#include "core/base/hash.h"

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

// Opening a pipe waits until somebody writes into it, and a device may go on for ever.
TEST_F(Files, PipesAndDevicesAreNoFiles) {
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  for (const fs::path& path : {folder_ / "pipe", fs::path("/dev/zero")}) {
    EXPECT_FALSE(read_file(path).ok()) << path;
    EXPECT_FALSE(read_head(path, 8).ok()) << path;
    EXPECT_FALSE(check_not_endless(path).ok()) << path;
    EXPECT_FALSE(hash_file(path).ok()) << path;
  }
  EXPECT_TRUE(check_not_endless(folder_).ok());
}

TEST_F(Files, AFileThatIsTooLargeIsNotRead) {
  std::ofstream(folder_ / "sparse") << "x";
  fs::resize_file(folder_ / "sparse", kLargestText + 1);
  const auto read = read_text(folder_ / "sparse");
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().code, ErrorCode::bad_input);
  EXPECT_EQ(read_head(folder_ / "sparse", 4)->size(), 4u);
}

TEST_F(Files, NothingIsWrittenThroughALink) {
  std::ofstream(folder_ / "theirs") << "theirs";
  fs::create_symlink(folder_ / "theirs", folder_ / "a.txt");
  ASSERT_TRUE(write_text(folder_ / "a.txt", "ours").ok());
  EXPECT_EQ(*read_text(folder_ / "theirs"), "theirs");
  EXPECT_EQ(*read_text(folder_ / "a.txt"), "ours");
}

TEST_F(Files, OnlyPartsOfProcessesThatNoLongerLiveAreRemoved) {
  const pid_t gone = ::fork();
  if (gone == 0) ::_exit(0);
  ::waitpid(gone, nullptr, 0);
  const std::string abandoned = "." + std::string("frames.") + std::to_string(gone) + "-5.part";
  const fs::path own = temporary_name(folder_ / "avatar.bin");
  const std::vector<std::string> kept{".parties.txt", ".my.parts", ".notes.frames.txt", ".a.part",
                                      own.filename().string()};
  for (const std::string& name : kept) std::ofstream(folder_ / name) << "x";
  fs::create_directories(folder_ / abandoned / "inner");
  remove_abandoned_parts(folder_, "masks");
  EXPECT_TRUE(fs::exists(folder_ / abandoned));
  remove_abandoned_parts(folder_);
  EXPECT_FALSE(fs::exists(folder_ / abandoned));
  for (const std::string& name : kept) EXPECT_TRUE(fs::exists(folder_ / name)) << name;
  EXPECT_TRUE(is_part_name(own.filename().string()));
}

}  // namespace
}  // namespace likeness
