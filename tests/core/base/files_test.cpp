// Claims about atomic files.
#include "core/base/files.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <iterator>
#include <string>

#include "core/base/hash.h"

namespace {
int failing_syncs = 0;  // the errno that fsync answers; 0: it does its work
}

// In the C library's place, for this whole program.
extern "C" int fsync(int descriptor) {
  if (failing_syncs == 0) return int(::syscall(SYS_fsync, descriptor));
  errno = failing_syncs;
  return -1;
}

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

// 255 bytes are a file's longest name, and what it is written under for a while is longer.
TEST_F(Files, ALongNameHasATemporaryOneThatFits) {
  std::string letters;
  for (int i = 0; i < 63; ++i) letters += "\u5c71\u00e4";  // 315 bytes
  for (const std::string& name : {std::string(255, 'x'), std::string(244, 'y') + ".mp4",
                                  letters.substr(0, 255), "a." + std::string(250, 'z')}) {
    ASSERT_TRUE(write_text(folder_ / name, "x").ok()) << name;
    const fs::path part = temporary_name(folder_ / name).filename();
    EXPECT_LE(part.string().size(), 255u) << name;
    EXPECT_TRUE(is_part_name(part.string())) << name;
    if (name.ends_with(".mp4")) {
      EXPECT_EQ(part.extension(), ".mp4");
    }
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 4);
  const auto refused = write_text(folder_ / std::string(256, 'x'), "x");
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().fix.find("255 bytes"), std::string::npos) << refused.error().fix;
}

// Shares and file systems of programs that do not know how; a disk that fails does.
TEST_F(Files, WhatCannotBeFlushedIsWrittenAllTheSame) {
  for (const auto& [failure, written] : {std::pair(EINVAL, true), {ENOSYS, true}, {EIO, false}}) {
    failing_syncs = failure;
    const bool file = write_text(folder_ / "a.txt", "x").ok();
    std::ofstream(folder_ / "film.part") << "x";
    const bool film = commit_file(folder_ / "film.part", folder_ / "film").ok();
    const bool folder = make_writable_folder(folder_).ok();
    failing_syncs = 0;
    for (const bool done : {file, film, folder}) EXPECT_EQ(done, written) << failure;
  }
  fs::remove(folder_ / "a.txt"), fs::remove(folder_ / "film");
  EXPECT_TRUE(fs::is_empty(folder_)) << "something half-written stays";
}

TEST_F(Files, AFileThatMayNotGrowIsAnErrorWithARemedyAndLeavesNothing) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1000, 1000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    const auto refused = write_text(folder_ / "a.txt", std::string(2000, 'x'));
    ::_exit(!refused && refused.error().fix.find("FAT32") != std::string::npos ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(fs::is_empty(folder_));
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
