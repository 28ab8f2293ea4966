// Bars along the picture's sides: see find_film.h.
#include "core/capture/find_film.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <system_error>
#include <vector>

#include "core/base/quantile.h"
#include "core/video/decode_for.h"

namespace likeness {
namespace {

constexpr double kLookEvery = 0.2;               // s
constexpr std::size_t kFewestLooks = 5;          // with fewer, nothing is said
constexpr int kPlaces = 256;                     // along a line that are looked at
constexpr int kTone = 6, kStep = 6, kRough = 2;  // 8-bit levels: noise of a codec, an edge, texture
constexpr int kSpan = 2;              // lines over which an edge is spread by scaling and compression
constexpr int kMargin = 1;            // px of the film at a bar in which its colour is mixed
constexpr double kLargestBar = 0.45;  // of the picture

// One line of one frame. Shares are of 255.
struct LineLook {
  std::uint8_t tone = 0;   // median
  std::uint8_t plain = 0;  // share of the line that has this tone
  std::uint8_t rough = 0;  // share where three pixels along the line are not in a row of levels
  std::uint8_t edge = 0;   // share where the line kSpan further in differs
};

// All lines of one direction, of all frames looked at: (frames, lines).
struct LineLooks {
  int lines = 0;
  std::vector<LineLook> looks;
  std::size_t frames() const { return lines > 0 ? looks.size() / std::size_t(lines) : 0; }
};

std::uint8_t share(int count, int of) { return std::uint8_t(255 * count / std::max(1, of)); }

// pixel(line, place along it): a level.
template <class Pixel>
void look_at_lines(int lines, int length, const Pixel& pixel, LineLooks& out) {
  const int places = std::min(kPlaces, length - 2);
  std::vector<std::uint8_t> line(static_cast<std::size_t>(places));
  for (int i = 0; i < lines; ++i) {
    int rough = 0, edge = 0, plain = 0;
    const int further = i + kSpan < lines ? i + kSpan : i - kSpan;
    for (int k = 0; k < places; ++k) {
      const int at = int(std::int64_t(k) * (length - 2) / places), level = pixel(i, at);
      line[std::size_t(k)] = std::uint8_t(level);
      rough += std::abs(level - 2 * pixel(i, at + 1) + pixel(i, at + 2)) > kRough;
      edge += std::abs(level - pixel(further, at)) > kStep;
    }
    std::vector<std::uint8_t> sorted = line;
    std::ranges::nth_element(sorted, sorted.begin() + places / 2);
    const int tone = sorted[std::size_t(places / 2)];
    for (const std::uint8_t level : line) plain += std::abs(int(level) - tone) <= kTone;
    out.looks.push_back(
        {std::uint8_t(tone), share(plain, places), share(rough, places), share(edge, places)});
  }
}

// The lines of one side, counted from the picture's border inwards.
struct Side {
  const LineLooks& looks;
  bool far;  // the right or lower one

  int lines() const { return looks.lines; }
  const LineLook& at(std::size_t frame, int line) const {
    const int own = far ? looks.lines - 1 - line : line;
    return looks.looks[frame * std::size_t(looks.lines) + std::size_t(own)];
  }
  // Edge between this line and the one kSpan further in.
  double edge(std::size_t frame, int line) const { return at(frame, far ? line + kSpan : line).edge / 255.0; }
  // Over the frames: a quantile of f(frame).
  template <class F>
  double over_time(double q, const F& f) const {
    std::vector<double> values;
    for (std::size_t t = 0; t < looks.frames(); ++t) values.push_back(double(f(t)));
    return quantile(std::move(values), q);
  }
};

// Lines of a bar of one colour; 0: there is none.
int plain_bar(const Side& side) {
  constexpr double kPure = 0.97, kBesideText = 0.5, kFilm = 0.5, kStraight = 0.6;
  constexpr double kNearlyNever = 0.1;  // of the frames may be otherwise: a fade, a flash
  const double tone = side.over_time(0.5, [&](std::size_t t) { return side.at(t, 0).tone; });
  const auto of_bar = [&](std::size_t t, int line) {
    const LineLook& look = side.at(t, line);
    return std::abs(look.tone - tone) <= kTone ? look.plain / 255.0 : 0.0;
  };
  const auto pure = [&](int line) {
    return side.over_time(kNearlyNever, [&](std::size_t t) { return of_bar(t, line); }) >= kPure;
  };
  int bar = 0;
  for (int line = 0; line < int(kLargestBar * side.lines()); ++line) {
    const double usual = side.over_time(0.5, [&](std::size_t t) { return of_bar(t, line); });
    if (usual < kBesideText) break;
    if (line < 1 || !pure(line) || !pure(line - 1)) continue;
    const int film = line + kSpan;
    const bool ends = side.over_time(0.5, [&](std::size_t t) { return of_bar(t, film); }) < kFilm;
    // In the dark the edge need not be seen.
    const bool straight =
        side.over_time(1 - kNearlyNever, [&](std::size_t t) { return side.edge(t, line); }) >= kStraight;
    if (ends && straight) bar = line + 1;
  }
  return bar > 0 && pure(0) ? bar : 0;
}

// Lines of a bar that is a blurred picture: without any texture up to an edge seen at nearly all times.
int blurred_bar(const Side& side) {
  constexpr double kSmooth = 0.1, kStraight = 0.5, kNearlyAll = 0.1;
  int bar = 0;
  for (int line = 0; line < int(kLargestBar * side.lines()); ++line) {
    const double rough = side.over_time(0.5, [&](std::size_t t) { return side.at(t, line).rough / 255.0; });
    const double edge = side.over_time(kNearlyAll, [&](std::size_t t) { return side.edge(t, line); });
    if (edge >= kStraight && line >= kSpan) return line + kSpan;
    if (rough > kSmooth) break;
  }
  return bar;
}

struct Bars {
  int near = 0, far = 0;  // lines
};

Bars bars_of(const LineLooks& looks) {
  const Side near{looks, false}, far{looks, true};
  Bars bars{plain_bar(near), plain_bar(far)};
  if (bars.near > 0 || bars.far > 0) return bars;
  // A blurred copy lies on both sides of the film, which is in the middle.
  constexpr int kEven = 3;  // px
  const Bars blurred{blurred_bar(near), blurred_bar(far)};
  const bool even = std::abs(blurred.near - blurred.far) <= kEven;
  return blurred.near > 0 && blurred.far > 0 && even ? blurred : Bars{};
}

}  // namespace

struct FilmFinder::State {
  int width = 0, height = 0;
  std::size_t every = 1, seen = 0;
  LineLooks rows, columns;
};

FilmFinder::FilmFinder(const VideoInfo& info) : state_(std::make_unique<State>()) {
  state_->width = info.width, state_->height = info.height;
  const double rate = info.frames_per_second / sampling_stride(info);
  state_->every = std::size_t(std::max(1.0, std::round(kLookEvery * rate)));
  state_->rows.lines = info.height, state_->columns.lines = info.width;
}
FilmFinder::~FilmFinder() = default;
FilmFinder::FilmFinder(FilmFinder&&) noexcept = default;
FilmFinder& FilmFinder::operator=(FilmFinder&&) noexcept = default;

void FilmFinder::add(const VideoFrame& frame) {
  State& s = *state_;
  const Image8& picture = frame.rgb;
  if (s.seen++ % s.every != 0 || picture.width != s.width || picture.height != s.height ||
      std::min(s.width, s.height) < 16)
    return;
  const int green = picture.channels >= 3 ? 1 : 0;  // most of the luma
  look_at_lines(
      s.height, s.width, [&](int y, int x) { return int(picture.at(x, y)[green]); }, s.rows);
  look_at_lines(
      s.width, s.height, [&](int x, int y) { return int(picture.at(x, y)[green]); }, s.columns);
}

PixelRect FilmFinder::film() const {
  const State& s = *state_;
  if (s.rows.frames() < kFewestLooks) return {};
  const Bars rows = bars_of(s.rows), columns = bars_of(s.columns);
  const auto kept = [](const Bars& bars, int lines, int& first) {
    first = bars.near > 0 ? bars.near + kMargin : 0;
    return lines - first - (bars.far > 0 ? bars.far + kMargin : 0);
  };
  PixelRect film;
  film.width = kept(columns, s.width, film.x);
  film.height = kept(rows, s.height, film.y);
  const bool whole = film.width == s.width && film.height == s.height;
  constexpr int kSmallest = 64;  // px
  return whole || std::min(film.width, film.height) < kSmallest ? PixelRect{} : film;
}

Result<PixelRect> find_film(const std::filesystem::path& video, const Progress& progress,
                            std::stop_token stop) {
  std::error_code ignored;
  if (std::filesystem::is_directory(video, ignored)) return PixelRect{};
  auto reader = VideoReader::open(video, VideoPixels::luma, VideoFrames::sampled);
  if (!reader) return reader.error();
  const VideoInfo info = reader->info();
  FilmFinder finder(info);
  const FrameListener listener{
      VideoPixels::luma, [&](const VideoFrame& frame) {
        finder.add(frame);
        progress.report(double(frame.index) / std::max(frame.index + 1, info.frame_count));
        return Result<void>();
      }};
  if (const auto decoded = decode_for(*reader, {&listener, 1}, stop); !decoded) return decoded.error();
  progress.report(1);
  return finder.film();
}

}  // namespace likeness
