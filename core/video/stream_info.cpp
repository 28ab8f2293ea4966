// Reading a stream's header: see stream_info.h.
#include "core/video/stream_info.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
}

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "core/video/libav.h"

namespace likeness {
namespace {

// Frame rate from the times of the first packets; 0 if they do not show it.
double measured_rate(const std::filesystem::path& path, int stream) {
  constexpr std::size_t kPackets = 240;
  constexpr int kMaxRead = 10 * int(kPackets);
  AVFormatContext* raw = nullptr;
  if (avformat_open_input(&raw, ("file:" + path.string()).c_str(), nullptr, nullptr) < 0) return 0;
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

}  // namespace

void CloseFormat::operator()(AVFormatContext* c) const { avformat_close_input(&c); }

int find_stream_info(AVFormatContext& format) {
  std::vector<AVDictionary*> options(format.nb_streams);
  for (AVDictionary*& each : options) av_dict_set_int(&each, "max_pixels", kMaxPixels, 0);
  const int error = avformat_find_stream_info(&format, options.data());
  for (AVDictionary*& each : options) av_dict_free(&each);
  return error;
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

double rate_of(const std::filesystem::path& path, AVFormatContext& format, AVStream& stream) {
  if (stream.avg_frame_rate.num > 0 && stream.avg_frame_rate.den > 0) return av_q2d(stream.avg_frame_rate);
  // FFmpeg's guess may be the clock's ticks: WebM written by browsers holds nothing else.
  if (const double measured = measured_rate(path, stream.index); measured > 0) return measured;
  const AVRational rate = av_guess_frame_rate(&format, &stream, nullptr);
  return rate.num > 0 && rate.den > 0 ? av_q2d(rate) : 0;
}

}  // namespace likeness
