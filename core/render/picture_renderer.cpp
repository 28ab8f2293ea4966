// See picture_renderer.h.
#include "core/render/picture_renderer.h"

#include <utility>

namespace likeness {

PictureRenderer::PictureRenderer(OpenBackend open, std::function<void(const std::string&)> say)
    : open_(std::move(open)), say_(std::move(say)) {}

void PictureRenderer::continue_on_processor(const Error& error) {
  let_go();
  backend_.reset();
  if (say_) say_(continuing_on_processor(error));
}

bool PictureRenderer::on_device() {
  if (const OpenBackend open = std::exchange(open_, nullptr)) {
    if (auto opened = open(); opened)
      backend_ = std::move(*opened);
    else
      continue_on_processor(opened.error());
  }
  return backend_ != nullptr;
}

RenderedFrame PictureRenderer::render(std::shared_ptr<const Avatar> avatar, const Camera& camera,
                                      const RenderState& state, const RenderOptions& options) {
  if (!on_device()) return render_frame(*avatar, camera, state, options);
  if (avatar_ != avatar) {
    let_go();  // before the next one takes its place
    auto made = backend_->make_renderer(*avatar);
    if (!made) {
      continue_on_processor(made.error());
      return render_frame(*avatar, camera, state, options);
    }
    renderer_ = std::move(*made), avatar_ = avatar;
  }
  auto frame = renderer_->render(camera, state, options);
  if (frame) return std::move(*frame);
  continue_on_processor(frame.error());
  return render_frame(*avatar, camera, state, options);
}

}  // namespace likeness
