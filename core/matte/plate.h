// The background plate: temporal median over the pixels not covered by the person.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <vector>

namespace likeness {

struct Plate {
  cv::Mat colour;  // 8UC3 RGB; holes filled smoothly from their border
  cv::Mat noise;   // 32F, per channel spread of the free pixels over time plus the uncertainty at edges, in
                   // 0..255 units
  cv::Mat known;   // 8U: kSeen, kOfRoom, or 0 = filled in
  double coverage() const;  // share of it that was seen
};
constexpr unsigned char kSeen = 255;    // free in enough frames
constexpr unsigned char kOfRoom = 128;  // filled from a model of the room

// pictures: 8UC3 of one size; occupied: 8U, non-zero where the person is or may be. At least one picture.
//
// What a cut of the person leaves free near the person may still be the person's: hair at rest before a wall
// of its colour, cut off once, would become the wall and stay cut off. With `doubt`, only pictures in which a
// pixel is free and not near decide, if there are enough of them; elsewhere a colour that the person is more
// likely to have than the background stays unknown, unless it lies in static texture: hair moves with the
// head.
struct PlateDoubt {
  std::vector<cv::Mat> near;                          // one per picture, 8U: where the person may be
  std::function<bool(const cv::Vec3b&)> persons_own;  // whether a colour is rather the person's
};
Plate estimate_plate(const std::vector<cv::Mat>& pictures, const std::vector<cv::Mat>& occupied,
                     const PlateDoubt* doubt = nullptr);

// The plate of one picture of a moving camera: `room` as a model shows it behind the person, trusted only as
// far as it agrees with the picture beside the person. free: 8U, non-zero where the person surely is not;
// reach: 8U, non-zero where the plate is needed.
Plate room_plate(const cv::Mat& picture, const cv::Mat& room, const cv::Mat& free, const cv::Mat& reach);

// Fills the plate's unseen part from `room`, a model's picture from the plate's camera; the difference of
// brightness and colour at the rim is continued inwards.
void complete_plate(Plate& plate, const cv::Mat& room);

// 32F, 0..1: how certainly a pixel lies in texture that is static through all pictures, person or not.
cv::Mat still_texture(const std::vector<cv::Mat>& pictures);

// Fills where `known` is zero with a smooth continuation (pull-push: averages of ever coarser levels).
cv::Mat fill_holes(const cv::Mat& colour, const cv::Mat& known);

}  // namespace likeness
