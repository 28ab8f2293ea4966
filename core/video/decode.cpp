// Demuxing and decoding through libavformat and libavcodec: see decode.h.
#include "core/video/decode.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/log.h>
}

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <deque>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <string_view>
#include <vector>

#include "core/base/check.h"
#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/video/broken_video.h"
#include "core/video/decoded_picture.h"
#include "core/video/deinterlace.h"
#include "core/video/lens_tag.h"
#include "core/video/libav.h"
#include "core/video/matroska_elements.h"
#include "core/video/mp4_boxes.h"
#include "core/video/photos.h"
#include "core/video/stream_info.h"

namespace likeness {
namespace {

std::atomic<std::int64_t> frames_decoded = 0;  // by all readers

void silence_ffmpeg() {
  static std::once_flag once;
  std::call_once(once, [] { av_log_set_level(AV_LOG_QUIET); });  // what matters comes back as an Error
}

}  // namespace

struct VideoReader::Impl {
  enum class Received { frame, end, damaged };
  // A frame that was handed out and stays for rewind().
  struct Kept {
    int index = 0;
    double time_s = 0;
    int shape = 0;
    std::unique_ptr<AVFrame, FreeFrame> frame;
  };

  std::filesystem::path path;
  std::unique_ptr<AVFormatContext, CloseFormat> format;
  std::unique_ptr<AVCodecContext, FreeCodec> codec;
  std::unique_ptr<AVPacket, FreePacket> packet{av_packet_alloc()};
  std::unique_ptr<AVFrame, FreeFrame> frame{av_frame_alloc()};
  AVStream* stream = nullptr;
  VideoPixels pixels = VideoPixels::rgb;
  VideoFrames frames = VideoFrames::all;
  int stride = 1;                                         // of the frames handed out
  int first = 0, last = std::numeric_limits<int>::max();  // of them
  ClipSeconds seconds;                                    // of the film that are handed out
  DecodedPictures pictures;
  VideoInfo info;
  PixelRect part;             // of the pictures that is handed out; empty: all of them
  VideoInfo shown;            // info of that part
  bool cut_off = false;       // by its outermost boxes or elements
  bool cut_fragment = false;  // so that nothing counts the pictures that are lost
  bool draining = false, ended = false;
  int read_error = 0;        // of the demuxer, if it stopped before the end
  std::int64_t packets = 0;  // of the video stream, whole
  double end_s = 0;          // where the last of them ends, on the stream's clock
  bool own_length = false;   // info.duration_s is the pictures' own, not their container's
  int next_index = 0;
  double last_time_s = 0;
  double clock_offset_s = 0;     // of the file's clock, which may have jumped back
  std::optional<Error> failure;  // repeated by every later next()
  std::optional<Error> fault;    // with which the film ended, where it goes on but cannot be read further

  bool keeping = false;    // and all frames so far are kept
  bool replaying = false;  // frames come from `kept`
  std::uint64_t room = 0;  // bytes that are left for kept frames
  std::deque<Kept> kept;

  // The first frames, as decoded, until it is known whether they are interlaced; then what followed them.
  std::deque<std::unique_ptr<AVFrame, FreeFrame>> ahead;
  std::optional<Received> after_ahead;
  bool looked_ahead = false, interlaced = false;
  std::unique_ptr<AVFrame, FreeFrame> before;  // of interlaced ones, the last as it was decoded

  std::vector<std::filesystem::path> photos;  // of a folder; then nothing of FFmpeg is used
  std::vector<Error> left_out;                // why, of some of them

  Result<void> open();
  Result<void> open_photos();
  Result<std::optional<VideoFrame>> next_photo();
  Result<void> open_decoder();
  void fill_info();
  Result<void> feed();
  Received receive();
  void look_ahead();
  Received next_decoded();
  Result<std::optional<VideoFrame>> take();
  void make_progressive(bool handed_out);
  Result<std::optional<VideoFrame>> replay();
  Result<void> convert(const AVFrame& decoded, VideoFrame& result);
  void keep(const VideoFrame& taken);
  void forget_kept();
  double time_of_frame();
  Result<std::optional<VideoFrame>> finish();
  ReadSoFar so_far() const;
  Error broken_off() const;
  Error damaged() const;
  bool is_incomplete() const;
};

Result<void> VideoReader::Impl::open() {
  silence_ffmpeg();
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return open_photos();
  if (const auto checked = check_is_video_file(path); !checked) return checked;
  AVFormatContext* raw = nullptr;
  if (const int error = open_container(raw, path); error < 0) return cannot_open_video(path, error);
  format.reset(raw);
  if (const int error = find_stream_info(*raw); error < 0) return cannot_open_video(path, error);
  stream = picture_stream(*raw);
  if (!stream) {
    const bool sound = av_find_best_stream(raw, AVMEDIA_TYPE_AUDIO, -1, -1, nullptr, 0) >= 0;
    return bad_video(
        path,
        fmt::format("\"{}\" holds {} no video.", path.filename().string(), sound ? "sound but" : "data but"),
        "Choose the video itself; exporting only the sound drops the picture.");
  }
  if (avcodec_get_type(stream->codecpar->codec_id) != AVMEDIA_TYPE_VIDEO ||
      stream->codecpar->codec_id == AV_CODEC_ID_ANSI || stream->codecpar->width <= 0 ||
      stream->codecpar->height <= 0) {
    return cannot_open_video(path, AVERROR_INVALIDDATA);
  }
  for (unsigned i = 0; i < raw->nb_streams; ++i) {
    if (raw->streams[i] != stream) raw->streams[i]->discard = AVDISCARD_ALL;
  }
  const Mp4Boxes boxes = scan_mp4_boxes(path);
  cut_off = boxes.cut_off || is_cut_matroska(path);
  cut_fragment = boxes.cut_fragment;
  fill_info();
  info.focal_35mm = read_focal_35mm(path);
  if (std::int64_t(info.width) * info.height > kMaxPixels) {
    return incomplete_video(path,
                            fmt::format("\"{}\" claims pictures of {} x {} pixels, more than 8192 x 8192.",
                                        path.filename().string(), info.width, info.height));
  }
  return open_decoder();
}

// The first that can be read says the size of all.
Result<void> VideoReader::Impl::open_photos() {
  auto listed = list_photos(path);
  if (!listed) return listed.error();
  photos = std::move(*listed);
  Result<Image8> first = read_photo(photos.front());
  for (std::size_t i = 1; !first && may_leave_out(first.error(), i, photos.size()); ++i)
    first = read_photo(photos[i]);
  if (!first) return first.error();
  info.width = first->width;
  info.height = first->height;
  info.frames_per_second = 1;
  info.frame_count = int(photos.size());
  info.duration_s = double(photos.size());
  info.codec = "photographs";
  return {};
}

// One that is damaged or of another size is left out.
Result<std::optional<VideoFrame>> VideoReader::Impl::next_photo() {
  while (true) {
    next_index = (std::max(next_index, first) + stride - 1) / stride * stride;
    if (std::size_t(next_index) >= photos.size() || next_index > last) {
      ended = true;
      if (!left_out.empty()) fault = left_out_error(left_out, photos.size());
      return std::optional<VideoFrame>();
    }
    const std::filesystem::path& file = photos[std::size_t(next_index)];
    VideoFrame result;
    result.index = next_index++;
    result.time_s = last_time_s = result.index;
    auto photo = read_photo(file, &result.alpha);
    ++frames_decoded;
    if (photo && (photo->width != info.width || photo->height != info.height))
      photo = other_size_error(file, *photo, info.width, info.height);
    if (!photo) {
      left_out.push_back(photo.error());
      if (!may_leave_out(photo.error(), left_out.size(), photos.size())) return photo.error();
      continue;
    }
    if (!part.empty()) *photo = crop(*photo, part);
    if (!part.empty() && !result.alpha.empty()) result.alpha = crop(result.alpha, part);
    if (pixels == VideoPixels::both) result.luma = luma_of_photo(*photo);
    result.rgb = pixels == VideoPixels::luma ? luma_of_photo(*photo) : std::move(*photo);
    return std::optional<VideoFrame>(std::move(result));
  }
}

Result<void> VideoReader::Impl::open_decoder() {
  const AVCodec* decoder = find_decoder(*stream);
  const auto refused = [&](std::string_view why) {
    return Error{ErrorCode::missing_dependency,
                 fmt::format("The video's format ({}) cannot be decoded here: {}.", info.codec, why),
                 "Convert it to H.264, for instance: ffmpeg -i in.mov -c:v libx264 -crf 14 out.mp4",
                 path.string()};
  };
  if (!is_opened_codec(stream->codecpar->codec_id)) return refused("it is none of those that are opened");
  if (!decoder) return refused("this FFmpeg has no decoder for it");
  codec.reset(avcodec_alloc_context3(decoder));
  if (!codec || avcodec_parameters_to_context(codec.get(), stream->codecpar) < 0)
    return refused("its header is damaged");
  codec->thread_count = 0;  // all
  codec->max_pixels = kMaxPixels;
  codec->pkt_timebase = stream->time_base;
  if (const int error = avcodec_open2(codec.get(), decoder, nullptr); error < 0) {
    // Its threads' stacks among it.
    if (error == AVERROR(ENOMEM) || error == AVERROR(EAGAIN)) throw std::bad_alloc();
    return refused(av_text(error));
  }
  return {};
}

void VideoReader::Impl::fill_info() {
  const Orientation orientation = orientation_of(*stream);
  int width = stream->codecpar->width, height = stream->codecpar->height;
  const AVRational aspect = av_guess_sample_aspect_ratio(format.get(), stream, nullptr);
  if (aspect.num > 0 && aspect.den > 0)
    width = int(std::clamp(std::round(width * av_q2d(aspect)), 1.0, 1e6));  // square pixels
  pictures = DecodedPictures(orientation, width, height, aspect);
  info.width = orientation.transposed ? height : width;
  info.height = orientation.transposed ? width : height;
  info.rotation_deg = orientation.clockwise_deg;
  info.frames_per_second = rate_of(path, *format, *stream);
  info.codec = avcodec_get_name(stream->codecpar->codec_id);
  const StreamLength length = length_of(*format, *stream, info.frames_per_second);
  info.duration_s = length.seconds, info.frame_count = length.frames;
  own_length = length.own;
}

// Sends packets until the decoder has taken one of the video stream, or signals that none follow.
Result<void> VideoReader::Impl::feed() {
  while (true) {
    const int error = av_read_frame(format.get(), packet.get());
    if (error == AVERROR(EAGAIN)) continue;
    if (error < 0) {
      if (error != AVERROR_EOF) read_error = error;
      draining = true;
      avcodec_send_packet(codec.get(), nullptr);
      return {};
    }
    if (packet->stream_index != stream->index) {
      av_packet_unref(packet.get());
      continue;
    }
    if (packet->flags & AV_PKT_FLAG_CORRUPT && cut_off) {  // the half packet at the cut
      av_packet_unref(packet.get());
      continue;
    }
    ++packets;
    if (packet->pts != AV_NOPTS_VALUE) {
      const std::int64_t start = stream->start_time == AV_NOPTS_VALUE ? 0 : stream->start_time;
      end_s = std::max(end_s, double(packet->pts + packet->duration - start) * av_q2d(stream->time_base));
    }
    const int sent = avcodec_send_packet(codec.get(), packet.get());
    av_packet_unref(packet.get());
    if (sent == AVERROR(ENOMEM)) throw std::bad_alloc();
    if (sent < 0 && sent != AVERROR(EAGAIN)) return damaged();
    return {};
  }
}

// Presentation time of the frame just decoded, from the stream's start; above the last one's, also where
// recordings were joined and the clock jumps back.
double VideoReader::Impl::time_of_frame() {
  const double step = info.frames_per_second > 0 ? 1 / info.frames_per_second : 0.04;
  const double next_s = next_index == 0 ? 0 : last_time_s + step;
  if (frame->best_effort_timestamp == AV_NOPTS_VALUE) return next_s;
  const std::int64_t start = stream->start_time == AV_NOPTS_VALUE ? 0 : stream->start_time;
  const double clock_s = double(frame->best_effort_timestamp - start) * av_q2d(stream->time_base);
  if (next_index == 0) return clock_s;
  // Of two frames at one time the second is moved, and the clock is right again once it is past that.
  constexpr double kRepeat_s = 1;
  if (clock_offset_s < kRepeat_s && clock_s > last_time_s) clock_offset_s = 0;
  if (clock_s + clock_offset_s <= last_time_s) clock_offset_s = next_s - clock_s;
  return clock_s + clock_offset_s;
}

// The decoder's next frame, into `frame`.
VideoReader::Impl::Received VideoReader::Impl::receive() {
  while (true) {
    const int error = avcodec_receive_frame(codec.get(), frame.get());
    if (error == 0) {
      ++frames_decoded;
      return Received::frame;
    }
    if (error == AVERROR_EOF) return Received::end;
    if (error != AVERROR(EAGAIN) || !feed()) return Received::damaged;
  }
}

// Nothing is decoded twice for it: what is looked at waits to be handed out.
void VideoReader::Impl::look_ahead() {
  constexpr std::size_t kMost = 25;  // frames
  constexpr std::uint64_t kMostBytes = std::uint64_t(128) << 20;
  looked_ahead = true;
  const AVFieldOrder order = stream->codecpar->field_order;
  bool flagged = order != AV_FIELD_UNKNOWN && order != AV_FIELD_PROGRESSIVE;
  double largest = 0;
  std::uint64_t bytes = 0;
  while (ahead.size() < kMost && bytes < kMostBytes && !is_interlaced(largest, false)) {
    const Received received = receive();
    if (received != Received::frame) {
      after_ahead = received;
      break;
    }
    std::unique_ptr<AVFrame, FreeFrame> next(av_frame_alloc());
    av_frame_move_ref(next.get(), frame.get());
    flagged |= is_flagged(*next);
    if (!ahead.empty()) largest = std::max(largest, combing(*ahead.back(), *next));
    bytes += frame_bytes(*next);
    ahead.push_back(std::move(next));
  }
  interlaced = is_interlaced(largest, flagged);
}

VideoReader::Impl::Received VideoReader::Impl::next_decoded() {
  if (!looked_ahead) look_ahead();
  if (!ahead.empty()) {
    av_frame_move_ref(frame.get(), ahead.front().get());
    ahead.pop_front();
    return Received::frame;
  }
  return after_ahead ? *after_ahead : receive();
}

void VideoReader::Impl::make_progressive(bool handed_out) {
  std::unique_ptr<AVFrame, FreeFrame> decoded(av_frame_clone(frame.get()));
  if (handed_out) interlaced = deinterlace(before.get(), *frame);
  before = std::move(decoded);
}

// nullopt for a skipped frame, and where the film has ended.
Result<std::optional<VideoFrame>> VideoReader::Impl::take() {
  if (frame->flags & AV_FRAME_FLAG_CORRUPT || frame->decode_error_flags != 0) {
    if (cut_off || read_error != 0) return broken_off();
    return damaged();
  }
  VideoFrame result;
  result.time_s = last_time_s = time_of_frame();
  if (seconds.to_s > 0 && result.time_s > seconds.to_s - kSameSecond) {
    ended = true;
    av_frame_unref(frame.get());
    return std::optional<VideoFrame>();
  }
  result.index = next_index++;
  result.shape = pictures.shape_of(*frame);
  ended = result.index >= last;
  const bool skipped =
      result.index % stride != 0 || result.index < first || result.time_s < seconds.from_s - kSameSecond;
  if (interlaced) make_progressive(!skipped);
  if (skipped) {
    av_frame_unref(frame.get());
    return std::optional<VideoFrame>();
  }
  if (const auto converted = convert(*frame, result); !converted) return converted.error();
  if (keeping) keep(result);
  av_frame_unref(frame.get());
  return std::optional<VideoFrame>(std::move(result));
}

Result<void> VideoReader::Impl::convert(const AVFrame& decoded, VideoFrame& result) {
  DecodedPicture shown;
  const bool rgb = pixels != VideoPixels::luma, luma = pixels != VideoPixels::rgb;
  if (!pictures.show(decoded, rgb, luma, part, shown)) return damaged();
  result.rgb = rgb ? std::move(shown.rgb) : std::move(shown.luma);
  if (rgb && luma) result.luma = std::move(shown.luma);
  result.alpha = std::move(shown.alpha);
  return {};
}

// The frame just handed out stays, or none does.
void VideoReader::Impl::keep(const VideoFrame& taken) {
  const std::uint64_t bytes = frame_bytes(*frame);
  Kept stays{taken.index, taken.time_s, taken.shape, std::unique_ptr<AVFrame, FreeFrame>(av_frame_alloc())};
  if (bytes > room || !stays.frame) return forget_kept();
  room -= bytes;
  av_frame_move_ref(stays.frame.get(), frame.get());
  kept.push_back(std::move(stays));
}

void VideoReader::Impl::forget_kept() {
  keeping = false;
  kept.clear();
}

Result<std::optional<VideoFrame>> VideoReader::Impl::replay() {
  while (!kept.empty() && kept.front().index < first) kept.pop_front();
  if (kept.empty()) {
    ended = true;
    return std::optional<VideoFrame>();
  }
  const Kept now = std::move(kept.front());
  kept.pop_front();
  VideoFrame result;
  result.index = now.index;
  result.time_s = now.time_s;
  result.shape = now.shape;
  if (const auto converted = convert(*now.frame, result); !converted) return converted.error();
  return std::optional<VideoFrame>(std::move(result));
}

// A cut-off MP4 may still hold every video packet (sound or tags were lost); then the video is complete. A
// Matroska file whose tail is lost within its length ends before its pictures do; its own length may be its
// sound's.
bool VideoReader::Impl::is_incomplete() const {
  if (read_error != 0) return true;
  if (cut_off) return cut_fragment || packets < stream->nb_frames || stream->nb_frames <= 0;
  const bool matroska = std::string_view(format->iformat->name).find("matroska") != std::string_view::npos;
  return matroska && own_length && stream->nb_frames <= 0 &&
         end_s < info.duration_s - std::max(1.0, 0.05 * info.duration_s);
}

Result<std::optional<VideoFrame>> VideoReader::Impl::finish() {
  ended = true;
  if (is_incomplete()) return broken_off();
  if (next_index == 0) {
    return incomplete_video(
        path, fmt::format("\"{}\" holds no frame that can be decoded.", path.filename().string()));
  }
  return std::optional<VideoFrame>();
}

ReadSoFar VideoReader::Impl::so_far() const { return {next_index, info.frame_count, last_time_s}; }
Error VideoReader::Impl::broken_off() const {
  // The disk or the network failed, and the film may be whole: FFmpeg's own errors are no numbers of the
  // system.
  if (const int number = AVUNERROR(read_error); number > 0 && number < 4096 && number != EINVAL)
    return file_error(path, "read", number);
  return cut_short_error(path, so_far());
}
Error VideoReader::Impl::damaged() const { return damaged_error(path, so_far()); }

Result<VideoReader> VideoReader::open(const std::filesystem::path& path, VideoPixels pixels,
                                      VideoFrames frames) {
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  impl->pixels = pixels;
  impl->frames = frames;
  if (const auto opened = impl->open(); !opened) return opened.error();
  if (frames == VideoFrames::sampled) impl->stride = sampling_stride(impl->info);
  return VideoReader(std::move(impl));
}

VideoReader::VideoReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VideoReader::~VideoReader() = default;
VideoReader::VideoReader(VideoReader&&) noexcept = default;
VideoReader& VideoReader::operator=(VideoReader&&) noexcept = default;

const VideoInfo& VideoReader::info() const { return impl_->part.empty() ? impl_->info : impl_->shown; }

void VideoReader::show_part(const PixelRect& part) {
  Impl& reader = *impl_;
  const PixelRect whole{0, 0, reader.info.width, reader.info.height};
  LIKENESS_CHECK(part.empty() || common_part(part, whole) == part, "a part at %d, %d of %d x %d px", part.x,
                 part.y, part.width, part.height);
  reader.part = part == whole ? PixelRect{} : part;
  reader.shown = reader.info, reader.shown.width = part.width, reader.shown.height = part.height;
}

Result<std::optional<VideoFrame>> VideoReader::next() {
  Impl& reader = *impl_;
  if (reader.failure) return *reader.failure;
  if (reader.ended) return std::optional<VideoFrame>();
  const auto step = [&]() -> Result<std::optional<VideoFrame>> {
    if (!reader.photos.empty()) return reader.next_photo();
    if (reader.replaying) return reader.replay();
    while (true) {
      const Impl::Received received = reader.next_decoded();
      if (received == Impl::Received::end) return reader.finish();
      if (received == Impl::Received::damaged) return reader.damaged();
      auto taken = reader.take();
      if (!taken || *taken || reader.ended) return taken;
    }
  };
  auto result = step();
  if (result) return result;
  const bool of_the_film = reader.photos.empty() && result.error().code == ErrorCode::bad_input;
  if (of_the_film && reader.next_index >= kFewestBeforeFault) {
    reader.fault = result.error();
    reader.fault->what += " Only what comes before is used.";
    reader.ended = true;
    return std::optional<VideoFrame>();
  }
  reader.failure = result.error();
  return result;
}

const std::optional<Error>& VideoReader::fault() const { return impl_->fault; }

std::string fault_words(const Error& fault) { return fault.what + " " + fault.fix; }

bool VideoReader::changed_shape() const { return impl_->pictures.changed_shape(); }
PixelRect VideoReader::shape_part(int shape) const { return impl_->pictures.part_of(shape); }
bool VideoReader::was_interlaced() const { return impl_->interlaced; }

void VideoReader::start_at(int index) { impl_->first = index; }
void VideoReader::end_at(int index) { impl_->last = index; }
void VideoReader::show_seconds(const ClipSeconds& seconds) { impl_->seconds = seconds; }

void VideoReader::keep_frames(std::uint64_t bytes) {
  Impl& reader = *impl_;
  if (!reader.photos.empty() || reader.next_index > 0) return;
  // What surely does not fit is not begun: 4:2:0 with eight bits is the least that phones write.
  constexpr double kBytesPerPixel = 1.5;
  const VideoInfo& film = reader.info;
  const double share =
      film.duration_s > 0 ? length_within(reader.seconds, film.duration_s) / film.duration_s : 1;
  const double expected =
      kBytesPerPixel * film.width * film.height * (share * film.frame_count / reader.stride);
  reader.keeping = expected <= double(bytes);
  reader.room = bytes;
}

Result<void> VideoReader::rewind(VideoPixels pixels) {
  Impl& reader = *impl_;
  const bool unread = reader.next_index == 0 && !reader.ended && !reader.failure;
  if (unread) {
    reader.pixels = pixels;
    return {};
  }
  if (reader.keeping && reader.ended && !reader.failure && !reader.replaying) {
    reader.pixels = pixels;
    reader.first = 0, reader.last = std::numeric_limits<int>::max();
    reader.ended = false;
    reader.replaying = true;
    return {};
  }
  reader.forget_kept();
  auto again = open(reader.path, pixels, reader.frames);
  if (!again) return again.error();
  again->show_part(reader.part);
  again->show_seconds(reader.seconds);
  *this = std::move(*again);
  return {};
}

int sampling_stride(const VideoInfo& info) {
  constexpr double kFast = 60.5, kUsual = 30;  // frames a second
  constexpr int kMost = 9000;
  const int for_rate =
      info.frames_per_second > kFast ? std::max(1, int(std::lround(info.frames_per_second / kUsual))) : 1;
  return std::max(for_rate, (info.frame_count + kMost - 1) / kMost);
}

Result<std::string> hash_video(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored) ? hash_photos(path) : hash_file(path);
}

std::int64_t decoded_frames() { return frames_decoded; }

Result<VideoInfo> probe_video(const std::filesystem::path& path) {
  auto reader = VideoReader::open(path);
  if (!reader) return reader.error();
  return reader->info();
}

}  // namespace likeness
