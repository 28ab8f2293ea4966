// H.264 in MP4 through libavcodec and libavformat: see encode.h.
#include "core/video/encode.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/log.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <string_view>

#include "core/base/check.h"
#include "core/base/files.h"
#include "core/video/finish_film.h"
#include "core/video/libav.h"

namespace likeness {
namespace {

struct FreeFormat {
  void operator()(AVFormatContext* c) const {
    if (c->pb) avio_closep(&c->pb);
    avformat_free_context(c);
  }
};
struct FreeScaler {
  void operator()(SwsContext* c) const { sws_freeContext(c); }
};

constexpr const char* kPieceFlags = "+frag_keyframe+empty_moov+default_base_moof+use_metadata_tags";
constexpr int kClock = 90000;  // ticks a second of a timed film: the usual rates' frames fall on whole ones

bool is_mp4_name(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension == ".mp4" || extension == ".m4v" || extension == ".mov";
}

}  // namespace

struct VideoWriter::Impl {
  std::filesystem::path path, temporary;
  int width = 0, height = 0;  // as given; the coded picture is rounded up to even
  std::unique_ptr<AVCodecContext, FreeCodec> codec;
  std::unique_ptr<AVFormatContext, FreeFormat> format;
  std::unique_ptr<SwsContext, FreeScaler> scaler;
  std::unique_ptr<AVFrame, FreeFrame> frame{av_frame_alloc()};
  std::unique_ptr<AVPacket, FreePacket> packet{av_packet_alloc()};
  AVStream* stream = nullptr;
  std::int64_t next = 0;         // of the codec's ticks: the earliest for the next frame
  std::int64_t frame_ticks = 1;  // that a frame is shown for, if none follows
  bool timed = false, finished = false, survives = false;
  std::shared_ptr<const int> lock;  // of pieces, while they are written

  ~Impl() {
    format.reset();
    std::error_code ignored;
    if (!finished && !temporary.empty()) std::filesystem::remove(temporary, ignored);
  }
  Result<void> open_encoder(const EncodeOptions& options);
  Result<void> open_file(const EncodeOptions& options);
  Result<void> add(const Image8& rgb, std::int64_t tick);
  Result<void> send(const AVFrame* picture);
  Error write_error(int error) const;
};

Error VideoWriter::Impl::write_error(int error) const {
  // Negated errno values are small; FFmpeg's own codes are four-letter tags.
  const int number = AVUNERROR(error);
  if (number > 0 && number < 4096) return file_error(path, "write", number);
  return {ErrorCode::io, fmt::format("Cannot write {}: {}.", path.string(), av_text(error)),
          "Check the disk and the path, then run it again.", path.string()};
}

Result<void> VideoWriter::Impl::open_encoder(const EncodeOptions& options) {
  const auto refused = [&](std::string_view why) {
    return Error{ErrorCode::missing_dependency, fmt::format("H.264 video cannot be written here: {}.", why),
                 "Install an FFmpeg with libx264.", path.string()};
  };
  const AVCodec* encoder = avcodec_find_encoder_by_name("libx264");
  if (!encoder) return refused("this FFmpeg was built without libx264");
  codec.reset(avcodec_alloc_context3(encoder));
  if (!codec) return refused("out of memory");
  codec->width = (width + 1) / 2 * 2;
  codec->height = (height + 1) / 2 * 2;
  codec->pix_fmt = AV_PIX_FMT_YUV420P;
  codec->framerate = av_d2q(options.frames_per_second, 100000);
  timed = options.timed;
  codec->time_base = timed ? AVRational{1, kClock} : av_inv_q(codec->framerate);
  if (timed) frame_ticks = std::max<std::int64_t>(1, std::llround(kClock / options.frames_per_second));
  codec->colorspace = AVCOL_SPC_BT709;
  codec->color_primaries = AVCOL_PRI_BT709;
  codec->color_trc =
      AVCOL_TRC_BT709;  // what players expect of SDR video; values are written display-referred as given
  codec->color_range = AVCOL_RANGE_MPEG;
  codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  if (options.survives) codec->gop_size = std::max(1, int(std::lround(options.frames_per_second)));
  av_opt_set(codec->priv_data, "crf", std::to_string(std::clamp(options.crf, 0, 51)).c_str(), 0);
  av_opt_set(codec->priv_data, "preset", "medium", 0);
  // Otherwise the same frames occasionally give different bytes: the fast macroblock tree rounds by what lies
  // in memory.
  av_opt_set(codec->priv_data, "x264-params", "cpu-independent=1", 0);
  if (const int error = avcodec_open2(codec.get(), encoder, nullptr); error < 0)
    return refused(av_text(error));

  frame->format = codec->pix_fmt;
  frame->width = codec->width;
  frame->height = codec->height;
  frame->colorspace = codec->colorspace;
  frame->color_range = codec->color_range;
  if (av_frame_get_buffer(frame.get(), 0) < 0) return refused("out of memory");
  scaler.reset(sws_getContext(codec->width, codec->height, AV_PIX_FMT_RGB24, codec->width, codec->height,
                              codec->pix_fmt, SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP, nullptr,
                              nullptr, nullptr));
  if (!scaler) return refused("colours cannot be converted");
  sws_setColorspaceDetails(scaler.get(), sws_getCoefficients(SWS_CS_DEFAULT), 1,
                           sws_getCoefficients(SWS_CS_ITU709), 0, 0, 1 << 16, 1 << 16);
  return {};
}

Result<void> VideoWriter::Impl::open_file(const EncodeOptions& options) {
  if (path.has_parent_path()) {
    if (auto folder = make_writable_folder(path.parent_path()); !folder) return folder;
  }
  // What a killed process left of a film of this name.
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  remove_abandoned_parts(folder, path.stem().string());
  survives = options.survives;
  temporary = survives ? unfinished_film_name(path) : temporary_name(path);
  AVFormatContext* raw = nullptr;
  const std::string name = "file:" + temporary.string();
  if (const int error = avformat_alloc_output_context2(&raw, nullptr, "mp4", name.c_str()); error < 0) {
    return write_error(error);
  }
  format.reset(raw);
  stream = avformat_new_stream(raw, nullptr);
  if (!stream || avcodec_parameters_from_context(stream->codecpar, codec.get()) < 0)
    return write_error(AVERROR(ENOMEM));
  stream->time_base = codec->time_base;
  stream->avg_frame_rate = codec->framerate;
  if (const int error = avio_open(&raw->pb, name.c_str(), AVIO_FLAG_WRITE); error < 0)
    return write_error(error);
  if (survives) lock = lock_pieces(temporary);
  AVDictionary* flags = nullptr;
  av_dict_set(&flags, "movflags", survives ? kPieceFlags : kMovFlags, 0);
  if (survives) raw->flags |= AVFMT_FLAG_FLUSH_PACKETS;
  for (const auto& [key, text] : options.tags) av_dict_set(&raw->metadata, key.c_str(), text.c_str(), 0);
  const int error = avformat_write_header(raw, &flags);
  av_dict_free(&flags);
  if (error < 0) return write_error(error);
  return {};
}

// picture: nullptr flushes the encoder.
Result<void> VideoWriter::Impl::send(const AVFrame* picture) {
  if (const int error = avcodec_send_frame(codec.get(), picture); error < 0) return write_error(error);
  while (true) {
    const int received = avcodec_receive_packet(codec.get(), packet.get());
    if (received == AVERROR(EAGAIN) || received == AVERROR_EOF) return {};
    if (received < 0) return write_error(received);
    av_packet_rescale_ts(packet.get(), codec->time_base, stream->time_base);
    packet->duration = av_rescale_q(frame_ticks, codec->time_base, stream->time_base);
    packet->stream_index = stream->index;
    const int written = av_interleaved_write_frame(format.get(), packet.get());
    if (written < 0) return write_error(written);
    if (format->pb->error < 0) return write_error(format->pb->error);  // a full disk is noticed here first
  }
}

VideoWriter::VideoWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VideoWriter::~VideoWriter() = default;
VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;
VideoWriter& VideoWriter::operator=(VideoWriter&&) noexcept = default;

Result<VideoWriter> VideoWriter::create(const std::filesystem::path& path, int width, int height,
                                        const EncodeOptions& options) {
  LIKENESS_CHECK(width > 0 && height > 0 && width <= 16384 && height <= 16384, "video of %d x %d", width,
                 height);
  LIKENESS_CHECK(options.frames_per_second > 0 && options.frames_per_second <= 1000, "%g frames per second",
                 options.frames_per_second);
  av_log_set_level(AV_LOG_QUIET);  // what matters comes back as an Error
  if (!is_mp4_name(path)) {
    return Error{ErrorCode::bad_input, fmt::format("\"{}\" does not end in .mp4.", path.filename().string()),
                 "Give the video a name that ends in .mp4.", path.string()};
  }
  auto impl = std::make_unique<Impl>();
  impl->path = path, impl->width = width, impl->height = height;
  if (const auto opened = impl->open_encoder(options); !opened) return opened.error();
  if (const auto opened = impl->open_file(options); !opened) return opened.error();
  return VideoWriter(std::move(impl));
}

Result<void> VideoWriter::Impl::add(const Image8& rgb, std::int64_t tick) {
  LIKENESS_CHECK(rgb.width == width && rgb.height == height && rgb.channels == 3,
                 "frame %d x %d x %d for a video of %d x %d", rgb.width, rgb.height, rgb.channels, width,
                 height);
  LIKENESS_CHECK(!finished, "frame added to a finished video");
  if (const int error = av_frame_make_writable(frame.get()); error < 0) return write_error(error);
  const bool odd = rgb.width % 2 || rgb.height % 2;
  const Image8 padded = odd ? crop(rgb, 0, 0, codec->width, codec->height) : Image8();
  const Image8& source = odd ? padded : rgb;
  const std::uint8_t* planes[1] = {source.data.data()};
  const int strides[1] = {source.width * 3};
  sws_scale(scaler.get(), planes, strides, 0, source.height, frame->data, frame->linesize);
  frame->pts = std::max(tick, next);
  next = frame->pts + 1;
  return send(frame.get());
}

Result<void> VideoWriter::add(const Image8& rgb) {
  LIKENESS_CHECK(!impl_->timed, "a frame without its time added to a timed video");
  return impl_->add(rgb, impl_->next);
}

Result<void> VideoWriter::add(const Image8& rgb, double time_s) {
  LIKENESS_CHECK(impl_->timed, "a frame with its time added to a video at a steady rate");
  constexpr double kLongest_s = 1e7;  // times come from files
  return impl_->add(rgb, std::llround(std::clamp(time_s, 0.0, kLongest_s) * kClock));
}

Result<void> VideoWriter::finish() {
  Impl& writer = *impl_;
  LIKENESS_CHECK(!writer.finished, "a video finished twice");
  auto ended = writer.send(nullptr);
  const auto end = [&](int error) {
    if (ended && error < 0) ended = writer.write_error(error);
  };
  if (ended || writer.survives) end(av_write_trailer(writer.format.get()));
  if (ended || writer.survives) end(avio_closep(&writer.format->pb));
  // Of pieces, those before a full disk's end are a film.
  if (!ended && !writer.survives) return ended;
  if (auto placed = writer.survives ? finish_film(writer.temporary, writer.path)
                                    : commit_file(writer.temporary, writer.path);
      !placed)
    return ended ? placed : ended;
  writer.finished = true;
  return {};
}

}  // namespace likeness
