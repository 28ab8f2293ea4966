// What is wrong with a picture of a person, told from the picture and the posed head alone: pieces that hang
// loose, a body one sees through, light that lies outside the person, specks. Pictures are (h, w, 1 or 3) in
// [0, 1], masks one channel with 255 inside, all of one size.
#pragma once

#include "core/base/linalg.h"
#include "core/image/image.h"

namespace likeness {

// Share of the opaque pixels (alpha above a half) that do not hang together with the largest piece.
double loose_share(const Image& alpha);

// Share of the person's inside through which one sees (alpha below 0.8). The inside: what is not clear, with
// holes and gaps of up to 6 % of the picture's width closed, less a rim of 2 % for the soft outline.
double shredded_share(const Image& alpha);

// Share of a mask through which one sees: the mean of 1 - alpha, without the mask's outermost `rim_px`.
double missing_share(const Image& alpha, const Image8& mask, double rim_px);

// Half a picture: what is nearer to its top than a line through `at`, across `up` (in pixels, y down).
struct Above {
  Vec2d at = Vec2d::Zero(), up = Vec2d(0, -1);
  bool holds(int x, int y) const { return (Vec2d(x + 0.5, y + 0.5) - at).dot(up) > 0; }
};

// How far from the mask, px, 98 % of the alpha above the line lie: how far hair stands off the scalp.
double reach_px(const Image& alpha, const Image8& mask, const Above& above);
// The alpha above the line that lies farther than reach_px from the mask, as a share of the mask's area above
// it.
double outside_share(const Image& alpha, const Image8& mask, const Above& above, double reach_px);

// Share of the mask's pixels that are, in some channel, more than 48 of 255 off the median of their 7 x 7
// neighbours.
double speck_share_within(const Image& rgb, const Image8& mask);

// Mean over the mask's pixels and channels of |a - b|; 0 for an empty mask.
double change_within(const Image& a, const Image& b, const Image8& mask);
// Mean over the mask's pixels and channels; 0 for an empty mask.
double brightness_within(const Image& rgb, const Image8& mask);

}  // namespace likeness
