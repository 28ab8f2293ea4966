// Webcams, for recording and for driving live (Video4Linux, through OpenCV).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/video/frame_source.h"

namespace likeness {

struct Webcam {
  std::string device;  // "/dev/video0"
  std::string name;    // as reported by the device
};
std::vector<Webcam> list_webcams();  // in order of their numbers; empty if there are none

// What is requested of a camera; it delivers what it can.
struct WebcamOptions {
  int width = 1280, height = 720;
  bool newest = false;  // no queue for late callers: old pictures are useless
};
inline constexpr WebcamOptions kToRecord{};
inline constexpr WebcamOptions kToDrive{
    .width = 640, .height = 480, .newest = true};  // more would only cost time

// device: empty = the first one.
Result<std::unique_ptr<FrameSource>> open_webcam(const std::string& device, const WebcamOptions& wanted);

}  // namespace likeness
