// The cameras of a clip about the head, in 3-D.
#pragma once

#include <memory>

#include <imgui.h>

#include "ui/studio/project_contents.h"
#include "ui/studio/solving_cameras.h"

namespace likeness::ui {

class CameraScene {
 public:
  CameraScene();
  ~CameraScene();

  // Shows these contents; cheap where they are shown already. Without cameras the scene is empty.
  void set(std::shared_ptr<const ProjectContents> contents);
  // The same while the cameras are still being solved and nobody knows where the head is.
  void set(std::shared_ptr<const SolvingCameras> solving);
  void look_at_all();  // as at first
  void draw(const char* name, ImVec2 size);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace likeness::ui
