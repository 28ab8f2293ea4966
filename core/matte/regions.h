// The frozen evaluation regions of one held-out frame, in source pixels.
#pragma once

#include <opencv2/core.hpp>

#include "core/capture/capture.h"
#include "core/image/image.h"
#include "core/matte/person_prior.h"

namespace likeness {

// 8U of the picture, 255: the bare head and the part of the matte (8U, not 0: person) that is hair around it,
// above the neck line.
cv::Mat head_with_hair(const cv::Mat& matte, const PersonModel& person, const PersonPlace& place,
                       const Intrinsics& picture);

// (height, width, 3): red = person, green = head with hair, without neck, grown by 3 % of the crop's side,
// blue = face. alpha: 8U matte of the crop. place and source: the person in the whole source picture.
Image8 draw_regions(const Capture& capture, const cv::Mat& alpha, const PersonModel& person,
                    const PersonPlace& place, const Intrinsics& source);

}  // namespace likeness
