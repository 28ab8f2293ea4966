// See views.h.
#include "ui/views.h"

namespace likeness::ui {

void FollowedTexture::follow(const FramePicture& picture) {
  if (!picture.image) {
    texture.clear();
    shown = nullptr;
    return;
  }
  follow(*picture.image, picture.image.get());
}

void FollowedTexture::follow(const Image8& image, const void* owner) {
  if (owner == shown || image.empty() || image.channels < 3) return;
  texture.set(image);
  shown = owner;
}

Result<std::unique_ptr<Views>> Views::create() {
  auto render = RenderView::create();
  if (!render) return render.error();
  auto views = std::make_unique<Views>();
  views->render = std::move(*render);
  return views;
}

}  // namespace likeness::ui
