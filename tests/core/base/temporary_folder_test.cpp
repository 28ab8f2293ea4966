// Claims about temporary folders: there is a place for them, and nothing of them stays.
#include "core/base/temporary_folder.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <optional>
#include <string>
#include <utility>

#include "core/base/files.h"

namespace likeness {
namespace {

TEST(TemporaryFolder, GoesWithItsObject) {
  std::filesystem::path place;
  {
    auto made = TemporaryFolder::make("test");
    ASSERT_TRUE(made.ok());
    TemporaryFolder folder = std::move(*made);
    place = folder.path();
    ASSERT_TRUE(write_text(place / "inner" / "file", "x").ok());
  }
  EXPECT_FALSE(path_exists(place));
}

TEST(TemporaryFolder, IsInTmpWhereTheStatedPlaceIsNowhere) {
  const char* before = ::getenv("TMPDIR");
  const std::optional<std::string> kept = before ? std::optional<std::string>(before) : std::nullopt;
  ::setenv("TMPDIR", "/nowhere/at/all", 1);
  const auto made = TemporaryFolder::make("test");
  kept ? ::setenv("TMPDIR", kept->c_str(), 1) : ::unsetenv("TMPDIR");
  ASSERT_TRUE(made.ok());
  EXPECT_EQ(made->path().parent_path(), "/tmp");
}

}  // namespace
}  // namespace likeness
