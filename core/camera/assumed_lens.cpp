// A usual lens: see assumed_lens.h.
#include "core/camera/assumed_lens.h"

#include <algorithm>

#include "core/video/lens_tag.h"

namespace likeness {

namespace {

Intrinsics centred(int width, int height, double focal) {
  return {width, height, focal, focal, width / 2.0, height / 2.0};
}

}  // namespace

Intrinsics film_intrinsics(int width, int height, double focal_35mm) {
  return centred(width, height, focal_35mm / kFilmWidth_mm * std::max(width, height));
}

Intrinsics assumed_intrinsics(int width, int height, double focal_35mm) {
  constexpr double kSquarest = 1.3, kWidest = 2.4;  // 4 : 3 to the cinema's
  const double longer = std::max(width, height), shorter = std::min(width, height);
  const bool filmed = longer >= kSquarest * shorter && longer <= kWidest * shorter;
  if (focal_35mm > 0 && filmed) return film_intrinsics(width, height, focal_35mm);
  return centred(width, height, (filmed ? kPhoneFocal : kCutOutFocal) * shorter);
}

}  // namespace likeness
