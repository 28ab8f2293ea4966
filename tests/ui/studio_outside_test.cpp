// The real program on a display of its own, used as a person would: found by its window, clicked and typed at
// from outside (xdotool), looked at from outside (a grab of the screen).
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <thread>

#include "core/image/files.h"
#include "core/project/project.h"
#include "core/video/encode.h"
#include "tests/support/run_program.h"
#include "ui/platform/settings.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;

struct Place {
  int x = 0, y = 0, width = 0, height = 0;
};

// The program in a home of its own, with a clip to open. Ended at the end, whatever it is doing.
class StudioOutside : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* needed : {"xdotool", "ffmpeg"})
      if (run_program({needed, "-version"}).exit_code == 127) GTEST_SKIP() << needed << " is not installed";
    std::string name = (fs::temp_directory_path() / "likeness_outside_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    home_ = name;
    auto writer = VideoWriter::create(home_ / "Ada.mp4", 96, 96);
    ASSERT_TRUE(writer.ok());
    for (int i = 0; i < 30; ++i) ASSERT_TRUE(writer->add(Image8(96, 96, 3, std::uint8_t(80 + i))).ok());
    ASSERT_TRUE(writer->finish().ok());
    ::setenv("HOME", name.c_str(), 1);
    ::setenv("XDG_CONFIG_HOME", (home_ / "config").c_str(), 1);
    ui::Settings settings;
    settings.licences_shown = true;
    ASSERT_TRUE(ui::write_settings(ui::settings_path(), settings).ok());
    studio_ = start_program({LIKENESS_BIN "/likeness-studio", (home_ / "Ada.mp4").string()}, home_);
  }
  void TearDown() override {
    if (studio_ > 0) ::kill(studio_, SIGKILL), wait_program(studio_);
    if (!home_.empty()) fs::remove_all(home_);
  }

  static bool until(double seconds, const std::function<bool()>& so) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (std::chrono::steady_clock::now() < end) {
      if (so()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
    }
    return false;
  }
  Image8 grab() const {
    const fs::path file = home_ / "screen.png";
    run_program({"ffmpeg", "-v", "error", "-y", "-f", "x11grab", "-i", ::getenv("DISPLAY"), "-frames:v", "1",
                 file.string()});
    const auto picture = read_image(file);
    if (const char* shots = ::getenv("LIKENESS_SHOTS"); shots && picture.ok()) {
      EXPECT_TRUE(write_image(fs::path(shots) / "outside.png", *picture).ok());
    }
    return picture.ok() ? *picture : Image8();
  }
  static void use(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "xdotool");
    const ProgramResult used = run_program(arguments);
    EXPECT_EQ(used.exit_code, 0) << used.err;
  }

  fs::path home_;
  pid_t studio_ = 0;
  int status_ = 0;
};

// Buttons that ask to be pressed, left to right: patches of the theme's accent, of a button's size and nearly
// filled.
std::vector<Place> primary_buttons(const Image8& screen) {
  std::vector<bool> accent(screen.pixels());
  for (std::size_t i = 0; i < accent.size(); ++i) {
    const std::uint8_t* p = &screen.data[i * std::size_t(screen.channels)];
    accent[i] = std::abs(p[0] - 0x4c) < 8 && std::abs(p[1] - 0x8d) < 8 && std::abs(p[2] - 0xff) < 8;
  }
  std::vector<Place> found;
  for (std::size_t start = 0; start < accent.size(); ++start) {
    if (!accent[start]) continue;
    int left = screen.width, right = 0, top = screen.height, bottom = 0, count = 0;
    std::vector<int> open{int(start)};
    accent[start] = false;
    while (!open.empty()) {
      const int at = open.back(), x = at % screen.width, y = at / screen.width;
      open.pop_back();
      left = std::min(left, x), right = std::max(right, x), top = std::min(top, y),
      bottom = std::max(bottom, y);
      ++count;
      for (const auto& [u, v] : {std::pair{x - 1, y}, {x + 1, y}, {x, y - 1}, {x, y + 1}}) {
        if (u < 0 || v < 0 || u >= screen.width || v >= screen.height) continue;
        const std::size_t next = std::size_t(v) * std::size_t(screen.width) + std::size_t(u);
        if (accent[next]) open.push_back(int(next));
        accent[next] = false;
      }
    }
    const Place place{left, top, right - left + 1, bottom - top + 1};
    if (place.width > 40 && place.width < 300 && place.height > 20 &&
        count > 0.6 * place.width * place.height)
      found.push_back(place);
  }
  std::ranges::sort(found, {}, &Place::x);
  return found;
}

TEST_F(StudioOutside, AClickAnswersAndAKeyQuits) {
  ASSERT_TRUE(until(30, [] {
    return run_program({"xdotool", "search", "--onlyvisible", "--name", "Likeness"}).exit_code == 0;
  })) << "no window came";
  std::vector<Place> buttons;
  ASSERT_TRUE(until(30, [&] { return (buttons = primary_buttons(grab())).size() == 2; }))
      << buttons.size() << " buttons instead of the two answers";
  // "It is me" is the first; what it means is kept in the project on disk.
  use({"mousemove", std::to_string(buttons[0].x + buttons[0].width / 2),
       std::to_string(buttons[0].y + buttons[0].height / 2)});
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  use({"click", "1"});
  const fs::path project = home_ / "Likeness" / "Ada.likeness";
  EXPECT_TRUE(until(20, [&] {
    const auto opened = open_project(project);
    return opened.ok() && opened->consent == Consent::own;
  })) << "the answer was not kept";
  // The question is gone from the screen.
  EXPECT_TRUE(until(20, [&] {
    const auto now = primary_buttons(grab());
    return !now.empty() && std::ranges::none_of(now, [&](const Place& p) {
      return p.x <= buttons[1].x && p.x + p.width > buttons[1].x && std::abs(p.y - buttons[1].y) < 4;
    });
  }));
  use({"key", "ctrl+q"});
  EXPECT_TRUE(until(20, [&] { return ::waitpid(studio_, &status_, WNOHANG) == studio_; }))
      << "it did not quit";
  EXPECT_TRUE(WIFEXITED(status_) && WEXITSTATUS(status_) == 0) << status_;
  studio_ = 0;
}

}  // namespace
}  // namespace likeness::test
