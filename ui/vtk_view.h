// A VTK view inside a Dear ImGui panel, in the window's own context. Rendered only when something changed.
#pragma once

#include <memory>

#include <imgui.h>

class vtkRenderer;

namespace likeness::ui {

class VtkView {
 public:
  enum class Hand { orbit, chart };  // what the mouse does
  explicit VtkView(Hand hand);
  ~VtkView();  // with the context current
  VtkView(const VtkView&) = delete;
  VtkView& operator=(const VtkView&) = delete;

  vtkRenderer* renderer();
  void touch();  // something in the scene changed
  // Draws it with this size at the cursor, passes the mouse on, notes it by name.
  void draw(const char* name, ImVec2 size);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace likeness::ui
