// Who watches a run of the stages: it changes nothing of what comes out.
#pragma once

#include <functional>
#include <vector>

#include "core/project/project.h"
#include "core/render/avatar.h"
#include "core/train/train.h"

namespace likeness {

// What a watcher of a run may want to see while it lasts. Called from the running thread.
struct RunObserver {
  std::function<void(Stage, const StageRecord&)> stage_changed = [](Stage, const StageRecord&) {};
  // The same of a further clip, by its number.
  std::function<void(Stage, int, const Project&)> further_changed = [](Stage, int, const Project&) {};
  std::function<void(const TrainStatus&)> training = [](const TrainStatus&) {};
  // What the training's avatar is made of, and why: once, before its first step.
  std::function<void(const std::vector<AvatarPart>&)> parts = [](const std::vector<AvatarPart>&) {};
  AvatarTap tap;  // of the training
};

}  // namespace likeness
