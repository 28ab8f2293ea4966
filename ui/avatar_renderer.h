// Pictures of an avatar from a thread of its own: the newest request wins, and each is answered first
// coarsely, then better, while nothing newer comes.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include "core/image/image.h"
#include "ui/acting.h"
#include "ui/project_contents.h"

namespace likeness::ui {

struct PictureRequest {
  std::shared_ptr<const DirectedAvatar> avatar;
  Acting acting;
  std::optional<FrameView> frame;  // a captured frame instead of the acting
  int finest = 256;                // px of the last rung: the size it is shown at, at most twice the avatar's
};

enum class Rung { coarse, preview, final, fine };  // fine: more pixels than the avatar was trained at
inline constexpr const char* kRungWords[] = {"coarse", "preview", "final", "fine"};

struct AvatarPicture {
  Image rgba;  // (h, w, 4) premultiplied
  Rung rung = Rung::coarse;
  bool last = false;   // nothing better will come
  double seconds = 0;  // it took
  Acting acting;
  int frame = -1;  // of the clip, or -1
};

class AvatarRenderer {
 public:
  // wake: called from the thread whenever there is a new picture.
  explicit AvatarRenderer(std::function<void()> wake);

  void request(PictureRequest request);
  void clear();  // forgets avatar and picture
  // Null before the first picture.
  std::shared_ptr<const AvatarPicture> latest() const;
  bool busy() const;

 private:
  void loop(std::stop_token stop);
  void answer(const PictureRequest& request, std::uint64_t number, std::stop_token stop);
  bool publish(std::uint64_t number, AvatarPicture picture);  // false: something newer was asked for
  bool is_newest(std::uint64_t number) const;

  std::function<void()> wake_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<PictureRequest> waiting_;
  std::shared_ptr<const AvatarPicture> latest_;
  std::uint64_t number_ = 0;  // of the newest request
  bool working_ = false;
  std::jthread thread_;  // last: stops before the rest goes
};

}  // namespace likeness::ui
