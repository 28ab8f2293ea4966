// The cutting of a ray's stretches into strata (strata.h), for processor and device. Plain C++17.
//
// Lists: a ray's stretches, in depth order within each field. It offers count(field), interval(field, i),
// and weight(i), set_weight(i, w) with i counting the head's stretches first, then the torso's.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/base/host_device.h"
#include "core/render/ray_samples.h"

namespace likeness {

// Share of the pieces of refined strata distributed by length, regardless of the weights.
constexpr float kRefineEvenShare = 0.25f;

LIKENESS_HOST_DEVICE inline float smaller(float a, float b) { return b < a ? b : a; }
LIKENESS_HOST_DEVICE inline float larger(float a, float b) { return a < b ? b : a; }
LIKENESS_HOST_DEVICE inline float bounded(float v, float low, float high) {
  return v < low ? low : high < v ? high : v;
}

// Sets the weights to the transmittance up to each stretch times what it takes away, both lists in depth
// order; returns their sum.
template <class Lists>
LIKENESS_HOST_DEVICE float lost_light(Lists& lists) {
  const int head = lists.count(0), torso = lists.count(1);
  int h = 0, t = 0;
  float transmittance = 1;
  while (h < head || t < torso) {
    const bool from_head = t == torso || (h < head && lists.interval(0, h).near <= lists.interval(1, t).near);
    const float d = from_head ? lists.interval(0, h).depth : lists.interval(1, t).depth;
    // exp(d) by its first terms: this is accurate enough to place samples.
    const float after = transmittance / (1 + d * (1 + d * (0.5f + d * (1.f / 6 + d * (1.f / 24)))));
    lists.set_weight(from_head ? h : head + t, transmittance - after);
    transmittance = after;
    from_head ? ++h : ++t;
  }
  return 1 - transmittance;
}

// Where in its stratum a ray's sample k lies, of [0, 1): by the ray's seed, or in the middle with 0.
LIKENESS_HOST_DEVICE inline float place_in_stratum(std::uint64_t jitter, int k) {
  if (jitter == 0) return 0.5f;
  std::uint64_t v = jitter + std::uint64_t(k) + 0x9e3779b97f4a7c15ull;  // splitmix64
  v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9ull;
  v = (v ^ (v >> 27)) * 0x94d049bb133111ebull;
  return float((v ^ (v >> 31)) >> 40) * 0x1p-24f;
}

// Maps lengths along the two lists, requested in rising order, to places on the ray.
template <class Lists>
struct Placing {
  const Lists& lists;
  int index = 0;
  float passed = 0;  // length of the stretches before `index`
  int field = 0;

  LIKENESS_HOST_DEVICE explicit Placing(const Lists& of) : lists(of) {}
  LIKENESS_HOST_DEVICE RaySample at(float length) {
    while (true) {
      if (index == lists.count(field)) {
        if (field == 1 || lists.count(1) == 0) break;
        field = 1, index = 0;
        continue;
      }
      const Interval here = lists.interval(field, index);
      const float own = here.far - here.near;
      if (length < passed + own) return {here.near + (length - passed), 0, field};
      passed += own;
      ++index;
    }
    return {lists.interval(field, lists.count(field) - 1).far, 0, field};  // rounding went past the end
  }
};

struct LengthAndMass {
  float length, mass;  // m; share
};

// Cuts the length of segments into `count` pieces of equal mass. segment(i): masses add up to 1.
// piece(k, start, end) in lengths, in rising order.
template <class Segment, class Piece>
LIKENESS_HOST_DEVICE void cut_evenly(int segments, const Segment& segment, float total, int count,
                                     const Piece& piece) {
  int index = 0;
  float mass = 0, passed = 0, start = 0;  // before segment `index`; start: of piece k
  for (int k = 0; k < count; ++k) {
    const float goal = float(k + 1) / float(count);
    float end = total;
    while (k + 1 < count && index < segments) {
      const LengthAndMass here = segment(index);
      if (mass + here.mass >= goal) {
        end = passed + here.length * bounded((goal - mass) / here.mass, 0.f, 1.f);
        break;
      }
      mass += here.mass, passed += here.length, ++index;
    }
    end = bounded(end, start, total);
    piece(k, start, end);
    start = end;
  }
}

// The strata of place_samples: calls stratum(k, start, end) in lengths along the two lists, in rising order;
// returns how many there are.
template <class Lists, class Stratum>
LIKENESS_HOST_DEVICE int cut_strata(Lists& lists, float min_step, float even_share, int most,
                                    const Stratum& stratum) {
  float total = 0, known = 0;
  for (int f = 0; f < 2; ++f)
    for (int i = 0; i < lists.count(f); ++i) {
      const Interval here = lists.interval(f, i);
      total += here.far - here.near, known += here.depth;
    }
  if (total <= 0 || most <= 0) return 0;
  const int wanted = int(std::ceil(total / min_step));
  const int count = wanted < 1 ? 1 : wanted > most ? most : wanted;
  const int head = lists.count(0), all = head + lists.count(1);
  float lost = 0;
  if (known > 0)
    lost = lost_light(lists);
  else
    for (int i = 0; i < all; ++i) lists.set_weight(i, 0);
  const float even = (1 - (1 - even_share) * lost) / total;  // share of the samples per m
  const auto segment = [&](int i) {
    const Interval here = i < head ? lists.interval(0, i) : lists.interval(1, i - head);
    const float length = here.far - here.near;
    return LengthAndMass{length, (1 - even_share) * lists.weight(i) + even * length};
  };
  cut_evenly(all, segment, total, count, stratum);
  return count;
}

// -- Strata cut again (refine_strata)

// Mass of a stratum whose weight is `own`, taking its neighbours in depth into account.
LIKENESS_HOST_DEVICE inline float blurred_weight(float before, float own, float after) {
  return larger(before, own) + larger(own, after);
}

// A stratum's share of the pieces: scale times its blurred weight, plus `even`.
struct RefineShares {
  float scale, even;

  // lost, blurred: sums of the strata's weights, and of their blurred ones. Light that passes may still be
  // lost in any of them.
  LIKENESS_HOST_DEVICE RefineShares(float lost, float blurred, int strata) {
    const float directed = blurred > 0 ? (1 - kRefineEvenShare) * smaller(lost, 1.f) : 0;
    scale = blurred > 0 ? directed / blurred : 0, even = (1 - directed) / float(strata);
  }
};

}  // namespace likeness
