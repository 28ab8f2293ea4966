// Pictures in the window: textures, and the shader that enlarges and composites renders of an avatar. All of
// it belongs to the window's thread and needs its OpenGL context.
#pragma once

#include <memory>
#include <string>

#include <imgui.h>

#include "core/base/result.h"
#include "core/image/image.h"
#include "ui/platform/imgui_versions.h"

namespace likeness::ui {

// A picture on the graphics card.
class Texture {
 public:
  Texture() = default;
  ~Texture();
  Texture(Texture&& other) noexcept;
  Texture& operator=(Texture&& other) noexcept;

  void set(const Image8& image);  // 3 or 4 channels
  void set(const Image& rgba);    // 4 channels, kept in floats
  void clear();
  bool empty() const { return id_ == 0; }
  int width() const { return width_; }
  int height() const { return height_; }
  unsigned id() const { return id_; }
  ImTextureID imgui_id() const { return texture_id(id_); }

 private:
  unsigned id_ = 0;
  int width_ = 0, height_ = 0;
};

// The largest rectangle of the picture's shape inside an area, centred.
struct Fitted {
  ImVec2 at, size;
};
Fitted fit_into(ImVec2 at, ImVec2 area, float picture_width, float picture_height);

// Draws the picture as large as fits into the rest of the window or `area`, and notes it by name. mirrored:
// left is right.
Fitted draw_picture(const char* name, const Texture& picture, ImVec2 area, bool mirrored = false);

// What lies behind a render.
struct Backdrop {
  const Texture* plate = nullptr;             // null: none
  float plate_share = 0;                      // 1 shown, 0 not
  float scale = 1, shift_x = 0, shift_y = 0;  // where it lies: as the camera's zoom and shift
  float colour[4] = {0.9f, 0.9f, 0.9f, 1};    // otherwise; alpha 0: chequered
  float doubt = 0;                            // of the render: fades its colours into the ground
  float exposure = 1;
};

// A render composited and enlarged on the graphics card, into a texture of the view's own size.
class RenderView {
 public:
  static Result<std::unique_ptr<RenderView>> create();
  ~RenderView();
  RenderView(const RenderView&) = delete;
  RenderView& operator=(const RenderView&) = delete;

  void set_picture(const Image& rgba) { picture_.set(rgba); }
  void clear() { picture_.clear(); }
  bool empty() const { return picture_.empty(); }
  // Draws anew; width, height: px. The texture stays valid until the next call.
  ImTextureID draw(int width, int height, const Backdrop& backdrop);

 private:
  RenderView() = default;
  Texture picture_;
  unsigned program_ = 0, vertices_ = 0, frame_ = 0, target_ = 0;
  int width_ = 0, height_ = 0;
};

}  // namespace likeness::ui
