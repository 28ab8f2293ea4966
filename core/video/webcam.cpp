// See webcam.h.
#include "core/video/webcam.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstring>
#include <exception>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <optional>
#include <utility>

#include "core/base/files.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int kAttempts = 10;  // a loose cable loses a picture or two

class WebcamSource : public FrameSource {
 public:
  WebcamSource(cv::VideoCapture capture, std::string device)
      : capture_(std::move(capture)), device_(std::move(device)) {}

  Result<std::optional<CapturedFrame>> next(std::stop_token stop) override {
    try {
      for (int attempt = 0; attempt < kAttempts && !stop.stop_requested(); ++attempt) {
        if (!capture_.read(bgr_) || bgr_.empty() || bgr_.type() != CV_8UC3) continue;
        const auto now = Clock::now();
        if (!start_) start_ = now;
        CapturedFrame frame{Image8(bgr_.cols, bgr_.rows, 3),
                            std::chrono::duration<double>(now - *start_).count(), now};
        cv::Mat rgb(bgr_.rows, bgr_.cols, CV_8UC3, frame.rgb.data.data());
        cv::cvtColor(bgr_, rgb, cv::COLOR_BGR2RGB);
        return std::optional(std::move(frame));
      }
    } catch (const std::exception& fault) {
      return Error{ErrorCode::failed, fmt::format("The webcam {} failed: {}.", device_, fault.what()),
                   "Plug it in again, or choose another one.", device_};
    }
    if (stop.stop_requested()) return std::optional<CapturedFrame>();
    return Error{ErrorCode::failed, fmt::format("The webcam {} gave no picture.", device_),
                 "Close other programs that use it, or plug it in again.", device_};
  }

  std::string name() const override { return "webcam " + device_; }

 private:
  cv::VideoCapture capture_;
  std::string device_;
  cv::Mat bgr_;
  std::optional<Clock::time_point> start_;
};

}  // namespace

std::vector<Webcam> list_webcams() {
  std::vector<std::pair<int, Webcam>> found;
  std::error_code fault;
  for (const auto& entry : fs::directory_iterator("/sys/class/video4linux", fault)) {
    const std::string device = entry.path().filename().string();
    if (!device.starts_with("video")) continue;  // radios and teletext are there too
    const std::string number = device.substr(std::strlen("video"));
    if (number.empty() || !std::ranges::all_of(number, [](unsigned char c) { return std::isdigit(c); }))
      continue;
    // A camera's second device carries metadata, not pictures.
    const auto index = read_text(entry.path() / "index");
    if (index && index->substr(0, 1) != "0") continue;
    auto name = read_text(entry.path() / "name");
    Webcam webcam{"/dev/video" + number, name ? *name : "webcam"};
    while (!webcam.name.empty() && webcam.name.back() == '\n') webcam.name.pop_back();
    found.emplace_back(std::stoi(number), std::move(webcam));
  }
  std::ranges::sort(found, {}, &std::pair<int, Webcam>::first);
  std::vector<Webcam> webcams;
  for (auto& [number, webcam] : found) webcams.push_back(std::move(webcam));
  return webcams;
}

Result<std::unique_ptr<FrameSource>> open_webcam(const std::string& device, const WebcamOptions& wanted) {
  if (device.empty()) {
    const std::vector<Webcam> webcams = list_webcams();
    if (!webcams.empty()) return open_webcam(webcams.front().device, wanted);
    return Error{ErrorCode::not_found, "No webcam was found.",
                 "Plug one in, or use a video, for instance from a phone.", "webcam"};
  }
  std::error_code ignored;
  if (!fs::exists(device, ignored))
    return Error{ErrorCode::not_found, fmt::format("There is no webcam {}.", device),
                 "Plug one in; `likeness record --list` lists those present.", device};
  try {
    cv::VideoCapture capture(device, cv::CAP_V4L2);
    if (!capture.isOpened())
      return Error{ErrorCode::failed, fmt::format("The webcam {} cannot be opened.", device),
                   "Close other programs that use it; you may need to be in the group `video`.", device};
    if (wanted.newest) {
      capture.set(cv::CAP_PROP_BUFFERSIZE, 1);
    } else {  // large pictures are fast enough only when compressed
      capture.set(cv::CAP_PROP_FOURCC, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'));
    }
    capture.set(cv::CAP_PROP_FRAME_WIDTH, wanted.width);
    capture.set(cv::CAP_PROP_FRAME_HEIGHT, wanted.height);
    if (!wanted.newest) capture.set(cv::CAP_PROP_FPS, 30);
    return std::unique_ptr<FrameSource>(std::make_unique<WebcamSource>(std::move(capture), device));
  } catch (const std::exception& fault) {
    return Error{ErrorCode::failed, fmt::format("The webcam {} failed: {}.", device, fault.what()),
                 "Plug it in again, or choose another one.", device};
  }
}

}  // namespace likeness
