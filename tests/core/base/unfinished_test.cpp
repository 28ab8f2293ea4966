// Claims about what a process leaves that is ended in the middle of writing: what was finished before.
#include "core/base/unfinished.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <set>
#include <string>

#include "core/base/files.h"
#include "core/base/temporary_folder.h"
#include "core/base/whole_folder.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

TEST(Unfinished, FilesAndFoldersGoAndWholeOnesStay) {
  const auto folder = TemporaryFolder::make("unfinished");
  ASSERT_TRUE(folder.ok());
  const fs::path place = folder->path();
  const pid_t child = ::fork();
  if (child == 0) {  // after remove_unfinished() a process only ends
    forget_unfinished(place);
    bool fine = write_text(place / "whole.txt", "whole").ok();
    WholeFolder done(place / "done"), half(place / "half");
    fine = fine && write_text(done.temporary() / "a.png", "a").ok() && done.commit().ok();
    fine = fine && write_text(half.temporary() / "deep" / "a.png", "a").ok();
    std::ofstream(temporary_name(place / "film.mp4")) << "half";
    const auto scratch = TemporaryFolder::make("scratch");
    fine = fine && scratch.ok();
    remove_unfinished();
    ::_exit(fine && !fs::exists(scratch->path()) ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  std::set<std::string> left;
  for (const auto& entry : fs::directory_iterator(place)) left.insert(entry.path().filename().string());
  EXPECT_EQ(left, (std::set<std::string>{"done", "whole.txt"}));
}

}  // namespace
}  // namespace likeness
