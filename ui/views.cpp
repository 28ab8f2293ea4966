// See views.h.
#include "ui/views.h"

namespace likeness::ui {

void FollowedTexture::follow(const FramePicture& picture) {
  if (!picture.image) {
    texture.clear();
    shown.reset();
    return;
  }
  follow(*picture.image, picture.image);
}

void FollowedTexture::follow(const Image8& image, const std::shared_ptr<const void>& owner) {
  const bool same = !texture.empty() && !shown.owner_before(owner) && !owner.owner_before(shown);
  if (same || image.empty() || image.channels < 3) return;
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
