// The studio's masks: their picture, what is painted on them - strokes and attributes - and the files of
// both.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "ui/studio/attribute_paint.h"
#include "ui/studio/directing.h"
#include "ui/studio/mask_picture.h"
#include "ui/studio/masks.h"
#include "ui/studio/session_context.h"

namespace likeness::ui {

// The panels see a MasksView and ask by MaskRequests (masks.h).
class MaskSession {
 public:
  // read_again: reads the open project's folder once more; what was painted may have made stages stale.
  MaskSession(const SessionContext& context, std::function<void()> read_again)
      : context_(context), read_again_(std::move(read_again)) {}

  // Once nobody has painted for a moment: finds which stages are stale now.
  void tick();
  MasksView view() const;
  void apply(const MaskRequests& requests);
  // Of the strokes or, while attributes are painted, of these.
  void undo();
  void redo();
  void step(int frames);  // to another frame
  // Every change at once, in the background: there is nothing to be lost by closing. What could not be
  // written is written with the next change.
  void save();

  // Of the open project's folder. What is painted after a reading began is not among what it read.
  void reading_begins() { edit_when_read_ = edit(); }
  void was_read(bool first);
  void close();  // while the project is still open: what is not saved is

  bool are_shown() const;  // in the Cameras step
  bool is_settling() const {
    return changed_.has_value();
  }  // painted on, and not yet seen what is stale by it

 private:
  // What the window last read or wrote of the attributes: after it was made only work of the background,
  // which runs in order, touches it.
  using SavedAttributes = std::shared_ptr<const PaintedAttributes>;

  std::uint64_t edit() const { return masks_.edit() + attributes_.edit(); }
  bool paint(const MaskRequests& requests);  // whether anything changed
  bool change(const AttributeRequests& requests);
  Result<void> check_attribute(const std::string& name) const;  // on the frame shown
  void set_aside(int frame);
  void show();
  void save_attributes();

  const SessionContext context_;
  const std::function<void()> read_again_;
  Masks masks_;
  AttributePaint attributes_;
  std::shared_ptr<SavedAttributes> attributes_saved_;
  MaskPicture drawn_;
  std::shared_ptr<const MaskSource> source_;  // of the picture, or of one like it
  std::uint64_t times_read_ = 0;              // the project's
  std::uint64_t edit_when_read_ = 0;
  std::optional<Directing::Clock::time_point> changed_;  // when last painted on
};

}  // namespace likeness::ui
