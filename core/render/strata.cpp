// Where the samples of a ray lie.
#include "core/render/strata.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/check.h"
#include "core/render/strata_math.h"

namespace likeness {
namespace {

// Two lists with the weights of their stretches.
struct HostLists {
  std::span<const Interval> list[2];
  float* weights;

  int count(int field) const { return int(list[field].size()); }
  const Interval& interval(int field, int i) const { return list[field][std::size_t(i)]; }
  float weight(int i) const { return weights[i]; }
  void set_weight(int i, float weight) { weights[i] = weight; }
};

// The same memory is used for all rays of a thread.
HostLists host_lists(std::span<const Interval> head, std::span<const Interval> torso) {
  static thread_local std::vector<float> weights;
  weights.resize(head.size() + torso.size());
  return {{head, torso}, weights.data()};
}

}  // namespace

int place_samples(std::span<const Interval> head, std::span<const Interval> torso, float min_step,
                  float even_share, std::uint64_t jitter, std::span<RaySample> samples) {
  HostLists lists = host_lists(head, torso);
  Placing placing(lists);
  const int count =
      cut_strata(lists, min_step, even_share, int(samples.size()), [&](int k, float start, float end) {
        const float u = place_in_stratum(jitter, k);
        samples[std::size_t(k)] = placing.at(start + u * (end - start));
        samples[std::size_t(k)].dt = end - start;
      });
  std::sort(samples.begin(), samples.begin() + count,
            [](const RaySample& a, const RaySample& b) { return a.t < b.t; });
  return count;
}

int place_strata(std::span<const Interval> head, std::span<const Interval> torso, float min_step,
                 std::span<RayStratum> strata) {
  HostLists lists = host_lists(head, torso);
  Placing placing(lists);
  const int count =
      cut_strata(lists, min_step, kEvenShare, int(strata.size()), [&](int k, float start, float end) {
        RaySample sample = placing.at(start + 0.5f * (end - start));
        sample.dt = end - start;
        strata[std::size_t(k)] = {sample, start};
      });
  std::sort(strata.begin(), strata.begin() + count,
            [](const RayStratum& a, const RayStratum& b) { return a.sample.t < b.sample.t; });
  return count;
}

int refine_strata(std::span<const Interval> head, std::span<const Interval> torso,
                  std::span<const RayStratum> strata, std::span<const float> weights,
                  std::span<RaySample> samples) {
  LIKENESS_CHECK(strata.size() == weights.size(), "%zu weights for %zu strata", weights.size(),
                 strata.size());
  if (strata.empty() || samples.empty()) return 0;
  struct Mass {
    float start, length, mass;
  };
  static thread_local std::vector<Mass> masses;
  masses.clear();
  float lost = 0, blurred = 0, total = 0;
  for (std::size_t i = 0; i < strata.size(); ++i) {
    const float own = weights[i], before = i > 0 ? weights[i - 1] : 0,
                after = i + 1 < strata.size() ? weights[i + 1] : 0;
    masses.push_back({strata[i].start, strata[i].sample.dt, blurred_weight(before, own, after)});
    lost += own, blurred += masses.back().mass, total += masses.back().length;
  }
  const RefineShares shares(lost, blurred, int(strata.size()));
  std::sort(masses.begin(), masses.end(), [](const Mass& a, const Mass& b) { return a.start < b.start; });
  const HostLists lists{{head, torso}, nullptr};
  Placing placing(lists);
  const auto segment = [&](int i) {
    const Mass& here = masses[std::size_t(i)];
    return LengthAndMass{here.length, shares.scale * here.mass + shares.even};
  };
  cut_evenly(int(masses.size()), segment, total, int(samples.size()), [&](int k, float start, float end) {
    samples[std::size_t(k)] = placing.at(0.5f * (start + end));
    samples[std::size_t(k)].dt = end - start;
  });
  std::sort(samples.begin(), samples.end(), [](const RaySample& a, const RaySample& b) { return a.t < b.t; });
  return int(samples.size());
}

}  // namespace likeness
