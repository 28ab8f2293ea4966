// The background plate: temporal median over the pixels that the person leaves free.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <vector>

namespace likeness {

struct Plate {
  cv::Mat colour;  // 8UC3 RGB; holes filled smoothly from their border
  cv::Mat
      noise;  // 32F, per channel spread of the free pixels over time plus the doubt at edges, in 0..255 units
  cv::Mat known;            // 8U: kSeen, kOfRoom, or 0 = filled in
  double coverage() const;  // share of it that was seen
};
constexpr unsigned char kSeen = 255;    // free in enough frames
constexpr unsigned char kOfRoom = 128;  // as a model of the room shows it

// pictures: 8UC3 of one size; occupied: 8U, non-zero where the person is or may be. At least one picture.
//
// What a cut of the person leaves free near the person may still be the person's: hair that rests before a
// wall of its colour, cut off once, would become the wall, and stay cut off. With `doubt`, pictures in which
// a pixel is free and not near decide alone where there are enough of them; elsewhere a colour that the
// person is more likely to have than the background stays unknown, unless it lies in texture that stays put:
// hair moves with the head.
struct PlateDoubt {
  std::vector<cv::Mat> near;                          // a picture each, 8U: where the person may be
  std::function<bool(const cv::Vec3b&)> persons_own;  // whether a colour is rather the person's
};
Plate estimate_plate(const std::vector<cv::Mat>& pictures, const std::vector<cv::Mat>& occupied,
                     const PlateDoubt* doubt = nullptr);

// The plate of one picture of a moving camera: `room` as a model shows it behind the person, believed only as
// far as it agrees with the picture beside the person. free: 8U, non-zero where the person surely is not;
// reach: 8U, non-zero where the plate is asked for.
Plate room_plate(const cv::Mat& picture, const cv::Mat& room, const cv::Mat& free, const cv::Mat& reach);

// Shows `room`, a model's picture from where the plate's camera is, where the plate was never seen; what of
// brightness and colour the two differ by at the rim is carried on inwards.
void complete_plate(Plate& plate, const cv::Mat& room);

// 32F, 0..1: how surely a pixel lies in texture that stays put through all pictures, person or not.
cv::Mat still_texture(const std::vector<cv::Mat>& pictures);

// Fills where `known` is zero with a smooth continuation (pull-push: averages of ever coarser levels).
cv::Mat fill_holes(const cv::Mat& colour, const cv::Mat& known);

}  // namespace likeness
