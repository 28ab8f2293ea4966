// Claims about painted attributes: edits keep their order, masks and boxes become strokes that cover them,
// and their file is whole or refused.
#include "core/matte/attributes.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "core/base/files.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class AttributesFile : public testing::Test {
 protected:
  void SetUp() override {
    path_ = fs::temp_directory_path() / ("likeness_attributes_" + std::to_string(getpid()) + ".json");
  }
  void TearDown() override { fs::remove(path_); }
  Error refused(const std::string& text) {
    EXPECT_TRUE(write_text(path_, text).ok());
    const auto read = read_attributes(path_);
    EXPECT_FALSE(read.ok()) << text;
    if (read.ok()) return {};
    EXPECT_EQ(read.error().code, ErrorCode::bad_input);
    EXPECT_FALSE(read.error().fix.empty());
    return read.error();
  }
  fs::path path_;
};

PaintedAttributes some() {
  PaintedAttributes attributes;
  annotate(attributes, "cheek puff", {40, 1, {{StrokeMark::person, 12.5, {{10, 20.25}, {30, 20}}}}});
  annotate(attributes, "cheek puff", {7, 0, {}});
  annotate(attributes, "dimple",
           {3, -0.5, {{StrokeMark::person, 4, {{1, 2}}}, {StrokeMark::erase, 2, {{1, 2}}}}});
  return attributes;
}

TEST_F(AttributesFile, RoundTrips) {
  ASSERT_TRUE(write_attributes(path_, some()).ok());
  const auto read = read_attributes(path_);
  ASSERT_TRUE(read.ok()) << read.error().what;
  EXPECT_EQ(*read, some());
}

TEST_F(AttributesFile, RefusesAnyTruncation) {
  ASSERT_TRUE(write_attributes(path_, some()).ok());
  const std::string whole = *read_text(path_);
  for (std::size_t length = 0; length + 2 < whole.size(); ++length) refused(whole.substr(0, length));
}

TEST_F(AttributesFile, RefusalSaysWhatIsWrong) {
  const std::string head = R"({"format":"likeness-attributes","version":1,"attributes":[)";
  const auto with = [&](const std::string& attribute) { return head + attribute + "]}"; };
  EXPECT_NE(refused(R"({"format":"likeness-strokes","version":1})").what.find("something else"),
            std::string::npos);
  EXPECT_NE(refused(R"({"format":"likeness-attributes","version":9,"attributes":[]})").what.find("newer"),
            std::string::npos);
  refused(R"({"format":"likeness-attributes","version":0,"attributes":[]})");
  refused(with(R"({"name":"a=b","annotations":[{"frame":1,"value":0,"strokes":[]}]})"));
  refused(with(R"({"name":"a","annotations":[]})"));
  refused(with(R"({"name":"a","annotations":[{"frame":-1,"value":0,"strokes":[]}]})"));
  refused(with(R"({"name":"a","annotations":[{"frame":1,"value":1.5,"strokes":[]}]})"));
  refused(with(R"({"name":"a","annotations":[{"frame":1,"value":null,"strokes":[]}]})"));
  refused(with(R"({"name":"a","annotations":[{"frame":1,"value":1,"strokes":{}}]})"));
  refused(with(
      R"({"name":"a","annotations":[{"frame":1,"value":1,"strokes":[{"mark":"person","radius":-1,"points":[[1,1]]}]}]})"));
  const std::string fine = R"({"name":"a","annotations":[{"frame":1,"value":1,"strokes":[]}]})";
  EXPECT_NE(refused(with(fine + "," + fine)).what.find("twice"), std::string::npos);
  ASSERT_TRUE(write_text(path_, with(fine)).ok());
  EXPECT_TRUE(read_attributes(path_).ok()) << "the others were refused for what is wrong with them";
}

TEST(Attributes, KeepOneAnnotationAFrameInOrder) {
  PaintedAttributes attributes = some();
  ASSERT_EQ(attributes.size(), 2u);
  EXPECT_EQ(attributes[0].annotations[0].frame, 7);
  annotate(attributes, "cheek puff", {40, 0.5, {}});
  ASSERT_EQ(attributes[0].annotations.size(), 2u);
  EXPECT_EQ(attributes[0].annotations[1].value, 0.5);
  EXPECT_FALSE(take_back(attributes, "cheek puff", 8));
  EXPECT_FALSE(take_back(attributes, "nothing"));
  EXPECT_TRUE(take_back(attributes, "dimple", 3));
  EXPECT_EQ(attributes.size(), 1u) << "the last frame takes the attribute along";
  EXPECT_TRUE(take_back(attributes, "cheek puff"));
  EXPECT_TRUE(attributes.empty());
}

TEST(Attributes, MergeWhatTwoProgramsChanged) {
  const PaintedAttributes base = some();
  PaintedAttributes mine = base, theirs = base;
  annotate(mine, "cheek puff", {7, 0.25, {}});
  annotate(mine, "cheek puff", {40, 0.5, {}});
  take_back(mine, "dimple", 3);
  annotate(theirs, "cheek puff", {7, 0.75, {}});
  annotate(theirs, "cheek puff", {41, 1, {}});
  annotate(theirs, "wink", {9, 1, {}});
  PaintedAttributes expected = base;
  annotate(expected, "cheek puff", {7, 0.25, {}});
  annotate(expected, "cheek puff", {40, 0.5, {}});
  annotate(expected, "cheek puff", {41, 1, {}});
  take_back(expected, "dimple", 3);
  annotate(expected, "wink", {9, 1, {}});
  EXPECT_EQ(merge_attributes(base, mine, theirs), expected);
  EXPECT_EQ(merge_attributes(base, base, theirs), theirs);
  EXPECT_EQ(merge_attributes(base, mine, base), mine);
  PaintedAttributes less = base;
  take_back(less, base[0].name);
  EXPECT_EQ(merge_attributes(less, base, less), base) << "one that comes back has its place again";
}

TEST(Attributes, HaveNamesThatCanBeTyped) {
  for (const char* name : {"cheek puff", "a", "brow_L-2"})
    EXPECT_TRUE(check_attribute_name(name).ok()) << name;
  for (const char* name : {"", " a", "a ", "a=b", "a,b", "caf\xc3\xa9", "a\n", "cheek_L", "cheek_R"})
    EXPECT_FALSE(check_attribute_name(name).ok()) << name;
  EXPECT_FALSE(check_attribute_name(std::string(41, 'a')).ok());
}

double share_wrong(const Image& cover, const Image8& truth) {
  double wrong = 0, inside = 0;
  for (std::size_t i = 0; i < truth.data.size(); ++i) {
    wrong += (cover.data[i] > 0.5f) != (truth.data[i] > 127);
    inside += truth.data[i] > 127;
  }
  return wrong / inside;
}

TEST(Attributes, StrokesOfAMaskCoverIt) {
  for (const int size : {40, 160, 400}) {
    Image8 mask(size, size, 1);
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const double u = (x + 0.5) / size - 0.4, v = (y + 0.5) / size - 0.55, hole = std::hypot(u + 0.1, v);
        *mask.at(x, y) = std::hypot(u, 1.5 * v) < 0.3 && hole > 0.06 ? 255 : 0;
      }
    const StrokeCover cover = cover_strokes(strokes_of_mask(mask), {0, 0, size}, size);
    ASSERT_FALSE(cover.empty());
    EXPECT_LT(share_wrong(cover.person, mask), size < 100 ? 0.15 : 0.06) << size;
  }
  EXPECT_TRUE(strokes_of_mask(Image8(30, 20, 1)).empty());
  // Two marks, lower than the strokes lie apart, far from each other.
  Image8 marks(900, 900, 1);
  for (const int y : {100, 698})
    for (int row = y; row < y + 3; ++row)
      for (int x = 400; x < 440; ++x) *marks.at(x, row) = 255;
  const StrokeCover both = cover_strokes(strokes_of_mask(marks), {0, 0, 900}, 900);
  ASSERT_FALSE(both.empty());
  for (const int y : {101, 699}) EXPECT_GT(both.person.data[std::size_t(y) * 900 + 420], 0.5f) << y;
}

TEST(Attributes, StrokesOfABoxFillIt) {
  const Vec2d low(20, 30), high(90, 55);
  Image8 box(128, 128, 1);
  for (int y = 30; y < 55; ++y)
    for (int x = 20; x < 90; ++x) *box.at(x, y) = 255;
  const StrokeCover cover = cover_strokes(strokes_of_box(low, high), {0, 0, 128}, 128);
  EXPECT_LT(share_wrong(cover.person, box), 0.08);
  EXPECT_FALSE(strokes_of_box({3, 3}, {4, 5}).empty());
}

}  // namespace
}  // namespace likeness
