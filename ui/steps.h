// The panels of the guided path, one a step. Each draws a snapshot into the current window and returns what
// the user asked for.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ui/studio/snapshot.h"
#include "ui/views.h"

namespace likeness::ui {

void draw_film_step(const Snapshot& snapshot, Views& views, Requests& requests);
void draw_check_step(const Snapshot& snapshot, Views& views, Requests& requests);
void draw_cameras_step(const Snapshot& snapshot, Views& views, Requests& requests);
void draw_face_step(const Snapshot& snapshot, Views& views, Requests& requests);
void draw_train_step(const Snapshot& snapshot, Views& views, Requests& requests);
// Of the Train step, in its place: this capture learnt by other methods, too.
void draw_study_page(const Snapshot& snapshot, Views& views, Requests& requests);
void draw_direct_step(const Snapshot& snapshot, Views& views, Requests& requests);
void draw_export_step(const Snapshot& snapshot, Views& views, Requests& requests);

// Of the Direct step: the performance's keys over time, with what plays and edits them. The height wanted
// where the whole step has `area`.
float timeline_height(const Snapshot& snapshot, float area);
void draw_timeline(const Snapshot& snapshot, Views& views, ImVec2 size, Requests& requests);

// Of the Direct step: what drives the avatar live, or could.
void draw_drive(const Snapshot& snapshot, Views& views, Requests& requests);

// Of the Cameras step: the mask of every frame and the background plate, with the brush that corrects masks.
void draw_masks(const Snapshot& snapshot, Views& views, Requests& requests);

// What a step shows above its own work: progress, failure with its remedy, warnings.
void draw_step_state(const StepView& view);
// A heading that opens and closes what follows; whether it is open.
bool group_heading(const char* words, bool& open);
// What a trained avatar learnt and never saw, with the moments of the clip to look at.
void draw_card(const Snapshot& snapshot, const Card& card, Views& views, Requests& requests);
// What an avatar is made of and why, in a group that opens and closes.
void draw_parts(const std::vector<AvatarPart>& parts, bool& open);
// The capture check's verdict in a band of its colour; why: what speaks against the clip, or nothing.
void draw_verdict_note(const CaptureVerdict& verdict, const std::string& why = {});
// The buttons that begin or continue the avatar; of a clip that will make no good one, another clip is the
// main one. width: of each, px, one below the other; 0: side by side, as wide as their words.
void draw_make_buttons(const Snapshot& snapshot, Requests& requests, float width = 0);
// In place of a result that is not there yet.
void draw_nothing_yet(const char* words);
// Large letters in a small window: a picture needs the height more than the strip above it, which then goes
// into the card beside it.
bool is_low();

// One bar a frame of a clip, clicked to choose one. Long clips share columns: the tallest bar is shown.
struct StripBar {
  int frame = 0;
  float height = 0;  // 0..1
  ImU32 ink = 0;
  bool struck = false;  // crossed out: left out of the training
  bool again = false;   // underlined: fitted again
};
// The frame clicked, or nullopt. words: the tooltip of a bar, by its index; asked only for the one under the
// mouse. span: null, or what dragging over the strip marks; a click or Esc clears it.
std::optional<int> draw_frame_strip(const char* name, const std::vector<StripBar>& bars, int chosen,
                                    float height, const std::function<std::string(std::size_t)>& words,
                                    StripSpan* span = nullptr);

}  // namespace likeness::ui
