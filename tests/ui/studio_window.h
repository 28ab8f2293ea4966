// A hidden window with the studio in it, driven frame by frame: clicks by the names of widgets, pixels read
// back.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "core/image/files.h"
#include "ui/platform/window.h"
#include "ui/shell.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui::test {

// One window for the whole program: a second OpenGL context would only cost time.
struct TestWindow {
  std::unique_ptr<Window> window;
  std::unique_ptr<Shell> shell;
  inline static bool shown = false;  // to be said before the window is opened

  static TestWindow& get() {
    static TestWindow one = [] {
      TestWindow made;
      auto window = Window::open({.width = 1280, .height = 800, .visible = shown});
      if (!window) {
        ADD_FAILURE() << window.error().what;
        std::abort();
      }
      made.window = std::move(*window);
      auto shell = Shell::create();
      if (!shell) {
        ADD_FAILURE() << shell.error().what;
        std::abort();
      }
      made.shell = std::move(*shell);
      return made;
    }();
    return one;
  }
};

// Draws one frame of a snapshot without a studio behind it.
inline Requests draw_frame(const Snapshot& snapshot) {
  TestWindow& test = TestWindow::get();
  const float scale = float(snapshot.settings.scale_percent) / 100;
  if (!theme().fonts.body || theme().scale != scale || theme().dark != snapshot.settings.dark)
    apply_theme(snapshot.settings.dark, scale);
  test.window->wait(0);
  test.window->begin_frame();
  Requests requests = test.shell->draw(snapshot);
  test.window->end_frame();
  return requests;
}

// Standard deviation of the brightness inside a widget, 0..255: a blank view has none.
inline double liveliness(const Image8& screen, const std::string& widget) {
  const auto found = noted_widgets().find(widget);
  if (found == noted_widgets().end()) return -1;
  const Rectangle& r = found->second;
  double sum = 0, squares = 0, count = 0;
  for (int y = std::max(0, int(r.low.y)); y < std::min(screen.height, int(r.high.y)); ++y)
    for (int x = std::max(0, int(r.low.x)); x < std::min(screen.width, int(r.high.x)); ++x) {
      const double v = screen.at(x, y)[1];
      sum += v, squares += v * v, ++count;
    }
  return count > 0 ? std::sqrt(std::max(0.0, squares / count - sum * sum / count / count)) : -1;
}

// Share of the pixels in a rectangle that are near a colour (0..1 a channel).
inline double ink_share(const Image8& screen, const Rectangle& r, const ImVec4& ink) {
  const std::array<double, 3> wanted{255 * ink.x, 255 * ink.y, 255 * ink.z};
  double near = 0, count = 0;
  for (int y = std::max(0, int(r.low.y)); y < std::min(screen.height, int(r.high.y)); ++y)
    for (int x = std::max(0, int(r.low.x)); x < std::min(screen.width, int(r.high.x)); ++x, ++count) {
      double apart = 0;
      for (std::size_t c = 0; c < 3; ++c) apart = std::max(apart, std::abs(screen.at(x, y)[c] - wanted[c]));
      near += apart < 10;
    }
  return count > 0 ? near / count : 0;
}

// Where the step itself is drawn: right of the path, between the menus and the status bar.
inline Rectangle panel_of(const Image8& screen) {
  const Rectangle& row = noted_widgets().at("step Film");
  const float edge = 30 * theme().scale;
  return {{row.high.x + edge, row.low.y - edge},
          {float(screen.width), float(screen.height) - 40 * theme().scale}};
}

// For people: the picture goes to $LIKENESS_SHOTS where that is set.
inline void keep_shot(const std::string& name) {
  const char* folder = std::getenv("LIKENESS_SHOTS");
  if (!folder) return;
  const auto written =
      write_image(std::filesystem::path(folder) / (name + ".png"), TestWindow::get().window->read_pixels());
  EXPECT_TRUE(written.ok()) << written.error().what;
}

// The mouse over a widget's middle; where it is not shown, nowhere, and the test fails.
inline InjectedInput mouse_over(const std::string& widget) {
  InjectedInput input;
  const auto found = noted_widgets().find(widget);
  EXPECT_NE(found, noted_widgets().end()) << "no widget \"" << widget << "\" is shown";
  if (found == noted_widgets().end()) return input;
  input.mouse_x = 0.5f * (found->second.low.x + found->second.high.x);
  input.mouse_y = 0.5f * (found->second.low.y + found->second.high.y);
  return input;
}

// Moves the mouse onto a widget, presses and lets go. frame: draws one frame.
inline void click(const std::string& widget, const std::function<void()>& frame) {
  Window& window = *TestWindow::get().window;
  InjectedInput input = mouse_over(widget);
  for (const bool down : {false, true, false}) {
    input.down[0] = down;
    window.inject(input);
    frame();
  }
  input.mouse_x = input.mouse_y = 1;
  window.inject(input);
  frame();
}

inline void drag(const std::string& widget, float dx, float dy, int button,
                 const std::function<void()>& frame) {
  Window& window = *TestWindow::get().window;
  InjectedInput input = mouse_over(widget);
  window.inject(input);
  frame();
  input.down[std::size_t(button)] = true;
  window.inject(input);
  frame();
  for (int i = 0; i < 4; ++i) {
    input.mouse_x += dx / 4, input.mouse_y += dy / 4;
    window.inject(input);
    frame();
  }
  input.down[std::size_t(button)] = false;
  window.inject(input);
  frame();
}

}  // namespace likeness::ui::test
