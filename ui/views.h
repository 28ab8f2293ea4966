// What the window keeps for itself: textures, 3-D views, what is typed and opened. Everything here needs the
// OpenGL context and belongs to the window's thread.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ui/camera_scene.h"
#include "ui/chart.h"
#include "ui/picture_view.h"
#include "ui/studio/snapshot.h"

namespace likeness::ui {

// A texture that follows a picture of the snapshot: uploaded when the picture changed.
struct FollowedTexture {
  Texture texture;
  std::weak_ptr<const void> shown;  // no address: another picture may come to lie where this one lay

  void follow(const FramePicture& picture);
  // owner: another one is another picture.
  void follow(const Image8& image, const std::shared_ptr<const void>& owner);
};

struct TimelineRow {
  std::string channel;  // empty: all of them
  const std::vector<Key>* keys = nullptr;
  std::vector<double> times;   // where it has keys, ascending, each time once
  std::vector<double> chosen;  // those of them that are chosen
  float low = 0, high = 0;     // of its values; of all channels: nothing
};

// What of a timeline is in sight, and what the mouse holds there.
struct TimelineSight {
  std::vector<TimelineRow> rows;                      // the first is of all channels
  std::shared_ptr<const Performance> rows_of;         // whose they are
  std::shared_ptr<const std::vector<KeyPlace>> seen;  // what of them is chosen
  double from_s = 0, span_s = 0;                      // span 0: all of it
  float scroll = 0;                                   // px, of the rows
  enum class Hold { nothing, playhead, keys, box, end } hold = Hold::nothing;
  double held_s = 0;                          // where the mouse took it
  std::shared_ptr<const Performance> before;  // as the keys lay then
  std::vector<KeyPlace> taken;
  ImVec2 corner;  // of the box
};

// What the mouse paints on a mask just now, and with which brush.
struct MaskSight {
  FollowedTexture picture;
  StrokeMark mark = StrokeMark::person;
  float radius_share = 0.03f;    // of the picture's side
  std::optional<Stroke> stroke;  // under the mouse, source px
  int frame = -1;                // that it is painted on
  // What the stroke covers, on a small picture of its own, and the same in its colour. It is drawn until the
  // mask's picture has the change of this number.
  Image cover;
  Texture ink;
  std::uint64_t until_edit = 0;
  float amount = 1;             // that a stroke gives its frame, of an attribute
  bool moving_amount = false;   // the frame's own, by its slider
  std::array<char, 41> name{};  // typed, of a new attribute
};

// What is marked on a strip of frames, by dragging over it.
struct StripSpan {
  std::optional<int> pressed;     // the frame where the mouse went down
  std::optional<RefitSpan> span;  // marked; ascending
};

struct Views {
  FollowedTexture clip, check, face, truth, plate, driver, mirror, first;
  std::array<FollowedTexture, 4> previews;
  TrainingChart chart;
  CameraScene cameras;
  std::unique_ptr<RenderView> render;
  std::shared_ptr<const AvatarPicture> rendered;  // that is in `render`
  std::map<std::string, float> drag_began;        // values of channels when the drag that moves them began
  bool more_choices = false;
  float exposure_ev = 0;  // of the avatar's view only
  float wipe = 0.5f;      // of the comparison: share of the view that is the avatar
  std::array<bool, 9> open_groups{true, false, true};
  float export_what = 300, export_how = 300;  // px: how high the cards of these were
  bool open_drive = true, open_gains = false;
  bool open_parts = false;   // of the avatar, and why
  bool open_chosen = false;  // the same while it is trained
  std::vector<FollowedTexture> study_plots;
  float study_choices = 400;  // px: how high the card of them was
  TimelineSight timeline;
  MaskSight masks;
  StripSpan face_span;
  std::filesystem::path face_span_of;  // the project it was marked on

  static Result<std::unique_ptr<Views>> create();
};

}  // namespace likeness::ui
