// Words for videos that are missing, cut short or damaged: see broken_video.h.
#include "core/video/broken_video.h"

extern "C" {
#include <libavutil/error.h>
}

#include <new>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/base/files.h"
#include "core/video/libav.h"
#include "core/video/mp4_boxes.h"
#include "core/video/stream_info.h"

namespace likeness {
namespace {

constexpr std::string_view kCopyAgain =
    "Copy it again from the phone and wait until the copy is complete; if the phone cannot play it to its "
    "end either, film again.";
constexpr std::string_view kNoIndex =
    "Copy it again and wait until the copy is complete. If the recording itself was broken off, the program "
    "\"untrunc\" can make the index from it and another, whole recording of the same camera.";

std::string of_about(const ReadSoFar& read) {
  return read.expected > read.frames ? fmt::format(" of about {}", read.expected) : "";
}

}  // namespace

Error bad_video(const std::filesystem::path& path, std::string what, std::string fix) {
  return {ErrorCode::bad_input, std::move(what), std::move(fix), path.string()};
}

Error incomplete_video(const std::filesystem::path& path, std::string what) {
  return bad_video(path, std::move(what), std::string(kCopyAgain));
}

Result<void> check_is_video_file(const std::filesystem::path& path) {
  std::error_code failure;
  const auto status = std::filesystem::status(path, failure);
  if (!std::filesystem::exists(status)) {
    return Error{ErrorCode::not_found, fmt::format("There is no video \"{}\".", path.string()),
                 "Check the name and the folder.", path.string()};
  }
  if (auto plain = check_not_endless(path); !plain) return plain;
  if (std::filesystem::is_regular_file(status) && std::filesystem::file_size(path, failure) == 0)
    return incomplete_video(path, fmt::format("\"{}\" is empty (0 bytes).", path.filename().string()));
  return {};
}

Error cannot_open_video(const std::filesystem::path& path, int av_error) {
  if (av_error == AVERROR(ENOMEM)) throw std::bad_alloc();
  const std::string name = path.filename().string();
  if (av_error == AVERROR(EACCES) || av_error == AVERROR(EPERM) || av_error == AVERROR(EIO)) {
    return file_error(path, "open", AVUNERROR(av_error));
  }
  const Mp4Boxes boxes = scan_mp4_boxes(path);
  if (boxes.is_mp4 && (boxes.cut_off || !boxes.has_index)) {
    return bad_video(
        path,
        fmt::format("\"{}\" is cut short before its index: the recording or the copy was not completed.",
                    name),
        std::string(kNoIndex));
  }
  if (auto refused = refused_container(path)) return *refused;
  return bad_video(path, fmt::format("\"{}\" is not a video that can be read ({}).", name, av_text(av_error)),
                   "Choose a video as a phone records it (.mp4 or .mov).");
}

Error cut_short_error(const std::filesystem::path& path, const ReadSoFar& read) {
  if (read.frames == 0)
    return incomplete_video(
        path, fmt::format("The video is cut short before its first frame{} is complete.", of_about(read)));
  return incomplete_video(
      path, fmt::format("The video is cut short after frame {}{}, {:.1f} s from its start.", read.frames,
                        of_about(read), read.last_s));
}

Error damaged_error(const std::filesystem::path& path, const ReadSoFar& read) {
  return bad_video(
      path,
      fmt::format("The video is damaged after frame {}{}, {:.1f} s from its start.", read.frames,
                  of_about(read), read.last_s),
      "Copy it again from the phone; if the phone shows the same flaw, cut that part out and keep one side.");
}

}  // namespace likeness
