// The masks' part of the studio: their picture, what is painted on them, its files: see studio.h.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/project/corrections.h"
#include "core/project/project_attributes.h"
#include "ui/studio/studio.h"

namespace likeness::ui {

namespace fs = std::filesystem;

namespace {

// After the last change: what became stale is found by reading the project again, which takes a moment.
constexpr std::chrono::milliseconds kSettled{500};

}  // namespace

bool Studio::masking() const {
  return shown_.step == Step::cameras && masks_.shown() && masks_.has_frames() && open_.contents != nullptr;
}

void Studio::apply(const MaskRequests& requests) {
  if (!open_.contents) return;
  const bool still = !open_.is_running();  // a run reads the strokes and replaces the masks
  if (requests.shown) masks_.show(*requests.shown);
  if (requests.frame) masks_.look_at(*requests.frame);
  if (requests.look) masks_.set_look(*requests.look);
  if (still && paint(requests)) save_strokes();
  const bool attributes = change(requests.attributes);
  if (requests.set_aside && still) set_aside(*requests.set_aside);
  if (requests.shown || requests.frame || requests.look || requests.stroke || requests.clear || attributes)
    show_mask();
}

bool Studio::paint(const MaskRequests& requests) {
  if (!attributes_.on())
    return (requests.stroke && masks_.paint(*requests.stroke)) || (requests.clear && masks_.clear());
  if (requests.clear) return attributes_.clear(masks_.frame());
  if (!requests.stroke && !requests.attributes.set) return false;
  if (const auto fine = check_attribute(attributes_.name()); !fine) {
    notices_.fail(fine.error());
    return false;
  }
  if (!requests.stroke) return attributes_.set_value(masks_.frame(), *requests.attributes.set);
  return attributes_.paint(masks_.frame(), requests.attributes.value, *requests.stroke);
}

// Whether another picture is wanted.
bool Studio::change(const AttributeRequests& requests) {
  if (requests.on) attributes_.turn(*requests.on);
  if (requests.on.value_or(false) && masks_.look() == MaskLook::plate) masks_.set_look(MaskLook::picture);
  if (requests.name) {
    const auto fine = check_attribute_name(*requests.name);
    if (fine) attributes_.choose(*requests.name);
    if (!fine) notices_.fail(fine.error());
  }
  const bool still = !open_.is_running();
  const bool removed = requests.remove && still && attributes_.remove(*requests.remove);
  if (removed) save_strokes();
  return requests.on || requests.name || requests.set || removed;
}

Result<void> Studio::check_attribute(const std::string& name) const {
  if (const auto named = check_attribute_name(name); !named) return named;
  const auto refused = [](std::string what, std::string fix) {
    return Error{ErrorCode::bad_input, std::move(what), std::move(fix), ""};
  };
  if (open_.contents->model && find_action(*open_.contents->model, name))
    return refused(fmt::format("The head model has an action '{}' of its own.", name),
                   "Give the attribute another name.");
  const auto& frames = open_.contents->capture->frames;
  const auto own = std::ranges::find(frames, masks_.frame(), &CaptureFrame::frame);
  const auto& left_out = open_.contents->project.options.left_out;
  if (own == frames.end() || !own->used || std::ranges::find(left_out, own->frame) != left_out.end())
    return refused("Nothing is learnt from this frame, so it says nothing of an attribute.",
                   "Paint on a frame that trains.");
  return {};
}

void Studio::correct(Command command) {
  const bool still = !open_.is_running();
  if (command == Command::previous_picture) masks_.step(-1);
  if (command == Command::next_picture) masks_.step(1);
  const auto back = [&] { return attributes_.on() ? attributes_.undo() : masks_.undo(); };
  const auto again = [&] { return attributes_.on() ? attributes_.redo() : masks_.redo(); };
  if (command == Command::undo && still && back()) save_strokes();
  if (command == Command::redo && still && again()) save_strokes();
  show_mask();
}

void Studio::show_mask() {
  if (!masks_.shown() || masks_.frame() < 0 || !open_.contents || !open_.contents->capture) return;
  const int frame = masks_.frame();
  const MaskLook look = masks_.look();
  background_.run(
      "mask",
      [this, frame, look, folder = open_.folder, read_before = masks_read_,
       crop = open_.contents->capture->crop, edit = painted_edit(),
       strokes = attributes_.on() ? attributes_.strokes(frame) : masks_.strokes(frame),
       attributes = attributes_.on(),
       source = mask_source_ && mask_source_->frame == frame ? mask_source_ : nullptr](
          std::stop_token) mutable -> Background::Delivery {
        MaskPicture drawn{{frame, 0, nullptr, ""}, look, edit};
        if (look == MaskLook::plate) {
          auto plate = draw_plate(folder);
          if (plate) drawn.picture.image = std::make_shared<const Image8>(std::move(*plate));
          if (!plate) drawn.picture.missing = plate.error().what;
        } else {
          auto read = source ? Result<MaskSource>(Error{}) : read_mask_source(folder, frame);
          if (read) source = std::make_shared<const MaskSource>(std::move(*read));
          if (source)
            drawn.picture.image =
                std::make_shared<const Image8>(draw_mask(*source, *strokes, crop, look, attributes));
          if (!source) drawn.picture.missing = read.error().what;
        }
        return [this, folder, read_before, source, drawn = std::move(drawn)]() mutable {
          if (folder != open_.folder || read_before != masks_read_ || drawn.picture.frame != masks_.frame())
            return;
          mask_source_ = source;
          drawn.picture.number = ++pictures_;
          mask_picture_ = std::move(drawn);
        };
      });
}

// Every change at once, in the background: there is nothing to be lost by closing. What could not be written
// is written with the next change.
void Studio::save_strokes() {
  if (!open_.contents || (!masks_.has_unsaved() && !attributes_.has_unsaved())) return;
  if (attributes_.take_unsaved())
    background_.run("attributes " + open_.folder.string(),
                    [this, project = open_.contents->project, all = attributes_.all(),
                     before = attributes_saved_](std::stop_token) -> Background::Delivery {
                      const auto saved = save_attribute_changes(project, **before, *all);
                      if (saved) *before = all;
                      return [this, folder = project.folder,
                              error = saved ? std::nullopt : std::optional(saved.error())] {
                        if (error) notices_.fail(*error);
                        if (error && folder == open_.folder) attributes_.was_not_saved();
                      };
                    });
  for (const int frame : masks_.take_unsaved()) {
    background_.run(fmt::format("strokes {} {}", open_.folder.string(), frame),
                    [this, frame, project = open_.contents->project,
                     strokes = masks_.strokes(frame)](std::stop_token) -> Background::Delivery {
                      const auto saved = save_corrections(project, frame, *strokes);
                      return [this, frame, folder = project.folder,
                              error = saved ? std::nullopt : std::optional(saved.error())] {
                        if (error) notices_.fail(*error);
                        if (error && folder == open_.folder) masks_.was_not_saved(frame);
                      };
                    });
  }
  strokes_changed_ = Directing::Clock::now();
}

// Once nobody has painted for a moment: which stages are stale now.
void Studio::settle_strokes() {
  if (!strokes_changed_ || Directing::Clock::now() - *strokes_changed_ < kSettled) return;
  strokes_changed_.reset();
  if (open_.contents) load(open_.folder);
}

void Studio::set_aside(int frame) {
  background_.run("",
                  [this, frame, project = open_.contents->project](std::stop_token) -> Background::Delivery {
                    if (read_strokes(strokes_path(project, frame)))  // somebody put a good copy back
                      return [this, folder = project.folder] {
                        if (folder == open_.folder) load(open_.folder);
                      };
                    const auto aside = set_aside_strokes(project, frame);
                    return [this, frame, aside, folder = project.folder] {
                      if (folder != open_.folder) return;
                      if (!aside) return notices_.fail(aside.error());
                      masks_.was_set_aside(frame);
                      notices_.message = "The damaged strokes are kept as " + aside->string();
                      load(open_.folder);
                    };
                  });
}

// After the project was read: whatever was drawn is of earlier masks.
// edit: of the masks when the reading began; what was painted since is not among what was read.
void Studio::take_masks(bool first, std::uint64_t edit) {
  if (first) {
    masks_.open(open_.contents->strokes, open_.contents->unreadable_strokes);
    attributes_.open(open_.contents->attributes, open_.contents->unreadable_attributes);
    attributes_saved_ = std::make_shared<SavedAttributes>(attributes_.all());
  } else if (edit == painted_edit()) {
    masks_.refresh(open_.contents->strokes, open_.contents->unreadable_strokes);
    if (attributes_.refresh(open_.contents->attributes, open_.contents->unreadable_attributes))
      attributes_saved_ = std::make_shared<SavedAttributes>(attributes_.all());
  }
  masks_.set_frames(matted_frames(*open_.contents));
  mask_source_.reset();
  ++masks_read_;
  show_mask();
}

MasksView Studio::masks_view() const {
  MasksView view = masks_.view();
  view.edit = painted_edit();
  view.attributes = attributes_.view();
  if (attributes_.on()) {
    view.strokes = attributes_.strokes(view.frame);
    view.can_undo = attributes_.can_undo(), view.can_redo = attributes_.can_redo();
  }
  const bool trained =
      open_.contents && open_.contents->project.record(Stage::train).state == StageState::done;
  view.attributes.unlearnt = attributes_.has_unsaved() ||
                             (trained && (strokes_changed_ || !open_.contents->is_current(Stage::train)));
  const bool still = !open_.is_running();
  view.can_undo &= still;
  view.can_redo &= still;
  view.unmade =
      still && (strokes_changed_ || masks_.has_unsaved() ||
                (open_.contents && open_.contents->is_stale(Stage::matte)) ||
                (open_.contents && open_.contents->project.record(Stage::matte).state == StageState::done &&
                 !open_.contents->is_current(Stage::matte)));
  return view;
}

}  // namespace likeness::ui
