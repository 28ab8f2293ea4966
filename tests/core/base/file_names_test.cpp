// Claims about names that are made of others: they fit, and no letter is halved.
#include "core/base/file_names.h"

#include <gmock/gmock.h>

#include <string>

namespace likeness {
namespace {

using ::testing::HasSubstr;

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

TEST(FileNames, AreCutBetweenTwoLetters) {
  EXPECT_EQ(cut_name("short", 10), "short");
  EXPECT_EQ(cut_name("longer", 4), "long");
  EXPECT_EQ(cut_name("abm\u00fcller", 4), "abm");              // two bytes
  EXPECT_EQ(cut_name("\u5c71\u7530", 5), "\u5c71");            // three
  EXPECT_EQ(cut_name("a\U0001f600b", 4), "a");                 // four
  EXPECT_EQ(cut_name("abce\u0301f", 4), "abc");                // an accent that follows its letter
  EXPECT_EQ(cut_name("ab\u0e01\u0e33\u0e48", 5), "ab\u0e01");  // before a letter of its own
  EXPECT_EQ(cut_name("ab\u0e01\u0e35\u0e48", 7), "ab");        // Thai marks stay with theirs
  const std::string family = "\U0001f468\u200d\U0001f469\u200d\U0001f467";
  EXPECT_EQ(cut_name("ab" + family, 8), "ab");
  EXPECT_EQ(cut_name("ab" + family, 12), "ab");
  EXPECT_EQ(cut_name("ab\U0001f44d\U0001f3fd", 8), "ab");  // a skin tone
}

TEST(FileNames, ThatAreNoUtf8OrNothingButMarksAreCutAnyhow) {
  EXPECT_EQ(cut_name("m\xfcller", 3), "m\xfcl");
  EXPECT_EQ(cut_name("ab\x80\x80\x80\x80\x80\x80", 5), "ab\x80\x80\x80");
  EXPECT_EQ(cut_name(repeated("\u0301", 40), 21).size(), 20u);
}

TEST(FileNames, HaveRoomForWhatIsAdded) {
  const std::string longest = repeated("\u00e4", 126) + "x";  // 253 bytes, as a clip's before its ".mp4"
  for (const std::string ending : {".likeness", "-2.likeness", ".colmap"}) {
    const std::string name = name_with(longest, ending);
    EXPECT_LE(name.size(), kLongestName);
    EXPECT_GE(name.size(), kLongestName - 1);
    EXPECT_TRUE(name.ends_with(ending));
    EXPECT_TRUE(name.starts_with("\u00e4\u00e4"));
    EXPECT_EQ((name.size() - ending.size()) % 2, 0u) << "a letter is halved";
  }
  EXPECT_EQ(name_with("clip", ".likeness"), "clip.likeness");
}

TEST(FileNames, ThatCannotBeMadeAreTold) {
  EXPECT_TRUE(check_can_be_named("/tmp/" + std::string(255, 'x')).ok());
  EXPECT_TRUE(check_can_be_named("clip.likeness").ok());
  const auto name = check_can_be_named("/tmp/" + std::string(256, 'x') + "/inner");
  ASSERT_FALSE(name.ok());
  EXPECT_THAT(name.error().what, HasSubstr("256 bytes, and there at most 255"));
  const auto path = check_can_be_named("/tmp/" + repeated(std::string(200, 'x') + "/", 20) + "me.likeness");
  ASSERT_FALSE(path.ok());
  EXPECT_THAT(path.error().fix, HasSubstr("less deep"));
}

}  // namespace
}  // namespace likeness
