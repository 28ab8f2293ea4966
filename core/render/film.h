// An avatar's poses and cameras, picture by picture.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "core/camera/camera.h"
#include "core/scene/avatar_pose.h"

namespace likeness {

struct FilmFrame {
  Camera camera;
  AvatarPose pose;
};

// Its frames are made as they are asked for: those of an hour, or of a length that a file only claims, would
// fill the memory.
struct Film {
  std::size_t frames = 0;
  std::function<FilmFrame(std::size_t frame)> at;  // all cameras have one picture size
};

// As long as the shorter list.
inline Film listed_film(std::vector<Camera> cameras, std::vector<AvatarPose> poses) {
  const std::size_t frames = std::min(cameras.size(), poses.size());
  const auto list = std::make_shared<const std::pair<std::vector<Camera>, std::vector<AvatarPose>>>(
      std::move(cameras), std::move(poses));
  return {frames, [list](std::size_t frame) { return FilmFrame{list->first[frame], list->second[frame]}; }};
}

}  // namespace likeness
