// A webcam through OpenCV: see frame_source.h.
#include <fmt/format.h>

#include <exception>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "core/live/frame_source.h"

namespace likeness {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kWidth = 640, kHeight = 480;  // wanted; more only costs time
constexpr int kMostFailures = 10;           // pictures in a row that do not come

class Webcam : public FrameSource {
 public:
  Webcam(cv::VideoCapture camera, std::string name) : camera_(std::move(camera)), name_(std::move(name)) {}

  Result<std::optional<CapturedFrame>> next(std::stop_token stop) override {
    try {
      for (int failures = 0; failures < kMostFailures && !stop.stop_requested(); ++failures) {
        if (!camera_.read(picture_) || picture_.empty() || picture_.channels() != 3) continue;
        const auto now = Clock::now();
        if (!start_) start_ = now;
        CapturedFrame frame{Image8(picture_.cols, picture_.rows, 3),
                            std::chrono::duration<double>(now - *start_).count(), now};
        cv::Mat rgb(picture_.rows, picture_.cols, CV_8UC3, frame.rgb.data.data());
        cv::cvtColor(picture_, rgb, cv::COLOR_BGR2RGB);
        return std::optional(std::move(frame));
      }
    } catch (const std::exception& e) {
      return gone(e.what());
    }
    if (stop.stop_requested()) return std::optional<CapturedFrame>();
    return gone("no picture comes");
  }

  std::string name() const override { return name_; }

 private:
  Error gone(const std::string& why) const {
    return {ErrorCode::failed, fmt::format("The {} stopped: {}.", name_, why),
            "Plug it in again, close other programs that use it, and start again.", "webcam"};
  }

  cv::VideoCapture camera_;
  std::string name_;
  cv::Mat picture_;
  std::optional<Clock::time_point> start_;
};

}  // namespace

Result<std::unique_ptr<FrameSource>> open_webcam(int number) {
  const std::string name = number == 0 ? "webcam" : fmt::format("webcam {}", number);
  const Error refused{ErrorCode::not_found, fmt::format("No {} answers.", name),
                      "Plug one in, allow this user to read it (group video), and close other programs that "
                      "use it; or drive from a video.",
                      "webcam"};
  try {
    cv::VideoCapture camera(number, cv::CAP_V4L2);
    if (!camera.isOpened()) return refused;
    camera.set(cv::CAP_PROP_FRAME_WIDTH, kWidth);
    camera.set(cv::CAP_PROP_FRAME_HEIGHT, kHeight);
    camera.set(cv::CAP_PROP_BUFFERSIZE, 1);  // old pictures are worth nothing
    return std::unique_ptr<FrameSource>(std::make_unique<Webcam>(std::move(camera), name));
  } catch (const std::exception&) {
    return refused;
  }
}

}  // namespace likeness
