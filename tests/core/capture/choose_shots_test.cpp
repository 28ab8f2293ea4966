// Claims about which shots of a film serve, on films made of blotches with a head before them.
#include "core/capture/choose_shots.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "tests/core/capture/made_film.h"

namespace likeness {
namespace {

using test::blotches;
using test::MadeFilm;

const std::vector<FrameSpan> kThree{{0, 39}, {40, 69}, {70, 99}};

std::optional<double> always_there(int f) { return 160 + 6 * std::sin(0.2 * f); }

std::vector<ClipShot> chosen(MadeFilm film, const std::vector<FrameSpan>& shots = kThree) {
  film.frames = shots.back().last + 1;
  if (!film.head_x) film.head_x = always_there;
  std::vector<FaceSample> samples;
  for (int f = 0; f < film.frames; f += 5) samples.push_back({f, test::made_face(film, f), false});
  return choose_shots(test::sketches_of(film), samples, shots, test::kSceneWidth, test::kSceneHeight);
}

std::vector<bool> used(const std::vector<ClipShot>& shots) {
  std::vector<bool> out;
  for (const ClipShot& shot : shots) out.push_back(shot.used);
  return out;
}

TEST(ChooseShots, AllOfOnePlaceServe) {
  const auto shots = chosen({[](double x, double y, int) { return blotches(x, y, 0); }});
  EXPECT_EQ(used(shots), (std::vector<bool>{true, true, true}));
  EXPECT_EQ(counted_words(shots), "");
}

TEST(ChooseShots, AnotherPlaceIsLeftOutWithItsReason) {
  const auto shots =
      chosen({[](double x, double y, int f) { return blotches(x, y, f >= 40 && f < 70 ? 1 : 0); }});
  EXPECT_EQ(used(shots), (std::vector<bool>{true, false, true}));
  EXPECT_EQ(shots[1].reason, "another place, angle or crop");
  EXPECT_NEAR(shots[1].from_s, 1.6, 1e-9);
  EXPECT_NEAR(shots[1].to_s, 2.8, 1e-9);
  EXPECT_TRUE(shots[0].reason.empty());
  EXPECT_NE(counted_words(shots).find("the other 1.2 s"), std::string::npos) << counted_words(shots);
}

TEST(ChooseShots, ACloserCropIsLeftOutAndALampIsNot) {
  const auto closer = chosen({[](double x, double y, int f) {
    const double zoom = f >= 40 && f < 70 ? 1.15 : 1;
    return blotches((x - 160) / zoom + 160, (y - 96) / zoom + 96, 0);
  }});
  EXPECT_EQ(used(closer), (std::vector<bool>{true, false, true}));
  const auto darker =
      chosen({[](double x, double y, int f) { return blotches(x, y, 0) * (f >= 40 && f < 70 ? 0.7 : 1); }});
  EXPECT_EQ(used(darker), (std::vector<bool>{true, true, true}));
}

TEST(ChooseShots, AnotherShapeOfPictureIsLeftOut) {
  MadeFilm film{[](double x, double y, int) { return blotches(x, y, 0); }, always_there, 100};
  std::vector<FaceSample> samples;
  for (int f = 0; f < film.frames; f += 5) samples.push_back({f, test::made_face(film, f), false});
  auto sketches = test::sketches_of(film);
  for (int f = 40; f < 70; ++f) sketches[std::size_t(f)].shape = 1;
  EXPECT_EQ(used(choose_shots(sketches, samples, kThree, test::kSceneWidth, test::kSceneHeight)),
            (std::vector<bool>{true, false, true}));
}

// Together they are longer than the one between them, which is longer than either.
TEST(ChooseShots, ThePlaceShownLongestServesNotTheLongestShot) {
  const auto shots =
      chosen({[](double x, double y, int f) { return blotches(x, y, f >= 30 && f < 70 ? 1 : 0); }},
             {{0, 29}, {30, 69}, {70, 99}});
  EXPECT_EQ(used(shots), (std::vector<bool>{true, false, true}));
}

TEST(ChooseShots, ANudgedTripodServes) {
  const auto shots =
      chosen({[](double x, double y, int f) { return blotches(x + (f >= 40 ? 8 : 0), y, 0); }});
  EXPECT_EQ(used(shots), (std::vector<bool>{true, true, true}));
}

// It is at one place at the cut, and far from it at the ends.
TEST(ChooseShots, ACameraThatWandersServesOnBothSidesOfACut) {
  const auto shots = chosen({[](double x, double y, int f) { return blotches(x + 1.5 * f, y, 0); }});
  EXPECT_EQ(used(shots), (std::vector<bool>{true, true, true}));
}

TEST(ChooseShots, NobodyAndAMomentAreLeftOut) {
  const MadeFilm film{
      [](double x, double y, int) { return blotches(x, y, 0); },
      [](int f) { return f >= 40 && f < 70 ? std::nullopt : always_there(f); },
  };
  const auto shots = chosen(film, {{0, 39}, {40, 69}, {70, 73}, {74, 99}});
  EXPECT_EQ(used(shots), (std::vector<bool>{true, false, false, true}));
  EXPECT_EQ(shots[1].reason, "no face");
  EXPECT_EQ(shots[2].reason, "it has only 4 frames");
}

TEST(ChooseShots, WithoutAnyFaceNothingIsLeftOut) {
  const auto shots = chosen({[](double x, double y, int f) { return blotches(x, y, f >= 40); },
                             [](int) -> std::optional<double> { return std::nullopt; }});
  EXPECT_EQ(used(shots), (std::vector<bool>{true, true, true}));
}

TEST(ChooseShots, BeforeAPlainWallTheFaceDecides) {
  const auto plain = [](double, double, int) { return 150.0; };
  EXPECT_EQ(used(chosen({plain})), (std::vector<bool>{true, true, true}));
  const auto painted = [](double, double, int f) { return f >= 40 && f < 70 ? 110.0 : 150.0; };
  EXPECT_EQ(used(chosen({painted})), (std::vector<bool>{true, false, true}));
}

TEST(EveryShot, IsFollowedWhateverItShowsAndAnUncutFilmHasNone) {
  const auto film_of = [](auto&& scene) {
    MadeFilm film{scene, always_there};
    film.frames = 100;
    ClipScan scan;
    scan.film = test::sketches_of(film);
    scan.info.frames_per_second = 25;
    return every_shot(scan);
  };
  const auto cut =
      film_of([](double x, double y, int f) { return blotches(x, y, f >= 40 && f < 70 ? 1 : 0); });
  ASSERT_EQ(cut.size(), 3u);
  for (std::size_t i = 0; i < cut.size(); ++i) EXPECT_EQ(cut[i].first, kThree[i].first);
  EXPECT_GE(cut.back().last, 99);
  EXPECT_TRUE(film_of([](double x, double y, int) { return blotches(x, y, 0); }).empty());
}

TEST(ChooseShots, WordsNameTheSecondsThatServe) {
  const std::vector<ClipShot> shots{{0, 99, 0, 4, true, ""},
                                    {100, 149, 4, 6, true, ""},
                                    {150, 199, 6, 8, false, "no face"},
                                    {200, 299, 8, 12, true, ""}};
  EXPECT_EQ(serving_words(shots), "0:00-0:06 and 0:08-0:12");
}

}  // namespace
}  // namespace likeness
