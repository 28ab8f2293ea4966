// OpenGL 3.3: see picture_view.h.
#include "ui/picture_view.h"

#define GL_GLEXT_PROTOTYPES
#define GLFW_INCLUDE_GLCOREARB
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "ui/shaders.h"
#include "ui/widgets.h"

namespace likeness::ui {

namespace {

unsigned make_texture(bool nearest) {
  unsigned id = 0;
  glGenTextures(1, &id);
  glBindTexture(GL_TEXTURE_2D, id);
  const int filter = nearest ? GL_NEAREST : GL_LINEAR;
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return id;
}

Result<unsigned> compile(unsigned kind, const char* source) {
  // The file's comment comes before #version, which GLSL requires first.
  const char* version = std::strstr(source, "#version");
  const unsigned shader = glCreateShader(kind);
  glShaderSource(shader, 1, &version, nullptr);
  glCompileShader(shader);
  int fine = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &fine);
  if (fine) return shader;
  char words[1024] = {};
  glGetShaderInfoLog(shader, sizeof words, nullptr, words);
  glDeleteShader(shader);
  return Error{ErrorCode::failed, std::string("The graphics driver cannot compile a shader: ") + words,
               "Update the graphics driver, or start with LIBGL_ALWAYS_SOFTWARE=1.", "shaders"};
}

Result<unsigned> link_program() {
  const auto vertex = compile(GL_VERTEX_SHADER, kPictureVertexShader);
  if (!vertex) return vertex.error();
  const auto fragment = compile(GL_FRAGMENT_SHADER, kPictureFragmentShader);
  if (!fragment) return fragment.error();
  const unsigned program = glCreateProgram();
  glAttachShader(program, *vertex);
  glAttachShader(program, *fragment);
  glLinkProgram(program);
  glDeleteShader(*vertex);
  glDeleteShader(*fragment);
  int fine = 0;
  glGetProgramiv(program, GL_LINK_STATUS, &fine);
  if (fine) return program;
  glDeleteProgram(program);
  return Error{ErrorCode::failed, "The graphics driver cannot link the shaders.",
               "Update the graphics driver, or start with LIBGL_ALWAYS_SOFTWARE=1.", "shaders"};
}

}  // namespace

Texture::~Texture() { clear(); }

Texture::Texture(Texture&& other) noexcept
    : id_(std::exchange(other.id_, 0)), width_(other.width_), height_(other.height_) {}

Texture& Texture::operator=(Texture&& other) noexcept {
  std::swap(id_, other.id_);
  std::swap(width_, other.width_);
  std::swap(height_, other.height_);
  return *this;
}

void Texture::clear() {
  if (id_ != 0) glDeleteTextures(1, &id_);
  id_ = 0, width_ = height_ = 0;
}

void Texture::set(const Image8& image) {
  if (id_ == 0) id_ = make_texture(false);
  width_ = image.width, height_ = image.height;
  glBindTexture(GL_TEXTURE_2D, id_);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  const unsigned layout = image.channels == 4 ? GL_RGBA : GL_RGB;
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width_, height_, 0, layout, GL_UNSIGNED_BYTE, image.data.data());
}

void Texture::set(const Image& rgba) {
  if (id_ == 0) id_ = make_texture(true);
  width_ = rgba.width, height_ = rgba.height;
  glBindTexture(GL_TEXTURE_2D, id_);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, width_, height_, 0, GL_RGBA, GL_FLOAT, rgba.data.data());
}

Fitted fit_into(ImVec2 at, ImVec2 area, float picture_width, float picture_height) {
  const float scale =
      std::max(0.f, std::min(area.x / std::max(1.f, picture_width), area.y / std::max(1.f, picture_height)));
  const ImVec2 size{picture_width * scale, picture_height * scale};
  return {{at.x + 0.5f * (area.x - size.x), at.y + 0.5f * (area.y - size.y)}, size};
}

Fitted draw_picture(const char* name, const Texture& picture, ImVec2 area, bool mirrored) {
  const Fitted place =
      fit_into(ImGui::GetCursorScreenPos(), area, float(picture.width()), float(picture.height()));
  ImGui::SetCursorScreenPos(place.at);
  ImGui::Image(picture.imgui_id(), place.size, {mirrored ? 1.f : 0.f, 0}, {mirrored ? 0.f : 1.f, 1});
  note_widget(name);
  return place;
}

Result<std::unique_ptr<RenderView>> RenderView::create() {
  const auto program = link_program();
  if (!program) return program.error();
  std::unique_ptr<RenderView> view(new RenderView);
  view->program_ = *program;
  glGenVertexArrays(1, &view->vertices_);
  glGenFramebuffers(1, &view->frame_);
  view->target_ = make_texture(false);
  return view;
}

RenderView::~RenderView() {
  glDeleteProgram(program_);
  glDeleteVertexArrays(1, &vertices_);
  glDeleteFramebuffers(1, &frame_);
  glDeleteTextures(1, &target_);
}

ImTextureID RenderView::draw(int width, int height, const Backdrop& backdrop) {
  width = std::max(width, 1), height = std::max(height, 1);
  glBindTexture(GL_TEXTURE_2D, target_);
  if (width != width_ || height != height_)
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  width_ = width, height_ = height;
  glBindFramebuffer(GL_FRAMEBUFFER, frame_);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target_, 0);
  // No state is inherited from earlier drawing.
  glViewport(0, 0, width, height);
  for (const unsigned state : {GL_BLEND, GL_DEPTH_TEST, GL_STENCIL_TEST, GL_SCISSOR_TEST, GL_CULL_FACE})
    glDisable(state);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  glUseProgram(program_);
  const bool plate = backdrop.plate && !backdrop.plate->empty();
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, plate ? backdrop.plate->id() : picture_.id());
  glBindSampler(1, 0);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, picture_.id());
  glBindSampler(0, 0);
  const auto at = [&](const char* name) { return glGetUniformLocation(program_, name); };
  glUniform1i(at("picture"), 0);
  glUniform1i(at("background"), 1);
  glUniform1f(at("background_share"), plate ? backdrop.plate_share : 0);
  glUniform3f(at("background_place"), backdrop.scale, backdrop.shift_x, backdrop.shift_y);
  glUniform4fv(at("plain"), 1, backdrop.colour);
  glUniform1f(at("doubt"), backdrop.doubt);
  glUniform1f(at("exposure"), backdrop.exposure);
  glBindVertexArray(vertices_);
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  glBindVertexArray(0);
  glUseProgram(0);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  return texture_id(target_);
}

}  // namespace likeness::ui
