// What is being directed: the performance with its history, the playhead, the keys that are chosen. Free of
// windows, files and renderers; the session (direct_session.h) keeps its file and its picture.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/direct/beyond_seen.h"
#include "core/direct/edit_keys.h"
#include "core/direct/performance_history.h"
#include "core/direct/set_values.h"

namespace likeness::ui {

// For the panels. performance and selected are never null.
struct DirectingView {
  std::shared_ptr<const Performance> performance = std::make_shared<const Performance>();
  double playhead_s = 0;
  bool playing = false, looping = true;
  bool record_keys = false;  // what is set becomes a key at the playhead
  bool linked = true;        // the two halves of an action move together
  std::shared_ptr<const std::vector<KeyPlace>> selected = std::make_shared<const std::vector<KeyPlace>>();
  std::string undo_name, redo_name;  // of the steps; empty: none
  bool keys_copied = false, pose_copied = false;
  ViewPoint view;     // at the playhead
  BeyondSeen beyond;  // at the playhead

  ValueEdit edit() const { return {playhead_s, record_keys, linked}; }
};

// What the panels ask for.
struct DirectingRequests {
  std::optional<Performance> performance;  // as edited
  std::string what;                        // names the step
  bool finished = false;                   // the slider or key was let go: the step ends
  std::optional<double> playhead_s;
  std::optional<std::vector<KeyPlace>> selected;
  std::optional<bool> linked, record_keys, looping;

  // What edits of this frame go on from.
  Performance start(const DirectingView& view) const { return performance.value_or(*view.performance); }
  void edit(Performance edited, std::string name) {
    performance = std::move(edited);
    what = std::move(name);
  }
};

class Directing {
 public:
  using Clock = std::chrono::steady_clock;

  // Another project's, or none; nothing can be undone.
  void open(Performance performance);
  void apply(const DirectingRequests& requests);
  // One step of its own.
  void edit(Performance performance, std::string what);
  const std::shared_ptr<const Performance>& performance() const { return performance_; }
  double playhead_s() const { return playhead_s_; }
  ValueEdit value_edit() const { return {playhead_s_, record_keys_, linked_}; }
  // Without what only the session knows: view and beyond.
  DirectingView view() const;

  void undo();
  void redo();
  void toggle_playing(Clock::time_point now);
  void toggle_looping() { looping_ = !looping_; }
  void toggle_recording() { record_keys_ = !record_keys_; }
  void stop_playing() { playing_since_.reset(); }
  bool playing() const { return playing_since_.has_value(); }
  // Moves the playhead while it plays; true where it moved.
  bool advance(Clock::time_point now);

  void go_to(double time_s);  // to the nearest frame
  void step_frames(int frames);
  void go_to_key(int direction);  // the next one of any channel, or the end
  void select_all();
  void select_here();  // the keys at the playhead
  void copy_selected();
  void paste();
  void delete_selected();
  void move_selected(int frames);
  void ease_selected(Easing easing);
  void next_easing();  // of the selected keys, all to one
  void add_keys();     // at the playhead, of every channel that has any
  void copy_pose();
  void paste_pose();

  // Changed since, and not yet written.
  std::optional<Clock::time_point> unsaved_since() const { return unsaved_since_; }
  void was_saved() { unsaved_since_.reset(); }
  void was_not_saved(Clock::time_point try_from) { unsaved_since_ = try_from; }

 private:
  void show_present();
  void select(std::vector<KeyPlace> keys);
  double frame_s() const { return 1 / performance_->frames_per_second; }

  PerformanceHistory history_{Performance{}};
  std::shared_ptr<const Performance> performance_ = std::make_shared<const Performance>();
  std::size_t gesture_ = 1;
  double playhead_s_ = 0, played_from_s_ = 0;
  std::optional<Clock::time_point> playing_since_, unsaved_since_;
  bool looping_ = true, record_keys_ = false, linked_ = true;
  std::shared_ptr<const std::vector<KeyPlace>> selected_ = std::make_shared<const std::vector<KeyPlace>>();
  KeyClip keys_;
  std::optional<PoseValues> pose_;
};

}  // namespace likeness::ui
