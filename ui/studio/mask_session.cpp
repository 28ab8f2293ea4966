// See mask_session.h.
#include "ui/studio/mask_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/project/corrections.h"
#include "core/project/project_attributes.h"

namespace likeness::ui {

namespace {

// After the last change the project is read again to find what became stale; as that takes time, not at once.
constexpr std::chrono::milliseconds kSettled{500};

}  // namespace

bool MaskSession::are_shown() const {
  return context_.shown.step == Step::cameras && masks_.shown() && masks_.has_frames() &&
         context_.open.contents != nullptr;
}

void MaskSession::apply(const MaskRequests& requests) {
  if (!context_.open.contents) return;
  const bool still = context_.open.may_change();  // a run reads the strokes and replaces the masks
  if (requests.shown) masks_.show(*requests.shown);
  if (requests.frame) masks_.look_at(*requests.frame);
  if (requests.look) masks_.set_look(*requests.look);
  if (still && paint(requests)) save();
  const bool attributes = change(requests.attributes);
  if (requests.set_aside && still) set_aside(*requests.set_aside);
  if (requests.shown || requests.frame || requests.look || requests.stroke || requests.clear || attributes)
    show();
}

bool MaskSession::paint(const MaskRequests& requests) {
  if (!attributes_.on())
    return (requests.stroke && masks_.paint(*requests.stroke)) || (requests.clear && masks_.clear());
  if (requests.clear) return attributes_.clear(masks_.frame());
  if (!requests.stroke && !requests.attributes.set) return false;
  if (const auto fine = check_attribute(attributes_.name()); !fine) {
    context_.notices.fail(fine.error());
    return false;
  }
  if (!requests.stroke) return attributes_.set_value(masks_.frame(), *requests.attributes.set);
  return attributes_.paint(masks_.frame(), requests.attributes.value, *requests.stroke);
}

// Applies the requests; true if another picture is needed.
bool MaskSession::change(const AttributeRequests& requests) {
  if (requests.on) attributes_.turn(*requests.on);
  if (requests.on.value_or(false) && masks_.look() == MaskLook::plate) masks_.set_look(MaskLook::picture);
  if (requests.name) {
    const auto fine = check_attribute_name(*requests.name);
    if (fine) attributes_.choose(*requests.name);
    if (!fine) context_.notices.fail(fine.error());
  }
  const bool still = context_.open.may_change();
  const bool removed = requests.remove && still && attributes_.remove(*requests.remove);
  if (removed) save();
  return requests.on || requests.name || requests.set || removed;
}

Result<void> MaskSession::check_attribute(const std::string& name) const {
  if (const auto named = check_attribute_name(name); !named) return named;
  const auto refused = [](std::string what, std::string fix) {
    return Error{ErrorCode::bad_input, std::move(what), std::move(fix), ""};
  };
  const ProjectContents& contents = *context_.open.contents;
  if (contents.model && find_action(*contents.model, name))
    return refused(fmt::format("The head model already has an action '{}'.", name),
                   "Give the attribute another name.");
  const auto& frames = contents.capture->frames;
  const auto own = std::ranges::find(frames, masks_.frame(), &CaptureFrame::frame);
  const auto& left_out = contents.project.options.train.left_out;
  if (own == frames.end() || !own->used || std::ranges::find(left_out, own->frame) != left_out.end())
    return refused("This frame does not train, so no attribute can be learnt from it.",
                   "Paint on a frame that trains.");
  return {};
}

void MaskSession::undo() {
  if (context_.open.may_change() && (attributes_.on() ? attributes_.undo() : masks_.undo())) save();
  show();
}

void MaskSession::redo() {
  if (context_.open.may_change() && (attributes_.on() ? attributes_.redo() : masks_.redo())) save();
  show();
}

void MaskSession::step(int frames) {
  masks_.step(frames);
  show();
}

void MaskSession::show() {
  const auto& contents = context_.open.contents;
  if (!masks_.shown() || masks_.frame() < 0 || !contents || !contents->capture) return;
  const int frame = masks_.frame();
  const MaskLook look = masks_.look();
  context_.background.run(
      "mask",
      [this, frame, look, folder = context_.open.folder, times_read = times_read_,
       crop = contents->capture->crop, edit = edit(),
       strokes = attributes_.on() ? attributes_.strokes(frame) : masks_.strokes(frame),
       attributes = attributes_.on(), source = source_ && source_->frame == frame ? source_ : nullptr](
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
        return [this, folder, times_read, source, drawn = std::move(drawn)]() mutable {
          if (folder != context_.open.folder || times_read != times_read_ ||
              drawn.picture.frame != masks_.frame())
            return;
          source_ = source;
          drawn.picture.number = ++context_.pictures;
          drawn_ = std::move(drawn);
        };
      });
}

void MaskSession::save() {
  if (!context_.open.contents || (!masks_.has_unsaved() && !attributes_.has_unsaved())) return;
  if (attributes_.take_unsaved()) save_attributes();
  for (const int frame : masks_.take_unsaved()) {
    context_.background.run(fmt::format("strokes {} {}", context_.open.folder.string(), frame),
                            [this, frame, project = context_.open.contents->project,
                             strokes = masks_.strokes(frame)](std::stop_token) -> Background::Delivery {
                              const auto saved = save_corrections(project, frame, *strokes);
                              return [this, frame, folder = project.folder,
                                      error = saved ? std::nullopt : std::optional(saved.error())] {
                                if (error) context_.notices.fail(*error);
                                if (error && folder == context_.open.folder) masks_.was_not_saved(frame);
                              };
                            });
  }
  changed_ = Directing::Clock::now();
}

void MaskSession::save_attributes() {
  context_.background.run("attributes " + context_.open.folder.string(),
                          [this, project = context_.open.contents->project, all = attributes_.all(),
                           before = attributes_saved_](std::stop_token) -> Background::Delivery {
                            const auto saved = save_attribute_changes(project, **before, *all);
                            if (saved) *before = all;
                            return [this, folder = project.folder,
                                    error = saved ? std::nullopt : std::optional(saved.error())] {
                              if (error) context_.notices.fail(*error);
                              if (error && folder == context_.open.folder) attributes_.was_not_saved();
                            };
                          });
}

void MaskSession::tick() {
  if (!changed_ || Directing::Clock::now() - *changed_ < kSettled) return;
  changed_.reset();
  if (context_.open.contents) read_again_();
}

void MaskSession::set_aside(int frame) {
  context_.background.run(
      "", [this, frame, project = context_.open.contents->project](std::stop_token) -> Background::Delivery {
        if (read_strokes(strokes_path(project, frame)))  // a good copy was put back
          return [this, folder = project.folder] {
            if (folder == context_.open.folder) read_again_();
          };
        const auto aside = set_aside_strokes(project, frame);
        return [this, frame, aside, folder = project.folder] {
          if (folder != context_.open.folder) return;
          if (!aside) return context_.notices.fail(aside.error());
          masks_.was_set_aside(frame);
          context_.notices.message = "The damaged strokes are kept as " + aside->string();
          read_again_();
        };
      });
}

// Draws again: what was drawn shows earlier masks.
void MaskSession::was_read(bool first) {
  const ProjectContents& contents = *context_.open.contents;
  if (first) {
    masks_.open(contents.strokes, contents.unreadable_strokes);
    attributes_.open(contents.attributes, contents.unreadable_attributes);
    attributes_saved_ = std::make_shared<SavedAttributes>(attributes_.all());
  } else if (edit_when_read_ == edit()) {
    masks_.refresh(contents.strokes, contents.unreadable_strokes);
    if (attributes_.refresh(contents.attributes, contents.unreadable_attributes))
      attributes_saved_ = std::make_shared<SavedAttributes>(attributes_.all());
  }
  masks_.set_frames(matted_frames(contents));
  source_.reset();
  ++times_read_;
  show();
}

void MaskSession::close() {
  save();
  masks_.open({}, {});
  attributes_.open({}, {});
  masks_.set_frames({});
  drawn_ = {};
  source_.reset();
  changed_.reset();
}

MasksView MaskSession::view() const {
  const auto& contents = context_.open.contents;
  MasksView view = masks_.view();
  view.drawn = drawn_;
  view.edit = edit();
  view.attributes = attributes_.view();
  if (attributes_.on()) {
    view.strokes = attributes_.strokes(view.frame);
    view.can_undo = attributes_.can_undo(), view.can_redo = attributes_.can_redo();
  }
  const bool trained = contents && contents->project.record(Stage::train).state == StageState::done;
  view.attributes.unlearnt =
      attributes_.has_unsaved() || (trained && (changed_ || !contents->is_current(Stage::train)));
  const bool still = context_.open.may_change();
  view.can_undo &= still;
  view.can_redo &= still;
  const bool stale = contents && (contents->is_stale(Stage::matte) ||
                                  (contents->project.record(Stage::matte).state == StageState::done &&
                                   !contents->is_current(Stage::matte)));
  view.unmade = still && (changed_ || masks_.has_unsaved() || stale);
  return view;
}

}  // namespace likeness::ui
