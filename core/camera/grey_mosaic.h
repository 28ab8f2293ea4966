// The wall as a clip shows it, in grey: first a running mean that grows with the frames, then a temporal
// median of many.
#pragma once

#include <span>
#include <vector>

#include "core/camera/align_view.h"

namespace likeness {

// Running mean; grows as frames come.
class GrowingMosaic {
 public:
  GrowingMosaic(const Intrinsics& reference, int levels);
  void add(const GreyPicture& picture, const AlignedView& aligned);
  // With all that was added so far.
  const ViewTarget& target();

 private:
  void grow(const Intrinsics& extent);

  Intrinsics reference_;
  int levels_;
  ViewTarget target_;  // level 0 is the mean
  Image weight_;
  bool stale_ = true;
};

struct AlignedFrame {
  const GreyPicture* picture = nullptr;
  AlignedView aligned;
};
// Of each place the mean of what lies close to the median of the frames' values, each freed of its gain and
// bias.
ViewTarget median_mosaic(std::span<const AlignedFrame> frames, const Intrinsics& reference, int levels);

}  // namespace likeness
