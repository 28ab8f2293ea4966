// The curve of a training: how near the avatar's pictures are to the clip, over the seconds of training.
#pragma once

#include <memory>
#include <span>

#include <imgui.h>

#include "core/train/train.h"
#include "ui/studio/training_preview.h"

namespace likeness::ui {

class TrainingChart {
 public:
  TrainingChart();
  ~TrainingChart();

  // Shows these points, in order of time; drawn anew only where they changed. of_person: what was held out
  // was compared on the person alone.
  void set(std::span<const TrainStatus> training, std::span<const HeldOutScore> held_out, bool of_person);
  // Wheel and drag zoom and pan; a double click shows all.
  void draw(const char* name, ImVec2 size);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace likeness::ui
