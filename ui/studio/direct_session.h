// The studio's Direct step: what is directed and its file, the avatar's picture, driving it live.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ui/studio/avatar_renderer.h"
#include "ui/studio/directing.h"
#include "ui/studio/frame_picture.h"
#include "ui/studio/live_drive.h"
#include "ui/studio/session_context.h"

namespace likeness::ui {

// For the panels.
struct DirectView {
  DirectingView directing;
  LiveView live;
  std::uint64_t moment = 0;  // number of what the picture is asked to show
  std::shared_ptr<const AvatarPicture> picture;
  bool rendering = false, on_device = false;  // a better picture is being made; the last was a device's
  bool comparing = false;                     // with a frame of the clip
  FramePicture compare_picture;
};

// What the panels ask for.
struct DirectRequests : DirectingRequests {
  std::optional<int> compare_frame;
  std::optional<std::filesystem::path> open_performance, save_performance, drive_video;
  std::optional<std::map<std::string, float>> gains;
  std::optional<int> view_px;  // size of the avatar's picture on the screen
};

class DirectSession {
 public:
  explicit DirectSession(const SessionContext& context)
      : context_(context), renderer_(context.wake, context.options.compute.open) {}

  void tick();
  DirectView view() const;
  void apply(const DirectRequests& requests);

  // What is directed; whoever changes it asks for its picture.
  Directing& directing() { return directing_; }
  void request_picture();
  void rest(ChannelPart part);  // sets its channels to rest
  void random_walk();           // each other than the one before
  void camera_orbit();
  void camera_dolly();
  void go_to_start();
  void go_to_end();
  void toggle_playing() { directing_.toggle_playing(Directing::Clock::now()); }
  void toggle_comparing();

  void drive(LiveDriver::Open open);
  void rest_driver() { drive_.rest_now(); }
  void toggle_drive_recording();
  void stop_driving();
  // For whoever wants its camera; what was recorded is kept. Null: nothing is driven.
  std::unique_ptr<LiveDriver> take_driver();
  const std::map<std::string, float>& gains() const { return drive_.gains(); }
  void shown(const std::shared_ptr<const AvatarPicture>& picture) { drive_.shown(picture); }  // on the screen
  bool is_playing() const { return directing_.playing(); }
  bool is_driven() const { return drive_.on(); }

  void open();      // the open project's performance, as it was left
  void close();     // while the project is still open: what is not saved is
  void save_all();  // recorded drives and the performance, at once

 private:
  // Saves of performances, by the window and by the thread behind it: an older one that is still queued when
  // a newer is written writes nothing.
  struct Saves;

  // Recorded, and on its way into the performance.
  struct Take {
    std::uint64_t number = 0;
    std::shared_ptr<const ProjectAvatar> avatar;  // that was driven
    std::shared_ptr<const std::vector<DrivenFrame>> frames;
    double rate = 25, at_s = 0;
    Performance keys() const;  // of a long take a while
  };

  void edit(std::string what, const std::function<void(Performance&)>& change);
  void open_performance(const std::filesystem::path& file);
  void save_performance_as(const std::filesystem::path& file);
  void save_performance(bool at_once);
  std::optional<std::uint64_t> keep_take();  // its number, where something was recorded
  void take_drive();                         // what was recorded, into the performance
  void lay_takes();                          // the same at once, with those on their way
  void lay_take(const Performance& keys, double at_s);

  const SessionContext context_;
  Directing directing_;
  std::shared_ptr<Saves> saves_;  // of the performance
  std::uint64_t save_number_ = 0;
  std::shared_ptr<const Performance> saving_;  // queued or being written
  std::vector<Take> takes_;
  std::uint64_t take_number_ = 0, moment_number_ = 0, walks_ = 0;
  int view_px_ = 256;
  bool comparing_ = false;
  FramePicture compare_picture_;
  AvatarRenderer renderer_;
  LiveDrive drive_{renderer_};
};

}  // namespace likeness::ui
