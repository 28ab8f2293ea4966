// The studio's side of driving live: hands every driven frame to the renderer at once, seen from where the
// user looks, and measures what reaches the screen.
#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/drive/live_driver.h"
#include "ui/studio/avatar_renderer.h"

namespace likeness::ui {

// For the panels: the avatar driven by a video or a webcam as it happens.
struct LiveView {
  bool on = false;
  LiveStatus status;
  // On the screen, of late: pictures a second, and the last one's time since its capture. 0: none came.
  double shown_per_second = 0, latency_s = 0;
  std::map<std::string, float> gains;  // per named action, those that are not 1
};

class LiveDrive {
 public:
  explicit LiveDrive(AvatarRenderer& renderer) : renderer_(renderer) {}
  ~LiveDrive() { stop(); }

  void start(std::shared_ptr<const ProjectAvatar> avatar, LiveDriver::Open open, LiveOptions options);
  // What is left of the driver, to be waited for elsewhere: a camera may take a while to let go.
  std::unique_ptr<LiveDriver> stop();
  bool on() const { return driver_ != nullptr; }
  const std::shared_ptr<const ProjectAvatar>& avatar() const { return avatar_; }  // driven now or last
  bool has_ended() const;                                                         // by itself

  // Where the user looks from; the pose is the driver's, once there is one.
  void look(PictureRequest request);
  void rest_now();
  bool toggle_recording();  // true: it records now
  std::vector<DrivenFrame> take_recording();
  void set_gains(std::map<std::string, float> gains);
  const std::map<std::string, float>& gains() const { return gains_; }

  void shown(const std::shared_ptr<const AvatarPicture>& picture);
  LiveView view() const;

 private:
  using Clock = std::chrono::steady_clock;
  // Shared with the tracking thread.
  struct Sight {
    std::mutex mutex;
    bool on = true, posed = false;
    PictureRequest request;
  };

  AvatarRenderer& renderer_;
  std::shared_ptr<const ProjectAvatar> avatar_;
  std::shared_ptr<Sight> sight_;
  std::map<std::string, float> gains_;
  std::weak_ptr<const AvatarPicture> last_shown_;
  std::deque<Clock::time_point> shown_;
  double latency_s_ = 0;
  std::unique_ptr<LiveDriver> driver_;
};

}  // namespace likeness::ui
