// Everything in the window around the steps: menus, keys, the path down the side, the start screen, the
// status bar, questions. Draws one frame of a snapshot.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <utility>

#include "ui/file_browser.h"
#include "ui/studio/snapshot.h"
#include "ui/views.h"

namespace likeness::ui {

enum class Question { none, shortcuts, film_guide, licences, closing, delete_person, open_elsewhere };
enum class Closing { none, keep_and_stop };

class Shell {
 public:
  // wake: called from threads when there is something new to draw.
  static Result<std::unique_ptr<Shell>> create(std::function<void()> wake = [] {});
  explicit Shell(std::function<void()> wake) : browser_(std::move(wake)) {}

  // Draws one frame; what the user asked for in it.
  Requests draw(const Snapshot& snapshot);
  void browse(Wanted wanted, const std::filesystem::path& start) { browser_.open(wanted, start); }
  void ask(Question question) { asked_ = question; }
  Closing take_closing() { return std::exchange(closing_, Closing::none); }
  Views& views() { return *views_; }

 private:
  void draw_menus(const Snapshot& snapshot, Requests& requests);
  void press_keys(const Snapshot& snapshot, Requests& requests);
  void take_picked(const std::filesystem::path& picked, const Snapshot& snapshot, Requests& requests);
  void draw_questions(const Snapshot& snapshot, Requests& requests);

  std::unique_ptr<Views> views_;
  FileBrowser browser_;
  Question asked_ = Question::none, shown_ = Question::none;
  Closing closing_ = Closing::none;
};

// The parts, each into the current window.
void draw_start_screen(const Snapshot& snapshot, Requests& requests);
void draw_record_page(const Snapshot& snapshot, Views& views, Requests& requests);
void draw_path(const Snapshot& snapshot, Requests& requests);
void draw_status_bar(const Snapshot& snapshot, Requests& requests);
void draw_film_guide();
void draw_licences();

}  // namespace likeness::ui
