// Claims about people drawn by hand: reading, filling, what the drawing is unsure of, and the files there
// are.
#include "core/lab/truth/person_marks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "core/base/files.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

Polygon circle(double x, double y, double radius) {
  Polygon corners;
  for (int i = 0; i < 200; ++i) {
    const double a = 2 * std::numbers::pi * i / 200;
    corners.emplace_back(x + radius * std::cos(a), y + radius * std::sin(a));
  }
  return corners;
}

double area(const Image8& mask) {
  double sum = 0;
  for (const std::uint8_t v : mask.data) sum += v > 0;
  return sum;
}

// A round head on a torso that fills the picture's lower half, with a hole in it.
PersonOutline figure() {
  PersonOutline outline;
  outline.person = {circle(100, 60, 40), {{0, 200}, {0, 100}, {200, 100}, {200, 200}}};
  outline.holes = {circle(150, 150, 10)};
  outline.head = {circle(100, 60, 40)};
  return outline;
}

TEST(PersonMarks, AreFilledToTheirAreaAndHolesAreLeftOut) {
  const DrawnPerson drawn = draw_marks(figure(), 200, 200);
  const double pi = std::numbers::pi;
  EXPECT_NEAR(area(drawn.head), pi * 1600, 10);
  EXPECT_NEAR(area(drawn.person), pi * 1600 + 20000 - pi * 100, 15);
  EXPECT_DOUBLE_EQ(drawn.head_width_px, 80);
  EXPECT_EQ(*drawn.person.at(150, 150), 0);
  EXPECT_EQ(*drawn.person.at(0, 199), 255);
}

TEST(PersonMarks, PixelsAreInWhereTheirCentresAre) {
  PersonOutline outline;
  outline.person = outline.head = {{{2.4, 1.6}, {7.6, 1.6}, {7.6, 4.4}, {2.4, 4.4}}};
  const DrawnPerson drawn = draw_marks(outline, 10, 10);
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 10; ++x)
      EXPECT_EQ(*drawn.person.at(x, y) > 0, x >= 2 && x <= 7 && y >= 2 && y <= 3) << x << ", " << y;
}

TEST(PersonMarks, AreUnsureWithinAHundredthOfTheHeadsWidthAlongEdgesButNotAtThePicturesBorder) {
  PersonOutline outline;
  outline.head = {circle(200, 150, 150)};  // 300 px wide: 3 px to either side
  outline.person = {circle(200, 150, 150), {{0, 400}, {0, 290}, {400, 290}, {400, 400}}};
  const DrawnPerson drawn = draw_marks(outline, 400, 400);
  for (const double r : {145.0, 148.0, 149.5, 151.0, 152.0, 155.0})
    EXPECT_EQ(*drawn.unsure.at(200 - int(r), 150) > 0, std::abs(r - 0.5 - 150) <= 3) << r;
  EXPECT_EQ(*drawn.unsure.at(10, 291), 255);  // the torso's upper edge
  EXPECT_EQ(*drawn.unsure.at(0, 350), 0);     // the picture's edge
  EXPECT_EQ(*drawn.unsure.at(200, 399), 0);
}

TEST(PersonMarks, AreUnsureWhereTheyAreDrawnSo) {
  PersonOutline outline = figure();
  outline.unsure = {circle(20, 20, 5)};
  const DrawnPerson drawn = draw_marks(outline, 200, 200);
  EXPECT_EQ(*drawn.unsure.at(20, 20), 255);
  EXPECT_EQ(*drawn.unsure.at(28, 20), 0);
  EXPECT_EQ(*drawn.person.at(20, 20), 0);
}

TEST(PersonMarks, WhatIsBesideTheHeadIsTheHeadsAndWhatIsBesideTheTorsoIsTheTorsos) {
  const DrawnPerson drawn = draw_marks(figure(), 200, 200);
  EXPECT_EQ(*drawn.head_nearer.at(100, 60), 255);
  EXPECT_EQ(*drawn.head_nearer.at(100, 2), 255);
  EXPECT_EQ(*drawn.head_nearer.at(40, 60), 255);
  EXPECT_EQ(*drawn.head_nearer.at(100, 150), 0);
  EXPECT_EQ(*drawn.head_nearer.at(10, 95), 0);
  EXPECT_EQ(*drawn.head_nearer.at(150, 150), 0);  // the hole
}

TEST(PersonMarks, AreReadAndRefusedByName) {
  const fs::path path = fs::temp_directory_path() / "likeness_person_marks.json";
  const std::string head = R"({"version":1,"clip":"a.mp4","video_hash":"0f","size":[64,48],"frames":[)";
  const std::string frame =
      R"({"frame":3,"person":[[[4,48],[9.5,2],[40,48]]],"head":[[[6,20],[9.5,2],[20,20]]]})";
  ASSERT_TRUE(write_text(path, head + frame + "]}"));
  const auto marks = read_person_marks(path);
  ASSERT_TRUE(marks) << marks.error().what;
  EXPECT_EQ(marks->width, 64);
  EXPECT_EQ(marks->video_hash, "0f");
  ASSERT_EQ(marks->frames.size(), 1u);
  EXPECT_EQ(marks->frames[0].frame, 3);
  EXPECT_EQ(marks->frames[0].person[0][1], Vec2d(9.5, 2));
  EXPECT_TRUE(marks->frames[0].holes.empty());
  for (const std::string& bad :
       {head + frame + "," + frame + "]}", head + R"({"frame":3,"person":[[[4,48],[9.5,2],[40,48]]]}]})",
        head + R"({"frame":3,"person":[[[4,48],[9.5,2]]],"head":[[[6,20],[9.5,2],[20,20]]]}]})",
        head + R"({"frame":3,"person":[[[4,48],[9.5,2],[65,48]]],"head":[[[6,20],[9.5,2],[20,20]]]}]})",
        std::string(R"({"version":2,"clip":"a.mp4","video_hash":"0f","size":[64,48],"frames":[]})"),
        std::string(R"({"version":1})"), std::string("[")}) {
    ASSERT_TRUE(write_text(path, bad));
    EXPECT_FALSE(read_person_marks(path)) << bad;
  }
  fs::remove(path);
}

// The files that are kept hold what their format promises, and a head that is part of the person.
TEST(PersonMarks, OfEveryClipAreFiveFramesWithTheHeadWithinThePerson) {
  int clips = 0;
  for (const auto& entry :
       fs::directory_iterator(fs::path(LIKENESS_SOURCE) / "tests/core/lab/truth/person_marks")) {
    ++clips;
    const auto marks = read_person_marks(entry.path());
    ASSERT_TRUE(marks) << entry.path() << ": " << marks.error().what;
    EXPECT_EQ(marks->frames.size(), 5u) << entry.path();
    EXPECT_EQ(entry.path().stem(), fs::path(marks->clip).stem());
    for (const PersonOutline& outline : marks->frames) {
      const DrawnPerson drawn = draw_marks(outline, marks->width, marks->height);
      double outside = 0;
      for (std::size_t i = 0; i < drawn.head.data.size(); ++i)
        outside += drawn.head.data[i] && !drawn.person.data[i] && !drawn.unsure.data[i];
      EXPECT_LT(outside, 0.005 * area(drawn.head)) << marks->clip << " " << outline.frame;
      EXPECT_LT(area(drawn.head), area(drawn.person)) << marks->clip << " " << outline.frame;
      EXPECT_LT(area(drawn.unsure), 0.5 * area(drawn.person)) << marks->clip << " " << outline.frame;
    }
  }
  EXPECT_GT(clips, 0);
}

}  // namespace
}  // namespace likeness
