// Claims about films: what cannot be written is said before any picture is rendered, with a remedy.
#include "core/film/film.h"

#include <gtest/gtest.h>

namespace likeness {
namespace {

const Intrinsics kPicture{.width = 32, .height = 32};

Avatar with_plate(int size) {
  Avatar avatar;
  avatar.plate = Image8(size, size, 3);
  return avatar;
}

TEST(CheckFilm, AStillOnThePlateIsFine) {
  EXPECT_TRUE(check_film(with_plate(32), kPicture, 1, {.out = "a.png", .background = "plate"}).ok());
}

TEST(CheckFilm, ImpossibleFilmsAreRefusedWithARemedy) {
  struct Case {
    FilmOptions options;
    std::size_t frames;
  };
  for (const Case& c :
       {Case{{.out = "a.png"}, 2}, Case{{.out = "a.mp4", .alpha = true}, 2},
        Case{{.out = "a", .background = "blue"}, 2}, Case{{.out = "a", .background = "#12345g"}, 2}}) {
    const auto checked = check_film(with_plate(32), kPicture, c.frames, c.options);
    ASSERT_FALSE(checked.ok()) << c.options.out << c.options.background;
    EXPECT_FALSE(checked.error().fix.empty());
  }
}

TEST(CheckFilm, APlateIsNotEnlarged) {
  EXPECT_FALSE(check_film(with_plate(16), kPicture, 1, {.out = "a.png", .background = "plate"}).ok());
  EXPECT_FALSE(check_film({}, kPicture, 1, {.out = "a.png", .background = "plate"}).ok());
  EXPECT_TRUE(check_film(with_plate(16), kPicture, 1, {.out = "a.png", .background = "#e6e6e6"}).ok());
}

}  // namespace
}  // namespace likeness
