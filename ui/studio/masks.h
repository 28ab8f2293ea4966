// The masks looked at and corrected: the frame shown, the strokes of every frame with their history. Free of
// windows, files and threads; the session (mask_session.h) reads, writes and draws for it.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/matte/strokes.h"
#include "ui/studio/attribute_paint.h"
#include "ui/studio/frame_picture.h"
#include "ui/studio/mask_picture.h"

namespace likeness::ui {

// A frame's mask or the plate, drawn with the strokes after this change; its frame is the one that is drawn.
struct MaskPicture {
  FramePicture picture;
  MaskLook look = MaskLook::picture;
  std::uint64_t edit = 0;
};

// For the panels. frames and strokes are never null.
struct MasksView {
  bool shown = false;  // in place of the cameras
  int frame = -1;      // that is looked at; -1: there is none
  MaskLook look = MaskLook::picture;
  std::shared_ptr<const std::vector<int>> frames = std::make_shared<const std::vector<int>>();  // with masks
  std::shared_ptr<const Strokes> strokes = std::make_shared<const Strokes>();  // of the frame
  std::set<int> corrected;                                                     // frames with strokes
  std::map<int, Error> unreadable;  // frames whose strokes' files are damaged: nothing is painted on these
  std::uint64_t edit = 0;           // rises with every change of strokes
  bool can_undo = false, can_redo = false;
  bool unmade = false;        // the masks were made before the last change
  AttributesView attributes;  // painted on the same pictures; while they are, strokes and undo are theirs
  MaskPicture drawn;
};

// What the panels ask for.
struct MaskRequests {
  std::optional<bool> shown;
  std::optional<int> frame;
  std::optional<MaskLook> look;
  std::optional<Stroke> stroke;  // painted on the frame shown
  bool clear = false;            // its strokes
  std::optional<int> set_aside;  // this frame's unreadable file
  AttributeRequests attributes;
};

class Masks {
 public:
  // Another project's, or none; nothing can be undone.
  void open(FrameStrokes strokes, std::map<int, Error> unreadable);
  // The same project's, read again: what is on the disk counts but where a change was not yet saved.
  void refresh(const FrameStrokes& strokes, std::map<int, Error> unreadable);
  // The frames that have masks, ascending. The one shown stays, or is the middle one.
  void set_frames(std::vector<int> frames);
  void show(bool shown) { shown_ = shown; }
  void look_at(int frame);  // unknown ones are ignored
  void set_look(MaskLook look) { look_ = look; }
  void step(int frames);
  bool shown() const { return shown_; }
  bool has_frames() const { return !frames_->empty(); }
  int frame() const { return frame_; }
  MaskLook look() const { return look_; }
  std::uint64_t edit() const { return edit_; }
  std::shared_ptr<const Strokes> strokes(int frame) const;  // never null
  // Without what only the session knows: unmade, attributes and drawn.
  MasksView view() const;

  // On the frame shown. False: nothing changed, for its file cannot be read or there was nothing to change.
  bool paint(Stroke stroke);
  bool clear();
  // Of whichever frame; it is shown then.
  bool undo();
  bool redo();
  bool can_undo() const { return present_ > 0; }
  bool can_redo() const { return present_ < history_.size(); }
  void was_set_aside(int frame);  // its unreadable file

  // Frames whose strokes changed since they were last taken to be written.
  std::set<int> take_unsaved();
  void was_not_saved(int frame) { unsaved_.insert(frame); }
  bool has_unsaved() const { return !unsaved_.empty(); }

 private:
  struct Change {
    int frame = 0;
    std::shared_ptr<const Strokes> before, after;
  };
  bool change(Strokes after);
  void place(int frame, std::shared_ptr<const Strokes> strokes);

  bool shown_ = false;
  int frame_ = -1;
  MaskLook look_ = MaskLook::picture;
  std::shared_ptr<const std::vector<int>> frames_ = std::make_shared<const std::vector<int>>();
  std::map<int, std::shared_ptr<const Strokes>> strokes_;  // none is empty
  std::map<int, Error> unreadable_;
  std::vector<Change> history_;
  std::size_t present_ = 0;  // changes that are done
  std::uint64_t edit_ = 0;
  std::set<int> unsaved_;
};

}  // namespace likeness::ui
