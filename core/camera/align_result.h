// What finding a clip's cameras results in.
#pragma once

#include <string>
#include <vector>

#include "core/camera/camera.h"

namespace likeness {

struct AlignResult {
  CameraSet cameras;
  std::string evidence;  // why the camera was taken as static or moving, in words with numbers
  // The kind is what is taken where the pictures show none: there is too little texture to tell, or a path
  // was asked for and none was found.
  bool kind_assumed = false;
  int frames = 0, registered = 0;
  std::vector<std::string> warnings;
  std::vector<std::string> photos;  // align_photos: file name of photograph `frame` = 0, 1, ...
};

}  // namespace likeness
