// Claims about strokes: what they cover, how they lie over each other, and their file.
#include "core/matte/strokes.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <numbers>

#include "core/base/files.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr SquareCrop kCrop{100, 40, 200};  // px of the source

// A place of the crop, 0..1, in the source's pixels.
Vec2d at(double x, double y) { return {kCrop.x + x * kCrop.side, kCrop.y + y * kCrop.side}; }

double sum(const Image& cover) {
  double total = 0;
  for (const float v : cover.data) total += v;
  return total;
}

TEST(Strokes, ADabCoversItsDiscWithASoftRim) {
  const Strokes dab{{StrokeMark::person, 40, {at(0.5, 0.5)}}};
  const StrokeCover cover = cover_strokes(dab, kCrop, 100);  // radius 20 px
  EXPECT_NEAR(sum(cover.person), std::numbers::pi * 20 * 20, 25);
  EXPECT_EQ(sum(cover.background), 0);
  EXPECT_EQ(*cover.person.at(50, 50), 1);
  EXPECT_GT(*cover.person.at(50 + 19, 50), kSurelyCovered);
  EXPECT_LT(*cover.person.at(50 + 20, 50), kSurelyCovered);
  EXPECT_EQ(*cover.person.at(50 + 23, 50), 0);
  for (int x = 51; x < 75; ++x) EXPECT_LE(*cover.person.at(x, 50), *cover.person.at(x - 1, 50)) << x;
}

TEST(Strokes, ALineIsCoveredFromEndToEnd) {
  const Strokes line{{StrokeMark::background, 10, {at(0.2, 0.2), at(0.8, 0.2), at(0.8, 0.7)}}};
  const StrokeCover cover = cover_strokes(line, kCrop, 100);
  for (int i = 20; i < 80; ++i) EXPECT_EQ(*cover.background.at(i, 20), 1) << i;
  for (int i = 20; i < 70; ++i) EXPECT_EQ(*cover.background.at(80, i), 1) << i;
  EXPECT_EQ(*cover.background.at(50, 45), 0);
}

TEST(Strokes, CoverTheSameAtEveryPictureSize) {
  const Strokes line{{StrokeMark::person, 24, {at(0.3, 0.25), at(0.7, 0.6)}}};
  const double small = sum(cover_strokes(line, kCrop, 64).person) / (64 * 64),
               large = sum(cover_strokes(line, kCrop, 512).person) / (512 * 512);
  EXPECT_NEAR(small, large, 0.03 * large);
}

TEST(Strokes, LaterOnesLieOverEarlierOnesAndAnEraserRemovesBoth) {
  const Stroke person{StrokeMark::person, 40, {at(0.5, 0.5)}},
      background{StrokeMark::background, 20, {at(0.5, 0.5)}}, erase{StrokeMark::erase, 10, {at(0.5, 0.5)}};
  const StrokeCover cover = cover_strokes(Strokes{person, background, erase}, kCrop, 100);
  EXPECT_EQ(*cover.person.at(50, 50), 0);
  EXPECT_EQ(*cover.background.at(50, 50), 0);
  EXPECT_EQ(*cover.background.at(57, 50), 1);
  EXPECT_EQ(*cover.person.at(57, 50), 0);
  EXPECT_EQ(*cover.person.at(65, 50), 1);
  for (std::size_t i = 0; i < cover.person.data.size(); ++i)
    ASSERT_LE(cover.person.data[i] + cover.background.data[i], 1.00001f) << i;
  const StrokeCover nothing =
      cover_strokes(Strokes{person, {StrokeMark::erase, 60, {at(0.5, 0.5)}}}, kCrop, 100);
  EXPECT_EQ(sum(nothing.person), 0);
}

TEST(Strokes, OutsideTheCropTheyCoverNothing) {
  const Strokes away{{StrokeMark::person, 5, {{0, 0}}}, {StrokeMark::person, 5, {{1e6, -1e6}}}};
  EXPECT_EQ(sum(cover_strokes(away, kCrop, 64).person), 0);
  EXPECT_TRUE(cover_strokes({}, kCrop, 64).empty());
}

TEST(Strokes, SetAlphaWhereTheyAreAndLeaveItElsewhere) {
  Image8 alpha(100, 100, 1, 90);
  const Strokes both{{StrokeMark::person, 20, {at(0.3, 0.5)}}, {StrokeMark::background, 20, {at(0.7, 0.5)}}};
  apply_strokes(cover_strokes(both, kCrop, 100), alpha);
  EXPECT_EQ(*alpha.at(30, 50), 255);
  EXPECT_EQ(*alpha.at(70, 50), 0);
  EXPECT_EQ(*alpha.at(50, 10), 90);
  int between = 0;
  for (int x = 30; x < 50; ++x) between += *alpha.at(x, 50) > 95 && *alpha.at(x, 50) < 250;
  EXPECT_GE(between, 1) << "the rim is soft";
  Image8 same(100, 100, 1, 90);
  apply_strokes({}, same);
  EXPECT_EQ(same.data, Image8(100, 100, 1, 90).data);
}

class StrokesFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("likeness_strokes_" + std::to_string(::getpid()));
    file_ = folder_ / "000012.json";
  }
  void TearDown() override { fs::remove_all(folder_); }

  const Strokes some_{{StrokeMark::person, 12.25, {{1.5, 2.75}, {100.1, 1.0 / 3}}},
                      {StrokeMark::erase, 0.01, {{7, 8}}},
                      {StrokeMark::background, 300, {{-3, 4}, {5, 6}, {7, 8}}}};
  fs::path folder_, file_;
};

TEST_F(StrokesFile, RoundTrips) {
  ASSERT_TRUE(write_strokes(file_, some_).ok());
  const auto read = read_strokes(file_);
  ASSERT_TRUE(read.ok()) << read.error().what;
  EXPECT_EQ(*read, some_);
  ASSERT_TRUE(write_strokes(file_, {}).ok());
  EXPECT_TRUE(read_strokes(file_)->empty());
}

TEST_F(StrokesFile, RefusesADamagedOrNewerFileWithARemedyAndKeepsIt) {
  ASSERT_TRUE(write_strokes(file_, some_).ok());
  const std::string whole = *read_text(file_);
  const auto replaced = [&](const std::string& what, const std::string& with) {
    std::string text = whole;
    const std::size_t place = text.find(what);
    EXPECT_NE(place, std::string::npos) << what;
    return text.replace(place, what.size(), with);
  };
  for (const std::string& text :
       {std::string(), std::string("{}"), whole.substr(0, whole.size() / 2),
        replaced("likeness-strokes", "likeness-plate"), replaced("\"version\":1", "\"version\":99"),
        replaced("\"person\"", "\"somebody\""), replaced("12.25", "-12.25"), replaced("12.25", "1e300"),
        replaced("[1.5,2.75]", "[1.5]"), replaced("[1.5,2.75]", "[1.5,null]"), replaced("[[7,8]]", "[]"),
        replaced("[[7,8]]", "7")}) {
    ASSERT_TRUE(write_text(file_, text).ok());
    const auto read = read_strokes(file_);
    ASSERT_FALSE(read.ok()) << text;
    EXPECT_EQ(read.error().code, ErrorCode::bad_input) << text;
    EXPECT_NE(read.error().what.find("000012.json"), std::string::npos) << text;
    EXPECT_FALSE(read.error().fix.empty()) << text;
    EXPECT_EQ(*read_text(file_), text) << "nothing is lost by a look at it";
  }
}

}  // namespace
}  // namespace likeness
