// GLFW and Dear ImGui's backends: see window.h.
#include "ui/platform/window.h"

#define GL_GLEXT_PROTOTYPES
#define GLFW_INCLUDE_GLCOREARB
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <utility>

#include "ui/platform/imgui_versions.h"

namespace likeness::ui {

struct Window::Impl {
  GLFWwindow* window = nullptr;
  bool visible = true;
  bool touched = false;  // there was input since the last wait
  std::vector<std::filesystem::path> drops;
  std::optional<InjectedInput> injected;
  // Keys pressed since the last frame, with their modifiers: one released before the next frame counts, too.
  std::vector<std::array<int, 2>> pressed;
};

namespace {

std::string last_failure;

Window::Impl& impl_of(GLFWwindow* window) {
  return *static_cast<Window::Impl*>(glfwGetWindowUserPointer(window));
}

void watch_input(GLFWwindow* window) {
  glfwSetCursorPosCallback(window, [](GLFWwindow* w, double, double) { impl_of(w).touched = true; });
  glfwSetCursorEnterCallback(window, [](GLFWwindow* w, int) { impl_of(w).touched = true; });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int, int, int) { impl_of(w).touched = true; });
  glfwSetScrollCallback(window, [](GLFWwindow* w, double, double) { impl_of(w).touched = true; });
  glfwSetCharCallback(window, [](GLFWwindow* w, unsigned) { impl_of(w).touched = true; });
  glfwSetWindowFocusCallback(window, [](GLFWwindow* w, int) { impl_of(w).touched = true; });
  glfwSetFramebufferSizeCallback(window, [](GLFWwindow* w, int, int) { impl_of(w).touched = true; });
  glfwSetWindowRefreshCallback(window, [](GLFWwindow* w) { impl_of(w).touched = true; });
  glfwSetWindowCloseCallback(window, [](GLFWwindow* w) { impl_of(w).touched = true; });
  glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** paths) {
    for (int i = 0; i < count; ++i) impl_of(w).drops.emplace_back(paths[i]);
    impl_of(w).touched = true;
  });
}

void watch_keys(GLFWwindow* window) {
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int modifiers) {
    impl_of(w).touched = true;
    if (action == GLFW_PRESS && key >= 0) impl_of(w).pressed.push_back({key, modifiers});
  });
}

// Keys held down now, or pressed since the last frame.
Keys keys_of(GLFWwindow* window, const std::vector<std::array<int, 2>>& pressed) {
  Keys keys;
  for (int key = GLFW_KEY_SPACE; key < kKeys; ++key)
    keys.down[std::size_t(key)] = glfwGetKey(window, key) == GLFW_PRESS;
  int modifiers = 0;
  for (const auto& [key, with] : pressed) keys.down[std::size_t(key)] = true, modifiers |= with;
  const auto held = [&](int left, int right, int modifier) {
    return keys.down[std::size_t(left)] || keys.down[std::size_t(right)] || (modifiers & modifier) != 0;
  };
  keys.ctrl = held(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL, GLFW_MOD_CONTROL);
  keys.shift = held(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT, GLFW_MOD_SHIFT);
  keys.alt = held(GLFW_KEY_LEFT_ALT, GLFW_KEY_RIGHT_ALT, GLFW_MOD_ALT);
  return keys;
}

Error no_window(std::string what) {
  return {ErrorCode::missing_dependency, std::move(what),
          "Start it in a desktop session with OpenGL 3.3, or use the command line: likeness build CLIP "
          "--project DIR",
          "window"};
}

}  // namespace

Result<std::unique_ptr<Window>> Window::open(const WindowOptions& options) {
  glfwSetErrorCallback([](int, const char* words) { last_failure = words; });
  if (!glfwInit()) return no_window("No window can be opened: " + last_failure);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_VISIBLE, options.visible);
  glfwWindowHint(GLFW_MAXIMIZED, options.maximised);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
  glfwWindowHintString(GLFW_X11_CLASS_NAME, "likeness-studio");
  auto impl = std::make_unique<Impl>();
  impl->visible = options.visible;
  impl->window = glfwCreateWindow(options.width, options.height, options.title.c_str(), nullptr, nullptr);
  if (!impl->window) {
    glfwTerminate();
    return no_window("No OpenGL 3.3 window can be opened: " + last_failure);
  }
  glfwSetWindowSizeLimits(impl->window, 960, 600, GLFW_DONT_CARE, GLFW_DONT_CARE);
  glfwMakeContextCurrent(impl->window);
  glfwSwapInterval(options.visible ? 1 : 0);
  glfwSetWindowUserPointer(impl->window, impl.get());
  watch_input(impl->window);  // before ImGui's callbacks, which call these

  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.ConfigFlags |= ImGuiConfigFlags_NavEnableKeyboard;
  io.ConfigWindowsMoveFromTitleBarOnly = true;
  ImGui_ImplGlfw_InitForOpenGL(impl->window, true);
  keep_keys_free();
  watch_keys(impl->window);  // instead of ImGui's: begin_frame() passes keys on
  ImGui_ImplOpenGL3_Init("#version 330 core");
  return std::unique_ptr<Window>(new Window(std::move(impl)));
}

Window::Window(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Window::~Window() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwDestroyWindow(impl_->window);
  glfwTerminate();
}

bool Window::wait(double timeout_s) {
  if (timeout_s > 0) {
    glfwWaitEventsTimeout(timeout_s);
  } else {
    glfwPollEvents();
  }
  return std::exchange(impl_->touched, false);
}

void Window::wake() { glfwPostEmptyEvent(); }

void Window::begin_frame() {
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  Keys keys = keys_of(impl_->window, std::exchange(impl_->pressed, {}));
  ImGuiIO& io = ImGui::GetIO();
  leave_input_to_backend();
  if (const auto& input = impl_->injected) {
    keys = {.ctrl = input->ctrl, .shift = input->shift};
    if (input->key != 0) keys.down[std::size_t(input->key)] = true;
    give_mouse({input->mouse_x, input->mouse_y, input->down, input->wheel}, input->text);
    impl_->injected->text.clear();
    impl_->injected->wheel = 0;
    io.DeltaTime = 1.0f / 60;
  }
  give_keys(keys);
  // Home, End and, with Ctrl or Shift, arrows are commands; they must not move the keyboard focus as well.
  const auto down = [&](std::initializer_list<int> several) {
    return std::ranges::any_of(several, [&](int key) { return keys.down[std::size_t(key)]; });
  };
  const bool command =
      down({GLFW_KEY_HOME, GLFW_KEY_END}) ||
      ((keys.ctrl || keys.shift) && down({GLFW_KEY_LEFT, GLFW_KEY_RIGHT, GLFW_KEY_UP, GLFW_KEY_DOWN}));
  if (command) {
    io.ConfigFlags &= ~ImGuiConfigFlags_NavEnableKeyboard;
  } else {
    io.ConfigFlags |= ImGuiConfigFlags_NavEnableKeyboard;
  }
  ImGui::NewFrame();
}

void Window::end_frame() {
  ImGui::Render();
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, width(), height());
  glClearColor(0, 0, 0, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  if (impl_->visible) glfwSwapBuffers(impl_->window);  // a hidden window keeps its frame, to be read
}

void Window::set_title(const std::string& title) { glfwSetWindowTitle(impl_->window, title.c_str()); }

bool Window::take_close_request() {
  const bool asked = glfwWindowShouldClose(impl_->window);
  glfwSetWindowShouldClose(impl_->window, GLFW_FALSE);
  return asked;
}

std::vector<std::filesystem::path> Window::take_drops() { return std::exchange(impl_->drops, {}); }

void Window::drop(std::vector<std::filesystem::path> paths) { impl_->drops = std::move(paths); }

int Window::width() const {
  int w = 0, h = 0;
  glfwGetFramebufferSize(impl_->window, &w, &h);
  return w;
}

int Window::height() const {
  int w = 0, h = 0;
  glfwGetFramebufferSize(impl_->window, &w, &h);
  return h;
}

float Window::pixel_scale() const {
  float x = 1, y = 1;
  glfwGetWindowContentScale(impl_->window, &x, &y);
  return std::clamp(std::max(x, y), 1.f, 3.f);
}

bool Window::maximised() const { return glfwGetWindowAttrib(impl_->window, GLFW_MAXIMIZED); }

std::array<int, 2> Window::size() const {
  std::array<int, 2> size{};
  glfwGetWindowSize(impl_->window, &size[0], &size[1]);
  return size;
}

std::string Window::renderer() const {
  const auto* words = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return words ? words : "unknown";
}

void Window::inject(std::optional<InjectedInput> input) { impl_->injected = std::move(input); }

Image8 Window::read_pixels() const {
  const int w = width(), h = height();
  Image8 bottom_up(w, h, 3), image(w, h, 3);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
  glReadBuffer(GL_BACK);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, w, h, GL_RGB, GL_UNSIGNED_BYTE, bottom_up.data.data());
  for (int y = 0; y < h; ++y) std::copy_n(bottom_up.at(0, h - 1 - y), 3 * w, image.at(0, y));
  return image;
}

}  // namespace likeness::ui
