// The whole studio in a hidden window of its own folder, used by clicks alone.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <memory>

#include "tests/ui/studio_window.h"
#include "ui/run_window.h"

namespace likeness::ui::test {

class DrivenStudio : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "likeness_studio_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    options_.settings = folder_ / "studio.json";
    options_.projects = folder_ / "projects";
    options_.demo = {.width = 320, .height = 320, .frames = 34, .moving_share = 0, .samples_per_pixel = 1};
  }
  void TearDown() override {
    loop_.reset();
    studio_.reset();
    TestWindow::get().window->inject(std::nullopt);
    std::filesystem::remove_all(folder_);
  }

  // The program started, or started again.
  void start() {
    loop_.reset();
    studio_.reset();
    studio_ = std::make_unique<Studio>(options_, [] {});
    TestWindow& test = TestWindow::get();
    loop_ = std::make_unique<WindowLoop>(*test.window, *studio_, *test.shell);
    frame();
    frame();
  }
  void frame() { going_ = loop_->frame(); }
  void click(const std::string& widget) {
    frame();  // a window that has just appeared takes its place in its second frame
    frame();
    test::click(widget, [this] { frame(); });
  }
  // Draws until it is so, five times a second; false after the time.
  bool until(double seconds, const std::function<bool(const Snapshot&)>& so) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (std::chrono::steady_clock::now() < end) {
      frame();
      if (so(studio_->snapshot())) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
    return false;
  }
  double liveliness(const std::string& widget) {
    frame();
    return test::liveliness(TestWindow::get().window->read_pixels(), widget);
  }

  std::filesystem::path folder_;
  StudioOptions options_;
  std::unique_ptr<Studio> studio_;
  std::unique_ptr<WindowLoop> loop_;
  bool going_ = true;
};

}  // namespace likeness::ui::test
