// See masks.h.
#include "ui/studio/masks.h"

#include <algorithm>
#include <utility>

namespace likeness::ui {

namespace {

// Each change holds its frame's strokes; far more changes than anybody undoes.
constexpr std::size_t kMaxChanges = 200;

}  // namespace

void Masks::open(FrameStrokes strokes, std::map<int, Error> unreadable) {
  const std::uint64_t edit = edit_;
  *this = {};
  edit_ = edit + 1;  // so that no picture of another project's strokes is taken for one of these
  for (auto& [frame, own] : strokes) strokes_[frame] = std::make_shared<const Strokes>(std::move(own));
  unreadable_ = std::move(unreadable);
}

void Masks::refresh(const FrameStrokes& strokes, std::map<int, Error> unreadable) {
  std::map<int, std::shared_ptr<const Strokes>> now;
  for (const auto& [frame, own] : strokes) {
    const auto held = strokes_.find(frame);
    const bool same = held != strokes_.end() && *held->second == own;
    now[frame] = same ? held->second : std::make_shared<const Strokes>(own);
  }
  for (const int frame : unsaved_) {
    now.erase(frame);
    if (const auto held = strokes_.find(frame); held != strokes_.end()) now[frame] = held->second;
  }
  unreadable_ = std::move(unreadable);
  if (now == strokes_) return;
  strokes_ = std::move(now);
  history_.clear(), present_ = 0;  // it is of strokes that are gone
  ++edit_;
}

void Masks::set_frames(std::vector<int> frames) {
  frames_ = std::make_shared<const std::vector<int>>(std::move(frames));
  if (frames_->empty()) {
    frame_ = -1;
  } else if (!std::ranges::binary_search(*frames_, frame_)) {
    frame_ = (*frames_)[frames_->size() / 2];
  }
}

void Masks::look_at(int frame) {
  if (std::ranges::binary_search(*frames_, frame)) frame_ = frame;
}

void Masks::step(int frames) {
  if (frames_->empty()) return;
  const auto at = std::ranges::lower_bound(*frames_, frame_) - frames_->begin();
  frame_ = (*frames_)[std::size_t(std::clamp<std::ptrdiff_t>(at + frames, 0, std::ssize(*frames_) - 1))];
}

std::shared_ptr<const Strokes> Masks::strokes(int frame) const {
  static const auto none = std::make_shared<const Strokes>();
  const auto own = strokes_.find(frame);
  return own == strokes_.end() ? none : own->second;
}

MasksView Masks::view() const {
  MasksView view;
  view.shown = shown_;
  view.frame = frame_;
  view.look = look_;
  view.frames = frames_;
  view.strokes = strokes(frame_);
  for (const auto& [frame, own] : strokes_) view.corrected.insert(frame);
  view.unreadable = unreadable_;
  view.edit = edit_;
  view.can_undo = can_undo();
  view.can_redo = can_redo();
  return view;
}

bool Masks::paint(Stroke stroke) {
  // There is nothing to erase.
  if (stroke.mark == StrokeMark::erase && strokes(frame_)->empty()) return false;
  Strokes after = *strokes(frame_);
  after.push_back(std::move(stroke));
  return change(std::move(after));
}

bool Masks::clear() { return !strokes(frame_)->empty() && change({}); }

bool Masks::change(Strokes after) {
  if (frame_ < 0 || unreadable_.contains(frame_)) return false;
  history_.resize(present_);
  if (history_.size() == kMaxChanges) history_.erase(history_.begin()), --present_;
  history_.push_back({frame_, strokes(frame_), std::make_shared<const Strokes>(std::move(after))});
  return redo();
}

bool Masks::undo() {
  if (!can_undo()) return false;
  const Change& last = history_[--present_];
  place(last.frame, last.before);
  return true;
}

bool Masks::redo() {
  if (!can_redo()) return false;
  const Change& next = history_[present_++];
  place(next.frame, next.after);
  return true;
}

void Masks::place(int frame, std::shared_ptr<const Strokes> strokes) {
  if (strokes->empty()) {
    strokes_.erase(frame);
  } else {
    strokes_[frame] = std::move(strokes);
  }
  unsaved_.insert(frame);
  ++edit_;
  look_at(frame);
}

void Masks::was_set_aside(int frame) {
  unreadable_.erase(frame);
  ++edit_;
}

std::set<int> Masks::take_unsaved() { return std::exchange(unsaved_, {}); }

}  // namespace likeness::ui
