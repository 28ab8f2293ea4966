// The tracked pictures of a project as the trainer and the evaluation want them.
#pragma once

#include <optional>

#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/capture/capture.h"
#include "core/project/project.h"
#include "core/scene/track.h"
#include "core/train/train.h"

namespace likeness {

// Camera of a tracked frame for the project's pictures: crop intrinsics at `size`, translation in metres.
// nullopt where the cameras lost the frame.
std::optional<Camera> picture_camera(const Capture& capture, const CameraSet& cameras, const Track& track,
                                     int frame);

// The same for the part of the pictures that was filmed.
std::optional<Camera> filmed_camera(const Capture& capture, const CameraSet& cameras, const Track& track,
                                    int frame);

// What the stages before training found.
struct TrackedCapture {
  Capture capture;
  CameraSet cameras;
  Track track;
};
Result<TrackedCapture> read_tracked_capture(const Project& project);

// That an avatar was made with this head model. where: for the error.
Result<void> check_avatar_fits(const Avatar& avatar, const HeadModel& model, const std::string& where);

// An edited or foreign track.json is told apart here, before its numbers meet a model they were not made
// with.
Result<void> check_track_fits(const Track& track, const HeadModel& model);

// The capture without training from these frames; held-out ones stay what they are.
Capture without_left_out(Capture capture, const std::vector<int>& left_out);

// One view a used frame with a good or weak track whose camera is known, without pictures; has_plate is not
// known here. What was not filmed of a picture does not teach.
std::vector<TrainingView> tracked_views(const TrackedCapture& tracked);
// One of the project's own pictures, frames/000360.png or masks/000360.png. One that is missing, damaged or
// of another size is an Error that says which folder to delete, so that it is made anew.
Result<Image8> read_own_picture(const std::filesystem::path& folder, const std::string& name, int size,
                                int channels);
// Frame and matte of a view of the project, by read_own_picture.
Result<void> load_view_pictures(const Project& project, TrainingView& view);

// The background plate and where it was seen; both stay empty where there is none.
Result<void> read_project_plate(const Project& project, Image8& plate, Image8& known);

}  // namespace likeness
