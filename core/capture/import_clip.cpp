// Import of a clip in two passes, so that it is never held in memory: look and choose, then crop and write.
#include <fmt/format.h>

#include <algorithm>

#include "core/base/files.h"
#include "core/base/parallel.h"
#include "core/capture/capture.h"
#include "core/capture/choose_crop.h"
#include "core/capture/choose_frames.h"
#include "core/capture/scan_clip.h"
#include "core/capture/split.h"
#include "core/image/files.h"
#include "core/video/decode.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kFewestFrames = 30;
constexpr int kFewestTraining = 20;
constexpr double kFaceShare = 0.1;  // of the samples: with fewer, the clip shows no usable face
constexpr double kFaceShareWarned = 0.8;
constexpr double kSecondFaceShare = 0.2;
constexpr std::size_t kBatch = 16;  // pictures written side by side

// Pictures gather in a hidden sibling of frames/, which takes its place only when complete.
class FramesFolder {
 public:
  explicit FramesFolder(const fs::path& project)
      : target_(project / "frames"), temporary_(temporary_name(target_)) {}
  ~FramesFolder() {
    std::error_code ignored;
    fs::remove_all(temporary_, ignored);
  }
  FramesFolder(const FramesFolder&) = delete;
  FramesFolder& operator=(const FramesFolder&) = delete;

  const fs::path& temporary() const { return temporary_; }

  Result<void> commit() {
    std::error_code failure;
    const fs::path old = temporary_name(target_);
    if (fs::exists(target_, failure)) fs::rename(target_, old, failure);
    if (!failure) fs::rename(temporary_, target_, failure);
    if (failure) {
      std::error_code ignored;
      if (!fs::exists(target_, ignored)) fs::rename(old, target_, ignored);
      return file_error(target_, "replace", failure.value());
    }
    fs::remove_all(old, failure);
    return {};
  }

 private:
  fs::path target_, temporary_;
};

// What a killed import left behind.
void remove_abandoned_parts(const fs::path& project) {
  std::error_code ignored;
  std::vector<fs::path> abandoned;
  for (fs::directory_iterator it(project, ignored), end; !ignored && it != end; it.increment(ignored)) {
    const std::string name = it->path().filename().string();
    if (name.starts_with(".frames.") && name.find(".part") != std::string::npos)
      abandoned.push_back(it->path());
  }
  for (const fs::path& path : abandoned) fs::remove_all(path, ignored);
}

bool is_photos(const fs::path& video) {
  std::error_code ignored;
  return fs::is_directory(video, ignored);
}

Error refused(ErrorCode code, const fs::path& video, std::string what, std::string_view fix) {
  return {code, std::move(what), std::string(fix), video.string()};
}

// The faces of the sampled frames, or why the clip cannot be used.
Result<std::vector<FaceBox>> judge_clip(const ClipScan& scan, const fs::path& video) {
  if (scan.frames.size() < kFewestFrames) {
    return is_photos(video)
               ? refused(ErrorCode::bad_input, video,
                         fmt::format("The folder has {} photographs; at least {} are needed.",
                                     scan.frames.size(), kFewestFrames),
                         "Take more: from different sides, the face making expressions.")
               : refused(ErrorCode::bad_input, video,
                         fmt::format("The video has {} frames; at least {} are needed.", scan.frames.size(),
                                     kFewestFrames),
                         "Film about a minute: the head turning and the face making expressions.");
  }
  std::vector<FaceBox> faces;
  std::size_t crowded = 0;
  for (const FaceSample& sample : scan.samples) {
    if (sample.face) faces.push_back(*sample.face);
    crowded += sample.second_face;
  }
  const std::size_t looks = scan.samples.size();
  if (faces.empty() || double(faces.size()) < kFaceShare * double(looks)) {
    return refused(
        ErrorCode::no_face, video,
        fmt::format("A face was found in {} of {} frames looked at.", faces.size(), looks),
        "Film one face from the front, upright and evenly lit, filling at least a quarter of the picture's "
        "height; check that the video is not lying on its side.");
  }
  if (double(crowded) > kSecondFaceShare * double(looks)) {
    return refused(
        ErrorCode::bad_input, video,
        fmt::format("Two faces are in view in {} of {} frames looked at.", crowded, looks),
        "Film one person alone, or cut the other person, the mirror or the poster out of the picture.");
  }
  return faces;
}

std::vector<std::string> warnings_about(const Capture& capture, const ClipScan& scan, const CropChoice& crop,
                                        std::size_t faces) {
  std::vector<std::string> warnings;
  if (const int stride = sampling_stride(scan.info); stride > 1) {
    warnings.push_back(fmt::format(
        "The clip has about {} frames at {:.0f} a second; one in {} is used. A minute at 30 frames "
        "a second is enough.",
        scan.info.frame_count, scan.info.frames_per_second, stride));
  }
  const std::size_t looks = scan.samples.size();
  if (double(faces) < kFaceShareWarned * double(looks)) {
    warnings.push_back(
        fmt::format("A face was found in only {} of {} frames looked at; hands, hair, darkness or strong "
                    "turns may hide it.",
                    faces, looks));
  }
  if (crop.head_cut_share > 0.2) {
    warnings.push_back(
        fmt::format("The top of the head is cut off in {:.0f} % of the frames; leave room above it.",
                    100 * crop.head_cut_share));
  }
  if (capture.crop.side < capture.size) {
    warnings.push_back(
        fmt::format("Head and shoulders cover only {} px of the video, so pictures of {} px are enlarged; "
                    "film from closer, or import at a smaller size.",
                    capture.crop.side, capture.size));
  }
  const auto blurred = std::count_if(capture.frames.begin(), capture.frames.end(),
                                     [](const CaptureFrame& f) { return f.refused.starts_with("Blurred"); });
  if (double(blurred) > 0.15 * double(capture.frames.size())) {
    warnings.push_back(
        fmt::format("{} of {} frames are blurred; film in brighter light, or move more slowly.", blurred,
                    capture.frames.size()));
  }
  return warnings;
}

// Second pass: writes the pictures of used and held-out frames into `folder`.
Result<void> write_frames(const Capture& capture, const fs::path& folder, const Progress& progress,
                          std::stop_token stop) {
  auto reader = VideoReader::open(capture.video, VideoPixels::rgb, VideoFrames::sampled);
  if (!reader) return reader.error();
  std::vector<VideoFrame> batch;
  const auto flush = [&]() -> Result<void> {
    std::vector<Result<void>> results(batch.size());
    parallel_for(batch.size(), [&](std::size_t i) {
      const SquareCrop& c = capture.crop;
      const Image8 picture = resize(crop(batch[i].rgb, c.x, c.y, c.side, c.side), capture.size, capture.size);
      results[i] = write_image(folder / frame_name(batch[i].index).filename(), picture, {.png_level = 1});
    });
    batch.clear();
    for (auto& result : results) {
      if (!result) return result;
    }
    return {};
  };
  std::size_t count = 0;
  for (const CaptureFrame& wanted : capture.frames) {
    if (stop.stop_requested()) return cancelled_error();
    auto frame = reader->next();
    if (!frame) return frame.error();
    if (!*frame || (*frame)->index != wanted.frame) {
      return refused(ErrorCode::failed, capture.video, "The video changed while it was being imported.",
                     "Import it again once nothing else writes to it.");
    }
    if (wanted.used || wanted.held_out) batch.push_back(std::move(**frame));
    if (batch.size() == kBatch) {
      if (auto flushed = flush(); !flushed) return flushed;
    }
    ++count;
    progress.report(double(count) / double(capture.frames.size()),
                    fmt::format("Writing picture {} of {}", count, capture.frames.size()));
  }
  return flush();
}

Result<void> hold_out(std::vector<CaptureFrame>& frames, const ImportOptions& options,
                      const fs::path& video) {
  constexpr double kRandomShare = 0.3;
  switch (options.split) {
    case Split::tail:
      hold_out_tail(frames, options.held_out_share);
      break;
    case Split::views:
      if (!options.moving)
        return refused(ErrorCode::bad_input, video,
                       "The camera rests in this clip: there are no views of it to hold out.",
                       "Leave out --split views, or film a part in which the camera goes round the head.");
      hold_out_views(frames, *options.moving, options.held_out_share);
      break;
    case Split::random30:
      hold_out_random(frames, kRandomShare);
      break;
  }
  return {};
}

Result<Capture> make_capture(const fs::path& video, const ClipScan& scan, const ImportOptions& options) {
  const auto faces = judge_clip(scan, video);
  if (!faces) return faces.error();
  Capture capture;
  std::error_code ignored;
  capture.video = fs::absolute(video, ignored);
  auto hash = hash_video(video);
  if (!hash) return hash.error();
  capture.video_hash = *hash;
  capture.width = scan.info.width;
  capture.height = scan.info.height;
  capture.frames_per_second = scan.info.frames_per_second;
  capture.size = options.size;
  capture.frames = scan.frames;
  capture.split = options.split;
  if (const auto held = hold_out(capture.frames, options, video); !held) return held.error();
  choose_training_frames(capture.frames, scan.samples, scan.change, options);
  const auto training = std::count_if(capture.frames.begin(), capture.frames.end(),
                                      [](const CaptureFrame& f) { return f.used; });
  if (training < std::min(kFewestTraining, options.max_frames)) {
    return refused(ErrorCode::bad_input, video,
                   fmt::format("Only {} of {} frames show a sharp face.", training, capture.frames.size()),
                   is_photos(video) ? "Take them again in brighter light, holding still."
                                    : "Film again in brighter light and move more slowly.");
  }
  const CropChoice crop = choose_crop(*faces, capture.width, capture.height);
  capture.crop = crop.crop;
  capture.warnings = warnings_about(capture, scan, crop, faces->size());
  return capture;
}

}  // namespace

Result<Capture> import_clip(const fs::path& video, const fs::path& folder, const ImportOptions& options,
                            const Progress& progress, std::stop_token stop) {
  if (options.size < 64 || options.size > 2048 || options.max_frames < 1 || !(options.held_out_share >= 0) ||
      options.held_out_share > 0.5) {
    return refused(
        ErrorCode::bad_input, video,
        fmt::format("Pictures of {} px, {} frames and a held-out share of {:g} do not go together.",
                    options.size, options.max_frames, options.held_out_share),
        "Use a size of 256, 512 or 1024 px, at least one frame and a share of 0 to 0.5.");
  }
  if (const auto probed = probe_video(video); !probed) return probed.error();
  if (const auto writable = make_writable_folder(folder); !writable) return writable.error();
  remove_abandoned_parts(folder);
  auto detector = FaceDetector::load(options.landmark_model);
  if (!detector) return detector.error();

  const auto scan = scan_clip(video, *detector, {}, progress.stage(0, 0.6, "look"), stop);
  if (!scan) return scan.error();
  auto capture = make_capture(video, *scan, options);
  if (!capture) return capture.error();

  FramesFolder frames(folder);
  if (const auto made = make_writable_folder(frames.temporary()); !made) return made.error();
  if (const auto written = write_frames(*capture, frames.temporary(), progress.stage(0.6, 1, "write"), stop);
      !written) {
    return written.error();
  }
  if (const auto committed = frames.commit(); !committed) return committed.error();
  progress.report(1);
  return capture;
}

}  // namespace likeness
