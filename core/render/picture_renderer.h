// Pictures of the current avatar, for a thread that shows them: on a device if there is one, otherwise, and
// once the device fails, on the processor.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "core/render/backend.h"
#include "core/render/render.h"

namespace likeness {

// A device belongs to one thread at a time: each computing thread opens its own. Empty: the processor.
using OpenBackend = std::function<Result<std::shared_ptr<Backend>>()>;

// For one thread. Opens the backend with the first picture and keeps the last avatar's parameters there.
class PictureRenderer {
 public:
  PictureRenderer() = default;  // the processor
  // say: called once, on the rendering thread, with the reason why the processor takes over.
  PictureRenderer(OpenBackend open, std::function<void(const std::string&)> say);

  // As render_frame. The avatar must not change.
  RenderedFrame render(std::shared_ptr<const Avatar> avatar, const Camera& camera, const RenderState& state,
                       const RenderOptions& options);
  // Whether the next picture is rendered on a device: then whole pictures are as quick as parts of them.
  bool on_device();
  // Releases the avatar's memory for now.
  void let_go() { renderer_.reset(), avatar_.reset(); }

 private:
  void continue_on_processor(const Error& error);

  OpenBackend open_;  // empty from its first use, or failure, on
  std::function<void(const std::string&)> say_;
  std::shared_ptr<Backend> backend_;  // null: the processor
  std::shared_ptr<const Avatar> avatar_;
  std::unique_ptr<FrameRenderer> renderer_;  // of that avatar
};

}  // namespace likeness
