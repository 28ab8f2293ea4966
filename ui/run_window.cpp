// See run_window.h.
#include "ui/run_window.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <thread>

#include "core/base/fault_words.h"
#include "ui/theme.h"

namespace likeness::ui {

namespace {

constexpr double kBusyFrame_s = 1.0 / 30;  // between frames while the program computes: smooth enough to drag

}  // namespace

double WindowLoop::patience() const { return lively_frames_ > 0 ? 0 : studio_.patience_s(); }

double WindowLoop::rest_s() const {
  if (!studio_.computes()) return 0;
  const std::chrono::duration<double> since = std::chrono::steady_clock::now() - began_;
  return std::max(0.0, kBusyFrame_s - since.count());
}

void WindowLoop::carry_out(WindowRequest request) {
  switch (request) {
    case WindowRequest::none:
      return;
    case WindowRequest::quit:
      if (studio_.is_working()) {
        shell_.ask(Question::closing);
      } else {
        quit_ = true;
      }
      return;
    case WindowRequest::pick_clip:
      shell_.browse(Wanted::clip, home_folder() / "Videos");
      return;
    case WindowRequest::pick_project:
      shell_.browse(Wanted::project, studio_.projects());
      return;
    case WindowRequest::pick_projects:
      shell_.browse(Wanted::projects, studio_.projects());
      return;
    case WindowRequest::pick_performance:
      shell_.browse(Wanted::performance, studio_.folder());
      return;
    case WindowRequest::pick_driver:
      shell_.browse(Wanted::driver, home_folder() / "Videos");
      return;
    case WindowRequest::name_performance:
      shell_.browse(Wanted::new_performance, studio_.folder());
      return;
    case WindowRequest::pick_further_clip:
      shell_.browse(Wanted::further_clip, home_folder() / "Videos");
      return;
    case WindowRequest::find_clip:
      shell_.browse(Wanted::moved_clip, home_folder());
      return;
    case WindowRequest::delete_person:
      shell_.ask(Question::delete_person);
      return;
    case WindowRequest::film_guide:
      shell_.ask(Question::film_guide);
      return;
    case WindowRequest::shortcuts:
      shell_.ask(Question::shortcuts);
      return;
    case WindowRequest::licences:
      shell_.ask(Question::licences);
      return;
  }
}

bool WindowLoop::frame() {
  began_ = std::chrono::steady_clock::now();
  if (lively_frames_ > 0) --lively_frames_;
  studio_.tick();
  const Snapshot snapshot = studio_.snapshot();
  const float scale = window_.pixel_scale() * float(snapshot.settings.scale_percent) / 100;
  if (scale != theme().scale || snapshot.settings.dark != theme().dark || !theme().fonts.body ||
      letters_are_missing()) {
    apply_theme(snapshot.settings.dark, scale);
    touched();
  }
  const std::string title =
      snapshot.project.contents
          ? snapshot.project.contents->project.folder.stem().string() + " \u2013 Likeness"
          : "Likeness";
  if (title != title_) window_.set_title(title_ = title);
  window_.begin_frame();
  Requests requests = shell_.draw(snapshot);
  window_.end_frame();
  studio_.shown(snapshot.direct.picture);

  const auto drops = window_.take_drops();
  if (!drops.empty()) requests.open = drops.front();
  if (window_.take_close_request()) requests.ask(Command::quit);
  if (requests.open || !requests.commands.empty() || requests.show || requests.direct.performance ||
      requests.direct.playhead_s)
    touched();
  carry_out(studio_.apply(requests));
  if (stopping_ && studio_.goes_on()) stopping_ = false;  // something new was asked for instead
  if (shell_.take_closing() == Closing::keep_and_stop) {
    studio_.stop_work();
    stopping_ = true;
  }
  if (stopping_ && !studio_.is_working()) quit_ = true;
  // The window is opened at the remembered size times the screen's scale.
  const float density = window_.pixel_scale();
  if (!window_.maximised() || snapshot.settings.maximised != window_.maximised())
    studio_.remember_window(int(std::lround(window_.size()[0] / density)),
                            int(std::lround(window_.size()[1] / density)), window_.maximised());
  return !quit_;
}

Result<void> guard_window(const std::function<void()>& frames) {
  try {
    frames();
    return {};
  } catch (const std::exception& fault) {
    return Error{ErrorCode::failed, fmt::format("The window broke: {}.", fault_words(fault)),
                 "What was made is kept. Start the studio again; close other programs where memory is short.",
                 ""};
  }
}

Result<void> run_window(const StudioOptions& options, const std::filesystem::path& to_open) {
  const Settings settings = read_settings(options.settings);
  auto window =
      Window::open({.width = settings.width, .height = settings.height, .maximised = settings.maximised});
  if (!window) return window.error();
  auto shell = Shell::create(&Window::wake);
  if (!shell) return shell.error();
  Studio studio(options, &Window::wake);
  if (!settings.licences_shown) {
    (*shell)->ask(Question::licences);
    studio.licences_were_shown();
  }
  if (!to_open.empty()) {
    Requests requests;
    requests.open = to_open;
    studio.apply(requests);
  }
  WindowLoop loop(**window, studio, **shell);
  const auto ran = guard_window([&] {
    while (loop.frame()) {
      if ((*window)->wait(loop.patience())) loop.touched();
      std::this_thread::sleep_for(std::chrono::duration<double>(loop.rest_s()));
    }
  });
  if (ran) return {};
  // A training writes its checkpoint, a recording its end.
  const auto ended = guard_window([&] {
    studio.stop_work();
    while (studio.is_working()) {
      studio.tick();
      std::this_thread::sleep_for(std::chrono::duration<double>(kBusyFrame_s));
    }
  });
  (void)ended;
  return ran;
}

}  // namespace likeness::ui
