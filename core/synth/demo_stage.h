// The demo's set: person, room and light put together, one frame at a time.
#pragma once

#include <memory>
#include <stop_token>

#include "core/head/head_model.h"
#include "core/image/image.h"
#include "core/synth/demo_capture.h"
#include "core/synth/performance.h"

namespace likeness {

struct DemoFrame {
  Image8 rgb;            // the options' size
  Image8 mask;           // one channel, share of the pixel the person covers
  bool complete = true;  // false when stopped on the way
};

// Who plays: seed 0 is the person of the documentation, other seeds are others.
Eigen::VectorXf demo_identity(const HeadModel& model, int seed);

class DemoStage {
 public:
  DemoStage(HeadModel model, const DemoOptions& options);
  ~DemoStage();

  const HeadModel& model() const;
  const HeadShape& shape() const;
  Shot shot(int frame) const;
  // Not thread-safe; parallel inside. Frames of a resting camera share the picture of the room.
  DemoFrame film(int frame, std::stop_token stop);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace likeness
