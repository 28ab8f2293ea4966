// How the window and a training get along: from a dropped clip to a head that turns, what an open window
// costs the training, and how often the window is drawn meanwhile. Run by `packaging/studio-pace`; no test,
// because it is about time, and takes a quarter of an hour on a quiet computer.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>

#include "tests/support/run_program.h"
#include "tests/ui/studio_window.h"
#include "ui/run_window.h"

namespace likeness::ui {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using test::TestWindow;

constexpr int kRounds = 3;
constexpr std::uint64_t kSteps = 400;  // of a training that is compared
constexpr std::uint64_t kFirst = 40;   // steps that are not: caches and regions are still settling
constexpr double kMouse_s = 1.0 / 60;  // between two moves of a hand

double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// What the window did over a while.
struct Watched {
  double seconds = 0;
  int drawn = 0;
  double longest_s = 0;  // picture of the window
  double steps = 0;      // of training
  double per_second() const { return drawn / std::max(1e-9, seconds); }
  double rate() const { return steps / std::max(1e-9, seconds); }
};

class StudioPace : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_pace_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    StudioOptions options;
    options.settings = folder_ / "studio.json";
    options.projects = folder_ / "projects";
    Settings settings;
    settings.licences_shown = true;
    ASSERT_TRUE(write_settings(options.settings, settings).ok());
    studio_ = std::make_unique<Studio>(options, &Window::wake);
    TestWindow::shown = true;  // a hidden window's pictures are not brought to the screen
    TestWindow& test = TestWindow::get();
    loop_ = std::make_unique<WindowLoop>(*test.window, *studio_, *test.shell);
    fmt::print("Window of 1280 x 800 px drawn by {}\n", test.window->renderer());
  }
  void TearDown() override {
    loop_.reset();
    studio_.reset();
    TestWindow::get().window->inject(std::nullopt);
    fs::remove_all(folder_);
  }

  // As the program's own loop: draws when something happened, else waits.
  void live_once() {
    loop_->frame();
    if (TestWindow::get().window->wait(loop_->patience())) loop_->touched();
    std::this_thread::sleep_for(std::chrono::duration<double>(loop_->rest_s()));
  }
  bool until(double minutes, const std::function<bool(const Snapshot&)>& so) {
    const auto start = Clock::now();
    while (!so(studio_->snapshot())) {
      if (since(start) > 60 * minutes) return false;
      if (const auto error = studio_->snapshot().error) {
        ADD_FAILURE() << error->what;
        return false;
      }
      live_once();
    }
    return true;
  }
  void click(const std::string& widget) {
    for (int i = 0; i < 3; ++i) loop_->frame();
    test::click(widget, [this] { loop_->frame(); });
    TestWindow::get().window->inject(std::nullopt);
  }

  static double step_of(const Snapshot& s) {
    return s.project.pipeline.training.empty() ? 0 : double(s.project.pipeline.training.back().step);
  }
  // The window left alone for a time, or until its work is done.
  Watched leave_alone(double seconds) {
    Watched watched;
    const double first = step_of(studio_->snapshot());
    const auto start = Clock::now();
    while (since(start) < seconds && studio_->is_working()) {
      live_once();
      ++watched.drawn;
    }
    watched.seconds = since(start), watched.steps = step_of(studio_->snapshot()) - first;
    return watched;
  }
  // A hand that moves in a widget; pressed: drags.
  Watched touch(const std::string& widget, bool pressed, double seconds) {
    Watched watched;
    for (int i = 0; i < 3; ++i) loop_->frame();
    const InjectedInput middle = test::mouse_over(widget);
    const double first = step_of(studio_->snapshot());
    const auto start = Clock::now();
    while (since(start) < seconds) {
      InjectedInput input = middle;
      input.mouse_x += 40 * float(std::sin(3 * since(start)));
      input.mouse_y += 10 * float(std::cos(3 * since(start)));
      input.down[0] = pressed && watched.drawn > 1;
      TestWindow::get().window->inject(input);
      const auto drawn = Clock::now();
      loop_->touched();
      loop_->frame();
      TestWindow::get().window->wait(0);
      watched.longest_s = std::max(watched.longest_s, since(drawn));
      ++watched.drawn;
      std::this_thread::sleep_for(
          std::chrono::duration<double>(std::max(loop_->rest_s(), kMouse_s - since(drawn))));
    }
    watched.seconds = since(start), watched.steps = step_of(studio_->snapshot()) - first;
    TestWindow::get().window->inject(std::nullopt);
    return watched;
  }

  void from_a_clip_to_a_turned_head() {
    const char* clip = std::getenv("LIKENESS_CLIP");
    if (clip && *clip) {
      TestWindow::get().window->drop({clip});
    } else {
      click("Try the demo");
    }
    ASSERT_TRUE(
        until(10, [](const Snapshot& s) { return s.project.contents && s.project.clip_picture.image; }));
    if (studio_->snapshot().project.contents->project.consent == Consent::not_asked) click("They agreed");
    const auto start = Clock::now();
    click("Make the avatar");
    ASSERT_TRUE(until(30, [](const Snapshot& s) { return !s.project.pipeline.training.empty(); }));
    const double training = since(start);
    ASSERT_TRUE(until(5, [](const Snapshot& s) { return s.project.pipeline.preview != nullptr; }));
    const double preview = since(start) - training;
    ASSERT_TRUE(
        until(30, [](const Snapshot& s) { return s.situation.finished && s.project.contents->avatar; }));
    test::drag("avatar view", 60, 10, 0, [this] { loop_->frame(); });
    TestWindow::get().window->inject(std::nullopt);
    ASSERT_TRUE(until(1, [](const Snapshot& s) {
      return s.direct.picture && s.direct.picture->last && s.direct.picture->origin.moment == s.direct.moment;
    }));
    fmt::print(
        "From the click to the first step of training {:.0f} s, from there to the first preview {:.0f} s; "
        "the avatar turned after {:.1f} min.\n",
        training, preview, since(start) / 60);
    project_ = studio_->folder();
  }

  // The project as it is before its training.
  fs::path untrained(const std::string& name) const {
    const fs::path folder = folder_ / name;
    fs::copy(project_, folder, fs::copy_options::recursive);
    auto project = open_project(folder);
    EXPECT_TRUE(project.ok());
    for (const fs::path& made :
         {avatar_path(*project), checkpoint_path(*project), training_curve_path(*project)})
      fs::remove(made);
    project->options.train.steps = kSteps;
    project->record(Stage::train) = {};
    EXPECT_TRUE(save_project(*project).ok());
    return folder;
  }

  double rate_of_command_line(int round) {
    const fs::path folder = untrained(fmt::format("line{}", round));
    const auto ran = likeness::test::likeness({"train", folder.string(), "--steps", std::to_string(kSteps)});
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    const auto project = open_project(folder);
    const auto curve = read_training_curve(training_curve_path(*project));
    if (!curve || curve->training.empty()) {
      ADD_FAILURE() << "no curve";
      return 0;
    }
    const auto first = std::ranges::find_if(curve->training, [](const auto& s) { return s.step >= kFirst; });
    const TrainStatus &a = *first, &b = curve->training.back();
    fs::remove_all(folder);
    return double(b.step - a.step) / (b.seconds - a.seconds);
  }

  Watched rate_of_window(int round) {
    const fs::path folder = untrained(fmt::format("window{}", round));
    TestWindow::get().window->drop({folder});
    EXPECT_TRUE(until(1, [&](const Snapshot& s) {
      return s.project.contents && s.project.contents->project.folder == folder && !s.project.loading;
    }));
    click("step Train");
    click("Make the avatar");
    EXPECT_TRUE(until(5, [](const Snapshot& s) { return step_of(s) >= kFirst; }));
    // To the last report of the training: what comes after it is not training.
    Watched watched;
    const double first = step_of(studio_->snapshot());
    const auto start = Clock::now();
    double step = first;
    while (studio_->is_working() && step < kSteps) {
      live_once();
      ++watched.drawn;
      const double now = step_of(studio_->snapshot());
      if (now > step) watched.seconds = since(start), step = now;
    }
    watched.steps = step - first;
    EXPECT_TRUE(until(5, [](const Snapshot& s) { return !is_working(s.project.pipeline.job); }));
    fs::remove_all(folder);
    return watched;
  }

  void cost_of_an_open_window() {
    double line = 0, window = 0, drawn = 0, seconds = 0;
    for (int round = 0; round < kRounds; ++round) {
      const double alone = rate_of_command_line(round);
      const Watched seen = rate_of_window(round);
      fmt::print(
          "Round {}: command line {:.2f} steps a second, window {:.2f}, drawn {:.1f} times a second.\n",
          round + 1, alone, seen.rate(), seen.per_second());
      line += alone, window += seen.rate(), drawn += seen.drawn, seconds += seen.seconds;
    }
    fmt::print(
        "Training in an untouched window with previews: {:.3f} of the command line's speed; drawn {:.1f} "
        "times a second.\n",
        window / line, drawn / seconds);
  }

  void touched_beside_a_training() {
    TestWindow::get().window->drop({project_});
    ASSERT_TRUE(until(1, [&](const Snapshot& s) {
      return s.project.contents && s.project.contents->project.folder == project_ &&
             s.project.contents->avatar;
    }));
    click("step Train");
    click("Train longer");
    const double first = step_of(studio_->snapshot());
    ASSERT_TRUE(until(2, [&](const Snapshot& s) { return step_of(s) > first; }));
    struct View {
      const char *step, *widget;
      bool pressed;
    };
    constexpr View kViews[] = {{"Cameras", "camera view", true},
                               {"Face", "face picture", false},
                               {"Train", "training curve", false},
                               {"Direct", "avatar view", true}};
    for (const bool paused : {false, true}) {
      if (paused) {
        click("step Train");
        click("Pause");
        ASSERT_TRUE(until(1, [](const Snapshot& s) { return s.project.pipeline.job.waiting; }));
      }
      for (const View& view : kViews) {
        click(std::string("step ") + view.step);
        const Watched before = leave_alone(paused ? 1 : 8), touched = touch(view.widget, view.pressed, 8);
        fmt::print("{}, {}: {:.1f} pictures of the window a second, the longest {:.0f} ms", view.step,
                   paused ? "training paused" : "training", touched.per_second(), 1000 * touched.longest_s);
        if (!paused)
          fmt::print("; training at {:.2f} of its speed untouched",
                     touched.rate() / std::max(1e-9, before.rate()));
        fmt::print(".\n");
      }
    }
    click("step Train");
    click("Stop");
    EXPECT_TRUE(until(1, [](const Snapshot& s) { return !is_working(s.project.pipeline.job); }));
  }

  fs::path folder_, project_;
  std::unique_ptr<Studio> studio_;
  std::unique_ptr<WindowLoop> loop_;
};

TEST_F(StudioPace, OfOneClip) {
  const char* given = std::getenv("LIKENESS_CLIP");
  if (given && fs::is_directory(given)) {
    project_ = folder_ / "copy";
    fs::copy(given, project_, fs::copy_options::recursive);
    auto project = open_project(project_);
    ASSERT_TRUE(project.ok()) << project.error().what;
    project->consent = Consent::given;  // it was made already; the command line does not ask
    ASSERT_TRUE(save_project(*project).ok());
  } else {
    ASSERT_NO_FATAL_FAILURE(from_a_clip_to_a_turned_head());
    ASSERT_NO_FATAL_FAILURE(cost_of_an_open_window());
  }
  ASSERT_NO_FATAL_FAILURE(touched_beside_a_training());
}

}  // namespace
}  // namespace likeness::ui
