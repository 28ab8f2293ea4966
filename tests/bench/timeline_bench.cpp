// How long the window's thread takes to draw the panels of a long clip and a long performance: 2,400 frames,
// and as many keys in every channel of the head and the face. What the panels draw, not the graphics card's
// part. Run under xvfb-run.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>

#include "tests/core/export/tiny_project.h"
#include "tests/ui/studio_window.h"

namespace likeness::ui {
namespace {

constexpr int kFrames = 2400;

std::shared_ptr<const ProjectContents> long_contents() {
  static const auto contents = [] {
    auto made = std::make_shared<ProjectContents>();
    made->project.folder = "/home/me/Likeness/Long.likeness";
    made->project.consent = Consent::own;
    made->current.fill(true);
    made->model = std::make_shared<const HeadModel>(likeness::test::tiny_head());
    Capture capture;
    CameraSet cameras;
    cameras.cameras.push_back({-1, {256, 256, 500, 500, 128, 128, 0, 0, 0, 0}, Pose::Identity()});
    Track track;
    capture.crop.side = capture.width = capture.height = capture.size = 256;
    for (int i = 0; i < kFrames; ++i) {
      const bool held_out = i > kFrames * 9 / 10;
      capture.frames.push_back({i, i / 30.0, 100 + 40 * std::sin(i * 0.7), held_out, !held_out, ""});
      TrackedFrame frame;
      frame.frame = i, frame.time_s = i / 30.0;
      frame.pose.articulation = neutral_articulation(*made->model);
      frame.inner_error_px = 1 + 0.8 * std::sin(i * 0.5);
      track.frames.push_back(frame);
    }
    made->capture = std::make_shared<const Capture>(capture);
    made->cameras = std::make_shared<const CameraSet>(cameras);
    made->track = std::make_shared<const Track>(track);
    made->avatar = ProjectAvatar::make(likeness::test::filmed_avatar(), made->model, {});
    return std::shared_ptr<const ProjectContents>(made);
  }();
  return contents;
}

std::shared_ptr<const Performance> long_performance() {
  static const auto performance = [] {
    auto made = std::make_shared<Performance>();
    made->frames_per_second = 30;
    made->duration_s = kFrames / made->frames_per_second;
    const auto fill = [&](const std::string& channel) {
      std::vector<Key>& keys = made->channels[channel];
      for (int i = 0; i < kFrames; ++i)
        keys.push_back({i / made->frames_per_second, 0.5f + 0.5f * std::sin(0.1f * float(i))});
    };
    for (const char* channel : {"head yaw", "head pitch", "head roll", "gaze yaw", "gaze pitch"})
      fill(channel);
    for (const NamedAction& action : likeness::test::tiny_head().actions) fill(action_channel(action.name));
    return std::shared_ptr<const Performance>(made);
  }();
  return performance;
}

Snapshot long_snapshot(Step step) {
  Snapshot s;
  s.shown = step;
  s.project.contents = long_contents();
  s.situation = {.project = true, .clip_there = true, .finished = true, .avatar = true, .consent = true};
  s.situation.directing = step == Step::direct;
  s.project.check_picture.frame = s.project.face_picture.frame = s.direct.compare_picture.frame = kFrames / 2;
  s.direct.directing.performance = long_performance();
  s.steps = view_steps(s.project.contents.get(), false, {}, {}, {});
  return s;
}

void draw(benchmark::State& state, const Snapshot& snapshot) {
  test::TestWindow& window = test::TestWindow::get();
  test::draw_frame(snapshot);
  for (auto _ : state) {
    window.window->wait(0);
    window.window->begin_frame();
    const auto start = std::chrono::steady_clock::now();
    const Requests requests = window.shell->draw(snapshot);
    state.SetIterationTime(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    benchmark::DoNotOptimize(requests.commands.size());
    window.window->end_frame();
  }
}

void check(benchmark::State& state) { draw(state, long_snapshot(Step::check)); }
void face(benchmark::State& state) { draw(state, long_snapshot(Step::face)); }
void direct(benchmark::State& state) { draw(state, long_snapshot(Step::direct)); }
void direct_all_chosen(benchmark::State& state) {
  Snapshot s = long_snapshot(Step::direct);
  s.direct.directing.selected = std::make_shared<const std::vector<KeyPlace>>(all_keys(*long_performance()));
  draw(state, s);
}
void compare(benchmark::State& state) {
  Snapshot s = long_snapshot(Step::direct);
  s.direct.comparing = true;
  draw(state, s);
}

BENCHMARK(check)->UseManualTime()->Iterations(20)->Unit(benchmark::kMillisecond);
BENCHMARK(face)->UseManualTime()->Iterations(20)->Unit(benchmark::kMillisecond);
BENCHMARK(direct)->UseManualTime()->Iterations(20)->Unit(benchmark::kMillisecond);
BENCHMARK(direct_all_chosen)->UseManualTime()->Iterations(20)->Unit(benchmark::kMillisecond);
BENCHMARK(compare)->UseManualTime()->Iterations(20)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace likeness::ui

BENCHMARK_MAIN();
