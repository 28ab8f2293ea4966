// Colour conversion and orientation of decoded frames: see frame_to_rgb.h.
#include "core/video/frame_to_rgb.h"

extern "C" {
#include <libavutil/frame.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "core/base/parallel.h"
#include "core/image/srgb.h"

namespace likeness {
namespace {

// The old "J" formats mean the same layout with full range.
AVPixelFormat without_range(AVPixelFormat format, bool& full_range) {
  switch (format) {
    case AV_PIX_FMT_YUVJ420P:
      full_range = true;
      return AV_PIX_FMT_YUV420P;
    case AV_PIX_FMT_YUVJ422P:
      full_range = true;
      return AV_PIX_FMT_YUV422P;
    case AV_PIX_FMT_YUVJ444P:
      full_range = true;
      return AV_PIX_FMT_YUV444P;
    case AV_PIX_FMT_YUVJ440P:
      full_range = true;
      return AV_PIX_FMT_YUV440P;
    default:
      return format;
  }
}

int matrix_of(const AVFrame& frame) {
  switch (frame.colorspace) {
    case AVCOL_SPC_BT709:
      return SWS_CS_ITU709;
    case AVCOL_SPC_BT470BG:
    case AVCOL_SPC_SMPTE170M:
      return SWS_CS_ITU601;
    case AVCOL_SPC_SMPTE240M:
      return SWS_CS_SMPTE240M;
    case AVCOL_SPC_FCC:
      return SWS_CS_FCC;
    case AVCOL_SPC_BT2020_NCL:
    case AVCOL_SPC_BT2020_CL:
      return SWS_CS_BT2020;
    default:
      return frame.width >= 1280 || frame.height > 576 ? SWS_CS_ITU709 : SWS_CS_ITU601;
  }
}

// -- High dynamic range: ITU-R BT.2100 signal to sRGB Diffuse white (HLG signal 0.75, or 203 cd/m2 in PQ:
// ITU-R BT.2408) counts as 1; then what lies above the knee is compressed, so that white itself is shown at
// 0.9 and highlights share the remainder.

double hlg_to_scene(double signal) {
  constexpr double a = 0.17883277, b = 0.28466892, c = 0.55991073;
  return signal <= 0.5 ? signal * signal / 3 : (std::exp((signal - c) / a) + b) / 12;
}

double pq_to_nits(double signal) {
  constexpr double m1 = 0.1593017578125, m2 = 78.84375, c1 = 0.8359375, c2 = 18.8515625, c3 = 18.6875;
  const double p = std::pow(signal, 1 / m2);
  return 10000 * std::pow(std::max(p - c1, 0.0) / (c2 - c3 * p), 1 / m1);
}

// Identity below the knee, then rising ever more slowly towards 1.
float compress_highlights(float value) {
  constexpr float knee = 0.8f;
  return value <= knee ? value : 1 - (1 - knee) * (1 - knee) / (value - knee + (1 - knee));
}

constexpr int kEncodeSteps = 4096;

struct HdrTables {
  std::vector<float> decode;         // 65536 signal values to light, diffuse white 1
  std::vector<std::uint8_t> encode;  // kEncodeSteps + 1 values of sqrt(light) in [0, 1] to sRGB bytes

  explicit HdrTables(bool hlg) : decode(65536), encode(kEncodeSteps + 1) {
    for (int i = 0; i < 65536; ++i) {
      const double signal = i / 65535.0;
      // HLG's system gamma 1.2 is applied per channel, which for the near-neutral colours of a face is close
      // to applying it to luminance and keeps the table one-dimensional.
      decode[i] =
          float(hlg ? std::pow(hlg_to_scene(signal) / hlg_to_scene(0.75), 1.2) : pq_to_nits(signal) / 203);
    }
    for (int i = 0; i <= kEncodeSteps; ++i) {
      const double root = double(i) / kEncodeSteps;
      encode[i] = std::uint8_t(std::lround(255 * srgb_of_linear(root * root)));
    }
  }
};

const HdrTables& hdr_tables(bool hlg) {
  static const HdrTables hlg_tables(true), pq_tables(false);
  return hlg ? hlg_tables : pq_tables;
}

bool is_hlg(const AVFrame& frame) { return frame.color_trc == AVCOL_TRC_ARIB_STD_B67; }
bool is_hdr(const AVFrame& frame) { return is_hlg(frame) || frame.color_trc == AVCOL_TRC_SMPTE2084; }

std::uint8_t shown(const HdrTables& tables, float light) {
  const float root = std::sqrt(std::clamp(compress_highlights(std::max(light, 0.0f)), 0.0f, 1.0f));
  return tables.encode[std::size_t(root * kEncodeSteps + 0.5f)];
}

Image8 hdr_to_srgb(const std::vector<std::uint16_t>& signal, int width, int height, bool hlg) {
  const HdrTables& tables = hdr_tables(hlg);
  // BT.2020 to BT.709 primaries (ITU-R BT.2087).
  constexpr float matrix[3][3] = {
      {1.6605f, -0.5876f, -0.0728f}, {-0.1246f, 1.1329f, -0.0083f}, {-0.0182f, -0.1006f, 1.1187f}};
  Image8 result(width, height, 3);
  parallel_ranges(std::size_t(height), 32, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin * width; i < end * width; ++i) {
      const std::uint16_t* s = signal.data() + 3 * i;
      const float light[3] = {tables.decode[s[0]], tables.decode[s[1]], tables.decode[s[2]]};
      for (int c = 0; c < 3; ++c) {
        const float v = matrix[c][0] * light[0] + matrix[c][1] * light[1] + matrix[c][2] * light[2];
        result.data[3 * i + c] = shown(tables, v);
      }
    }
  });
  return result;
}

}  // namespace

Orientation orientation_from_matrix(const std::array<int, 9>& m) {
  // A coded vector (p, q) is shown as (a p + c q, b p + d q).
  const int a = m[0], b = m[1], c = m[3], d = m[4];
  Orientation o;
  o.transposed = std::abs(double(b)) > std::abs(double(a));
  o.flip_x = o.transposed ? b < 0 : a < 0;
  o.flip_y = o.transposed ? c < 0 : d < 0;
  // The direction in which the coded x axis points when shown.
  o.clockwise_deg = o.transposed ? (b > 0 ? 90 : 270) : (a >= 0 ? 0 : 180);
  return o;
}

Image8 oriented(const Image8& coded, const Orientation& o) {
  if (!o.transposed && !o.flip_x && !o.flip_y) return coded;
  const int width = o.transposed ? coded.height : coded.width,
            height = o.transposed ? coded.width : coded.height;
  Image8 result(width, height, coded.channels);
  parallel_ranges(std::size_t(height), 32, [&](std::size_t begin, std::size_t end) {
    for (int y = int(begin); y < int(end); ++y) {
      for (int x = 0; x < width; ++x) {
        int cx = o.transposed ? y : x, cy = o.transposed ? x : y;
        if (o.flip_x) cx = coded.width - 1 - cx;
        if (o.flip_y) cy = coded.height - 1 - cy;
        std::copy_n(coded.at(cx, cy), coded.channels, result.at(x, y));
      }
    }
  });
  return result;
}

bool has_alpha(const AVFrame& frame) {
  const AVPixFmtDescriptor* about = av_pix_fmt_desc_get(AVPixelFormat(frame.format));
  return about && about->flags & AV_PIX_FMT_FLAG_ALPHA;
}

void FrameConverter::Free::operator()(SwsContext* context) const { sws_freeContext(context); }
FrameConverter::FrameConverter() = default;
FrameConverter::~FrameConverter() = default;
FrameConverter::FrameConverter(FrameConverter&&) noexcept = default;
FrameConverter& FrameConverter::operator=(FrameConverter&&) noexcept = default;

bool FrameConverter::convert(const AVFrame& frame, int width, int height, int format, int bytes_per_pixel) {
  bool full_range = frame.color_range == AVCOL_RANGE_JPEG;
  const AVPixelFormat source_format = without_range(AVPixelFormat(frame.format), full_range);
  // Accurate rounding also turns off the shortcut that repeats chroma instead of interpolating it.
  const int flags = SWS_BILINEAR | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT;
  context_.reset(sws_getCachedContext(context_.release(), frame.width, frame.height, source_format, width,
                                      height, AVPixelFormat(format), flags, nullptr, nullptr, nullptr));
  if (!context_) return false;
  const int one = 1 << 16;
  // The same matrix on both sides: luma is then copied, not computed again from RGB. RGB has no use for the
  // second.
  const int* matrix = sws_getCoefficients(matrix_of(frame));
  sws_setColorspaceDetails(context_.get(), matrix, full_range, matrix, 1, 0, one, one);
  // swscale may write a few bytes past the end of a row, so rows are padded.
  stride_bytes_ = (std::size_t(width) * bytes_per_pixel + 127) / 64 * 64;
  pixels_.resize(stride_bytes_ / 2 * height + 64);
  std::uint8_t* planes[1] = {reinterpret_cast<std::uint8_t*>(pixels_.data())};
  const int strides[1] = {int(stride_bytes_)};
  return sws_scale(context_.get(), frame.data, frame.linesize, 0, frame.height, planes, strides) > 0;
}

Image8 FrameConverter::to_luma(const AVFrame& frame, int width, int height) {
  Image8 image(width, height, 1);
  if (is_hdr(frame)) {
    // The signal's tone is mapped like that of a neutral colour.
    if (!convert(frame, width, height, AV_PIX_FMT_GRAY16, 2)) return {};
    const HdrTables& tables = hdr_tables(is_hlg(frame));
    std::vector<std::uint8_t> tone(65536);
    for (std::size_t s = 0; s < tone.size(); ++s) tone[s] = shown(tables, tables.decode[s]);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        *image.at(x, y) = tone[pixels_[std::size_t(y) * (stride_bytes_ / 2) + std::size_t(x)]];
    return image;
  }
  if (!convert(frame, width, height, AV_PIX_FMT_GRAY8, 1)) return {};
  const auto* rows = reinterpret_cast<const std::uint8_t*>(pixels_.data());
  for (int y = 0; y < height; ++y) std::copy_n(rows + y * stride_bytes_, width, image.at(0, y));
  return image;
}

Image8 FrameConverter::to_rgba(const AVFrame& frame, int width, int height) {
  const Image8 toned = is_hdr(frame) ? to_rgb(frame, width, height) : Image8();
  if (!convert(frame, width, height, AV_PIX_FMT_RGBA, 4)) return {};
  Image8 image(width, height, 4);
  const auto* rows = reinterpret_cast<const std::uint8_t*>(pixels_.data());
  for (int y = 0; y < height; ++y)
    std::copy_n(rows + y * stride_bytes_, 4 * std::size_t(width), image.at(0, y));
  for (std::size_t i = 0; i < toned.pixels(); ++i)
    std::copy_n(toned.data.data() + 3 * i, 3, image.data.data() + 4 * i);
  return image;
}

Image8 FrameConverter::to_rgb(const AVFrame& frame, int width, int height) {
  const bool hlg = is_hlg(frame), hdr = is_hdr(frame);
  if (!convert(frame, width, height, hdr ? AV_PIX_FMT_RGB48 : AV_PIX_FMT_RGB24, hdr ? 6 : 3)) return {};
  const std::size_t row_values = std::size_t(width) * 3;
  if (hdr) {
    std::vector<std::uint16_t> signal(row_values * height);
    for (int y = 0; y < height; ++y) {
      std::copy_n(pixels_.data() + y * (stride_bytes_ / 2), row_values, signal.data() + y * row_values);
    }
    return hdr_to_srgb(signal, width, height, hlg);
  }
  Image8 image(width, height, 3);
  const auto* rows = reinterpret_cast<const std::uint8_t*>(pixels_.data());
  for (int y = 0; y < height; ++y) std::copy_n(rows + y * stride_bytes_, row_values, image.at(0, y));
  return image;
}

}  // namespace likeness
