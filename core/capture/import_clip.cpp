// Import of a clip in two passes: look and choose, then crop and write. It is decoded once where there is
// room for its frames as the decoder leaves them, else once a pass.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>

#include "core/base/files.h"
#include "core/base/memory.h"
#include "core/base/parallel.h"
#include "core/base/whole_folder.h"
#include "core/capture/capture.h"
#include "core/capture/choose_crop.h"
#include "core/capture/choose_frames.h"
#include "core/capture/choose_shots.h"
#include "core/capture/find_film.h"
#include "core/capture/head_views.h"
#include "core/capture/hold_out.h"
#include "core/capture/import_listeners.h"
#include "core/capture/repeated_frames.h"
#include "core/capture/scan_clip.h"
#include "core/capture/split.h"
#include "core/image/files.h"
#include "core/video/decode.h"
#include "core/video/photos.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kFewestFrames = 30;
constexpr int kFewestTraining = 20;
constexpr double kFaceShareWarned = 0.8;
constexpr double kSecondFaceShare = 0.2;
constexpr std::size_t kBatch = 16;  // pictures written side by side

bool is_photos(const fs::path& video) {
  std::error_code ignored;
  return fs::is_directory(video, ignored);
}

Error refused(ErrorCode code, const fs::path& video, std::string what, std::string_view fix) {
  return {code, std::move(what), std::string(fix), video.string()};
}

// The faces of the frames sampled in the shots that serve, or why the clip cannot be used.
Result<std::vector<FaceBox>> judge_clip(const ClipScan& scan, const std::vector<ClipShot>& shots,
                                        const ClipSeconds& seconds, const fs::path& video) {
  if (const std::string counted = counted_words(shots);
      scan.frames.size() < kFewestFrames && !counted.empty())
    return refused(ErrorCode::bad_input, video,
                   fmt::format("{} These are {} frames; at least {} are needed.", counted, scan.frames.size(),
                               kFewestFrames),
                   "Choose a film with a longer stretch without cuts.");
  if (scan.frames.size() < kFewestFrames && !seconds.whole())
    return refused(ErrorCode::bad_input, video,
                   fmt::format("The video {} has {} frames; at least {} are needed.", seconds_words(seconds),
                               scan.frames.size(), kFewestFrames),
                   "Choose a longer stretch of it.");
  if (scan.frames.size() < kFewestFrames) {
    const std::string unread = is_photos(video) ? unread_pictures(video) : "";
    return is_photos(video)
               ? refused(ErrorCode::bad_input, video,
                         fmt::format("The folder has {} photographs; at least {} are needed.{}{}",
                                     scan.frames.size(), kFewestFrames, unread.empty() ? "" : " ", unread),
                         "Take more: from different sides, with different expressions.")
               : refused(ErrorCode::bad_input, video,
                         fmt::format("The video has {} frames; at least {} are needed.", scan.frames.size(),
                                     kFewestFrames),
                         "Film for about a minute, turning the head and making expressions.");
  }
  std::vector<FaceBox> faces;
  std::size_t crowded = 0;
  for (const FaceSample& sample : scan.samples) {
    if (sample.face) faces.push_back(*sample.face);
    crowded += sample.second_face;
  }
  const std::size_t looks = scan.samples.size();
  if (faces.empty() || double(faces.size()) < kLeastFaceShare * double(looks)) {
    return refused(
        ErrorCode::no_face, video,
        fmt::format("A face was found in {} of {} frames examined.", faces.size(), looks),
        "Film one face from the front, upright and evenly lit, filling at least a quarter of the picture's "
        "height; check that the video is not lying on its side.");
  }
  if (double(crowded) > kSecondFaceShare * double(looks)) {
    return refused(ErrorCode::bad_input, video,
                   fmt::format("Two faces are in view in {} of {} frames examined.", crowded, looks),
                   "Film one person alone, or crop out the other person, mirror or poster.");
  }
  return faces;
}

std::vector<std::string> warnings_about(const Capture& capture, const ClipScan& scan, const CropChoice& crop,
                                        std::size_t faces) {
  std::vector<std::string> warnings;
  if (scan.fault) warnings.push_back(fault_words(*scan.fault));
  if (const PixelRect& film = capture.film; !film.empty()) {
    warnings.push_back(fmt::format(
        "The video has bars: only {} x {} px of its {} x {} were filmed, and only those are used. "
        "Where there is one, the film without bars is sharper.",
        film.width, film.height, capture.width, capture.height));
  }
  if (const std::string counted = counted_words(capture.shots); !counted.empty())
    warnings.push_back(counted +
                       " To use more of it, add other seconds of it as a further clip: "
                       "likeness clips PROJECT --add CLIP --from SECOND --to SECOND.");
  if (const int stride = sampling_stride(scan.info); stride > 1) {
    warnings.push_back(fmt::format("The clip has about {} frames at {:.0f} a second; one in {} is used. {}",
                                   scan.info.frame_count, scan.info.frames_per_second, stride,
                                   capture.seconds.whole()
                                       ? "A minute at 30 frames a second is enough."
                                       : "To use them all, cut the seconds out into a film of their own."));
  }
  const std::size_t looks = scan.samples.size();
  if (double(faces) < kFaceShareWarned * double(looks)) {
    warnings.push_back(
        fmt::format("A face was found in only {} of {} frames examined; hands, hair, darkness or strong "
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
  const std::vector<FrameSpan> shots = spans_where_cut(capture);
  const auto serving = std::ranges::count_if(
      capture.frames, [&](const CaptureFrame& f) { return span_of(shots, f.frame) >= 0; });
  if (double(blurred) > 0.15 * double(serving)) {
    warnings.push_back(fmt::format(
        "{} of {} frames are blurred; film in brighter light, or move more slowly.", blurred, serving));
  }
  return warnings;
}

// Second pass: writes the pictures of used and held-out frames into a folder.
class FrameWriter {
 public:
  FrameWriter(const Capture& capture, fs::path folder, const Progress& progress)
      : capture_(capture), folder_(std::move(folder)), progress_(progress) {}

  Result<void> add(const VideoFrame& frame) {
    if (count_ >= capture_.frames.size() || frame.index != capture_.frames[count_].frame) return changed();
    const CaptureFrame& wanted = capture_.frames[count_];
    const SquareCrop& c = capture_.crop;
    const PixelRect& film = capture_.film;
    const auto cut = [&](const Image8& picture) {
      if (picture.empty()) return Image8();
      return film.empty() ? crop(picture, c.x, c.y, c.side, c.side)
                          : crop(crop(picture, film), c.x - film.x, c.y - film.y, c.side, c.side);
    };
    if (wanted.used || wanted.held_out) batch_.push_back({frame.index, cut(frame.rgb), cut(frame.alpha)});
    if (batch_.size() == kBatch) {
      if (auto flushed = flush(); !flushed) return flushed;
    }
    ++count_;
    progress_.report(double(count_) / double(capture_.frames.size()),
                     fmt::format("Writing picture {} of {}", count_, capture_.frames.size()));
    return {};
  }
  Result<void> finish() { return count_ == capture_.frames.size() ? flush() : changed(); }

 private:
  struct Waiting {
    int frame = 0;
    Image8 picture, alpha;  // the crop, at the source's size; no alpha: empty
  };

  Result<void> changed() const {
    return refused(ErrorCode::failed, capture_.video, "The video changed while it was being imported.",
                   "Import it again once nothing else writes to it.");
  }
  Result<void> flush() {
    std::vector<Result<void>> results(batch_.size());
    parallel_for(batch_.size(), [&](std::size_t i) {
      Image8 picture = resize(batch_[i].picture, capture_.size, capture_.size);
      fill_outside(picture, capture_.inside, kUnfilmed);
      results[i] = write_image(folder_ / frame_name(batch_[i].frame).filename(), picture, {.png_level = 1});
      if (!results[i] || batch_[i].alpha.empty()) return;
      Image8 alpha = resize(batch_[i].alpha, capture_.size, capture_.size);
      fill_outside(alpha, capture_.inside, 0);
      results[i] = write_image(folder_ / alpha_name(batch_[i].frame).filename(), alpha, {.png_level = 1});
    });
    batch_.clear();
    for (auto& result : results) {
      if (!result) return result;
    }
    return {};
  }

  const Capture& capture_;
  fs::path folder_;
  Progress progress_;
  std::vector<Waiting> batch_;
  std::size_t count_ = 0;
};

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
    case Split::sides:
      hold_out_sides(frames, options.sides, options.held_out_share);
      return judge_sides(frames, options.sides, video.string());
  }
  return {};
}

// What of the scan lies in the shots that serve.
struct ServingPart {
  ClipScan scan;
  std::vector<char> repeats;  // of its frames (repeated_frames.h), in the rhythm of the whole film
};

ServingPart serving_part(const ClipScan& whole, const std::vector<FrameSpan>& spans) {
  ServingPart part;
  part.scan.info = whole.info;
  part.scan.fault = whole.fault;
  const std::vector<char> repeats = repeated_frames(whole.difference);
  for (std::size_t i = 0; i < whole.frames.size(); ++i) {
    if (span_of(spans, whole.frames[i].frame) < 0) continue;
    part.scan.frames.push_back(whole.frames[i]);
    part.scan.change.push_back(whole.change[i]);
    part.repeats.push_back(repeats[i]);
  }
  std::ranges::copy_if(whole.samples, std::back_inserter(part.scan.samples),
                       [&](const FaceSample& sample) { return span_of(spans, sample.frame) >= 0; });
  return part;
}

// Why a frame outside the shots that serve does not train.
std::string outside_words(const std::vector<ClipShot>& shots, int frame) {
  for (const ClipShot& shot : shots)
    if (frame >= shot.first && frame <= shot.last)
      return fmt::format("In another shot ({}): {}.", span_words(shot.from_s, shot.to_s), shot.reason);
  return "In a fade or dissolve.";
}

// The frames that serve in their places among all.
void put_serving(const std::vector<CaptureFrame>& serving, Capture& capture) {
  auto next = serving.begin();
  for (CaptureFrame& frame : capture.frames) {
    if (next != serving.end() && next->frame == frame.frame)
      frame = *next++;
    else
      frame.refused = outside_words(capture.shots, frame.frame);
  }
}

// capture: with frames, shots and film. info: of the whole picture.
Result<Capture> make_capture(const fs::path& video, const ClipScan& whole, Capture capture,
                             const VideoInfo& info, const ImportOptions& options) {
  auto [scan, repeats] = serving_part(whole, spans_where_cut(capture));
  const auto faces = judge_clip(scan, capture.shots, capture.seconds, video);
  if (!faces) return faces.error();
  std::error_code ignored;
  capture.video = fs::absolute(video, ignored);
  auto hash = hash_video(video);
  if (!hash) return hash.error();
  capture.video_hash = *hash;
  capture.width = info.width;
  capture.height = info.height;
  capture.frames_per_second = scan.info.frames_per_second;
  capture.size = options.size;
  capture.split = options.split;
  if (options.split == Split::sides) {
    capture.sides = options.sides;
    fill_in_views(scan.frames, scan.samples);
  }
  if (const auto held = hold_out(scan.frames, options, video); !held) return held.error();
  choose_training_frames(scan.frames, scan.samples, scan.change, repeats, options);
  put_serving(scan.frames, capture);
  const auto training = std::count_if(capture.frames.begin(), capture.frames.end(),
                                      [](const CaptureFrame& f) { return f.used; });
  if (training < std::min(kFewestTraining, options.max_frames)) {
    return refused(ErrorCode::bad_input, video,
                   fmt::format("Only {} of {} frames show a sharp face.", training, scan.frames.size()),
                   is_photos(video) ? "Take them again in brighter light, holding still."
                                    : "Film again in brighter light and move more slowly.");
  }
  const PixelRect filmed =
      capture.film.empty() ? PixelRect{0, 0, capture.width, capture.height} : capture.film;
  const CropChoice crop = choose_crop(*faces, filmed);
  capture.crop = crop.crop;
  capture.inside = filmed_part(capture.crop, filmed, capture.size);
  capture.warnings = warnings_about(capture, scan, crop, faces->size());
  return capture;
}

struct FirstLook {
  ClipScan scan;
  PixelRect found;                                  // what was filmed of the pictures looked at; empty: all
  std::unique_ptr<HeadViewFinder> views = nullptr;  // where the split asks for them
};

// Where the face is, how sharp and how much moved in every frame, within the film as far as it is known.
Result<FirstLook> look_once(VideoReader& reader, const FaceDetector& detector, const PixelRect& film,
                            const ImportListeners& listeners, Split split, const Progress& progress,
                            std::stop_token stop) {
  FaceLookout lookout;
  std::unique_ptr<HeadViewFinder> views;
  if (split == Split::sides) {
    views = std::make_unique<HeadViewFinder>(reader.info(), detector);
    lookout = [&views](const VideoFrame& frame, const FaceSample& sample) { views->look(frame, sample); };
  }
  ClipScanner scanner(reader.info(), detector, lookout, progress);
  FilmFinder finder(reader.info());
  std::vector<FrameListener> all{scanner.listener(), {VideoPixels::luma, [&](const VideoFrame& frame) {
                                                        finder.add(frame);
                                                        return Result<void>();
                                                      }}};
  if (listeners.looking) {
    auto others = listeners.looking(reader.info(), film);
    if (!others) return others.error();
    std::ranges::move(*others, std::back_inserter(all));
  }
  if (const auto ready = reader.rewind(pixels_for(all)); !ready) return ready.error();
  if (const auto decoded = decode_for(reader, all, stop); !decoded) return decoded.error();
  return FirstLook{scanner.take(film), finder.film(), std::move(views)};
}

// First pass. Where bars are found it is made again within them: a blurred copy shows the face again, and
// what rests in the picture is not the room. film: of the source, empty: all of it.
Result<ClipScan> look_at_clip(VideoReader& reader, const FaceDetector& detector,
                              const ImportListeners& listeners, Split split, bool photographs,
                              PixelRect& film, const Progress& progress, std::stop_token stop) {
  constexpr int kDirections = 2;  // bars above and below, bars on both sides
  for (int bars = photographs ? kDirections : 0;; ++bars) {
    reader.show_part(film);
    auto look = look_once(reader, detector, film, listeners, split, progress, stop);
    if (!look) return look.error();
    if (look->found.empty() || bars == kDirections) {
      if (look->views)
        if (const auto put = look->views->put_into(look->scan.samples, {}, stop); !put) return put.error();
      return std::move(look->scan);
    }
    film = {film.x + look->found.x, film.y + look->found.y, look->found.width, look->found.height};
  }
}

// The film without the black that the reader puts round pictures of another shape, where all that serve have
// it.
PixelRect shown_part(const VideoReader& reader, const ClipScan& scan, const Capture& cut) {
  std::optional<int> shape;
  for (const ClipShot& shot : cut.shots) {
    if (!shot.used) continue;
    const auto first = std::ranges::lower_bound(scan.film, shot.first, {}, &FrameSketch::frame);
    if (first == scan.film.end() || first->shape != shape.value_or(first->shape)) return cut.film;
    shape = first->shape;
  }
  if (!shape || !reader.changed_shape()) return cut.film;
  const PixelRect whole{0, 0, reader.info().width, reader.info().height}, own = reader.shape_part(*shape);
  if (own == whole) return cut.film;
  return cut.film.empty() ? own : common_part(cut.film, own);
}

Result<void> write_pictures(VideoReader& reader, const Capture& capture, const ImportListeners& listeners,
                            const fs::path& folder, const Progress& progress, std::stop_token stop) {
  FrameWriter writer(capture, folder, progress);
  std::vector<FrameListener> all{
      {VideoPixels::rgb, [&](const VideoFrame& frame) { return writer.add(frame); }}};
  if (listeners.writing) {
    auto others = listeners.writing(reader.info(), capture);
    if (!others) return others.error();
    std::ranges::move(*others, std::back_inserter(all));
  }
  if (const auto ready = reader.rewind(pixels_for(all)); !ready) return ready.error();
  if (const auto decoded = decode_for(reader, all, stop); !decoded) return decoded.error();
  return writer.finish();
}

}  // namespace

Result<Capture> import_clip(const fs::path& video, const fs::path& folder, const ImportOptions& options,
                            const Progress& progress, std::stop_token stop) {
  return import_clip(video, folder, options, ImportListeners{}, progress, stop);
}

Result<Capture> import_clip(const fs::path& video, const fs::path& folder, const ImportOptions& asked,
                            const ImportListeners& listeners, const Progress& progress,
                            std::stop_token stop) {
  ImportOptions options = asked;
  if (options.size < 64 || options.size > 2048 || options.max_frames < 1 || !(options.held_out_share >= 0) ||
      options.held_out_share > 0.5) {
    return refused(
        ErrorCode::bad_input, video,
        fmt::format("Import cannot work with pictures of {} px, {} frames and a held-out share of {:g}.",
                    options.size, options.max_frames, options.held_out_share),
        "Use a size of 256, 512 or 1024 px, at least one frame and a share of 0 to 0.5.");
  }
  const auto& [from_s, to_s] = options.seconds;
  if (!std::isfinite(from_s) || !std::isfinite(to_s) || from_s < 0 || to_s < 0 ||
      (to_s > 0 && to_s <= from_s))
    return refused(ErrorCode::bad_input, video,
                   fmt::format("From {:g} s to {:g} s there is nothing to read.", from_s, to_s),
                   "Choose a second to begin with and a later one to end with.");
  if (const auto& [inside_deg, beyond_deg] = options.sides;
      options.split == Split::sides && !(inside_deg > 0 && inside_deg < beyond_deg && beyond_deg < 180))
    return refused(ErrorCode::bad_input, video,
                   fmt::format("A frame cannot train within {:g} degrees and be held out beyond {:g}.",
                               inside_deg, beyond_deg),
                   "Choose a larger --beyond than --inside.");
  if (!options.seconds.whole() && is_photos(video))
    return refused(ErrorCode::bad_input, video, "Photographs have no seconds.",
                   "Put those that are to be read into a folder of their own.");
  auto reader = VideoReader::open(video, VideoPixels::both, VideoFrames::sampled);
  if (!reader) return reader.error();
  reader->show_seconds(options.seconds);
  if (const auto writable = make_writable_folder(folder); !writable) return writable.error();
  remove_abandoned_parts(folder, "frames");
  auto detector = FaceDetector::load(options.landmark_model);
  if (!detector) return detector.error();
  detector->keep_in(options.kept_faces);

  reader->keep_frames(options.memory.value_or(available_memory().value_or(0) / 3));
  PixelRect film;
  auto scan = look_at_clip(*reader, *detector, listeners, options.split, is_photos(video), film,
                           progress.stage(0, 0.6, "look"), stop);
  if (!scan) return scan.error();
  scan->fault = reader->fault();
  reader->show_part({});
  Capture cut;
  cut.film = film;
  cut.seconds = options.seconds;
  cut.frames = scan->frames;
  cut.shots = shots_of(*scan, film, is_photos(video));
  cut.film = shown_part(*reader, *scan, cut);
  scan->film.clear();
  if (listeners.moving) {
    auto moving = listeners.moving(stretches_that_serve(cut));
    if (!moving) return moving.error();
    options.moving = *moving;
  }
  auto capture = make_capture(video, *scan, std::move(cut), reader->info(), options);
  if (!capture) {
    Error error = capture.error();
    if (scan->fault) error.what = scan->fault->what + " " + error.what;
    return error;
  }
  if (is_photos(video))
    if (std::string unread = unread_pictures(video); !unread.empty()) capture->warnings.push_back(unread);
  if (reader->changed_shape())
    capture->warnings.push_back(
        "The picture changes its shape in the middle of the video, as where a phone is turned or a call "
        "becomes narrower: it is cut there.");
  if (reader->was_interlaced())
    capture->warnings.push_back(
        "The video is interlaced: half of the lines of what moves had to be made from the others. Set the "
        "camera to 25p or 30p instead of 50i or 60i.");

  WholeFolder frames(folder / "frames");
  if (const auto made = make_writable_folder(frames.temporary()); !made) return made.error();
  if (const auto written = write_pictures(*reader, *capture, listeners, frames.temporary(),
                                          progress.stage(0.6, 1, "write"), stop);
      !written) {
    return written.error();
  }
  if (const auto committed = frames.commit(); !committed) return committed.error();
  progress.report(1);
  return capture;
}

}  // namespace likeness
