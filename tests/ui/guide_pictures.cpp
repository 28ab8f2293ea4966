// The guide's pictures: the demo taken from the start screen to an export in the real window, by clicks, with
// a picture of every step. Run by `packaging/guide-pictures`; no test, because it wants a good avatar and
// takes minutes.
#include <gtest/gtest.h>
#include <stdlib.h>

#include "tests/ui/studio_window.h"
#include "ui/run_window.h"

namespace likeness::ui {
namespace {

namespace fs = std::filesystem;
using test::TestWindow;

class GuidePictures : public testing::Test {
 protected:
  void SetUp() override {
    // A home that shows in the pictures: the same on every computer.
    folder_ = fs::temp_directory_path() / "Ada";
    project_ = folder_ / "Likeness" / "demo.likeness";
    fs::remove(folder_ / "studio.json");
    StudioOptions options;
    options.settings = folder_ / "studio.json";
    options.projects = folder_ / "Likeness";
    options.demo = {};  // the camera walks first: so the Cameras step has something to show
    options.project.train.steps = 700;
    Settings settings;
    settings.scale_percent = 125;  // letters that are read in a picture of two thirds of the size
    settings.licences_shown = true;
    ASSERT_TRUE(write_settings(options.settings, settings).ok());
    studio_ = std::make_unique<Studio>(options, [] {});
    TestWindow& test = TestWindow::get();
    loop_ = std::make_unique<WindowLoop>(*test.window, *studio_, *test.shell);
  }
  void TearDown() override {
    loop_.reset();
    studio_.reset();
    TestWindow::get().window->inject(std::nullopt);
  }
  void frames(int count) {
    for (int i = 0; i < count; ++i) loop_->frame();
  }
  void click(const std::string& widget) {
    frames(3);
    test::click(widget, [this] { loop_->frame(); });
  }
  void until(const std::function<bool(const Snapshot&)>& so) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(20);
    while (!so(studio_->snapshot())) {
      ASSERT_LT(std::chrono::steady_clock::now(), end);
      ASSERT_FALSE(studio_->snapshot().error) << studio_->snapshot().error->what;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      loop_->frame();
    }
  }
  void rest() {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    frames(4);
    until([](const Snapshot& s) { return !s.direct.rendering && !s.project.loading; });
    frames(4);
  }
  void keep(const std::string& name) {
    rest();
    const char* folder = std::getenv("LIKENESS_GUIDE");
    ASSERT_NE(folder, nullptr) << "LIKENESS_GUIDE is the folder of the guide";
    const Image8 screen = TestWindow::get().window->read_pixels();
    const auto written =
        write_image(fs::path(folder) / (name + ".png"),
                    resize(screen, screen.width * 5 / 8, screen.height * 5 / 8), {.png_level = 9});
    ASSERT_TRUE(written.ok()) << written.error().what;
  }

  fs::path folder_, project_;
  std::unique_ptr<Studio> studio_;
  std::unique_ptr<WindowLoop> loop_;
};

TEST_F(GuidePictures, OfEveryStep) {
  keep("start");
  const bool made = fs::exists(project_ / "avatar.bin");
  if (made) {
    TestWindow::get().window->drop({project_});
  } else {
    click("Try the demo");
  }
  until([](const Snapshot& s) { return s.project.contents && s.project.clip_picture.image; });
  click("step Film");
  keep("film");
  if (!made) click("Make the avatar");
  until([](const Snapshot& s) {
    return s.situation.finished && !s.situation.running && s.project.contents->avatar;
  });
  for (const auto& [step, name] : std::vector<std::pair<const char*, const char*>>{
           {"Check", "check"}, {"Cameras", "cameras"}, {"Face", "face"}, {"Train", "train"}}) {
    click(std::string("step ") + step);
    keep(name);
  }
  click("step Direct");
  click("Smile");
  test::drag("avatar view", 70, 10, 0, [this] { loop_->frame(); });
  until([](const Snapshot& s) {
    return s.direct.picture && s.direct.picture->last && s.direct.picture->origin.moment == s.direct.moment;
  });
  keep("direct");
  click("step Export");
  click("Export a still");
  until([](const Snapshot& s) { return !s.exports.written.empty(); });
  keep("export");
}

}  // namespace
}  // namespace likeness::ui
