// From a performance to the renderer's inputs: where the head is, what the face does, where the camera is.
#pragma once

#include <span>

#include "core/base/result.h"
#include "core/direct/performance.h"
#include "core/drive/drive_clip.h"
#include "core/project/open_avatar.h"
#include "core/render/film.h"

namespace likeness {

// What all moments of one avatar share. Refers to avatar and model, which must outlive it.
struct DirectedAvatar {
  const Avatar* avatar = nullptr;
  const HeadModel* model = nullptr;
  Vec3d neck = Vec3d::Zero();    // head frame, m: what the head turns about
  Vec3d centre = Vec3d::Zero();  // head frame, m: what the camera goes round
};
DirectedAvatar direct_avatar(const Avatar& avatar, const HeadModel& model);

// Whether the head model knows every action of the performance, or the avatar has an attribute of that name
// (core/render/attribute.h); otherwise an Error that lists the known ones.
Result<void> check_performance(const Performance& performance, const HeadModel& model,
                               std::span<const AttributeRegion> attributes = {});

// The view of a moment: the camera channels' values.
struct ViewPoint {
  double yaw = 0, pitch = 0;  // rad, of orbit_camera
  float distance = 1, zoom = 1;
  float shift_x = 0, shift_y = 0;  // picture widths
  bool operator==(const ViewPoint&) const = default;
};

struct DirectedMoment {
  ViewPoint view;
  Camera camera;  // of the avatar's picture size
  AvatarPose pose;
};
// Actions that neither model nor avatar knows do nothing. The torso rests; where the head is shifted beyond
// the neck's reach (as in DriveOptions), the whole body moves along.
DirectedMoment direct_moment(const DirectedAvatar& directed, const Performance& performance, double time_s);

// One moment per frame. Refers to `opened`, which must outlive it.
Result<Film> direct_film(const OpenedAvatar& opened, const Performance& performance);

// What a clip made the avatar do, as dense keys that can be edited: one per frame, linear, for every channel
// that is ever away from rest. The torso's lag and what an eye does by itself are left out.
Performance performance_of(const DrivenClip& clip, const DirectedAvatar& directed);
// The same for frames as a camera delivered them. Times count from the first.
Performance performance_of(std::span<const DrivenFrame> frames, double frames_per_second,
                           const DirectedAvatar& directed);

}  // namespace likeness
