// The demo person ready to be filmed: head model, hair, beard, glasses and jumper, posed and lit per frame,
// traced per ray.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>

#include "core/head/head_model.h"
#include "core/head/pose_head.h"
#include "core/synth/cast.h"
#include "core/synth/performance.h"
#include "core/synth/personal_shape.h"
#include "core/synth/shade.h"

namespace likeness {

struct PersonOptions {
  float pixel_m =
      0.0009f;  // size of a pixel on the face: finer detail is left out, hair gets at least that wide
  std::uint32_t seed = 0;
  DemoPerson look;
  bool still_torso = false;  // the torso keeps its pose: nothing but shadows changes on it
};

class Person {
 public:
  // Model, shape and play must outlive the person. rig: in the world frame.
  Person(const HeadModel& model, const HeadShape& shape, const PersonalPlay& play, const LightRig& rig,
         const PersonOptions& options);
  ~Person();
  Person(Person&&) noexcept;
  Person& operator=(Person&&) noexcept;

  // Takes the pose of a shot and gathers the light on everything that its camera may see. Not thread-safe;
  // returns early, with the person unusable until the next call, when stopped.
  void pose(const Shot& shot, std::stop_token stop);

  // Linear radiance towards the origin of a world ray, or nullopt if it misses. Thread-safe between poses.
  std::optional<Vec3f> look(const Vec3f& origin, const Vec3f& direction) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace likeness
