// Packets of both files in the order of their times: see copy_sound.h.
#include "core/video/copy_sound.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <system_error>

#include "core/base/files.h"
#include "core/video/libav.h"
#include "core/video/stream_info.h"

namespace likeness {
namespace {

struct CloseOutput {
  void operator()(AVFormatContext* c) const {
    if (c->pb) avio_closep(&c->pb);
    avformat_free_context(c);
  }
};
using Input = std::unique_ptr<AVFormatContext, CloseFormat>;
using Output = std::unique_ptr<AVFormatContext, CloseOutput>;

// One stream of a file, read packet by packet.
struct Source {
  Input file;
  AVStream* stream = nullptr;
  std::unique_ptr<AVPacket, FreePacket> packet{av_packet_alloc()};
  std::int64_t start = 0;  // subtracted, so that both begin at zero
  bool ended = false;

  double time_s() const {
    const std::int64_t at = packet->dts == AV_NOPTS_VALUE ? packet->pts : packet->dts;
    return double(at - start) * av_q2d(stream->time_base);
  }
  // The next packet of the stream; `ended` at the end or where the file is cut off.
  void advance() {
    do {
      av_packet_unref(packet.get());
      ended = av_read_frame(file.get(), packet.get()) < 0;
    } while (!ended && packet->stream_index != stream->index);
  }
};

Error sound_error(const std::filesystem::path& film, int error) {
  const int number = AVUNERROR(error);
  if (number > 0 && number < 4096) return file_error(film, "write", number);
  return {ErrorCode::io, fmt::format("The sound cannot be added to {}: {}.", film.string(), av_text(error)),
          "Check the disk and the path, then run it again.", film.string()};
}

// Sound that is declared and never written has neither.
bool is_any(const AVStream& stream) {
  const AVCodecParameters& about = *stream.codecpar;
  return about.codec_type != AVMEDIA_TYPE_AUDIO || (about.sample_rate > 0 && about.ch_layout.nb_channels > 0);
}

// A phone's second track may be of a kind that neither mp4 nor FFmpeg knows.
bool fits_mp4(const AVStream& stream) {
  const AVOutputFormat* mp4 = av_guess_format("mp4", nullptr, nullptr);
  return is_any(stream) && mp4 &&
         avformat_query_codec(mp4, stream.codecpar->codec_id, FF_COMPLIANCE_NORMAL) == 1;
}

// Null `stream` if the file has none of the kind.
Source open_source(const std::filesystem::path& path, AVMediaType kind) {
  Source source;
  AVFormatContext* raw = nullptr;
  if (open_container(raw, path) < 0) return source;
  source.file.reset(raw);
  if (find_stream_info(*raw) < 0) return source;
  source.stream = default_stream(*raw, kind, fits_mp4);
  if (!source.stream) source.stream = default_stream(*raw, kind, is_any);
  return source;
}

int add_stream(AVFormatContext& output, const Source& source) {
  AVStream* stream = avformat_new_stream(&output, nullptr);
  if (!stream) return AVERROR(ENOMEM);
  const int error = avcodec_parameters_copy(stream->codecpar, source.stream->codecpar);
  stream->codecpar->codec_tag = 0;
  stream->time_base = source.stream->time_base;
  stream->avg_frame_rate = source.stream->avg_frame_rate;
  return error;
}

int write_packet(AVFormatContext& output, Source& source, int index) {
  AVPacket& packet = *source.packet;
  const AVRational from = source.stream->time_base, to = output.streams[index]->time_base;
  if (packet.pts != AV_NOPTS_VALUE) packet.pts -= source.start;
  if (packet.dts != AV_NOPTS_VALUE) packet.dts -= source.start;
  av_packet_rescale_ts(&packet, from, to);
  packet.stream_index = index;
  packet.pos = -1;
  return av_interleaved_write_frame(&output, &packet);
}

// The film's own tags; those that state the kind of file are set by the writer.
void copy_tags(AVFormatContext& output, const Source& film) {
  av_dict_copy(&output.metadata, film.file->metadata, 0);
  for (const char* key : {"major_brand", "minor_version", "compatible_brands", "encoder"})
    av_dict_set(&output.metadata, key, nullptr, 0);
}

int write_both(AVFormatContext& output, Source& pictures, Source& sound, double from_s) {
  // The sound's clock is its clip's: it begins where the film does in the clip's pictures.
  const auto begin = [](const Source& s) {
    return s.stream->start_time == AV_NOPTS_VALUE ? 0 : s.stream->start_time;
  };
  pictures.start = 0;
  sound.start = begin(sound);
  const AVStream* video = picture_stream(*sound.file);
  if (video && video->start_time != AV_NOPTS_VALUE)
    sound.start = av_rescale_q(video->start_time, video->time_base, sound.stream->time_base);
  sound.start += std::llround(from_s / av_q2d(sound.stream->time_base));
  const double length_s = double(pictures.file->duration) / AV_TIME_BASE;
  AVDictionary* flags = nullptr;
  av_dict_set(&flags, "movflags", kMovFlags, 0);
  int error = avformat_write_header(&output, &flags);
  av_dict_free(&flags);
  pictures.advance(), sound.advance();
  while (error >= 0 && !(pictures.ended && sound.ended)) {
    if (!sound.ended && (sound.time_s() < 0 || sound.time_s() > length_s)) {
      const bool over = sound.time_s() > length_s;
      sound.advance();
      sound.ended = sound.ended || over;
      continue;
    }
    const bool picture_first = !pictures.ended && (sound.ended || pictures.time_s() <= sound.time_s());
    Source& next = picture_first ? pictures : sound;
    error = write_packet(output, next, picture_first ? 0 : 1);
    next.advance();
  }
  return error < 0 ? error : av_write_trailer(&output);
}

}  // namespace

Result<CopiedSound> copy_sound(const std::filesystem::path& from, const std::filesystem::path& film,
                               double from_s) {
  Source sound = open_source(from, AVMEDIA_TYPE_AUDIO);
  if (!sound.stream) return CopiedSound{false, "the clip has no sound"};
  if (!fits_mp4(*sound.stream)) {
    return CopiedSound{false, fmt::format("an mp4 cannot hold the clip's kind of sound ({})",
                                          avcodec_get_name(sound.stream->codecpar->codec_id))};
  }
  Source pictures = open_source(film, AVMEDIA_TYPE_VIDEO);
  if (!pictures.stream) return sound_error(film, AVERROR_INVALIDDATA);
  const std::filesystem::path temporary = temporary_name(film);
  const std::string name = "file:" + temporary.string();
  AVFormatContext* raw = nullptr;
  if (const int error = avformat_alloc_output_context2(&raw, nullptr, "mp4", name.c_str()); error < 0)
    return sound_error(film, error);
  Output output(raw);
  int error = add_stream(*output, pictures);
  if (error >= 0) error = add_stream(*output, sound);
  copy_tags(*output, pictures);
  if (error >= 0) error = avio_open(&raw->pb, name.c_str(), AVIO_FLAG_WRITE);
  if (error >= 0) error = write_both(*output, pictures, sound, from_s);
  if (error >= 0) error = avio_closep(&raw->pb);
  output.reset();
  if (error < 0) {
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);
    return sound_error(film, error);
  }
  if (const auto committed = commit_file(temporary, film); !committed) return committed.error();
  return CopiedSound{true, ""};
}

}  // namespace likeness
