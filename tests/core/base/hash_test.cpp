// Claims about content hashes.
#include "core/base/hash.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "core/base/files.h"

namespace likeness {
namespace {

TEST(Hash, HasThirtyTwoDigitsAndChangesWithOneBit) {
  EXPECT_EQ(hash_text("a").size(), 32u);
  EXPECT_NE(hash_text("a"), hash_text("b"));
  EXPECT_EQ(hash_text("a"), hash_text("a"));
}

TEST(Hash, OfAFileIsThatOfItsContent) {
  const auto path = std::filesystem::temp_directory_path() / ("likeness_hash_" + std::to_string(::getpid()));
  const std::string text(3 << 20, 'x');  // longer than one buffer
  ASSERT_TRUE(write_text(path, text).ok());
  EXPECT_EQ(hash_file(path).value(), hash_text(text));
  std::filesystem::remove(path);
  EXPECT_FALSE(hash_file(path).ok());
}

}  // namespace
}  // namespace likeness
