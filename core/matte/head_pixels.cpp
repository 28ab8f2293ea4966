// See head_pixels.h.
#include "core/matte/head_pixels.h"

#include <opencv2/core.hpp>

#include "core/matte/person_prior.h"
#include "core/matte/regions.h"

namespace likeness {

HeadPixels::HeadPixels(const HeadModel& model, const Track& track)
    : person_(std::make_unique<PersonModel>(make_person_model(model, track))),
      metres_per_unit_(track.metres_per_unit) {}
HeadPixels::~HeadPixels() = default;

Image8 HeadPixels::taught(const TrackedFrame& tracked, const Camera& source, const Intrinsics& picture,
                          const Image8& alpha) const {
  Image8 taught(alpha.width, alpha.height, 1);
  const auto place = place_person(*person_, tracked, source, picture, metres_per_unit_);
  if (!place) return taught;
  cv::Mat matte(alpha.height, alpha.width, CV_8U);
  std::copy(alpha.data.begin(), alpha.data.end(), matte.data);
  const cv::Mat head = head_with_hair(matte, *person_, *place, picture);
  for (int y = 0; y < alpha.height; ++y)
    for (int x = 0; x < alpha.width; ++x)
      *taught.at(x, y) = *alpha.at(x, y) == 0 || head.at<std::uint8_t>(y, x) > 0 ? 255 : 0;
  return taught;
}

}  // namespace likeness
