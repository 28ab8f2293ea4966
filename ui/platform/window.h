// The window: GLFW, one OpenGL 3.3 core context, and Dear ImGui in it. All functions but wake() belong to the
// main thread.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness::ui {

struct WindowOptions {
  std::string title = "Likeness";
  int width = 1280, height = 800;  // screen coordinates
  bool maximised = false;
  bool visible = true;  // tests draw into a hidden one
};

// Input as if it came from the user, for tests: replaces mouse and keys of the next frames while it is set.
struct InjectedInput {
  float mouse_x = -1, mouse_y = -1;
  std::array<bool, 3> down{};  // left, right, middle
  float wheel = 0;
  int key = 0;  // GLFW's, held down during the frame; 0: none
  bool ctrl = false, shift = false;
  std::string text;
};

class Window {
 public:
  static Result<std::unique_ptr<Window>> open(const WindowOptions& options);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  // Waits for input, for wake() or for the time to pass; true unless only time has passed.
  bool wait(double timeout_s);
  // Ends a wait. From any thread.
  static void wake();

  void begin_frame();
  void end_frame();

  void set_title(const std::string& title);
  // Asked for once: the user wants to close; files that were dropped.
  bool take_close_request();
  std::vector<std::filesystem::path> take_drops();
  void drop(std::vector<std::filesystem::path> paths);  // as if dropped

  int width() const;  // px of the framebuffer
  int height() const;
  float pixel_scale() const;  // of the screen: 2 on a screen of double density
  bool maximised() const;
  std::array<int, 2> size() const;  // screen coordinates
  std::string renderer() const;     // what draws: the graphics driver's words

  void inject(std::optional<InjectedInput> input);
  // The last frame of a hidden window, (h, w, 3), top row first.
  Image8 read_pixels() const;

  struct Impl;

 private:
  explicit Window(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace likeness::ui
