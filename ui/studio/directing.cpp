// See directing.h.
#include "ui/studio/directing.h"

#include <algorithm>
#include <cmath>

namespace likeness::ui {

void Directing::open(Performance performance) {
  history_ = PerformanceHistory(std::move(performance));
  playhead_s_ = 0;
  playing_since_.reset();
  unsaved_since_.reset();
  select({});
  show_present();
}

void Directing::show_present() {
  performance_ = std::make_shared<const Performance>(history_.present());
  std::vector<KeyPlace> kept = *selected_;
  std::erase_if(kept, [&](const KeyPlace& place) { return !find_key(*performance_, place); });
  if (kept.size() != selected_->size()) select(std::move(kept));
  go_to(playhead_s_);
}

void Directing::select(std::vector<KeyPlace> keys) {
  selected_ = std::make_shared<const std::vector<KeyPlace>>(std::move(keys));
}

void Directing::apply(const DirectingRequests& requests) {
  if (requests.linked) linked_ = *requests.linked;
  if (requests.record_keys) record_keys_ = *requests.record_keys;
  if (requests.looping) looping_ = *requests.looping;
  if (requests.selected) select(*requests.selected);
  if (requests.performance && *requests.performance != *performance_) {
    history_.record(*requests.performance, requests.what, gesture_);
    unsaved_since_ = Clock::now();
    show_present();
  }
  if (requests.finished) ++gesture_;
  if (requests.playhead_s) {
    stop_playing();
    go_to(*requests.playhead_s);
  }
}

void Directing::edit(Performance performance, std::string what) {
  ++gesture_;
  DirectingRequests requests;
  requests.edit(std::move(performance), std::move(what));
  requests.finished = true;
  apply(requests);
}

DirectingView Directing::view() const {
  DirectingView view{performance_, playhead_s_, playing(), looping_, record_keys_, linked_, selected_};
  if (history_.can_undo()) view.undo_name = history_.undo_name();
  if (history_.can_redo()) view.redo_name = history_.redo_name();
  view.keys_copied = !keys_.channels.empty();
  view.pose_copied = pose_.has_value();
  return view;
}

void Directing::undo() {
  ++gesture_;
  if (!history_.can_undo()) return;
  history_.undo();
  unsaved_since_ = Clock::now();
  show_present();
}

void Directing::redo() {
  ++gesture_;
  if (!history_.can_redo()) return;
  history_.redo();
  unsaved_since_ = Clock::now();
  show_present();
}

void Directing::toggle_playing(Clock::time_point now) {
  if (playing()) {
    stop_playing();
    go_to(playhead_s_);
    return;
  }
  played_from_s_ = playhead_s_ >= performance_->duration_s - 1.5 * frame_s() ? 0 : playhead_s_;
  playing_since_ = now;
}

bool Directing::advance(Clock::time_point now) {
  if (!playing_since_) return false;
  const double before = playhead_s_, end = performance_->duration_s;
  double time = played_from_s_ + std::chrono::duration<double>(now - *playing_since_).count();
  if (time >= end && !looping_) {
    stop_playing();
    time = end;
  }
  go_to(looping_ && end > 0 ? std::fmod(time, end) : time);
  return playhead_s_ != before;
}

void Directing::go_to(double time_s) {
  const double last = std::max(0, frame_count(*performance_) - 1) * frame_s();
  playhead_s_ = std::clamp(std::round(time_s / frame_s()) * frame_s(), 0.0, last);
}

void Directing::step_frames(int frames) {
  stop_playing();
  go_to(playhead_s_ + frames * frame_s());
}

void Directing::go_to_key(int direction) {
  stop_playing();
  double best = direction > 0 ? performance_->duration_s : 0;
  for (const auto& [channel, keys] : performance_->channels)
    for (const Key& key : keys) {
      const double away = (key.time_s - playhead_s_) * direction;
      if (away > 0.5 * frame_s() && away < (best - playhead_s_) * direction) best = key.time_s;
    }
  go_to(best);
}

void Directing::select_all() { select(all_keys(*performance_)); }

void Directing::select_here() {
  std::vector<KeyPlace> here = all_keys(*performance_);
  std::erase_if(
      here, [&](const KeyPlace& place) { return std::abs(place.time_s - playhead_s_) >= 0.5 * frame_s(); });
  select(std::move(here));
}

void Directing::copy_selected() { keys_ = likeness::copy_keys(*performance_, *selected_); }

void Directing::paste() {
  Performance edited = *performance_;
  const std::vector<KeyPlace> pasted = paste_keys(edited, keys_, playhead_s_);
  edit(std::move(edited), "paste keys");
  select(pasted);
}

void Directing::delete_selected() {
  Performance edited = *performance_;
  erase_keys(edited, *selected_);
  edit(std::move(edited), "delete keys");
}

void Directing::move_selected(int frames) {
  Performance edited = *performance_;
  const std::vector<KeyPlace> moved = move_keys(edited, *selected_, frames * frame_s());
  for (const KeyPlace& place : moved) edited.duration_s = std::max(edited.duration_s, place.time_s);
  edit(std::move(edited), "move keys");
  select(moved);
}

void Directing::ease_selected(Easing easing) {
  Performance edited = *performance_;
  set_easing(edited, *selected_, easing);
  edit(std::move(edited), "easing");
}

void Directing::next_easing() {
  if (selected_->empty()) return;
  const Easing first = find_key(*performance_, selected_->front())->easing;
  ease_selected(Easing((int(first) + 1) % int(std::size(kEasings))));
}

void Directing::add_keys() {
  Performance edited = *performance_;
  hold_pose(edited, playhead_s_);
  edit(std::move(edited), "add keys");
  select_here();
}

void Directing::copy_pose() { pose_ = pose_at(*performance_, playhead_s_); }

void Directing::paste_pose() {
  if (!pose_) return;
  Performance edited = *performance_;
  set_pose(edited, *pose_, value_edit());
  edit(std::move(edited), "paste the pose");
}

}  // namespace likeness::ui
