// Live pictures written at a steady rate: see record.h.
#include "core/video/record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/video/encode.h"

namespace likeness {
namespace {

constexpr double kLongestRepeat_s = 1;  // gaps up to this are filled by repeating pictures; longer ones stay

Error no_picture(const std::filesystem::path& path) {
  return {ErrorCode::failed, "The camera gave no picture.",
          "Close other programs that use it, plug it in again, and check that it is not covered.",
          path.string()};
}

// Writes pictures at the file's rate. Slot k of the file is the time k / rate from the first picture on.
class SteadyWriter {
 public:
  SteadyWriter(VideoWriter writer, const RecordOptions& options)
      : writer_(std::move(writer)), rate_(options.frames_per_second) {}

  Result<void> add(const CapturedFrame& picture) {
    if (recording_.frames == 0) start_s_ = picture.time_s;
    const auto slot = std::lround((picture.time_s - start_s_) * rate_);
    if (slot < next_) {
      ++recording_.left_out;
      return {};
    }
    // Of a camera that stalled the last picture stays for as long.
    if (double(slot - next_) > kLongestRepeat_s * rate_) next_ = slot;
    for (; next_ < slot; ++recording_.repeated)
      if (auto added = write(last_); !added) return added;
    if (auto added = write(picture.rgb); !added) return added;
    last_ = picture.rgb;
    return {};
  }
  Result<Recording> finish() {
    if (auto finished = writer_.finish(); !finished) return finished.error();
    recording_.seconds = seconds();
    return recording_;
  }
  double seconds() const { return double(next_) / rate_; }

 private:
  Result<void> write(const Image8& picture) {
    ++recording_.frames;
    return writer_.add(picture, double(next_++) / rate_);
  }

  VideoWriter writer_;
  double rate_, start_s_ = 0;
  long next_ = 0;  // slot
  Image8 last_;
  Recording recording_;
};

}  // namespace

Result<Recording> record_clip(FrameSource& source, const std::filesystem::path& path,
                              const RecordOptions& options,
                              const std::function<void(const CapturedFrame&)>& seen, std::stop_token stop) {
  if (std::error_code ignored; std::filesystem::exists(path, ignored))
    return Error{ErrorCode::bad_input, "There is a file of this name already.",
                 "Name a new file: a recording never replaces one.", path.string()};
  std::optional<SteadyWriter> writer;
  int width = 0, height = 0;
  // What was filmed is kept, however the recording ended, if the film can still be finished.
  const auto ended = [&](Error error) -> Result<Recording> {
    if (!writer) return error;
    auto recording = writer->finish();
    if (!recording) return error;  // the disk is full: nothing can be finished on it
    recording->interruption = std::move(error);
    return recording;
  };
  while (!stop.stop_requested() && (!writer || writer->seconds() < options.longest_s)) {
    auto next = source.next(stop);
    if (!next) return ended(next.error());
    if (!*next) break;
    const CapturedFrame& picture = **next;
    if (picture.rgb.channels != 3 || picture.rgb.empty()) return no_picture(path);
    if (!writer) {
      width = picture.rgb.width, height = picture.rgb.height;
      auto created = VideoWriter::create(path, width, height,
                                         {.frames_per_second = options.frames_per_second,
                                          .crf = options.crf,
                                          .timed = true,
                                          .survives = true});
      if (!created) return created.error();
      writer.emplace(std::move(*created), options);
    }
    if (picture.rgb.width != width || picture.rgb.height != height)
      return ended({ErrorCode::failed,
                    fmt::format("The camera changed its picture from {} x {} to {} x {} px.", width, height,
                                picture.rgb.width, picture.rgb.height),
                    "Record again without turning the camera or changing its settings.", path.string()});
    if (seen) seen(picture);
    if (auto added = writer->add(picture); !added) return ended(added.error());
  }
  if (!writer) return stop.stop_requested() ? cancelled_error() : no_picture(path);
  return writer->finish();
}

}  // namespace likeness
