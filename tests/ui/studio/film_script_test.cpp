// Claims about what is asked of a person who is being filmed.
#include "ui/studio/film_script.h"

#include <gtest/gtest.h>

#include <set>

namespace likeness::ui {
namespace {

TEST(FilmScript, TakesAboutAMinuteAndAsksForEverythingOnce) {
  EXPECT_GT(film_script_s(), 50);
  EXPECT_LT(film_script_s(), 70);
  std::set<std::string_view> words;
  std::set<FilmDrawing> drawings;
  for (const FilmCue& cue : film_script()) {
    EXPECT_GE(cue.seconds, 3) << cue.words << ": too short to hear of it and do it";
    EXPECT_TRUE(words.insert(cue.words).second) << cue.words;
    drawings.insert(cue.drawing);
  }
  for (const FilmDrawing asked :
       {FilmDrawing::turn_left, FilmDrawing::turn_right, FilmDrawing::raise_chin, FilmDrawing::lower_chin,
        FilmDrawing::smile, FilmDrawing::open_mouth, FilmDrawing::close_eyes, FilmDrawing::speak})
    EXPECT_TRUE(drawings.contains(asked)) << int(asked);
}

TEST(FilmScript, EveryCueHasItsTimeAndTheEndHasNone) {
  double start_s = 0;
  for (std::size_t i = 0; i < film_script().size(); ++i) {
    const FilmCue& cue = film_script()[i];
    EXPECT_EQ(script_place(start_s).cue, i);
    EXPECT_NEAR(script_place(start_s).left_s, cue.seconds, 1e-9);
    EXPECT_EQ(script_place(start_s + 0.9 * cue.seconds).cue, i);
    start_s += cue.seconds;
  }
  EXPECT_EQ(script_place(film_script_s()).cue, film_script().size());
  EXPECT_EQ(script_place(1000).cue, film_script().size());
  EXPECT_EQ(script_place(1000).left_s, 0);
}

}  // namespace
}  // namespace likeness::ui
