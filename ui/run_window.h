// The program's loop: waits for something to happen, draws, carries out requests.
#pragma once

#include <chrono>
#include <functional>

#include "core/base/result.h"
#include "ui/platform/window.h"
#include "ui/shell.h"
#include "ui/studio/studio.h"

namespace likeness::ui {

// One frame of the window. False: the program ends.
class WindowLoop {
 public:
  // The references must outlive it.
  WindowLoop(Window& window, Studio& studio, Shell& shell)
      : window_(window), studio_(studio), shell_(shell) {}

  bool frame();
  // Seconds to wait for input before the next frame: none while something still settles, otherwise until the
  // clock in the window should go on.
  double patience() const;
  // Seconds to let pass before the next frame even if something happens: a moving mouse asks for a hundred
  // frames a second, and each is time that work on this computer does not have.
  double rest_s() const;
  void touched() { lively_frames_ = 3; }

 private:
  void carry_out(WindowRequest request);

  Window& window_;
  Studio& studio_;
  Shell& shell_;
  std::string title_;
  std::chrono::steady_clock::time_point began_;  // the last frame
  int lively_frames_ = 3;                        // ImGui needs a frame to settle after an input
  bool quit_ = false, stopping_ = false;
};

// `frames` until it returns; an exception that it lets out, as where memory ends, becomes an Error.
Result<void> guard_window(const std::function<void()>& frames);

// An Error, too, where the window itself broke: work is then ended as by "Keep and stop".
Result<void> run_window(const StudioOptions& options, const std::filesystem::path& to_open);

}  // namespace likeness::ui
