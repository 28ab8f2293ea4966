// Claims about folders written whole or not at all.
#include "core/base/whole_folder.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include "core/base/files.h"

namespace likeness {
namespace {

class WholeFolderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "likeness_whole_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
  }
  void TearDown() override { std::filesystem::remove_all(root_); }
  std::size_t entries() const {
    return std::size_t(std::distance(std::filesystem::directory_iterator(root_), {}));
  }
  std::filesystem::path root_;
};

TEST_F(WholeFolderTest, TakesThePlaceOfTheOldOneWhenItIsCommitted) {
  ASSERT_TRUE(write_text(root_ / "results" / "old.txt", "old"));
  WholeFolder folder(root_ / "results");
  ASSERT_TRUE(write_text(folder.temporary() / "new.txt", "new"));
  EXPECT_TRUE(path_exists(root_ / "results" / "old.txt"));
  EXPECT_FALSE(path_exists(root_ / "results" / "new.txt"));
  ASSERT_TRUE(folder.commit());
  EXPECT_FALSE(path_exists(root_ / "results" / "old.txt"));
  EXPECT_EQ(*read_text(root_ / "results" / "new.txt"), "new");
  EXPECT_EQ(entries(), 1u);
}

TEST_F(WholeFolderTest, LeavesNothingWhereItIsNot) {
  ASSERT_TRUE(write_text(root_ / "results" / "old.txt", "old"));
  {
    const WholeFolder folder(root_ / "results");
    ASSERT_TRUE(write_text(folder.temporary() / "new.txt", "new"));
    EXPECT_TRUE(folder.temporary().filename().string().starts_with("."));
  }
  EXPECT_EQ(*read_text(root_ / "results" / "old.txt"), "old");
  EXPECT_EQ(entries(), 1u);
}

TEST_F(WholeFolderTest, ThatWasNeverMadeCannotTakeAPlaceAndTheOldOneStays) {
  ASSERT_TRUE(write_text(root_ / "results" / "old.txt", "old"));
  WholeFolder folder(root_ / "results");
  EXPECT_FALSE(folder.commit());
  EXPECT_EQ(*read_text(root_ / "results" / "old.txt"), "old");
  EXPECT_EQ(entries(), 1u);
}

}  // namespace
}  // namespace likeness
