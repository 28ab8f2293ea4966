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
  std::string name;    // as it calls itself
};
std::vector<Webcam> list_webcams();  // in order of their numbers; none where the system has none

// What is asked of a camera; it gives what it can.
struct WebcamOptions {
  int width = 1280, height = 720;
  bool newest = false;  // nothing is kept for whoever is late: old pictures are worth nothing
};
inline constexpr WebcamOptions kToRecord{};
inline constexpr WebcamOptions kToDrive{.width = 640, .height = 480, .newest = true};  // more only costs time

// device: empty = the first there is.
Result<std::unique_ptr<FrameSource>> open_webcam(const std::string& device, const WebcamOptions& wanted);

}  // namespace likeness
