// Where the samples of a ray lie.
#include "core/render/strata.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/check.h"

namespace likeness {
namespace {

// Share of the pieces of refine_strata that goes by length, whatever the weights say.
constexpr float kRefineEvenShare = 0.25f;

// splitmix64: one well-mixed number per (seed, index).
std::uint64_t mix(std::uint64_t v) {
  v += 0x9e3779b97f4a7c15ull;
  v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9ull;
  v = (v ^ (v >> 27)) * 0x94d049bb133111ebull;
  return v ^ (v >> 31);
}

float unit_float(std::uint64_t bits) { return float(bits >> 40) * 0x1p-24f; }

// Transmittance up to each interval times what it takes away, both lists in depth order; returns the sum.
float lost_light(std::span<const Interval> head, std::span<const Interval> torso, float* weights) {
  std::size_t h = 0, t = 0;
  float transmittance = 1;
  while (h < head.size() || t < torso.size()) {
    const bool from_head = t == torso.size() || (h < head.size() && head[h].near <= torso[t].near);
    const Interval& interval = from_head ? head[h] : torso[t];
    const float d = interval.depth;
    // exp(d) by its first terms: where the light goes need not be known better.
    const float after = transmittance / (1 + d * (1 + d * (0.5f + d * (1.f / 6 + d * (1.f / 24)))));
    weights[from_head ? h : head.size() + t] = transmittance - after;
    transmittance = after;
    from_head ? ++h : ++t;
  }
  return 1 - transmittance;
}

// Lengths along the two lists, asked for in rising order, to places on the ray.
struct Placing {
  std::span<const Interval> list, next;
  std::size_t index = 0;
  float passed = 0;  // length of the intervals before list[index]
  int field = 0;

  RaySample at(float length) {
    while (true) {
      if (index == list.size()) {
        if (field == 1 || next.empty()) break;
        list = next, field = 1, index = 0;
        continue;
      }
      const float own = list[index].far - list[index].near;
      if (length < passed + own) return {list[index].near + (length - passed), 0, field};
      passed += own;
      ++index;
    }
    return {list.back().far, 0, field};  // rounding went past the end
  }
};

// Cuts the length of segments into `count` pieces of equal mass. segment(i): length (m) and mass, which add
// up to 1. piece(k, start, end) in lengths, in rising order.
template <class Segment, class Piece>
void cut_evenly(std::size_t segments, const Segment& segment, float total, int count, const Piece& piece) {
  std::size_t index = 0;
  float mass = 0, passed = 0, start = 0;  // before segment `index`; start: of piece k
  for (int k = 0; k < count; ++k) {
    const float goal = float(k + 1) / float(count);
    float end = total;
    while (k + 1 < count && index < segments) {
      const auto [length, own] = segment(index);
      if (mass + own >= goal) {
        end = passed + length * std::clamp((goal - mass) / own, 0.f, 1.f);
        break;
      }
      mass += own, passed += length, ++index;
    }
    end = std::clamp(end, start, total);
    piece(k, start, end);
    start = end;
  }
}

struct Segment {
  float length, mass;
};

// The strata of place_samples: calls stratum(k, start, end) in lengths along the two lists, in rising order;
// returns how many there are.
template <class Stratum>
int cut_strata(std::span<const Interval> head, std::span<const Interval> torso, float min_step,
               float even_share, int most, const Stratum& stratum) {
  float total = 0, known = 0;
  for (const std::span<const Interval> list : {head, torso})
    for (const Interval& i : list) total += i.far - i.near, known += i.depth;
  if (total <= 0 || most <= 0) return 0;
  const int count = std::clamp(int(std::ceil(total / min_step)), 1, most);
  static thread_local std::vector<float> weights;  // of the lists' intervals, head first; sum: what is lost
  weights.assign(head.size() + torso.size(), 0.f);
  const float lost = known > 0 ? lost_light(head, torso, weights.data()) : 0;
  const float even = (1 - (1 - even_share) * lost) / total;  // share of the samples per m
  const auto segment = [&](std::size_t i) {
    const Interval& interval = i < head.size() ? head[i] : torso[i - head.size()];
    const float length = interval.far - interval.near;
    return Segment{length, (1 - even_share) * weights[i] + even * length};
  };
  cut_evenly(weights.size(), segment, total, count, stratum);
  return count;
}

}  // namespace

int place_samples(std::span<const Interval> head, std::span<const Interval> torso, float min_step,
                  float even_share, std::uint64_t jitter, std::span<RaySample> samples) {
  Placing placing{head, torso};
  const int count =
      cut_strata(head, torso, min_step, even_share, int(samples.size()), [&](int k, float start, float end) {
        const float u = jitter == 0 ? 0.5f : unit_float(mix(jitter + std::uint64_t(k)));
        samples[std::size_t(k)] = placing.at(start + u * (end - start));
        samples[std::size_t(k)].dt = end - start;
      });
  std::sort(samples.begin(), samples.begin() + count,
            [](const RaySample& a, const RaySample& b) { return a.t < b.t; });
  return count;
}

int place_strata(std::span<const Interval> head, std::span<const Interval> torso, float min_step,
                 std::span<RayStratum> strata) {
  Placing placing{head, torso};
  const int count =
      cut_strata(head, torso, min_step, kEvenShare, int(strata.size()), [&](int k, float start, float end) {
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
    masses.push_back({strata[i].start, strata[i].sample.dt, std::max(before, own) + std::max(own, after)});
    lost += own, blurred += masses.back().mass, total += masses.back().length;
  }
  // What passes may yet be lost in any of them.
  const float directed = blurred > 0 ? (1 - kRefineEvenShare) * std::min(lost, 1.f) : 0;
  const float scale = blurred > 0 ? directed / blurred : 0, even = (1 - directed) / float(strata.size());
  std::sort(masses.begin(), masses.end(), [](const Mass& a, const Mass& b) { return a.start < b.start; });
  Placing placing{head, torso};
  const auto segment = [&](std::size_t i) {
    return Segment{masses[i].length, scale * masses[i].mass + even};
  };
  cut_evenly(masses.size(), segment, total, int(samples.size()), [&](int k, float start, float end) {
    samples[std::size_t(k)] = placing.at(0.5f * (start + end));
    samples[std::size_t(k)].dt = end - start;
  });
  std::sort(samples.begin(), samples.end(), [](const RaySample& a, const RaySample& b) { return a.t < b.t; });
  return int(samples.size());
}

}  // namespace likeness
