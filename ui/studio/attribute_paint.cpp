// See attribute_paint.h.
#include "ui/studio/attribute_paint.h"

#include <algorithm>

namespace likeness::ui {

namespace {

constexpr std::size_t kMaxPaintChanges = 200;

}  // namespace

void AttributePaint::open(PaintedAttributes attributes, std::optional<Error> unreadable) {
  const std::uint64_t edit = edit_;
  *this = {};
  edit_ = edit + 1;
  all_ = std::make_shared<const PaintedAttributes>(std::move(attributes));
  unreadable_ = std::move(unreadable);
  if (!all_->empty()) name_ = all_->front().name;
}

bool AttributePaint::refresh(const PaintedAttributes& attributes, std::optional<Error> unreadable) {
  unreadable_ = std::move(unreadable);
  if (unsaved_) return false;
  if (attributes == *all_) return true;
  all_ = std::make_shared<const PaintedAttributes>(attributes);
  history_.clear(), present_ = 0;  // it is of attributes that are gone
  ++edit_;
  return true;
}

std::shared_ptr<const Strokes> AttributePaint::strokes(int frame) const {
  const AttributeAnnotation* own = find_annotation(*all_, name_, frame);
  return std::make_shared<const Strokes>(own ? own->region : Strokes{});
}

bool AttributePaint::paint(int frame, float value, Stroke stroke) {
  const AttributeAnnotation* own = find_annotation(*all_, name_, frame);
  // There is nothing to erase.
  if (stroke.mark == StrokeMark::erase && (!own || own->region.empty())) return false;
  AttributeAnnotation after = own ? *own : AttributeAnnotation{frame, double(value), {}};
  after.region.push_back(std::move(stroke));
  PaintedAttributes all = *all_;
  annotate(all, name_, std::move(after));
  return change(std::move(all));
}

bool AttributePaint::set_value(int frame, float value) {
  const AttributeAnnotation* own = find_annotation(*all_, name_, frame);
  if (own && own->value == double(value)) return false;
  AttributeAnnotation after = own ? *own : AttributeAnnotation{frame, 0, {}};
  after.value = double(value);
  PaintedAttributes all = *all_;
  annotate(all, name_, std::move(after));
  return change(std::move(all));
}

bool AttributePaint::clear(int frame) {
  PaintedAttributes all = *all_;
  return take_back(all, name_, frame) && change(std::move(all));
}

bool AttributePaint::remove(const std::string& name) {
  PaintedAttributes all = *all_;
  return take_back(all, name) && change(std::move(all));
}

bool AttributePaint::change(PaintedAttributes after) {
  if (unreadable_) return false;
  history_.resize(present_);
  if (history_.size() == kMaxPaintChanges) history_.erase(history_.begin()), --present_;
  history_.emplace_back(all_, std::make_shared<const PaintedAttributes>(std::move(after)));
  return redo();
}

bool AttributePaint::undo() {
  if (unreadable_ || !can_undo()) return false;
  place(history_[--present_].first);
  return true;
}

bool AttributePaint::redo() {
  if (unreadable_ || !can_redo()) return false;
  place(history_[present_++].second);
  return true;
}

void AttributePaint::place(const Shared& attributes) {
  all_ = attributes;
  unsaved_ = true;
  ++edit_;
}

}  // namespace likeness::ui
