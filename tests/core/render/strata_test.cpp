// Claims about the placing of a ray's samples.
#include "core/render/strata.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace likeness {
namespace {

TEST(PlaceSamples, AreSortedInsideTheirIntervalsAndCoverTheLength) {
  const std::vector<Interval> head{{1.0f, 1.1f}, {1.3f, 1.35f}}, torso{{1.05f, 1.25f}};
  for (const std::uint64_t jitter : {0, 7, 99}) {
    std::vector<RaySample> samples(16);
    const int n = place_samples(head, torso, 0.0015f, 0.25f, jitter, samples);
    EXPECT_EQ(n, 16);
    float length = 0;
    for (int i = 0; i < n; ++i) {
      if (i > 0) {
        EXPECT_LE(samples[i - 1].t, samples[i].t);
      }
      bool inside = false;
      for (const Interval& interval : samples[i].field == 0 ? head : torso)
        inside |= samples[i].t >= interval.near - 1e-5f && samples[i].t <= interval.far + 1e-5f;
      EXPECT_TRUE(inside) << samples[i].t << " of field " << samples[i].field;
      length += samples[i].dt;
    }
    EXPECT_NEAR(length, 0.35f, 1e-5);
  }
}

TEST(PlaceSamples, AreNoDenserThanAsked) {
  const std::vector<Interval> head{{1.0f, 1.01f}};
  std::vector<RaySample> samples(16);
  EXPECT_EQ(place_samples(head, {}, 0.0025f, 0.25f, 0, samples), 4);
}

// Air, a wall that takes nearly all light, and what lies behind it: most samples go into the wall.
TEST(PlaceSamples, GoWhereTheLightIsLost) {
  std::vector<Interval> head{{1.00f, 1.04f, 0.001f}, {1.04f, 1.05f, 8.f}, {1.05f, 1.10f, 8.f}};
  for (const std::uint64_t jitter : {0, 5}) {
    std::vector<RaySample> samples(16);
    ASSERT_EQ(place_samples(head, {}, 0.0015f, 0.25f, jitter, samples), 16);
    int in_wall = 0, behind = 0;
    float length = 0;
    for (const RaySample& s : samples)
      in_wall += s.t >= 1.04f && s.t < 1.05f, behind += s.t >= 1.05f, length += s.dt;
    EXPECT_GE(in_wall, 11);
    EXPECT_GE(behind, 1);  // the grid may be wrong
    EXPECT_NEAR(length, 0.1f, 1e-6);
  }
}

// With no share left to the light, strata are equally long; with half of them, a wall that takes all light
// has half the samples, and its part of the others.
TEST(PlaceSamples, EvenShareIsSpreadOverTheWholeLength) {
  const std::vector<Interval> head{{1.00f, 1.04f, 0.f}, {1.04f, 1.05f, 50.f}, {1.05f, 1.10f, 8.f}};
  std::vector<RaySample> samples(40);
  ASSERT_EQ(place_samples(head, {}, 1e-4f, 1.f, 0, samples), 40);
  for (const RaySample& s : samples) EXPECT_NEAR(s.dt, 0.1f / 40, 1e-6);
  ASSERT_EQ(place_samples(head, {}, 1e-4f, 0.5f, 0, samples), 40);
  const auto in_wall =
      std::ranges::count_if(samples, [](const RaySample& s) { return s.t >= 1.04f && s.t < 1.05f; });
  EXPECT_NEAR(double(in_wall), 40 * (0.5 + 0.5 * 0.1), 1.5);
}

// The torso's wall stands before the head's: what is behind it gets few samples, whichever list it is in.
TEST(PlaceSamples, LooksThroughBothFieldsInDepthOrder) {
  const std::vector<Interval> head{{1.1f, 1.12f, 9.f}}, torso{{1.0f, 1.02f, 9.f}};
  std::vector<RaySample> samples(16);
  const int n = place_samples(head, torso, 0.001f, 0.25f, 0, samples);
  const auto of_torso =
      std::count_if(samples.begin(), samples.begin() + n, [](auto& s) { return s.field == 1; });
  EXPECT_GE(of_torso, n * 3 / 4);
  EXPECT_LT(of_torso, n);
}

// A homogeneous medium needs no samples placed well: by any density guessed, its transmittance is the same.
TEST(PlaceSamples, AnyGuessOfTheDensityCoversTheSameLength) {
  std::mt19937 engine(6);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Interval> lists[2];
    float total = 0;
    for (auto& list : lists) {
      float t = 1 + uniform(engine);
      for (int i = 0; i < 8; ++i) {
        const float near = t + 0.01f * uniform(engine), far = near + 0.0001f + 0.01f * uniform(engine);
        list.push_back({near, far, std::pow(10.f, 8 * uniform(engine) - 4)});
        total += far - near, t = far;
      }
    }
    std::vector<RaySample> samples(16);
    const int n = place_samples(lists[0], lists[1], 0.0015f, 0.25f, std::uint64_t(trial), samples);
    float length = 0;
    for (int k = 0; k < n; ++k) {
      length += samples[k].dt;
      EXPECT_GE(samples[k].dt, 0);
      bool inside = false;
      for (const Interval& i : lists[samples[k].field])
        inside |= samples[k].t >= i.near - 1e-5f && samples[k].t <= i.far + 1e-5f;
      EXPECT_TRUE(inside);
    }
    EXPECT_NEAR(length, total, 1e-5f);
  }
}

// Two intervals with a gap, the light lost in a thin wall that the first strata only know the place of.
TEST(RefineStrata, PutTheSamplesWhereTheLightWasFoundToBeLost) {
  const std::vector<Interval> head{{1.00f, 1.04f}, {1.10f, 1.16f}};
  std::vector<RayStratum> strata(10);
  ASSERT_EQ(place_strata(head, {}, 0.001f, strata), 10);
  std::vector<float> weights(10, 0.f);
  for (std::size_t i = 0; i < strata.size(); ++i)
    if (strata[i].sample.t > 1.12f && strata[i].sample.t < 1.13f) weights[i] = 1;
  std::vector<RaySample> samples(12);
  ASSERT_EQ(refine_strata(head, {}, strata, weights, samples), 12);
  int near_wall = 0;
  float length = 0;
  for (const RaySample& s : samples) {
    near_wall += s.t > 1.11f && s.t < 1.14f;
    length += s.dt;
    EXPECT_TRUE((s.t >= 1.00f && s.t <= 1.04f) || (s.t >= 1.10f && s.t <= 1.16f)) << s.t;
  }
  EXPECT_GE(near_wall, 9);   // the stratum and its neighbours
  EXPECT_LT(near_wall, 12);  // a guess may be wrong
  EXPECT_NEAR(length, 0.1f, 1e-5f);
}

// Where nothing was lost, every stratum is as good as another.
TEST(RefineStrata, KeepTheStrataOfATransparentRay) {
  const std::vector<Interval> head{{1.0f, 1.05f, 0.2f}}, torso{{1.02f, 1.08f, 0.1f}};
  std::vector<RayStratum> strata(8);
  ASSERT_EQ(place_strata(head, torso, 0.001f, strata), 8);
  std::vector<RaySample> samples(8);
  ASSERT_EQ(refine_strata(head, torso, strata, std::vector<float>(8, 0.f), samples), 8);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_NEAR(samples[i].t, strata[i].sample.t, 1e-5f);
    EXPECT_NEAR(samples[i].dt, strata[i].sample.dt, 1e-5f);
    EXPECT_EQ(samples[i].field, strata[i].sample.field);
  }
}

// Whatever was found, the samples are in depth order, in their intervals, and stand for the whole length.
TEST(RefineStrata, CoverTheLengthWhateverTheWeights) {
  std::mt19937 engine(12);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<Interval> lists[2];
    float total = 0;
    for (auto& list : lists) {
      float t = 1 + uniform(engine);
      for (int i = 0; i < 6; ++i) {
        const float near = t + 0.01f * uniform(engine), far = near + 0.0005f + 0.01f * uniform(engine);
        list.push_back({near, far, uniform(engine) < 0.5f ? 0.f : uniform(engine)});
        total += far - near, t = far;
      }
    }
    std::vector<RayStratum> strata(1 + std::size_t(trial) % 16);
    strata.resize(std::size_t(place_strata(lists[0], lists[1], 0.0001f, strata)));
    std::vector<float> weights;
    float left = 1;
    for (std::size_t i = 0; i < strata.size(); ++i) {
      weights.push_back(left * std::pow(uniform(engine), 4.f));
      left -= weights.back();
    }
    std::vector<RaySample> samples(1 + std::size_t(trial) % 12);
    ASSERT_EQ(refine_strata(lists[0], lists[1], strata, weights, samples), int(samples.size()));
    float length = 0;
    for (std::size_t k = 0; k < samples.size(); ++k) {
      length += samples[k].dt;
      EXPECT_GE(samples[k].dt, 0);
      if (k > 0) {
        EXPECT_LE(samples[k - 1].t, samples[k].t);
      }
      bool inside = false;
      for (const Interval& i : lists[samples[k].field])
        inside |= samples[k].t >= i.near - 1e-5f && samples[k].t <= i.far + 1e-5f;
      EXPECT_TRUE(inside);
    }
    EXPECT_NEAR(length, total, 1e-5f);
  }
}

// A wall in fog, somewhere in cells as coarse as an avatar's: 8 strata looked into and 8 samples by what they
// showed come nearer to the true colour than 16 samples by the cells' opacity.
TEST(RefineStrata, BeatTheSameNumberOfSamplesPlacedByTheGrid) {
  std::mt19937 engine(14);
  std::uniform_real_distribution<float> uniform(0, 1);
  double by_grid = 0, by_strata = 0;
  for (int trial = 0; trial < 400; ++trial) {
    std::vector<Interval> cells;  // 5 mm each
    const float wall = 1.01f + 0.02f * uniform(engine);
    for (int i = 0; i < 8; ++i) {
      const float near = 1 + 0.005f * float(i), far = near + 0.005f;
      cells.push_back({near, far, far < wall - 0.002f ? 0.01f : near < wall + 0.004f ? 2.f : 8.f});
    }
    const auto density = [&](float t) { return t < wall ? 5.f : 2000.f; };
    const auto colour = [&](float t) { return 0.5f + 0.5f * std::sin(800 * (t - wall)); };
    const auto composited = [&](std::span<const RaySample> samples, std::vector<float>* weights) {
      float transmittance = 1, sum = 0;
      for (const RaySample& s : samples) {
        const float after = transmittance * std::exp(-density(s.t) * s.dt);
        if (weights) weights->push_back(transmittance - after);
        sum += (transmittance - after) * colour(s.t);
        transmittance = after;
      }
      return sum;
    };
    std::vector<RaySample> many(4096), grid(16), refined(8);
    std::vector<RayStratum> strata(8);
    const int most = place_samples(std::vector<Interval>{{1.0f, 1.04f}}, {}, 1e-6f, 0.25f, 0, many);
    const float truth = composited({many.data(), std::size_t(most)}, nullptr);
    place_samples(cells, {}, 1e-4f, kEvenShare, 0, grid);
    by_grid += std::pow(composited(grid, nullptr) - truth, 2);
    place_strata(cells, {}, 1e-4f, strata);
    std::vector<RaySample> middles;
    for (const RayStratum& s : strata) middles.push_back(s.sample);
    std::vector<float> weights;
    composited(middles, &weights);
    refine_strata(cells, {}, strata, weights, refined);
    by_strata += std::pow(composited(refined, nullptr) - truth, 2);
  }
  EXPECT_LT(by_strata, by_grid);
}

TEST(RefineStrata, EmptyInputGivesNoStrata) {
  std::vector<RaySample> samples(4);
  EXPECT_EQ(refine_strata({}, {}, {}, {}, samples), 0);
}

}  // namespace
}  // namespace likeness
