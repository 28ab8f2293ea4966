// Step 3: where the cameras stood about the head; on a second page, what was separated from the background in
// their pictures.
#include <fmt/format.h>

#include "ui/steps.h"
#include "ui/theme.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

void draw_solving(const Snapshot& snapshot, Views& views) {
  views.cameras.set(snapshot.project.solving);
  if (plain_button("Look at all")) views.cameras.look_at_all();
  ImGui::SameLine();
  ImGui::AlignTextToFramePadding();
  faint_text(fmt::format(
      "The camera's path so far: {} places, and points of the room. Several starts are tried, so it may "
      "start over. Drag to orbit, wheel to zoom.",
      snapshot.project.solving->cameras.size()));
  begin_card("cameras card");
  views.cameras.draw("camera view", ImGui::GetContentRegionAvail());
  end_card();
}

// Which of the step's two pages is shown.
void draw_pages(const Snapshot& snapshot, Requests& requests) {
  if (choice("Where the cameras stood", !snapshot.masks.shown)) requests.masks.shown = false;
  ImGui::SameLine(0, px(22));
  if (choice("Masks and background", snapshot.masks.shown)) requests.masks.shown = true;
  ImGui::Dummy({0, px(2)});
}

}  // namespace

void draw_cameras_step(const Snapshot& snapshot, Views& views, Requests& requests) {
  draw_step_state(snapshot.step(Step::cameras));
  const ProjectContents* contents = snapshot.project.contents.get();
  if (snapshot.project.solving) {
    draw_solving(snapshot, views);
    return;
  }
  if (!contents || !contents->cameras) {
    draw_nothing_yet("Here the cameras will stand about the head, as they were found from the clip.");
    return;
  }
  draw_pages(snapshot, requests);
  if (snapshot.masks.shown) return draw_masks(snapshot, views, requests);
  if (!contents->track) {
    draw_nothing_yet(
        "The cameras are found. They are drawn as soon as the next step knows where the head is.");
    return;
  }
  views.cameras.set(snapshot.project.contents);
  if (plain_button("Look at all")) views.cameras.look_at_all();
  ImGui::SameLine();
  ImGui::AlignTextToFramePadding();
  faint_text(
      contents->cameras->rests()
          ? "The camera rested: each frustum is how the turning head saw it. Drag to orbit, wheel to zoom."
      : contents->points && !contents->points->empty()
          ? fmt::format(
                "Each frustum is one frame's camera, seen from the head; the {} points are those that fix "
                "their path. Drag to orbit, wheel to zoom.",
                contents->points->size())
          : "Each frustum is one frame's camera, seen from the head. Drag to orbit, wheel to zoom.");
  begin_card("cameras card");
  views.cameras.draw("camera view", ImGui::GetContentRegionAvail());
  end_card();
}

}  // namespace likeness::ui
