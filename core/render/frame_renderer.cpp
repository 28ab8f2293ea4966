// Renderers of pictures: see FrameRenderer in backend.h.
#include "core/render/backend.h"

namespace likeness {
namespace {

class CpuRenderer : public FrameRenderer {
 public:
  explicit CpuRenderer(const Avatar& avatar) : avatar_(avatar) {}
  Result<RenderedFrame> render(const Camera& camera, const RenderState& state,
                               const RenderOptions& options) override {
    return render_frame(avatar_, camera, state, options);
  }
  std::string backend() const override { return "cpu"; }

 private:
  const Avatar& avatar_;
};

// Uses another renderer until it fails, then the processor's.
class FallingBack : public FrameRenderer {
 public:
  FallingBack(std::unique_ptr<FrameRenderer> first, const Avatar& avatar,
              std::function<void(const std::string&)> say)
      : renderer_(std::move(first)), avatar_(avatar), say_(std::move(say)) {}
  Result<RenderedFrame> render(const Camera& camera, const RenderState& state,
                               const RenderOptions& options) override {
    auto frame = renderer_->render(camera, state, options);
    if (frame || !failed_on_device(frame.error())) return frame;
    if (say_) say_(continuing_on_processor(frame.error()));
    renderer_ = cpu_renderer(avatar_);
    return renderer_->render(camera, state, options);
  }
  std::string backend() const override { return renderer_->backend(); }

 private:
  std::unique_ptr<FrameRenderer> renderer_;
  const Avatar& avatar_;
  std::function<void(const std::string&)> say_;
};

}  // namespace

bool failed_on_device(const Error& error) { return error.where.starts_with("CUDA"); }

std::string continuing_on_processor(const Error& error) {
  return error.what + " Continuing on the processor.";
}

RenderOptions device_options(RenderOptions options) {
  options.reduce = 1, options.max_rays = 0, options.deferred = false;
  return options;
}

std::unique_ptr<FrameRenderer> cpu_renderer(const Avatar& avatar) {
  return std::make_unique<CpuRenderer>(avatar);
}

Result<std::unique_ptr<FrameRenderer>> make_renderer(const RenderPlace& place, const Avatar& avatar) {
  if (!place.backend) return cpu_renderer(avatar);
  auto made = place.backend->make_renderer(avatar);
  if (made && place.fall_back)
    return std::unique_ptr<FrameRenderer>(std::make_unique<FallingBack>(std::move(*made), avatar, place.say));
  if (made || !place.fall_back || !failed_on_device(made.error())) return made;
  if (place.say) place.say(continuing_on_processor(made.error()));
  return cpu_renderer(avatar);
}

}  // namespace likeness
