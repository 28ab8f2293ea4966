// A project's clip in memory, at any size, as studies train on it and measure on it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/lab/score/held_out.h"
#include "core/project/project.h"
#include "core/render/pose_avatar.h"
#include "core/train/train.h"

namespace likeness {

struct HeldOutFrame {
  int frame = 0;
  AvatarPose pose;
  Camera camera;
  Image8 truth;
  Image8 plate;  // empty where the background is not known
  Regions regions;
  Vec3f exposure = Vec3f::Ones();  // beside the plate's (core/train/exposure.h)
  std::vector<float> amounts{};    // of the attributes of a model that knows these; empty: none
};

struct SizedClip {
  TrainingSet set;
  std::vector<HeldOutFrame> held_out;  // those with a track, ascending
  int lost = 0;                        // held-out frames without one
  std::string content;                 // hash of all that the above was read from
};

// size: px; 0 = the project's own. Smaller pictures are area-filtered. An Error where a stage before the
// training has not run.
Result<SizedClip> read_sized_clip(const Project& project, int size);

// The same views in pictures of another size.
TrainingSet resized(TrainingSet set, int size);

// `most` of `count` indices, evenly; 0 = all.
std::vector<std::size_t> evenly_chosen(std::size_t count, std::size_t most);

}  // namespace likeness
