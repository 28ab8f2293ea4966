// A picture of one frame of the clip, read in the background.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/image/image.h"

namespace likeness::ui {

struct FramePicture {
  int frame = -1;            // that is asked for
  std::uint64_t number = 0;  // another one is another picture
  std::shared_ptr<const Image8> image;
  std::string missing;  // why there is none
};

}  // namespace likeness::ui
