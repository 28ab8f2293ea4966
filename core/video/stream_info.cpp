// Reading a stream's header: see stream_info.h.
#include "core/video/stream_info.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/avstring.h>
#include <libavutil/display.h>
#include <libavutil/parseutils.h>
}

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/files.h"
#include "core/video/libav.h"

namespace likeness {
namespace {

// FFmpeg's names. Every further demuxer and decoder is code that a stranger's file could reach.
constexpr const char* kContainers =
    "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi,mpegts,mpeg,asf,flv,ogg,mxf,dv,nut,ivf,h264,hevc,mjpeg,"
    "mpegvideo,m4v,aac";
constexpr AVCodecID kPictureCodecs[] = {
    AV_CODEC_ID_H264,  AV_CODEC_ID_HEVC,     AV_CODEC_ID_VP8,        AV_CODEC_ID_VP9,
    AV_CODEC_ID_AV1,   AV_CODEC_ID_MPEG4,    AV_CODEC_ID_MPEG2VIDEO, AV_CODEC_ID_MPEG1VIDEO,
    AV_CODEC_ID_MJPEG, AV_CODEC_ID_PRORES,   AV_CODEC_ID_DNXHD,      AV_CODEC_ID_DVVIDEO,
    AV_CODEC_ID_H263,  AV_CODEC_ID_THEORA,   AV_CODEC_ID_WMV1,       AV_CODEC_ID_WMV2,
    AV_CODEC_ID_WMV3,  AV_CODEC_ID_VC1,      AV_CODEC_ID_MSMPEG4V2,  AV_CODEC_ID_MSMPEG4V3,
    AV_CODEC_ID_FFV1,  AV_CODEC_ID_HUFFYUV,  AV_CODEC_ID_FFVHUFF,    AV_CODEC_ID_RAWVIDEO,
    AV_CODEC_ID_V210,  AV_CODEC_ID_CFHD,     AV_CODEC_ID_FLV1,       AV_CODEC_ID_PNG,
    AV_CODEC_ID_QTRLE, AV_CODEC_ID_UTVIDEO,  AV_CODEC_ID_VP6,        AV_CODEC_ID_VP6F,
    AV_CODEC_ID_VP6A,  AV_CODEC_ID_JPEG2000, AV_CODEC_ID_MSMPEG4V1,  AV_CODEC_ID_MJPEGB,
    AV_CODEC_ID_H263P, AV_CODEC_ID_R210,     AV_CODEC_ID_V410};
constexpr AVCodecID kSoundCodecs[] = {
    AV_CODEC_ID_AAC,       AV_CODEC_ID_MP3,       AV_CODEC_ID_MP2,       AV_CODEC_ID_AC3,
    AV_CODEC_ID_EAC3,      AV_CODEC_ID_OPUS,      AV_CODEC_ID_VORBIS,    AV_CODEC_ID_FLAC,
    AV_CODEC_ID_ALAC,      AV_CODEC_ID_AMR_NB,    AV_CODEC_ID_AMR_WB,    AV_CODEC_ID_PCM_S16LE,
    AV_CODEC_ID_PCM_S16BE, AV_CODEC_ID_PCM_S24LE, AV_CODEC_ID_PCM_S24BE, AV_CODEC_ID_PCM_S32LE,
    AV_CODEC_ID_PCM_F32LE, AV_CODEC_ID_PCM_U8,    AV_CODEC_ID_PCM_ALAW,  AV_CODEC_ID_PCM_MULAW,
    AV_CODEC_ID_WMAV1,     AV_CODEC_ID_WMAV2,     AV_CODEC_ID_WMAPRO,    AV_CODEC_ID_PCM_BLURAY,
    AV_CODEC_ID_AAC_LATM,  AV_CODEC_ID_DTS};

// Of all decoders that this FFmpeg has for them: looking at a stream's beginning decodes it.
const std::string& decoder_names() {
  static const std::string names = [] {
    std::string list;
    void* at = nullptr;
    while (const AVCodec* codec = av_codec_iterate(&at))
      if (av_codec_is_decoder(codec) &&
          (is_opened_codec(codec->id) ||
           std::ranges::find(kSoundCodecs, codec->id) != std::end(kSoundCodecs)))
        list += (list.empty() ? "" : ",") + std::string(codec->name);
    return list;
  }();
  return names;
}

// Frame rate from the times of the first packets; 0 if they do not show it.
double measured_rate(const std::filesystem::path& path, int stream) {
  constexpr std::size_t kPackets = 240;
  constexpr int kMaxRead = 10 * int(kPackets);
  AVFormatContext* raw = nullptr;
  if (open_container(raw, path) < 0) return 0;
  const std::unique_ptr<AVFormatContext, CloseFormat> format(raw);
  const std::unique_ptr<AVPacket, FreePacket> packet(av_packet_alloc());
  std::vector<std::int64_t> times;
  for (int read = 0; read < kMaxRead && times.size() < kPackets; ++read) {
    if (av_read_frame(raw, packet.get()) < 0) break;
    const std::int64_t time = packet->pts != AV_NOPTS_VALUE ? packet->pts : packet->dts;
    if (packet->stream_index == stream && time != AV_NOPTS_VALUE) times.push_back(time);
    av_packet_unref(packet.get());
  }
  if (times.size() < 2 || stream >= int(raw->nb_streams)) return 0;
  const auto [first, last] = std::ranges::minmax(times);  // they come in the decoder's order
  const double seconds = double(last - first) * av_q2d(raw->streams[stream]->time_base);
  return seconds > 0 ? double(times.size() - 1) / seconds : 0;
}

// Matroska's tags of one track; their keys may end in a language.
const char* tag_of(const AVStream& stream, const char* key) {
  const AVDictionaryEntry* entry = av_dict_get(stream.metadata, key, nullptr, AV_DICT_IGNORE_SUFFIX);
  return entry ? entry->value : nullptr;
}

}  // namespace

void CloseFormat::operator()(AVFormatContext* c) const { avformat_close_input(&c); }

bool is_opened_codec(AVCodecID codec) {
  return std::ranges::find(kPictureCodecs, codec) != std::end(kPictureCodecs);
}

int open_container(AVFormatContext*& format, const std::filesystem::path& path) {
  AVDictionary* options = nullptr;
  av_dict_set(&options, "format_whitelist", kContainers, 0);
  av_dict_set(&options, "protocol_whitelist", "file", 0);
  av_dict_set(&options, "codec_whitelist", decoder_names().c_str(), 0);
  // The "file:" prefix keeps a name such as "a:b.mp4" from being taken for a protocol.
  const int error = avformat_open_input(&format, ("file:" + path.string()).c_str(), nullptr, &options);
  av_dict_free(&options);
  return error;
}

std::optional<Error> refused_container(const std::filesystem::path& path) {
  constexpr std::size_t kLooked = std::size_t(64) << 10;
  const auto head = read_head(path, kLooked);
  if (!head) return {};
  const std::string name = path.filename().string();
  std::vector<unsigned char> bytes(head->size() + AVPROBE_PADDING_SIZE, 0);
  std::transform(head->begin(), head->end(), bytes.begin(),
                 [](std::byte b) { return std::to_integer<unsigned char>(b); });
  const AVProbeData data{name.c_str(), bytes.data(), int(head->size()), nullptr};
  const AVInputFormat* kind = av_probe_input_format(&data, 1);
  if (!kind || av_match_list(kind->name, kContainers, ',') > 0) return {};
  return Error{ErrorCode::bad_input,
               fmt::format("\"{}\" is none of the kinds of video that are opened here: {}.", name,
                           kind->long_name ? kind->long_name : kind->name),
               "Choose the video itself, as a phone or camera records it, or convert it first, for instance: "
               "ffmpeg -i VIDEO -c:v libx264 -crf 14 out.mp4",
               path.string()};
}

int find_stream_info(AVFormatContext& format) {
  std::vector<AVDictionary*> options(format.nb_streams);
  for (AVDictionary*& each : options) av_dict_set_int(&each, "max_pixels", kMaxPixels, 0);
  const int error = avformat_find_stream_info(&format, options.data());
  for (AVDictionary*& each : options) av_dict_free(&each);
  return error;
}

AVStream* default_stream(AVFormatContext& format, AVMediaType kind,
                         const std::function<bool(const AVStream&)>& serves) {
  AVStream* first = nullptr;
  for (unsigned i = 0; i < format.nb_streams; ++i) {
    AVStream* stream = format.streams[i];
    const bool cover = stream->disposition & (AV_DISPOSITION_ATTACHED_PIC | AV_DISPOSITION_TIMED_THUMBNAILS);
    if (stream->codecpar->codec_type != kind || cover || !serves(*stream)) continue;
    if (stream->disposition & AV_DISPOSITION_DEFAULT) return stream;
    if (!first) first = stream;
  }
  return first;
}

const AVCodec* find_decoder(const AVStream& stream) {
  const AVCodecID codec = stream.codecpar->codec_id;
  const char* alpha = tag_of(stream, "alpha_mode");
  const AVCodec* other = nullptr;
  if (alpha && std::string_view(alpha) == "1" && codec == AV_CODEC_ID_VP9)
    other = avcodec_find_decoder_by_name("libvpx-vp9");
  if (alpha && std::string_view(alpha) == "1" && codec == AV_CODEC_ID_VP8)
    other = avcodec_find_decoder_by_name("libvpx");
  return other ? other : avcodec_find_decoder(codec);
}

AVStream* picture_stream(AVFormatContext& format) {
  const auto decodable = [](const AVStream& each) {
    const AVCodecID codec = each.codecpar->codec_id;
    return is_opened_codec(codec) && avcodec_find_decoder(codec) != nullptr;
  };
  AVStream* stream = default_stream(format, AVMEDIA_TYPE_VIDEO, decodable);
  return stream ? stream : default_stream(format, AVMEDIA_TYPE_VIDEO, [](const AVStream&) { return true; });
}

Orientation orientation_of(const AVStream& stream) {
#if LIBAVCODEC_VERSION_INT >= AV_VERSION_INT(60, 30, 100)
  const AVPacketSideData* side = av_packet_side_data_get(
      stream.codecpar->coded_side_data, stream.codecpar->nb_coded_side_data, AV_PKT_DATA_DISPLAYMATRIX);
  const std::uint8_t* data = side ? side->data : nullptr;
  const std::size_t size = side ? side->size : 0;
#else
  std::size_t size = 0;
  const std::uint8_t* data = av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, &size);
#endif
  if (!data || size < 9 * sizeof(int)) return {};
  std::array<int, 9> matrix;
  std::copy_n(reinterpret_cast<const std::int32_t*>(data), 9, matrix.begin());
  return orientation_from_matrix(matrix);
}

namespace {

// No picture takes fewer bytes.
bool has_room(const AVFormatContext& format, double frames) {
  constexpr double kLeastFrameBytes = 16, kMostFrames = 1e8;
  const std::int64_t bytes = format.pb ? avio_size(format.pb) : 0;
  return frames <= (bytes > 0 ? double(bytes) / kLeastFrameBytes : kMostFrames);
}

}  // namespace

StreamLength length_of(const AVFormatContext& format, const AVStream& stream, double rate) {
  StreamLength length;
  const auto frames = stream.nb_frames;
  if (frames > 0 && frames < std::numeric_limits<int>::max()) length.frames = int(frames);
  length.own = true;
  const double tick_s = av_q2d(stream.time_base);
  std::int64_t tagged = 0;  // 1/1000000 s
  if (stream.duration > 0) {
    length.seconds = double(stream.duration) * tick_s;
  } else if (const char* tag = tag_of(stream, "DURATION"); tag && av_parse_time(&tagged, tag, 1) >= 0) {
    // FFmpeg's ends where the track does, and others', who count its frames, are as long as the track.
    const bool counted = tag_of(stream, "NUMBER_OF_FRAMES") != nullptr;
    const bool late = !counted && stream.start_time != AV_NOPTS_VALUE;
    length.seconds = std::max(0.0, double(tagged) * 1e-6 - (late ? double(stream.start_time) * tick_s : 0));
  } else if (format.duration > 0) {
    length.seconds = double(format.duration) / AV_TIME_BASE;
    length.own = false;
  }
  const double claimed = length.frames > 0 ? length.frames : length.seconds * rate;
  if (!has_room(format, claimed)) return {};
  length.frames = int(std::lround(claimed));
  return length;
}

double rate_of(const std::filesystem::path& path, AVFormatContext& format, AVStream& stream) {
  if (stream.avg_frame_rate.num > 0 && stream.avg_frame_rate.den > 0) return av_q2d(stream.avg_frame_rate);
  // FFmpeg's guess may be the clock's ticks: WebM written by browsers holds nothing else.
  if (const double measured = measured_rate(path, stream.index); measured > 0) return measured;
  const AVRational rate = av_guess_frame_rate(&format, &stream, nullptr);
  return rate.num > 0 && rate.den > 0 ? av_q2d(rate) : 0;
}

}  // namespace likeness
