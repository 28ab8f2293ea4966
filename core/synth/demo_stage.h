// The demo's set: person, room and light put together, one frame at a time.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/head/head_model.h"
#include "core/image/image.h"
#include "core/synth/demo_options.h"
#include "core/synth/demo_shots.h"
#include "core/synth/performance.h"
#include "core/synth/personal_shape.h"

namespace likeness {

struct DemoFrame {
  Image8 rgb;            // the options' size
  Image8 mask;           // one channel, share of the pixel the person covers
  bool complete = true;  // false when stopped on the way
};

class DemoStage {
 public:
  DemoStage(HeadModel model, const DemoOptions& options);
  ~DemoStage();

  const HeadModel& model() const;
  const PersonShape& person_shape() const;
  const HeadShape& shape() const;  // of the person
  const PersonalPlay& play() const;
  Shot shot(int frame) const;
  const std::vector<DemoShot>& shots() const;
  std::vector<Vec3f> posed(const Shot& shot) const;  // (V) the true vertices in the head frame, m
  // Not thread-safe; parallel inside. Frames of a resting camera share the picture of the room.
  DemoFrame film(int frame, std::stop_token stop);
  // What nobody filmed: any camera and articulation, sharp and in the light of the film. The camera has the
  // options' size.
  DemoFrame film(const Shot& shot, std::stop_token stop);
  // The room alone as that frame's camera sees it, with that frame's exposure and focus; nullopt when
  // stopped.
  std::optional<Image8> film_room(int frame, std::stop_token stop);
  std::optional<Image8> film_room(const Camera& camera, std::stop_token stop);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace likeness
