// See finish_film.h.
#include "core/video/finish_film.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <optional>
#include <regex>
#include <string>
#include <system_error>

#include "core/base/file_names.h"
#include "core/base/files.h"
#include "core/base/unfinished.h"
#include "core/video/libav.h"
#include "core/video/stream_info.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLongestStem = 170;  // bytes: with the mark it stays whole in temporary_name()'s form

struct CloseWritten {
  void operator()(AVFormatContext* c) const {
    if (c->pb) avio_closep(&c->pb);
    avformat_free_context(c);
  }
};
using Written = std::unique_ptr<AVFormatContext, CloseWritten>;

// The disk's or the network's, not the file's: FFmpeg's own errors are tags.
bool is_disk_error(int error) {
  const int number = AVUNERROR(error);
  return number > 0 && number < 4096 && number != EINVAL;
}

// The pictures of `from`, packet by packet, up to its end or to where it was cut off; negative: an error.
int copy_pictures(AVFormatContext& from, AVFormatContext& to) {
  const int index = av_find_best_stream(&from, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (index < 0) return index;
  const AVStream& source = *from.streams[index];
  AVStream* stream = avformat_new_stream(&to, nullptr);
  if (!stream) return AVERROR(ENOMEM);
  if (const int error = avcodec_parameters_copy(stream->codecpar, source.codecpar); error < 0) return error;
  stream->codecpar->codec_tag = 0;
  stream->time_base = source.time_base;
  stream->avg_frame_rate = source.avg_frame_rate;
  av_dict_copy(&to.metadata, from.metadata, 0);
  for (const char* key : {"major_brand", "minor_version", "compatible_brands", "encoder"})
    av_dict_set(&to.metadata, key, nullptr, 0);
  AVDictionary* flags = nullptr;
  av_dict_set(&flags, "movflags", kMovFlags, 0);
  int error = avformat_write_header(&to, &flags);
  av_dict_free(&flags);
  const std::unique_ptr<AVPacket, FreePacket> packet(av_packet_alloc());
  if (!packet) return AVERROR(ENOMEM);
  std::int64_t count = 0;
  int read = 0;
  while (error >= 0 && (read = av_read_frame(&from, packet.get())) >= 0) {
    if (packet->stream_index != index) {
      av_packet_unref(packet.get());
      continue;
    }
    av_packet_rescale_ts(packet.get(), source.time_base, stream->time_base);
    packet->stream_index = 0;
    packet->pos = -1;
    ++count;
    error = av_interleaved_write_frame(&to, packet.get());
  }
  if (error >= 0 && is_disk_error(read)) error = read;  // not the end of what was written
  if (error >= 0 && count == 0) return AVERROR_INVALIDDATA;
  return error < 0 ? error : av_write_trailer(&to);
}

int copy_film(const fs::path& pieces, const fs::path& temporary) {
  AVFormatContext* opened = nullptr;
  if (const int error = open_container(opened, pieces); error < 0) return error;
  const std::unique_ptr<AVFormatContext, CloseFormat> from(opened);
  if (const int error = find_stream_info(*opened); error < 0) return error;
  const std::string name = "file:" + temporary.string();
  AVFormatContext* raw = nullptr;
  if (const int error = avformat_alloc_output_context2(&raw, nullptr, "mp4", name.c_str()); error < 0)
    return error;
  const Written to(raw);
  if (const int error = avio_open(&raw->pb, name.c_str(), AVIO_FLAG_WRITE); error < 0) return error;
  if (const int error = copy_pictures(*from, *to); error < 0) return error;
  return avio_closep(&raw->pb);
}

// Of a film in pieces whose process no longer lives: its name.
std::optional<std::string> abandoned_film(const fs::path& path) {
  static const std::regex form(R"(\.(.+)\.recording\.(\d{1,9})-\d+\.part(\.[^.]*))");
  const std::string name = path.filename().string();
  std::smatch found;
  if (!std::regex_match(name, found, form)) return std::nullopt;
  const bool lives = ::kill(pid_t(std::stol(found[2])), 0) == 0 || errno != ESRCH;
  return lives ? std::nullopt : std::optional(found[1].str() + found[3].str());
}

fs::path free_place(const fs::path& wanted) {
  fs::path place = wanted;
  for (int number = 2; path_exists(place); ++number)
    place = wanted.parent_path() /
            fmt::format("{}-{}{}", wanted.stem().string(), number, wanted.extension().string());
  return place;
}

}  // namespace

std::shared_ptr<const int> lock_pieces(const fs::path& pieces) {
  const int file = ::open(pieces.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return nullptr;
  std::shared_ptr<const int> lock(new int(file), [](const int* held) {
    ::close(*held);
    delete held;
  });
  // Where disks know no locks, the process's number has to do.
  return ::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK ? nullptr : lock;
}

fs::path unfinished_film_name(const fs::path& path) {
  const fs::path name = temporary_name(path.parent_path() / (cut_name(path.stem().string(), kLongestStem) +
                                                             kRecordingMark + path.extension().string()));
  forget_unfinished(name);  // what ends the process at once leaves it: it is a film
  return name;
}

Result<void> finish_film(const fs::path& pieces, const fs::path& path) {
  const fs::path temporary = temporary_name(path);
  std::error_code ignored;
  if (const int error = copy_film(pieces, temporary); error < 0) {
    fs::remove(temporary, ignored);
    forget_unfinished(temporary);
    const int number = AVUNERROR(error);
    if (number == ENOSPC || number == EDQUOT || number == EFBIG) {
      std::error_code failure;
      fs::rename(pieces, path, failure);
      return failure ? Result<void>(file_error(path, "write", failure.value())) : Result<void>();
    }
    if (is_disk_error(error)) return file_error(pieces, "read", number);
    return Error{error == AVERROR_INVALIDDATA || error == AVERROR_STREAM_NOT_FOUND ? ErrorCode::bad_input
                                                                                   : ErrorCode::failed,
                 fmt::format("{} holds no picture: {}.", pieces.string(), av_text(error)), "Record again.",
                 pieces.string()};
  }
  if (auto committed = commit_file(temporary, path); !committed) return committed;
  fs::remove(pieces, ignored);
  return {};
}

std::vector<fs::path> finish_abandoned_films(const fs::path& folder, std::stop_token stop) {
  std::vector<std::pair<fs::path, std::string>> found;
  std::error_code ignored;
  for (fs::directory_iterator it(folder, ignored), end; !ignored && it != end; it.increment(ignored))
    if (const auto name = abandoned_film(it->path()); name && it->is_regular_file(ignored))
      found.emplace_back(it->path(), *name);
  std::vector<fs::path> films;
  for (const auto& [pieces, name] : found) {
    if (stop.stop_requested()) break;
    const auto lock = lock_pieces(pieces);
    if (!lock) continue;
    const fs::path place = free_place(folder / name);
    if (const auto finished = finish_film(pieces, place); finished)
      films.push_back(place);
    else if (finished.error().code == ErrorCode::bad_input)
      fs::remove(pieces, ignored);
  }
  return films;
}

}  // namespace likeness
