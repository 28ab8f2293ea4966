// Person or background for every pixel of one picture: plate difference, colour statistics and place as
// likelihoods, made consistent by a minimum cut; then a real alpha along the boundary.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "core/matte/person_prior.h"
#include "core/matte/plate.h"

namespace likeness {

// Colour histograms (16 x 16 x 16, smoothed) of person and background.
class ColourModel {
 public:
  ColourModel();
  // Adds the pixels of `picture` where `mask` is non-zero.
  void add(const cv::Mat& picture, const cv::Mat& mask, bool person);
  void finish();                               // smooths and turns counts into a log-likelihood ratio
  float ratio(const cv::Vec3b& colour) const;  // person over background, within +-2.5

 private:
  std::vector<float> person_, background_, ratio_;
};

struct SegmentInput {
  const cv::Mat* picture = nullptr;  // 8UC3 RGB
  const PersonPrior* prior = nullptr;
  const Plate* plate = nullptr;                // may be null
  const ColourModel* colours = nullptr;        // of head and neck
  const ColourModel* lower_colours = nullptr;  // of the region below the neck's base; null = as above it
  const cv::Mat* still = nullptr;              // 32F, 0..1: texture that never moves; may be null
  const cv::Mat* network = nullptr;            // 8U alpha from a matting network; may be null
  bool plate_is_room = false;                  // a model's picture of the background, from the camera's place
};

// 8U, 255 = person.
cv::Mat cut_person(const SegmentInput& input);

// 8U alpha for the cut: closed-form mixing of the nearby person and background colours (the plate's where
// known) in a band of `radius` px about the boundary, 0 or 255 elsewhere.
cv::Mat soften(const cv::Mat& picture, const cv::Mat& person, const Plate* plate, int radius);

// 8U alpha for the cut, a network's in a band of `radius` px about the boundary.
cv::Mat soften_by_network(const cv::Mat& network, const cv::Mat& person, int radius);

}  // namespace likeness
