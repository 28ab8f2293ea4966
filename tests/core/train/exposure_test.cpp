// Claims about exposure and white balance told from the background, and about frames freed of them.
#include "core/train/exposure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/train/choose_parts.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

int largest_difference(const Image8& a, const Image8& b) {
  int largest = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i)
    largest = std::max(largest, std::abs(int(a.data[i]) - int(b.data[i])));
  return largest;
}

// As a camera's automatic wanders: at most a sixth brighter or darker, at most a twentieth redder.
Vec3f wander(std::size_t v) {
  const float light = 1 + 0.16f * std::sin(0.4f * float(v)), warm = 0.05f * std::cos(0.3f * float(v));
  return light * Vec3f(1 + warm, 1, 1 - warm);
}

TrainingSet wandering_set() {
  TrainingSet set = ball_set(40, 64);
  for (std::size_t v = 0; v < set.views.size(); ++v) set.views[v].rgb = exposed(set.views[v].rgb, wander(v));
  return set;
}

TEST(Exposure, APictureInItsOwnLightStaysAsItIs) {
  const TrainingSet set = ball_set(2, 64);
  EXPECT_EQ(exposed(set.views[0].rgb, Vec3f::Ones()).data, set.views[0].rgb.data);
}

TEST(Exposure, IsFoundInEachChannel) {
  const TrainingSet set = wandering_set();
  const std::vector<Vec3f> found = view_exposures(set);
  ASSERT_EQ(found.size(), set.views.size());
  for (std::size_t v = 0; v < found.size(); ++v)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[v][c], wander(v)[c], 0.015) << "view " << v;
}

TEST(Exposure, AShadowOnAThirdOfTheWallDoesNotCount) {
  TrainingSet set = wandering_set();
  Image8& picture = set.views[3].rgb;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width / 3; ++x)
      for (int c = 0; c < 3; ++c) picture.at(x, y)[c] = std::uint8_t(picture.at(x, y)[c] / 2);
  EXPECT_NEAR(view_exposures(set)[3].mean(), wander(3).mean(), 0.02);
}

TEST(Exposure, WhoHidesTheWallHasWhatTheNeighboursHave) {
  TrainingSet set = wandering_set();
  for (const std::size_t v : {0u, 10u, 11u, 39u})
    set.views[v].alpha = TiledMask(Image8(set.size, set.size, 1, 255));
  const std::vector<Vec3f> found = view_exposures(set);
  EXPECT_EQ(found[0], found[1]);
  EXPECT_EQ(found[39], found[38]);
  EXPECT_GT(found[10].mean(), std::min(found[9].mean(), found[12].mean()) - 1e-6f);
  EXPECT_LT(found[10].mean(), std::max(found[9].mean(), found[12].mean()) + 1e-6f);
}

TEST(Exposure, WithoutAPlateNothingIsKnownAndNothingChanges) {
  TrainingSet set = wandering_set();
  set.plate = {}, set.plate_known = {};
  for (const Vec3f& exposure : view_exposures(set)) EXPECT_EQ(exposure, Vec3f::Ones());
  const ChosenParts chosen = choose_parts(measure_capture(set, shape_head(set.model, set.person)), {});
  EXPECT_TRUE(chosen.exposures.empty());
}

TEST(Exposure, ATrainingSetIsEvenedOnceItsLightWanders) {
  const TrainingSet even = ball_set(40, 64);
  TrainingSet set = wandering_set();
  const CaptureMeasures measures = measure_capture(set, shape_head(set.model, set.person));
  ASSERT_TRUE(measures.light_drift);
  EXPECT_NEAR(*measures.light_drift, 0.16 / std::sqrt(2.0), 0.03);
  TrainOptions options;
  apply_parts(choose_parts(measures, {}), set, options);
  for (std::size_t v = 0; v < set.views.size(); ++v)  // rounded twice, and what was clipped stays clipped
    EXPECT_LE(largest_difference(set.views[v].rgb, even.views[v].rgb), 6) << "view " << v;
  EXPECT_LT(*exposure_drift(view_exposures(set)), 0.005);
}

// Red and blue swing, their mean stays.
TEST(Exposure, WhiteBalanceAloneCountsAsDrift) {
  std::vector<Vec3f> exposures;
  for (int v = 0; v < 40; ++v) {
    const float warm = 0.05f * std::sin(0.3f * float(v));
    exposures.emplace_back(1 + warm, 1, 1 - warm);
  }
  EXPECT_GT(*exposure_drift(exposures), kEvenLight);
  EXPECT_FALSE(exposure_drift({Vec3f::Ones()}));
}

// Of the frames of a walk nothing is known, and its room is learnt as filmed.
TEST(Exposure, AClipThatHardlyRestsIsLeftAlone) {
  TrainingSet set = wandering_set();
  for (std::size_t v = 10; v < set.views.size(); ++v) set.views[v].has_plate = false;
  const ChosenParts chosen = choose_parts(measure_capture(set, shape_head(set.model, set.person)), {});
  EXPECT_TRUE(chosen.exposures.empty());
}

TEST(Exposure, AnEvenSetIsLeftAlone) {
  TrainingSet set = ball_set(40, 64);
  const TrainingSet before = set;
  TrainOptions options;
  const ChosenParts chosen = choose_parts(measure_capture(set, shape_head(set.model, set.person)), {});
  EXPECT_TRUE(chosen.exposures.empty());
  apply_parts(chosen, set, options);
  for (std::size_t v = 0; v < set.views.size(); ++v)
    EXPECT_EQ(set.views[v].rgb.data, before.views[v].rgb.data);
}

}  // namespace
}  // namespace likeness
