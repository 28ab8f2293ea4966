// Pictures of an avatar from a thread of its own: the newest request wins, and each is answered first
// coarsely, then better, while nothing newer comes. On a device the best is the first.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "core/direct/direct_avatar.h"
#include "core/image/image.h"
#include "core/render/picture_renderer.h"
#include "ui/studio/project_contents.h"

namespace likeness::ui {

// What a picture shows; comes back with it.
struct PictureOrigin {
  std::uint64_t moment = 0;  // number of what was asked for
  ViewPoint view;
  double doubt = 0;  // 0: seen by the capture, 1: nothing near it was
  int frame = -1;    // of the clip, or -1
  std::optional<std::chrono::steady_clock::time_point> captured = {};  // of the driver's picture it follows
};

struct PictureRequest {
  std::shared_ptr<const ProjectAvatar> avatar;
  Camera camera;  // of square pictures of any size
  AvatarPose pose;
  PictureOrigin origin;
  int finest = 256;     // px of the last rung: the size it is shown at, at most twice the avatar's
  bool moving = false;  // one picture of the best rung that keeps pace, instead of better and better ones
};

enum class Rung { coarse, preview, final, fine };  // fine: more pixels than the avatar was trained at
inline constexpr const char* kRungWords[] = {"coarse", "preview", "final", "fine"};

struct AvatarPicture {
  Image rgba;  // (h, w, 4) premultiplied
  Rung rung = Rung::coarse;
  bool last = false;   // nothing better will come
  double seconds = 0;  // it took
  PictureOrigin origin;
};

class AvatarRenderer {
 public:
  // wake: called from the thread whenever there is a new picture. open: where it is rendered.
  explicit AvatarRenderer(std::function<void()> wake, OpenBackend open = {});

  void request(PictureRequest request);
  void clear();  // forgets avatar and picture
  // Null before the first picture.
  std::shared_ptr<const AvatarPicture> latest() const;
  bool busy() const;
  bool on_device() const;                  // the last picture was a device's
  std::optional<std::string> take_note();  // once: why the processor goes on

 private:
  void loop(std::stop_token stop);
  void answer(const PictureRequest& request, std::uint64_t number, std::stop_token stop);
  void answer_moving(const PictureRequest& request, const RenderState& state, double posed_s,
                     std::uint64_t number);
  bool publish(std::uint64_t number, AvatarPicture picture);  // false: something newer was asked for
  bool is_newest(std::uint64_t number) const;

  std::function<void()> wake_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<PictureRequest> waiting_;
  std::shared_ptr<const AvatarPicture> latest_;
  std::uint64_t number_ = 0;  // of the newest request
  bool working_ = false;
  bool on_device_ = false, forget_ = false;
  std::optional<std::string> note_;
  Rung pace_ = Rung::preview;  // of moving pictures; the thread's own
  PictureRenderer pictures_;   // the thread's own
  std::jthread thread_;        // last: stops before the rest goes
};

}  // namespace likeness::ui
