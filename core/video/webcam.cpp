// Webcams through OpenCV's videoio (Video4Linux): see record.h.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "core/base/files.h"
#include "core/video/record.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int kAttempts = 10;  // a cable that moves loses a picture or two

class WebcamSource : public PictureSource {
 public:
  WebcamSource(cv::VideoCapture capture, std::string device)
      : capture_(std::move(capture)), device_(std::move(device)) {}

  Result<std::optional<LivePicture>> next() override {
    try {
      cv::Mat bgr;
      bool given = false;
      for (int attempt = 0; attempt < kAttempts && !given; ++attempt)
        given = capture_.read(bgr) && !bgr.empty() && bgr.type() == CV_8UC3;
      if (!given)
        return Error{ErrorCode::failed, fmt::format("The webcam {} gave no picture.", device_),
                     "Close other programs that use it, or plug it in again.", device_};
      LivePicture picture;
      picture.time_s = std::chrono::duration<double>(Clock::now() - start_).count();
      picture.rgb = Image8(bgr.cols, bgr.rows, 3);
      cv::Mat rgb(bgr.rows, bgr.cols, CV_8UC3, picture.rgb.data.data());
      cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
      return std::optional<LivePicture>(std::move(picture));
    } catch (const cv::Exception& fault) {
      return Error{ErrorCode::failed, fmt::format("The webcam {} failed: {}.", device_, fault.err),
                   "Plug it in again, or choose another one.", device_};
    }
  }

 private:
  cv::VideoCapture capture_;
  std::string device_;
  Clock::time_point start_ = Clock::now();
};

}  // namespace

std::vector<Webcam> list_webcams() {
  std::vector<std::pair<int, Webcam>> found;
  std::error_code fault;
  for (const auto& entry : fs::directory_iterator("/sys/class/video4linux", fault)) {
    const std::string device = entry.path().filename().string();
    if (!device.starts_with("video")) continue;  // radios and teletext are there, too
    const std::string number = device.substr(std::strlen("video"));
    if (number.empty() || !std::ranges::all_of(number, [](unsigned char c) { return std::isdigit(c); }))
      continue;
    // A camera's second device carries its data about the pictures, not pictures.
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

Result<std::unique_ptr<PictureSource>> open_webcam(const std::string& device) {
  std::error_code ignored;
  if (!fs::exists(device, ignored))
    return Error{ErrorCode::not_found, fmt::format("There is no webcam {}.", device),
                 "Plug one in; `likeness record --list` names those that are there.", device};
  try {
    cv::VideoCapture capture(device, cv::CAP_V4L2);
    if (!capture.isOpened())
      return Error{ErrorCode::failed, fmt::format("The webcam {} cannot be opened.", device),
                   "Close other programs that use it; you may have to be in the group `video`.", device};
    capture.set(cv::CAP_PROP_FOURCC, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'));
    capture.set(cv::CAP_PROP_FRAME_WIDTH, 1280);
    capture.set(cv::CAP_PROP_FRAME_HEIGHT, 720);
    capture.set(cv::CAP_PROP_FPS, 30);
    return std::unique_ptr<PictureSource>(std::make_unique<WebcamSource>(std::move(capture), device));
  } catch (const cv::Exception& fault) {
    return Error{ErrorCode::failed, fmt::format("The webcam {} failed: {}.", device, fault.err),
                 "Plug it in again, or choose another one.", device};
  }
}

}  // namespace likeness
