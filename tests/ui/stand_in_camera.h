// Webcams for tests: made up, with a picture of which the left is red and the right is blue, and with the
// faults that cables have.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "ui/studio/clip_recorder.h"

namespace likeness::ui::test {

inline Image8 stand_in_picture(int number) {
  Image8 image(96, 64, 3);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      std::uint8_t* p = image.at(x, y);
      p[0] = x < image.width / 2 ? 220 : 20;
      p[1] = std::uint8_t(y / 8 == number % 8 ? 120 : 20);  // a bar that moves down
      p[2] = x < image.width / 2 ? 20 : 220;
    }
  return image;
}

// What the tests see and change while a camera is in use.
struct Cameras {
  std::mutex mutex;
  std::vector<Webcam> webcams{{"/dev/video0", "Built-in camera"}};
  std::vector<std::string> opened;  // in order
  std::atomic<int> in_use{0};
  std::atomic<bool> broken{false};   // every picture from now on fails
  std::atomic<bool> ended{false};    // no picture comes any more
  std::atomic<bool> held{false};     // the next picture waits
  std::atomic<bool> waiting{false};  // and it does
  std::atomic<bool> slow{false};     // a camera is let go only once this ends
  std::atomic<bool> leaving{false};  // and one waits for that

  void plug(std::vector<Webcam> now) {
    const std::lock_guard lock(mutex);
    webcams = std::move(now);
  }
  std::vector<std::string> were_opened() {
    const std::lock_guard lock(mutex);
    return opened;
  }
};

class StandInCamera : public FrameSource {
 public:
  StandInCamera(std::shared_ptr<Cameras> cameras, std::string device)
      : cameras_(std::move(cameras)), device_(std::move(device)) {
    ++cameras_->in_use;
  }
  ~StandInCamera() override {
    while (cameras_->slow) {
      cameras_->leaving = true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    --cameras_->in_use;
  }

  // Pictures of a thirtieth of a second each, sooner than they would come.
  Result<std::optional<CapturedFrame>> next(std::stop_token stop) override {
    do {
      cameras_->waiting = cameras_->held.load();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    } while (cameras_->held && !stop.stop_requested());
    if (stop.stop_requested() || cameras_->ended) return std::optional<CapturedFrame>();
    if (cameras_->broken)
      return Error{ErrorCode::failed, "The webcam " + device_ + " gave no picture.",
                   "Close other programs that use it, or plug it in again.", device_};
    CapturedFrame frame{stand_in_picture(number_), number_ / 30.0, std::chrono::steady_clock::now()};
    ++number_;
    return std::optional(std::move(frame));
  }
  std::string name() const override { return "webcam " + device_; }

 private:
  std::shared_ptr<Cameras> cameras_;
  std::string device_;
  int number_ = 0;
};

inline WebcamAccess stand_in_webcams(const std::shared_ptr<Cameras>& cameras) {
  return {[cameras] {
            const std::lock_guard lock(cameras->mutex);
            return cameras->webcams;
          },
          [cameras](const std::string& device) -> Result<std::unique_ptr<FrameSource>> {
            const std::lock_guard lock(cameras->mutex);
            const auto& all = cameras->webcams;
            const auto found = device.empty() ? all.begin() : std::ranges::find(all, device, &Webcam::device);
            // What a computer without such a webcam says.
            if (found == all.end())
              return open_webcam(list_webcams().empty() ? "" : "/dev/video_that_is_not", kToRecord);
            cameras->opened.push_back(found->device);
            return std::unique_ptr<FrameSource>(std::make_unique<StandInCamera>(cameras, found->device));
          }};
}

}  // namespace likeness::ui::test
