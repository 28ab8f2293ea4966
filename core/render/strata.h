// Where the samples of a ray lie: its stretches through occupied cells, cut into strata with a sample each,
// by what is expected in them and again by what was found in them.
#pragma once

#include <cstdint>
#include <span>

#include "core/render/ray_samples.h"

namespace likeness {

// Cuts the length of both lists (head first) into strata, at most `samples.size()` of them and on average no
// shorter than min_step, puts a sample into each and sorts them by depth; returns how many. Strata are short
// where the light is expected to be lost (transmittance times opacity, by the intervals' optical depths), but
// even_share of them (0 to 1) is spread over the whole length, as is the share of the light that is expected
// to pass. jitter 0: midpoints; otherwise a seed that places each sample anywhere in its stratum.
int place_samples(std::span<const Interval> head, std::span<const Interval> torso, float min_step,
                  float even_share, std::uint64_t jitter, std::span<RaySample> samples);
// The strata themselves with kEvenShare, samples in their midpoints.
int place_strata(std::span<const Interval> head, std::span<const Interval> torso, float min_step,
                 std::span<RayStratum> strata);

// Cuts strata again where the light is now known to be lost, and puts a sample into the middle of each piece;
// at most samples.size() of them, in depth order. head, torso, strata: the arguments and result of
// place_strata; weights: of each stratum, the share of the light that it takes. As Mildenhall et al. 2020,
// section 5.2, except that a stratum is cut evenly and that its neighbours' weights also count, since one
// sample may miss where a surface begins (Barron et al. 2021, section 3.4). A stratum that gets no piece is
// left out.
int refine_strata(std::span<const Interval> head, std::span<const Interval> torso,
                  std::span<const RayStratum> strata, std::span<const float> weights,
                  std::span<RaySample> samples);

}  // namespace likeness
