// What the track says about where the person is in one picture: certain inside, possible region, likelihood
// between.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/camera/camera.h"
#include "core/head/head_model.h"
#include "core/head/pose_head.h"
#include "core/image/image.h"
#include "core/scene/head_regions.h"
#include "core/scene/track.h"

namespace likeness {

// The person's head model, from which every frame's pose is made.
struct PersonModel {
  const HeadModel* model = nullptr;
  HeadShape shape;
  std::vector<Triangle> head, face;  // head without neck and torso; the face
  Vec3d neck_base =
      Vec3d::Zero();  // m, head frame of the reference: below the chin, between the jaw's corners
  Vec3d head_low = Vec3d::Zero(), head_high = Vec3d::Zero();  // m, head frame: box of the bare head at rest
};
PersonModel make_person_model(const HeadModel& model, const Track& track);

// The person in one picture of given intrinsics, in its pixels.
struct PersonPlace {
  std::vector<Vec3f> vertices;  // posed, head frame
  Pose cam_from_head = Pose::Identity(), cam_from_torso = Pose::Identity();
  Vec2d up = Vec2d(0, -1);            // the head's up in the picture, unit
  Vec2d neck = Vec2d::Zero();         // px, the neck's base
  Vec2d jaw_corners = Vec2d::Zero();  // px, the middle between them: the neck line goes through it
  Vec2d brow = Vec2d::Zero();         // px, between the brows and the ears' tops: hair is mostly above it
  double px_per_metre = 0;
  bool torso_known = false;  // cam_from_torso is near the head; otherwise the neck follows the head
};
// nullopt if the head is behind the camera or far outside the picture.
std::optional<PersonPlace> place_person(const PersonModel& person, const TrackedFrame& tracked,
                                        const Camera& camera, const Intrinsics& picture,
                                        double metres_per_unit);

struct PersonPrior {
  cv::Mat certain;   // 8U, 255 = person: head silhouette, shrunken, and the middle of neck and torso
  cv::Mat possible;  // 8U, 255 = may be person (generous: hair, wide shoulders)
  cv::Mat likely;    // 8U, 255 = head with thin hair, neck and a torso of usual width
  cv::Mat below;     // 8U, 255 = below the neck's base: clothes rather than skin and hair
  cv::Mat location;  // 32F, log-likelihood ratio of person over background from the place, -1.5..2
  cv::Mat excluded;  // 8U, 255 = certainly background, as painted or as a network sees it; empty if neither
  cv::Mat hair;      // 8U, 255 = within the reach of long hair about the head
  cv::Mat held;      // 8U, 255 = never background, as a network sees it; empty without one
};
PersonPrior person_prior(const PersonModel& person, const PersonPlace& place, const Intrinsics& picture);

// 8U, 255 where the head (face) is seen.
cv::Mat head_silhouette(const PersonModel& person, const PersonPlace& place, const Intrinsics& picture,
                        bool face_only);

}  // namespace likeness
