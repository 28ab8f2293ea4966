// See avatar_renderer.h.
#include "ui/studio/avatar_renderer.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <numeric>
#include <utility>
#include <vector>

#include "core/base/priority.h"

namespace likeness::ui {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kBandRows = 64;     // rendered between two checks for a newer request
constexpr double kPace_s = 0.07;  // that a moving picture may take
constexpr double kStep = 6;       // a rung costs at most this many times the one below

// The lower rungs are small pictures: the view enlarges them.
RenderOptions rung_options(Rung rung) {
  RenderOptions options = render_options(rung >= Rung::final ? RenderQuality::final : RenderQuality::preview);
  options.reduce = 1, options.max_rays = 0;
  if (rung < Rung::final) options.max_samples = 8;
  return options;
}

std::shared_ptr<const Avatar> avatar_of(const PictureRequest& request) {
  return {request.avatar, &request.avatar->avatar};
}

int rung_size(Rung rung, int size, int finest) {
  if (rung == Rung::coarse) return size / 4;
  if (rung == Rung::preview) return size / 2;
  return rung == Rung::fine ? finest : size;
}

}  // namespace

AvatarRenderer::AvatarRenderer(std::function<void()> wake, OpenBackend open)
    : wake_(std::move(wake)),
      pictures_(std::move(open),
                [this](const std::string& text) {
                  const std::lock_guard lock(mutex_);
                  note_ = text;
                }),
      thread_([this](std::stop_token stop) { loop(stop); }) {}

void AvatarRenderer::request(PictureRequest request) {
  {
    const std::lock_guard lock(mutex_);
    waiting_ = std::move(request);
    ++number_;
  }
  changed_.notify_one();
}

void AvatarRenderer::clear() {
  {
    const std::lock_guard lock(mutex_);
    waiting_.reset();
    latest_.reset();
    ++number_;
    forget_ = true;
  }
  changed_.notify_one();
}

std::shared_ptr<const AvatarPicture> AvatarRenderer::latest() const {
  const std::lock_guard lock(mutex_);
  return latest_;
}

bool AvatarRenderer::busy() const {
  const std::lock_guard lock(mutex_);
  return working_ || waiting_.has_value();
}

bool AvatarRenderer::on_device() const {
  const std::lock_guard lock(mutex_);
  return on_device_;
}

std::optional<std::string> AvatarRenderer::take_note() {
  const std::lock_guard lock(mutex_);
  return std::exchange(note_, std::nullopt);
}

bool AvatarRenderer::is_newest(std::uint64_t number) const {
  const std::lock_guard lock(mutex_);
  return number == number_;
}

bool AvatarRenderer::publish(std::uint64_t number, AvatarPicture picture) {
  bool newest = false;
  const bool device = pictures_.on_device();
  {
    const std::lock_guard lock(mutex_);
    on_device_ = device;
    // A coarse picture of a moment ago is still the best answer while a newer one is rendered.
    if (number != number_ && !waiting_) return false;
    latest_ = std::make_shared<const AvatarPicture>(std::move(picture));
    newest = number == number_;
  }
  wake_();
  return newest;
}

void AvatarRenderer::loop(std::stop_token stop) {
  lower_thread_priority();
  while (true) {
    PictureRequest request;
    std::uint64_t number = 0;
    {
      std::unique_lock lock(mutex_);
      working_ = false;
      if (!changed_.wait(lock, stop, [&] { return waiting_ || forget_; })) return;
      if (std::exchange(forget_, false)) {
        lock.unlock();
        pictures_.let_go();
        continue;
      }
      request = std::move(*waiting_);
      waiting_.reset();
      number = number_;
      working_ = true;
    }
    try {
      answer(request, number, stop);
    } catch (const std::exception&) {
      // Memory ran out over a picture: the last one stays, and all other work goes on.
    }
  }
}

void AvatarRenderer::answer_moving(const PictureRequest& request, const RenderState& state, double posed_s,
                                   std::uint64_t number) {
  const Avatar& avatar = request.avatar->avatar;
  const auto start = Clock::now();
  AvatarPicture picture;
  picture.rung = pace_;
  picture.origin = request.origin;
  const Camera camera = resized(request.camera, rung_size(pace_, avatar.size, avatar.size));
  picture.rgba = pictures_.render(avatar_of(request), camera, state, rung_options(pace_)).rgba;
  const double took = std::chrono::duration<double>(Clock::now() - start).count();
  picture.seconds = posed_s + took;
  if (took > kPace_s && pace_ > Rung::coarse) pace_ = Rung(int(pace_) - 1);
  if (took * kStep < kPace_s && pace_ < Rung::final) pace_ = Rung(int(pace_) + 1);
  publish(number, std::move(picture));
}

void AvatarRenderer::answer(const PictureRequest& request, std::uint64_t number, std::stop_token stop) {
  const Avatar& avatar = request.avatar->avatar;
  const auto posing = Clock::now();
  const RenderState state = pose_avatar(request.avatar->rig, request.pose);
  const double posed_s = std::chrono::duration<double>(Clock::now() - posing).count();
  if (request.moving) return answer_moving(request, state, posed_s, number);
  const int finest = std::clamp(request.finest, avatar.size, 2 * avatar.size);
  const Rung best = finest > avatar.size + avatar.size / 4 ? Rung::fine : Rung::final;
  for (int r = pictures_.on_device() ? int(best) : 0; r <= int(best); ++r) {
    if (stop.stop_requested() || (r > 0 && !is_newest(number))) break;
    const Rung rung = Rung(r);
    const int size = rung_size(rung, avatar.size, finest);
    const Camera camera = resized(request.camera, size);
    const auto start = Clock::now();
    AvatarPicture picture;
    if (rung < Rung::final || pictures_.on_device()) {
      picture.rgba = pictures_.render(avatar_of(request), camera, state, rung_options(rung)).rgba;
    } else {
      picture.rgba = Image(size, size, 4);
      bool newest = true;
      std::vector<std::uint32_t> pixels;
      for (int y = 0; y < size && newest; y += kBandRows) {
        const int rows = std::min(kBandRows, size - y);
        pixels.resize(std::size_t(rows) * std::size_t(size));
        std::iota(pixels.begin(), pixels.end(), std::uint32_t(y * size));
        const std::vector<float> band = render_pixels(avatar, camera, state, pixels, rung_options(rung));
        std::ranges::copy(band, picture.rgba.at(0, y));
        newest = is_newest(number) && !stop.stop_requested();
      }
      if (!newest) break;
    }
    picture.rung = rung;
    picture.last = rung == best;
    picture.seconds = posed_s + std::chrono::duration<double>(Clock::now() - start).count();
    picture.origin = request.origin;
    if (!publish(number, std::move(picture))) break;
  }
}

}  // namespace likeness::ui
