// The choice of one ray of a training step - which view, which pixel, which colour over which background -
// for processor and device. Plain C++17. The contract is in ray_batch.h.
//
// Views: the pictures that are learnt from. It offers, of view v and pixel (x, y),
//   width(v), height(v), face(v) -> PixelBox     px
//   has_alpha(v), alpha(v, x, y)                 0..255; only where it has one
//   masked(v), teaches(v, x, y)                  whether anything is learnt from a pixel
//   further(v)                                   whether it is of a further clip
//   colour(v, x, y, out), plate(v, x, y, out)    in the avatar's light, [0, 1]; plate is false where
//                                                nothing may stand for the background
//   meets(v, x, y)                               aims the ray; whether it meets an occupied cell
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/host_device.h"
#include "core/train/random_stream.h"

namespace likeness {

constexpr float kFaceShare = 0.25f, kPersonShare = 0.5f, kRandomBackgroundShare = 1.f / 3;
// Share of a step's rays for all further clips: torso and background are learnt only from the first clip.
constexpr double kFurtherShare = 1.0 / 3;
// Share of a step's rays for proxies: at first, and from half of the steps on. By then they have said where
// the surface is, and what they know less well than the clip must not hold it back.
constexpr double kProxyShare = 0.2, kLateProxyShare = 0.02;
constexpr int kTries = 8, kMaskedTries = 32;  // the second where only part of the picture is trained on

struct PixelBox {
  std::int32_t x0, y0, x1, y1;  // half open; empty: the whole picture
};
struct PixelPlace {
  std::int32_t x, y;
};

// Shared by all rays of a step.
struct ChoiceNumbers {
  std::uint64_t seed, step;
  std::uint32_t views, own, drawn;  // all; of the first clip; those that are drawn from
  std::uint32_t first, rays;        // earlier rays are chosen elsewhere; their number without those
  std::int32_t drop_codes;          // 1: half of the rays have none
  std::uint32_t proxies;            // the last views of all, in a share of their own
  std::uint64_t proxies_until;      // the first step of their late share
};

struct ChosenRay {
  std::int32_t view;     // row of conditions
  std::int32_t nowhere;  // 1: every try failed; the ray meets nothing and shows its background
  std::uint64_t jitter;
  float target[3], background[3];
};

LIKENESS_HOST_DEVICE inline PixelPlace draw_pixel(const PixelBox& face, int width, int height, bool in_face,
                                                  RandomStream& random) {
  PixelBox from{0, 0, width, height};
  if (in_face && face.x1 > face.x0 && face.y1 > face.y0) from = face;
  PixelPlace pixel;
  pixel.x = from.x0 + std::int32_t(random.below(std::uint32_t(from.x1 - from.x0)));
  pixel.y = from.y0 + std::int32_t(random.below(std::uint32_t(from.y1 - from.y0)));
  return pixel;
}

LIKENESS_HOST_DEVICE inline std::size_t place_of_share(double share, std::size_t views) {
  const auto place = std::size_t(share * double(views));
  return place < views ? place : views - 1;
}

LIKENESS_HOST_DEVICE inline double proxy_share(const ChoiceNumbers& numbers) {
  if (numbers.proxies == 0) return 0;
  return numbers.step < numbers.proxies_until ? kProxyShare : kLateProxyShare;
}

// at: in [0, rays), evenly spread over a step's rays.
LIKENESS_HOST_DEVICE inline std::size_t draw_view(std::size_t own, std::size_t drawn, double at,
                                                  double rays) {
  const std::size_t further = drawn - own;
  if (further == 0) {
    const auto place = std::size_t(at * double(own) / rays);
    return place < own ? place : own - 1;
  }
  const double even = double(further) / double(drawn), share = even < kFurtherShare ? even : kFurtherShare,
               first = 1 - share;
  return at < first * rays ? place_of_share(at / (first * rays), own)
                           : own + place_of_share((at - first * rays) / (share * rays), further);
}

// Over the plate, or with the matte over another colour if there is no plate, or it is to be swapped.
template <class Views>
LIKENESS_HOST_DEVICE void paint(const Views& views, std::size_t v, PixelPlace pixel, const float (&other)[3],
                                bool swap, float (&target)[3], float (&background)[3]) {
  float rgb[3], behind[3] = {0, 0, 0};
  views.colour(v, pixel.x, pixel.y, rgb);
  const bool plate = views.plate(v, pixel.x, pixel.y, behind);
  const float alpha = views.has_alpha(v) ? float(views.alpha(v, pixel.x, pixel.y)) / 255.f : 1.f;
  for (int c = 0; c < 3; ++c) {
    if (plate && !swap) {
      target[c] = rgb[c], background[c] = behind[c];
    } else if (plate) {
      const float over = rgb[c] + (1 - alpha) * (other[c] - behind[c]);
      target[c] = over < 0 ? 0 : over > 1 ? 1 : over;
      background[c] = other[c];
    } else {
      target[c] = alpha * rgb[c] + (1 - alpha) * other[c];
      background[c] = other[c];
    }
  }
}

// State of a ray before its pixel is found.
struct RayDraw {
  RandomStream random;  // as it is before the first try
  std::size_t view;
  bool in_face, on_person;
  int tries;
};

template <class Views>
LIKENESS_HOST_DEVICE RayDraw begin_choice(const Views& views, const ChoiceNumbers& numbers, std::size_t n) {
  RayDraw draw{{numbers.seed, numbers.step, numbers.first + n}, 0, false, false, 0};
  const double at = double(n) + double(draw.random.uniform()), rays = double(numbers.rays),
               filmed = (1 - proxy_share(numbers)) * rays;
  const bool proxy = at >= filmed;
  draw.view = !proxy ? draw_view(numbers.own, numbers.drawn, at, filmed)
                     : numbers.views - numbers.proxies +
                           place_of_share((at - filmed) / (rays - filmed), numbers.proxies);
  const float kind = draw.random.uniform();
  draw.in_face = kind < kFaceShare;
  // Beside a proxy nothing is as much to be learnt as itself.
  draw.on_person = !draw.in_face && kind < kFaceShare + kPersonShare && views.has_alpha(draw.view) && !proxy;
  draw.tries = views.masked(draw.view) ? kMaskedTries : kTries;
  return draw;
}

// Try number `attempt`, which takes kDrawsOfTry numbers from `random`; returns whether it is the last one
// needed.
constexpr int kDrawsOfTry = 2;
template <class Views>
LIKENESS_HOST_DEVICE bool try_pixel(Views& views, const RayDraw& draw, int attempt, RandomStream& random,
                                    PixelPlace& pixel) {
  const std::size_t v = draw.view;
  pixel = draw_pixel(views.face(v), views.width(v), views.height(v), draw.in_face, random);
  if (draw.on_person && attempt + 1 < draw.tries && views.alpha(v, pixel.x, pixel.y) == 0) return false;
  return views.teaches(v, pixel.x, pixel.y) && views.meets(v, pixel.x, pixel.y);
}

// random: after the last try, which gave `pixel`.
template <class Views>
LIKENESS_HOST_DEVICE ChosenRay end_choice(const Views& views, const ChoiceNumbers& numbers, std::size_t v,
                                          PixelPlace pixel, RandomStream random) {
  ChosenRay ray{};
  const bool drop = numbers.drop_codes && random.uniform() < 0.5f;
  const bool proxy = v >= numbers.views - numbers.proxies;
  ray.view = std::int32_t(v + (proxy || (drop && !views.further(v)) ? numbers.views : 0));
  ray.jitter = random.bits() | 1;
  if (!views.teaches(v, pixel.x, pixel.y)) {
    ray.nowhere = 1;
    return ray;
  }
  float other[3];
  for (int c = 2; c >= 0; --c) other[c] = random.uniform();
  const bool swap = random.uniform() < kRandomBackgroundShare && views.has_alpha(v);
  paint(views, v, pixel, other, swap, ray.target, ray.background);
  return ray;
}

// Ray n of those that are chosen one by one.
template <class Views>
LIKENESS_HOST_DEVICE ChosenRay choose_ray(Views& views, const ChoiceNumbers& numbers, std::size_t n) {
  const RayDraw draw = begin_choice(views, numbers, n);
  RandomStream random = draw.random;
  PixelPlace pixel{0, 0};
  for (int attempt = 0; attempt < draw.tries; ++attempt)
    if (try_pixel(views, draw, attempt, random, pixel)) break;
  return end_choice(views, numbers, draw.view, pixel, random);
}

// -- Rows of conditions of single samples, in canonical space. n: cells per axis; sample: its number in the
// field's batch.

LIKENESS_HOST_DEVICE inline std::size_t cell_of_place(int n, float x, float y, float z) {
  const float place[3] = {x, y, z};
  std::size_t index = 0;
  for (int a = 2; a >= 0; --a) {
    int cell = int(place[a] * float(n));
    cell = cell < 0 ? 0 : cell >= n ? n - 1 : cell;
    index = index * std::size_t(n) + std::size_t(cell);
  }
  return index;
}

// A bit of a grid, by its cell.
template <class Grid>
bool holds(const Grid& grid, std::size_t cell) {
  return grid.bits[cell >> 3] >> (cell & 7) & 1;
}

constexpr std::uint64_t kStillStream = 0x57117ull, kSideStream = 0x51de5ull;
// Each run of this many samples has its own random stream.
constexpr std::size_t kSampleStream = 4096;

LIKENESS_HOST_DEVICE inline RandomStream stream_of_sample(std::uint64_t seed, std::uint64_t step,
                                                          std::size_t sample) {
  RandomStream random(seed, step, sample / kSampleStream * kSampleStream);
  random.skip(sample % kSampleStream);
  return random;
}

// Of a sample in a still cell (still_cells.h).
LIKENESS_HOST_DEVICE inline std::int32_t shuffled_row(std::int32_t row, std::uint32_t views,
                                                      std::uint32_t own, bool still, RandomStream& random) {
  const std::uint32_t other = random.below(views);
  if (std::uint32_t(row) >= own && std::uint32_t(row) < views) return row;
  return still ? std::int32_t(views + other) : row;
}

// Of a sample on a side of the head that the first clip does not show (sides_seen.h).
LIKENESS_HOST_DEVICE inline std::int32_t row_on_side(std::int32_t row, std::uint32_t views, std::uint32_t own,
                                                     bool seen, RandomStream& random) {
  const bool drops = random.uniform() < 0.5f;
  return drops && std::uint32_t(row) >= own && std::uint32_t(row) < views && !seen ? row + std::int32_t(views)
                                                                                   : row;
}

}  // namespace likeness
