// Frames of a video file, or of a folder of photographs (core/video/photos.h), through FFmpeg's libraries:
// rotation tag applied, true timestamps kept, RGB 8 bit.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "core/base/clip_seconds.h"
#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness {

struct VideoInfo {
  int width = 0, height = 0;     // px, after rotation
  int rotation_deg = 0;          // of the tag that was applied
  double frames_per_second = 0;  // average
  int frame_count = 0;           // as the container declares or estimates; the decoder may find others
  double duration_s = 0;
  double focal_35mm = 0;  // of the lens, as recorded in the file (lens_tag.h); 0: not recorded
  std::string codec;
};

// The pixels a reader delivers. Luma costs a fraction of RGB and is enough for detection and tracking; it is
// the coded luma, not computed from RGB. `both` is for listeners that need one each
// (core/video/decode_for.h).
enum class VideoPixels { rgb, luma, both };

// Which frames a reader delivers: every one, or every sampling_stride-th from the first on, with its own
// number and time. Skipped frames are decoded, but neither converted nor delivered.
enum class VideoFrames { all, sampled };

struct VideoFrame {
  int index = 0;      // in decoding order, from 0: the frame's number everywhere in a project
  double time_s = 0;  // presentation time
  Image8 rgb;         // 3 channels; 1 from a reader of luma
  Image8 luma{};      // 1 channel, from a reader of both; else empty
  Image8 alpha{};     // 1 channel, of a picture that hides something; else empty (alpha.h)
  // Which of the film's shapes the picture has, from 0 on. Where a film changes it in the middle, pictures
  // keep their shape: they lie in the middle of the film's, whose size info() has, black around them.
  int shape = 0;
};

// 1 up to 60 frames a second and 9,000 frames. Faster films are reduced to about 30 a second, longer ones to
// 9,000 frames in all: more would not improve an avatar and could not be tracked in one piece.
int sampling_stride(const VideoInfo& info);

// Of a file's bytes; of a folder's photographs.
Result<std::string> hash_video(const std::filesystem::path& path);

Result<VideoInfo> probe_video(const std::filesystem::path& path);

// How many frames all readers of this process have decoded so far, those included that were not handed out:
// what reading a clip costs, for tests and measurements.
std::int64_t decoded_frames();

// Up to which second a film is used, or which photographs are left out, and what to do, in sentences.
std::string fault_words(const Error& fault);

// Sequential reader. next() gives nullopt at the end. A film that is cut short or damaged ends there, and
// fault() tells; where fewer than 30 frames precede, it is an Error of code bad_input naming the last one.
class VideoReader {
 public:
  static Result<VideoReader> open(const std::filesystem::path& path, VideoPixels pixels = VideoPixels::rgb,
                                  VideoFrames frames = VideoFrames::all);
  ~VideoReader();
  VideoReader(VideoReader&&) noexcept;
  VideoReader& operator=(VideoReader&&) noexcept;

  const VideoInfo& info() const;
  // So far, its pictures had several shapes.
  bool changed_shape() const;
  // Where pictures of this shape, which was seen, lie in the film's; px of all of it.
  PixelRect shape_part(int shape) const;
  // Once the end was reached: why it came before the film's own, or why photographs were left out; nullopt:
  // neither is so.
  const std::optional<Error>& fault() const;
  // From the next frame on: delivers only this part of the pictures, whose size info() then has; an empty
  // one: all of them. Lasts through rewind().
  void show_part(const PixelRect& part);
  // Once a frame was read: its frames were interlaced, and were made progressive one by one (deinterlace.h).
  bool was_interlaced() const;
  // Frames before it are decoded, but neither converted nor delivered: a fraction of their cost.
  void start_at(int index);
  // No frame after it is decoded: the film ends with it.
  void end_at(int index);
  // Before the first next(): the film is these seconds of it. Frames before them are decoded only, as by
  // start_at, and of those after them only the first. Lasts through rewind(). Not of photographs, which have
  // no seconds.
  void show_seconds(const ClipSeconds& seconds);
  Result<std::optional<VideoFrame>> next();

  // Before the first next(): frames that are handed out stay in memory as they were decoded, so that rewind()
  // need not decode them again; all of them, or none where they would take more than `bytes` together.
  // Photographs never stay.
  void keep_frames(std::uint64_t bytes);
  // Begins (again) at the first frame, with these pixels. Kept frames leave memory as they are handed out, so
  // a second rewind decodes.
  Result<void> rewind(VideoPixels pixels);

 private:
  struct Impl;
  explicit VideoReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace likeness
