// The room behind the person as a moving camera sees it, learnt by the caller from rough mattes: core/matte
// knows no field.
#pragma once

#include <functional>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness {

// Where the person is in a training frame of a moving camera, with a margin.
struct RoughMatte {
  int frame = 0;
  Image8 alpha;  // one channel, at `size`
};
// What a moving camera would see of the room in a frame without the person: 8-bit RGB at `size`; empty where
// the frame has no camera. Safe from several threads.
using RoomBehind = std::function<Image8(int frame)>;
// Learns the room from the pictures outside the mattes: first, quickly, from generous guesses, to help cut
// the person out; then, at full quality, from those cuts. An empty function: no room is known.
enum class RoomPass { first, last };
using LearnRoom = std::function<Result<RoomBehind>(const std::vector<RoughMatte>& mattes, RoomPass pass,
                                                   const Progress& progress, std::stop_token stop)>;

}  // namespace likeness
