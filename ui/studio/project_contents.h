// What the window shows of a project: read from its folder by a background thread, then never changed.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/capture/capture.h"
#include "core/check/checked_clip.h"
#include "core/direct/direct_avatar.h"
#include "core/direct/presets.h"
#include "core/direct/seen_limits.h"
#include "core/head/head_model.h"
#include "core/matte/attributes.h"
#include "core/matte/strokes.h"
#include "core/project/build_forecast.h"
#include "core/project/card.h"
#include "core/project/project.h"
#include "core/project/project_attributes.h"
#include "core/project/training_curve.h"
#include "core/render/pose_avatar.h"
#include "core/scene/track.h"
#include "core/video/decode.h"

namespace likeness::ui {

// A project's avatar, ready to be directed. Stays where it was made: its parts refer to each other.
struct ProjectAvatar {
  std::shared_ptr<const HeadModel> model;
  Avatar avatar;
  AvatarRig rig;
  DirectedAvatar directed;
  SeenViews views;                           // of the training frames
  std::map<std::string, ValueRange> limits;  // what holds or was seen, by channel
  std::vector<Preset> presets;               // within that
  std::string hash;                          // of avatar.bin, for the provenance of what is exported

  static std::shared_ptr<ProjectAvatar> make(Avatar avatar, std::shared_ptr<const HeadModel> model,
                                             SeenViews views);
  ProjectAvatar(const ProjectAvatar&) = delete;
  ProjectAvatar& operator=(const ProjectAvatar&) = delete;

 private:
  ProjectAvatar() = default;
};

// How far an orbit of the avatar goes that nobody limits, degrees from the typical view.
ValueRange orbit_of(const ProjectAvatar& avatar);

// What making the avatar takes, of what is still to be made.
struct Plan {
  std::optional<BuildForecast> forecast;  // absent: the clip cannot be read
  double seconds = 0;
  std::optional<Error> too_much;
  std::optional<int> smaller_size;  // px, that fits instead
};

// A further clip of the person.
struct FurtherClip {
  int number = 0;
  std::string name;               // of its file
  std::optional<VideoInfo> clip;  // absent: it cannot be read
  StageState state = StageState::to_do;
  std::string words;  // what was found in it, or why it failed
};

struct ProjectContents {
  Project project;
  std::vector<FurtherClip> further;
  std::array<bool, kStages.size()> current{};  // the stage's result is there and up to date
  std::array<bool, kStages.size()> stale{};    // it is there, and a new run would replace it
  std::optional<VideoInfo> clip;               // absent: the clip cannot be read
  std::shared_ptr<const HeadModel> model;
  // Absent where the stage has not run, or its file cannot be read.
  std::shared_ptr<const Capture> capture;
  std::shared_ptr<const CameraSet> cameras;
  std::shared_ptr<const Track> track;
  std::vector<RefitOutcome> refits;  // its spans that were fitted again
  std::shared_ptr<const std::vector<Vec3f>>
      points;  // of the room, world frame, m; null where the camera rests
  std::shared_ptr<const ProjectAvatar> avatar;
  std::shared_ptr<const Card> card;            // of the avatar: what it learnt and what not
  std::shared_ptr<const TrainingCurve> curve;  // of the last training
  FrameStrokes strokes;                        // painted on the masks
  std::map<int, Error> unreadable_strokes;     // of frames whose file of them is damaged
  PaintedAttributes attributes;
  std::optional<Error> unreadable_attributes;  // their file is damaged
  std::vector<AttributeCourse> courses;        // amounts of the avatar's attributes over the clip
  std::vector<AttributeCourse> next_courses;   // of the training at work, or of one that was stopped
  ClipFacts facts;                             // what the stages found of camera, mask and parts of the clip
  std::shared_ptr<const CheckedClip> checked;  // what the capture check found of it; null: it never looked
  std::string look_back;         // what the mattes say of a camera that did not do what it was taken for
  std::string background_fault;  // why the background is not the one that was filmed; empty: it is
  Plan plan;

  bool is_current(Stage stage) const { return current[std::size_t(stage)]; }
  bool is_stale(Stage stage) const { return stale[std::size_t(stage)]; }
};

// earlier: of the same folder, or null; what cannot have changed is taken from it.
Result<std::shared_ptr<const ProjectContents>> read_contents(const std::filesystem::path& folder,
                                                             const ProjectContents* earlier);

// A tracked frame for the renderer, with its camera for pictures of the project's size. frame_pose
// (core/project/project_attributes.h) says how an avatar stands in it.
struct FrameView {
  const TrackedFrame* tracked = nullptr;  // of the contents, which must outlive this
  Camera camera;
};
std::optional<FrameView> frame_view(const ProjectContents& contents, int frame);

// Frames whose pictures are in the folder and whose head was found, ascending; held_out: only those kept for
// measuring.
std::vector<int> shown_frames(const ProjectContents& contents, bool held_out);

// Frames that the matte stage makes masks of, ascending: those that train or are held out and have a camera.
// Empty before there is a track.
std::vector<int> matted_frames(const ProjectContents& contents);

}  // namespace likeness::ui
