// Motion-adaptive deinterlacing: see deinterlace.h.
#include "core/video/deinterlace.h"

extern "C" {
#include <libavutil/common.h>
#include <libavutil/frame.h>
#include <libavutil/imgutils.h>
#include <libavutil/pixdesc.h>
}

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "core/base/parallel.h"

namespace likeness {
namespace {

constexpr int kMoves = 12;  // 8-bit levels between two frames: more than noise
constexpr double kLeastMoving = 200, kShareMoving = 0.002;  // pixels, and of the picture

// One plane, of 8 or 16 bits a value.
struct Plane {
  std::uint8_t* data = nullptr;
  std::ptrdiff_t stride = 0;  // bytes
  int values = 0, lines = 0;  // values of a line
  int step = 1;               // values from a pixel to the next
  int bytes = 1;              // of a value
  int shift = 0;              // of its bits beyond eight
};

// The planes of a frame that can be worked on; none of another format.
std::vector<Plane> planes_of(const AVFrame& frame) {
  const auto format = AVPixelFormat(frame.format);
  const AVPixFmtDescriptor* about = av_pix_fmt_desc_get(format);
  const auto other = AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_BITSTREAM | AV_PIX_FMT_FLAG_HWACCEL |
                     AV_PIX_FMT_FLAG_BE | AV_PIX_FMT_FLAG_FLOAT;
  if (!about || about->flags & other || about->comp[0].depth > 16) return {};
  std::vector<Plane> planes;
  const int count = av_pix_fmt_count_planes(format);
  for (int p = 0; p < count; ++p) {
    const bool chroma = (p == 1 || p == 2) && count > 1;
    Plane plane;
    plane.data = frame.data[p], plane.stride = frame.linesize[p];
    plane.bytes = about->comp[0].depth > 8 ? 2 : 1;
    plane.shift = about->comp[0].depth - 8 + about->comp[0].shift;
    plane.values = av_image_get_linesize(format, frame.width, p) / plane.bytes;
    plane.lines = chroma ? AV_CEIL_RSHIFT(frame.height, about->log2_chroma_h) : frame.height;
    for (int c = 0; c < about->nb_components; ++c)
      if (about->comp[c].plane == p) plane.step = std::max(1, about->comp[c].step / plane.bytes);
    planes.push_back(plane);
  }
  return planes;
}

int value(const Plane& plane, int line, int at) {
  const std::uint8_t* row = plane.data + line * plane.stride;
  if (plane.bytes == 1) return row[at];
  return reinterpret_cast<const std::uint16_t*>(row)[at];
}

void set_value(const Plane& plane, int line, int at, int to) {
  std::uint8_t* row = plane.data + line * plane.stride;
  if (plane.bytes == 1)
    row[at] = std::uint8_t(to);
  else
    reinterpret_cast<std::uint16_t*>(row)[at] = std::uint16_t(to);
}

// Of the lines above and below: along the direction in which they agree best.
int interpolated(const Plane& plane, int line, int at) {
  const int above = line - 1, below = std::min(line + 1, plane.lines - 1) == line ? line - 1 : line + 1;
  int best = (value(plane, above, at) + value(plane, below, at) + 1) / 2;
  const auto disagree = [&](int lean) {
    int sum = 0;
    for (int k = -1; k <= 1; ++k) {
      const int a = at + (lean + k) * plane.step, b = at + (k - lean) * plane.step;
      sum += std::abs(value(plane, above, a) - value(plane, below, b));
    }
    return sum;
  };
  constexpr int kLean = 2;  // pixels to either side
  if (at < (kLean + 1) * plane.step || at + (kLean + 1) * plane.step >= plane.values) return best;
  int least = disagree(0) - (1 << plane.shift);  // straight down, if in doubt
  for (const int lean : {-1, 1, -2, 2}) {
    const int d = disagree(lean);
    if (d >= least) continue;
    least = d;
    best =
        (value(plane, above, at + lean * plane.step) + value(plane, below, at - lean * plane.step) + 1) / 2;
  }
  return best;
}

void deinterlace_plane(const Plane* before, const Plane& now) {
  const int moves = (kMoves / 2) << now.shift;
  const auto rests = [&](int line, int at) {
    return std::abs(value(*before, line, at) - value(now, line, at)) < moves;
  };
  // Odd lines are written, and only even ones are read of their neighbours.
  parallel_ranges(std::size_t(now.lines / 2), 16, [&](std::size_t begin, std::size_t end) {
    for (int line = 2 * int(begin) + 1; line < 2 * int(end); line += 2)
      for (int at = 0; at < now.values; ++at) {
        const int below = line + 1 < now.lines ? line + 1 : line - 1;
        if (before && rests(line, at) && rests(line - 1, at) && rests(below, at)) continue;
        set_value(now, line, at, interpolated(now, line, at));
      }
  });
}

bool same_shape(const AVFrame& a, const AVFrame& b) {
  return a.format == b.format && a.width == b.width && a.height == b.height;
}

}  // namespace

bool is_flagged(const AVFrame& frame) {
#if LIBAVUTIL_VERSION_INT >= AV_VERSION_INT(58, 7, 100)
  return frame.flags & AV_FRAME_FLAG_INTERLACED;
#else
  return frame.interlaced_frame != 0;
#endif
}

double combing(const AVFrame& before, const AVFrame& now) {
  if (!same_shape(before, now)) return 0;
  const std::vector<Plane> then = planes_of(before), planes = planes_of(now);
  if (planes.empty() || then.empty()) return 0;
  const Plane &a = then.front(), &b = planes.front();
  std::size_t moving = 0;
  double next = 0, next_but_one = 0;
  for (int line = 0; line + 2 < b.lines; ++line)
    for (int at = 0; at < b.values; at += b.step) {
      const int level = value(b, line, at);
      if (std::abs(level - value(a, line, at)) >> b.shift < kMoves) continue;
      ++moving;
      next += std::abs(level - value(b, line + 1, at)) >> b.shift;
      next_but_one += std::abs(level - value(b, line + 2, at)) >> b.shift;
    }
  const double enough = std::max(kLeastMoving, kShareMoving * b.lines * b.values / b.step);
  return double(moving) < enough ? 0 : next / std::max(1.0, next_but_one);
}

bool is_interlaced(double largest_combing, bool flagged) {
  constexpr double kSurely = 1.1, kHardly = 0.9;
  return flagged ? largest_combing == 0 || largest_combing > kHardly : largest_combing > kSurely;
}

bool deinterlace(const AVFrame* before, AVFrame& now) {
  if (av_frame_make_writable(&now) < 0) return false;
  const std::vector<Plane> planes = planes_of(now);
  const std::vector<Plane> then =
      before && same_shape(*before, now) ? planes_of(*before) : std::vector<Plane>();
  for (std::size_t p = 0; p < planes.size(); ++p)
    deinterlace_plane(then.empty() ? nullptr : &then[p], planes[p]);
  return !planes.empty();
}

}  // namespace likeness
