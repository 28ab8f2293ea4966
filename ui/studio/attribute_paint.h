// The attributes painted in the window (core/matte/attributes.h), with their history. Free of windows, files
// and threads; the session (mask_session.h) reads and writes for it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/matte/attributes.h"

namespace likeness::ui {

// For the panels. all is never null.
struct AttributesView {
  bool on = false;   // attributes are painted, not masks
  std::string name;  // of the one that is painted, which may not be there yet
  std::shared_ptr<const PaintedAttributes> all = std::make_shared<const PaintedAttributes>();
  std::optional<Error> unreadable;  // the file is damaged: nothing is painted
  bool unlearnt = false;            // the avatar was trained before the last change
};

// What the panels ask for; strokes come as the masks' own (MaskRequests::stroke).
struct AttributeRequests {
  std::optional<bool> on;
  std::optional<std::string> name;
  float value = 1;           // that a stroke gives its frame where it has none yet
  std::optional<float> set;  // the amount of the frame shown
  std::optional<std::string> remove;
};

class AttributePaint {
 public:
  // Another project's, or none; nothing can be undone.
  void open(PaintedAttributes attributes, std::optional<Error> unreadable);
  // The same project's, read again. False: there are unsaved changes, which stay instead.
  bool refresh(const PaintedAttributes& attributes, std::optional<Error> unreadable);
  void turn(bool on) { on_ = on, ++edit_; }
  void choose(std::string name) { name_ = std::move(name), ++edit_; }

  bool on() const { return on_; }
  const std::string& name() const { return name_; }
  std::uint64_t edit() const { return edit_; }
  std::shared_ptr<const PaintedAttributes> all() const { return all_; }
  // What is painted of the chosen one on a frame.
  std::shared_ptr<const Strokes> strokes(int frame) const;
  // Without `unlearnt`, which only the session knows.
  AttributesView view() const { return {on_, name_, all_, unreadable_, false}; }

  // Of the chosen one, on a frame. False: nothing changed.
  bool paint(int frame, float value, Stroke stroke);
  bool set_value(int frame, float value);
  bool clear(int frame);
  bool remove(const std::string& name);
  bool undo();
  bool redo();
  bool can_undo() const { return present_ > 0; }
  bool can_redo() const { return present_ < history_.size(); }

  bool take_unsaved() { return std::exchange(unsaved_, false); }
  void was_not_saved() { unsaved_ = true; }
  bool has_unsaved() const { return unsaved_; }

 private:
  using Shared = std::shared_ptr<const PaintedAttributes>;
  bool change(PaintedAttributes after);
  void place(const Shared& attributes);

  bool on_ = false, unsaved_ = false;
  std::string name_ = "attribute 1";
  Shared all_ = std::make_shared<const PaintedAttributes>();
  std::optional<Error> unreadable_;
  std::vector<std::pair<Shared, Shared>> history_;  // before and after
  std::size_t present_ = 0;                         // changes that are done
  std::uint64_t edit_ = 0;
};

}  // namespace likeness::ui
