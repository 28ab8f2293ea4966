// vtkGenericOpenGLRenderWindow in a context that is not VTK's: see vtk_view.h.
#include "ui/vtk_view.h"

#include <vtkCallbackCommand.h>
#include <vtkContextInteractorStyle.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkGenericRenderWindowInteractor.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkNew.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkRenderer.h>
#include <vtkTextureObject.h>

#include <algorithm>
#include <array>

#include "ui/platform/imgui_versions.h"
#include "ui/widgets.h"

namespace likeness::ui {

struct VtkView::Impl {
  vtkNew<vtkGenericOpenGLRenderWindow> window;
  vtkNew<vtkGenericRenderWindowInteractor> interactor;
  vtkNew<vtkRenderer> renderer;
  bool dirty = true;
  int width = 0, height = 0;
  std::array<bool, 3> held{};
};

namespace {

void answer(vtkObject* object, unsigned long event, vtkCommand::EventIds which, bool value, void* data) {
  (void)object;
  if (event == which) *static_cast<bool*>(data) = value;
}

template <class Function>
void observe(vtkObject* object, unsigned long event, void* client, Function function) {
  vtkNew<vtkCallbackCommand> command;
  command->SetClientData(client);
  command->SetCallback(function);
  object->AddObserver(event, command);
}

}  // namespace

VtkView::VtkView(Hand hand) : impl_(std::make_unique<Impl>()) {
  vtkGenericOpenGLRenderWindow* window = impl_->window;
  // The window's context is current whenever VTK asks.
  observe(window, vtkCommand::WindowIsCurrentEvent, nullptr,
          [](vtkObject* o, unsigned long e, void*, void* data) {
            answer(o, e, vtkCommand::WindowIsCurrentEvent, true, data);
          });
  observe(window, vtkCommand::WindowSupportsOpenGLEvent, nullptr,
          [](vtkObject* o, unsigned long e, void*, void* data) {
            answer(o, e, vtkCommand::WindowSupportsOpenGLEvent, true, data);
          });
  observe(window, vtkCommand::WindowMakeCurrentEvent, nullptr,
          [](vtkObject*, unsigned long, void*, void*) {});
  window->SetMapped(1);
  window->SetIsDirect(1);
  window->SetOwnContext(0);
  window->SetMultiSamples(0);
  window->SetFrameBlitModeToNoBlit();
  impl_->renderer->SetBackgroundAlpha(1.0);
  window->AddRenderer(impl_->renderer);
  impl_->interactor->SetRenderWindow(window);
  impl_->interactor->SetEnableRender(false);
  if (hand == Hand::orbit) {
    vtkNew<vtkInteractorStyleTrackballCamera> style;
    impl_->interactor->SetInteractorStyle(style);
  } else {
    vtkNew<vtkContextInteractorStyle> style;
    impl_->interactor->SetInteractorStyle(style);
  }
  observe(impl_->interactor, vtkCommand::RenderEvent, impl_.get(),
          [](vtkObject*, unsigned long, void* client, void*) { static_cast<Impl*>(client)->dirty = true; });
  impl_->interactor->Initialize();
}

VtkView::~VtkView() { impl_->window->Finalize(); }

vtkRenderer* VtkView::renderer() { return impl_->renderer; }

void VtkView::touch() { impl_->dirty = true; }

void VtkView::draw(const char* name, ImVec2 size) {
  Impl& my = *impl_;
  const int w = std::max(8, int(size.x)), h = std::max(8, int(size.y));
  if (w != my.width || h != my.height) {
    my.window->SetSize(w, h);
    my.interactor->SetSize(w, h);
    my.width = w, my.height = h;
    my.dirty = true;
  }
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::InvisibleButton(name, {float(w), float(h)},
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight |
                             ImGuiButtonFlags_MouseButtonMiddle);
  note_view(name);
  const bool hovered = ImGui::IsItemHovered(), held = my.held[0] || my.held[1] || my.held[2];
  if (hovered || held) {
    const ImGuiIO& io = ImGui::GetIO();
    vtkGenericRenderWindowInteractor* in = my.interactor;
    in->SetEventInformationFlipY(int(io.MousePos.x - at.x), int(io.MousePos.y - at.y), io.KeyCtrl,
                                 io.KeyShift);
    if (io.MouseDelta.x != 0 || io.MouseDelta.y != 0) in->InvokeEvent(vtkCommand::MouseMoveEvent);
    constexpr unsigned long kPress[] = {vtkCommand::LeftButtonPressEvent, vtkCommand::RightButtonPressEvent,
                                        vtkCommand::MiddleButtonPressEvent};
    constexpr unsigned long kRelease[] = {vtkCommand::LeftButtonReleaseEvent,
                                          vtkCommand::RightButtonReleaseEvent,
                                          vtkCommand::MiddleButtonReleaseEvent};
    for (int b = 0; b < 3; ++b) {
      if (hovered && ImGui::IsMouseClicked(b)) {
        in->InvokeEvent(kPress[b]);
        my.held[std::size_t(b)] = true;
      } else if (my.held[std::size_t(b)] && !ImGui::IsMouseDown(b)) {  // also outside the view
        in->InvokeEvent(kRelease[b]);
        my.held[std::size_t(b)] = false;
      }
    }
    if (hovered && io.MouseWheel != 0)
      in->InvokeEvent(io.MouseWheel > 0 ? vtkCommand::MouseWheelForwardEvent
                                        : vtkCommand::MouseWheelBackwardEvent);
  }
  if (my.dirty) {
    my.dirty = false;
    my.window->Render();
    my.dirty = false;  // a style's request to render has just been met
  }
  auto* texture = my.window->GetDisplayFramebuffer()->GetColorAttachmentAsTextureObject(0);
  if (!texture) return;
  ImGui::GetWindowDrawList()->AddImage(texture_id(texture->GetHandle()), at,
                                       {at.x + float(w), at.y + float(h)}, {0, 1}, {1, 0});
}

}  // namespace likeness::ui
