// Listeners to import's decoding: see kept_decoding.h.
#include "core/project/kept_decoding.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/whole_folder.h"
#include "core/camera/align_options.h"
#include "core/camera/kept_path.h"
#include "core/face/landmarks.h"
#include "core/matte/coarse_mask.h"
#include "core/matte/person_network.h"
#include "core/project/staleness.h"
#include "core/track/kept_frames.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t kMaxKept = std::uint64_t(2) << 30;  // bytes, of one clip
constexpr std::uint64_t kShareOfDisk = 4;                   // a quarter of what is free, at most

std::uint64_t room_for_kept(const fs::path& folder) {
  std::error_code failure;
  const fs::space_info space = fs::space(folder, failure);
  return failure ? 0 : std::min<std::uint64_t>(kMaxKept, space.available / kShareOfDisk);
}

bool is_folder(const fs::path& video) {
  std::error_code ignored;
  return fs::is_directory(video, ignored);
}

// A failure to keep what a later stage can compute itself must not fail the import.
template <class Add>
FrameListener forgiving_listener(bool& failed, Add add) {
  return {VideoPixels::rgb, [&failed, add](const VideoFrame& frame) -> Result<void> {
            if (failed) return {};
            try {
              failed = !add(frame).ok();
            } catch (const std::exception&) {
              failed = true;
            }
            return {};
          }};
}

}  // namespace

fs::path decoded_path(const Project& project) { return project.folder / "decoded"; }

std::string mask_inputs(const AlignInputs& inputs) {
  std::string text = landmark_source_hash(inputs.landmark_model);
  if (text.empty()) text = "system";
  const std::string network = person_network_hash(inputs.person_network);
  return network.empty() ? text : text + " person network " + network;
}

struct KeptDecoding::State {
  State(const StageContext& given, std::shared_ptr<KeptWork> found)
      : context(given),
        kept(decoded_path(given.project)),
        faces(std::move(found)),
        photographs(is_folder(inputs().video)) {
    align.seed = int(given.inputs.align.seed);
    align.mask_inputs = mask_inputs(given.inputs.align);
  }

  const ImportInputs& inputs() const { return context.inputs.import; }
  bool split_asks() const { return inputs().choices.split == Split::views; }

  Result<std::vector<FrameListener>> looking(const VideoInfo& info, const PixelRect& film) {
    if (photographs || inputs().camera == CameraKind::resting) return std::vector<FrameListener>();
    const auto hash = hash_video(inputs().video);
    if (!hash) return hash.error();
    video_hash = *hash;
    meter.reset();  // of the whole picture, where bars were found in it
    meter_failed = false;
    align.film = film;
    motion_key = motion_inputs(*hash, align);
    motion = kept_motion(decoded_path(context.project), motion_key);
    aligned = is_current_alone(context.project, Stage::align);
    auto mask = coarse_person_mask(context.inputs.align.landmark_model, Pictures::in_sequence,
                                   context.inputs.align.person_network);
    if (!mask) return mask.error();
    person = std::move(*mask);
    if (motion || (aligned && !split_asks())) return std::vector<FrameListener>();
    meter.emplace(info, inputs().video, person, rest_limit(align));
    if (split_asks())
      return std::vector<FrameListener>{
          {VideoPixels::rgb, [this](const VideoFrame& frame) { return meter->add(frame); }}};
    return std::vector<FrameListener>{
        forgiving_listener(meter_failed, [this](const VideoFrame& frame) { return meter->add(frame); })};
  }

  Result<void> measure() {
    if (motion || !meter || meter_failed) return {};
    auto measured = meter->finish();
    background = meter->take_pictures();
    meter.reset();
    if (!measured) return measured.error();
    motion = std::move(*measured);
    return {};
  }

  // Where parts of a film are left out, what was measured over its cuts is no motion of the camera.
  Result<void> measure_again(const std::vector<FrameSpan>& stretches) {
    if (align.stretches == stretches) return {};
    align.stretches = stretches;
    motion_key = motion_inputs(video_hash, align);
    meter.reset();
    motion = kept_motion(decoded_path(context.project), motion_key);
    if (motion) return {};
    auto measured = measure_background_motion(inputs().video, person, rest_limit(align), {}, context.stop,
                                              &background, align.film, stretches);
    if (!measured) return measured.error();
    motion = std::move(*measured);
    return {};
  }

  // The frames that a moving camera filmed; nullopt: it rests, or is stated to.
  Result<std::optional<FrameSpan>> moving(const std::vector<FrameSpan>& stretches) {
    if (inputs().camera == CameraKind::resting) return std::optional<FrameSpan>{};
    if (photographs)  // each was taken from another place
      return std::optional<FrameSpan>(FrameSpan{0, std::numeric_limits<int>::max()});
    if (const auto measured = measure_again(stretches); !measured) return measured.error();
    if (const auto measured = measure(); !measured) return measured.error();
    if (!motion || motion->motion <= align.static_motion_px_per_1000) return std::optional<FrameSpan>{};
    const auto stretch = moving_stretch(*motion);
    if (!stretch) return std::optional<FrameSpan>{};
    return std::optional<FrameSpan>(FrameSpan{stretch->first, stretch->last});
  }

  Result<std::vector<FrameListener>> writing(const VideoInfo& info, const Capture& capture) {
    std::vector<FrameListener> listeners;
    // Parts that are left out were measured with the rest; align, which needs it, measures again.
    if (align.stretches != stretches_that_serve(capture)) motion.reset(), meter.reset();
    const auto measured = measure();
    if (!make_writable_folder(kept.temporary())) return listeners;
    made = true;
    std::uint64_t room = room_for_kept(context.project.folder);
    if (measured && motion) {
      if (!keep_motion(kept.temporary(), motion_key, *motion)) return listeners;
      keep_pictures(room);
      if (!aligned && needs_path(*motion, align)) listen_for_path(capture, room, listeners);
    }
    if (!fit_stays(capture)) listen_for_fit(info, capture, room, listeners);
    return listeners;
  }

  void keep_pictures(std::uint64_t& room) {
    if (aligned || background.grey.empty()) return;
    const std::uint64_t bytes = background.grey.size() * background.grey[0].data.size() +
                                background.person.size() * background.grey[0].data.size();
    if (bytes > room) return;
    if (keep_background(kept.temporary(), motion_key, background)) room -= bytes;
    background = {};
  }

  void listen_for_path(const Capture& capture, std::uint64_t& room, std::vector<FrameListener>& listeners) {
    const std::uint64_t bytes = PathPictures::expected_bytes(*motion, align);
    if (bytes > room) return;
    auto created = PathPictures::create(kept.temporary(), capture.video_hash, *motion, person, align);
    if (!created) return;
    room -= bytes;
    path.emplace(std::move(*created));
    listeners.push_back(forgiving_listener(path_failed, [this](const VideoFrame& frame) {
      if (align.film.empty()) return path->add(frame);
      return path->add({frame.index, frame.time_s, crop(frame.rgb, align.film)});
    }));
  }

  void listen_for_fit(const VideoInfo& info, const Capture& capture, std::uint64_t& room,
                      std::vector<FrameListener>& listeners) {
    TrackOptions options;
    options.predictor = context.inputs.fit.landmark_model;
    options.shots = spans_where_cut(capture);
    options.part = frames_of_seconds(capture);
    options.kept_work = faces;
    const std::uint64_t bytes = kept_clip_bytes(capture.frames.size(), options);
    if (bytes > room) return;
    const PixelRect part = tracked_part(capture);
    const TrackRegion region{part.x, part.y, part.width, part.height};
    const std::set<int> held_out = silent_frames(capture);
    const auto key = clip_frames_inputs(capture.video_hash, region, held_out, options);
    auto follower = ClipFollower::create(info, inputs().video, region, held_out, options);
    if (!key || !follower) return;
    std::vector<int> numbers;
    for (const CaptureFrame& frame : capture.frames) numbers.push_back(frame.frame);
    auto created = ClipFrameKeeper::create(kept.temporary(), *key, std::move(*follower), numbers);
    if (!created) return;
    room -= bytes;
    fit.emplace(std::move(*created));
    listeners.push_back(forgiving_listener(
        fit_failed, [this](const VideoFrame& frame) { return fit->add(frame, context.stop); }));
  }

  // Whether the track stays current: the new capture is the old one, to the letter.
  bool fit_stays(const Capture& capture) {
    if (!is_current_alone(context.project, Stage::fit)) return false;
    const fs::path again = kept.temporary() / "capture.json";
    const auto written = write_capture(again, capture);
    const auto now = read_text(again), before = read_text(capture_path(context.project));
    std::error_code ignored;
    fs::remove(again, ignored);
    return written && now && before && *now == *before;
  }

  void commit() {
    std::error_code ignored;
    if (path && (path_failed || !path->finish())) drop_path_pictures(kept.temporary());
    if (fit && (fit_failed || !fit->finish(context.stop))) drop_clip_frames(kept.temporary());
    path.reset();
    fit.reset();
    if (!made || !kept.commit()) fs::remove_all(decoded_path(context.project), ignored);
  }

  const StageContext& context;
  WholeFolder kept;
  std::shared_ptr<KeptWork> faces;
  bool made = false;  // kept's temporary folder
  AlignOptions align;
  const bool photographs;
  bool aligned = false;  // the cameras are current
  PersonMask person;
  std::string motion_key, video_hash;
  std::optional<MotionMeter> meter;
  std::optional<BackgroundMotion> motion;
  BackgroundPictures background;
  std::optional<PathPictures> path;
  std::optional<ClipFrameKeeper> fit;
  bool meter_failed = false, path_failed = false, fit_failed = false;
};

KeptDecoding::KeptDecoding(const StageContext& context, std::shared_ptr<KeptWork> faces)
    : state_(std::make_unique<State>(context, std::move(faces))) {}
KeptDecoding::~KeptDecoding() = default;

ImportListeners KeptDecoding::listeners() {
  ImportListeners listeners;
  listeners.looking = [this](const VideoInfo& info, const PixelRect& film) {
    return state_->looking(info, film);
  };
  if (state_->split_asks())
    listeners.moving = [this](const std::vector<FrameSpan>& stretches) { return state_->moving(stretches); };
  listeners.writing = [this](const VideoInfo& info, const Capture& capture) {
    return state_->writing(info, capture);
  };
  return listeners;
}

void KeptDecoding::commit() { state_->commit(); }

}  // namespace likeness
