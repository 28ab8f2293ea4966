#include "core/track/clip_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "core/base/parallel.h"
#include "core/base/quantile.h"
#include "core/track/photo/face_look.h"
#include "core/video/decode_for.h"

namespace likeness {
namespace {

constexpr std::size_t kBatch = 24;        // frames decoded before faces are sought, in parallel
constexpr std::size_t kLookAhead = 4;     // frames a box may be smoothed with on the later side
constexpr int kBridge = 12;               // frames without a detection over which a box is carried
constexpr int kRecall = 60;               // frames for which a face's place is known to the detector
constexpr LandmarkEffort kEffort{8, 16};  // the second pass, after the dense poses, may take more
constexpr LandmarkEffort kGlance{4, 4};   // enough to know a person again
constexpr std::size_t kScanEvery = 8;     // frames; in between, one face is sought near its last place only
constexpr double kSamePerson = 0.6;       // correlation of looks above which a face that jumped is the same
constexpr double kCrowd = 0.35, kRival = 0.8;  // of the largest face's, the main person's width
constexpr double kWindow = 3.0;   // boxes' width round the last one that is searched before the whole picture
constexpr int kWindowSide = 320;  // px it is reduced to: the face is then 107 px wide
constexpr double kFaceSide = 960;  // px, longer side of the picture faces are sought in

// A frame waiting for its landmarks.
struct Pending {
  Image8 rgb;                  // region, at most kFaceSide
  std::vector<FaceBox> found;  // in its pixels
};

class ClipReader {
 public:
  ClipReader(const FaceDetector& detector, ClipFrames& clip) : detector_(detector), clip_(clip) {}

  void add(ClipFrame frame, Image8 face_picture) {
    clip_.frames.push_back(std::move(frame));
    pending_.push_back({std::move(face_picture), {}});
    raw_.emplace_back();
  }
  std::size_t waiting() const { return clip_.frames.size() - sought_; }

  // Seeks faces in the new frames; landmarks of those whose look-ahead is complete, or of all at the end.
  void advance(bool last, std::stop_token stop) {
    const std::size_t end = clip_.frames.size(), from = sought_;
    // Whole pictures first: they show whether there are several people, all of whom are then looked for
    // everywhere.
    const auto seek = [&](std::size_t k) {
      if (stop.stop_requested()) return;
      Pending& p = pending_[from + k - done_];
      ClipFrame& frame = clip_.frames[from + k];
      if (frame.shot < 0) return;
      if (k % kScanEvery != 0 && !crowd_[frame.held_out])
        p.found = seek_near(p.rgb, last_seen(from, frame.held_out, frame.shot));
      frame.scanned = p.found.empty();
      if (p.found.empty()) p.found = detector_.detect(p.rgb);
    };
    const std::size_t scans = (end - from + kScanEvery - 1) / kScanEvery;
    parallel_for(scans, [&](std::size_t s) { seek(s * kScanEvery); });
    note_crowd(from, end);
    parallel_for(end - from, [&](std::size_t k) {
      if (k % kScanEvery != 0) seek(k);
    });
    for (std::size_t i = from; i < end; ++i) choose(i);
    sought_ = end;
    const std::size_t ready = last ? end : end > kLookAhead ? end - kLookAhead : 0;
    if (ready <= done_) return;
    parallel_for(ready - done_, [&](std::size_t k) {
      if (!stop.stop_requested()) find_landmarks(done_ + k);
    });
    pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(ready - done_));
    done_ = ready;
  }

 private:
  // The last face of a shot before frame i. A training frame knows only training frames; a held-out one all
  // before it.
  const FaceBox* last_seen(std::size_t i, bool held_out, int shot, std::size_t reach = kBridge) const {
    for (std::size_t j = i; j-- > 0 && i - j <= reach && clip_.frames[j].shot == shot;)
      if (raw_[j] && (held_out || !clip_.frames[j].held_out)) return &*raw_[j];
    return nullptr;
  }

  // The detector on the surroundings of a box, several times faster than on the whole picture.
  std::vector<FaceBox> seek_near(const Image8& rgb, const FaceBox* before) const {
    if (!before) return {};
    const int side = static_cast<int>(std::lround(kWindow * before->width));
    if (side < kWindowSide || side * side > 0.8 * static_cast<double>(rgb.pixels())) return {};
    const int x = static_cast<int>(before->x + 0.5 * (before->width - side)),
              y = static_cast<int>(before->y + 0.5 * (before->height - side));
    const double s = static_cast<double>(side) / kWindowSide;
    const FaceBox inside{(before->x - x) / s, (before->y - y) / s, before->width / s, before->height / s, 0};
    std::vector<FaceBox> found =
        detector_.detect(resize(crop(rgb, x, y, side, side), kWindowSide, kWindowSide), &inside);
    for (FaceBox& b : found) b = {b.x * s + x, b.y * s + y, b.width * s, b.height * s, b.score};
    return found;
  }

  // Several faces in the scanned pictures. Training frames ask training frames only.
  void note_crowd(std::size_t from, std::size_t end) {
    if (end == from) return;
    bool crowd[2] = {};
    for (std::size_t i = from; i < end; i += kScanEvery) {
      const std::vector<FaceBox>& found = pending_[i - done_].found;
      double largest = 0;
      for (const FaceBox& b : found) largest = std::max(largest, b.width);
      const auto people = std::count_if(found.begin(), found.end(),
                                        [&](const FaceBox& b) { return b.width > kCrowd * largest; });
      crowd[1] |= people > 1;
      if (!clip_.frames[i].held_out) crowd[0] |= people > 1;
    }
    crowd_[0] = crowd[0], crowd_[1] = crowd[1];
  }

  FaceLook look_at(const Image8& rgb, const FaceBox& box) const {
    return face_look(rgb, detector_.landmarks(rgb, box, 0, nullptr, kGlance).points);
  }

  // How much a face is the main person's: known looks first, then its place before, then size and the middle.
  double claim(const Image8& rgb, const FaceBox& face, const FaceBox* before, double largest) const {
    double score = 0.5 * face.width / largest;
    if (before) {
      score += 0.5 * overlap(face, *before);
    } else {
      const double dx = face.x + 0.5 * face.width - 0.5 * rgb.width,
                   dy = face.y + 0.5 * face.height - 0.5 * rgb.height;
      score -= 0.5 * std::hypot(dx, dy) / std::hypot(0.5 * rgb.width, 0.5 * rgb.height);
    }
    if (!main_.values.empty()) score += 3 * alike(main_, look_at(rgb, face));
    return score;
  }

  void choose(std::size_t i) {
    ClipFrame& frame = clip_.frames[i];
    Pending& pending = pending_[i - done_];
    std::vector<FaceBox>& found = pending.found;
    if (frame.shot < 0) return;
    if (found.empty())
      if (const FaceBox* place = last_seen(i, frame.held_out, frame.shot, kRecall))
        found = detector_.detect(pending.rgb, place);
    if (found.empty()) return;
    const FaceBox* before = last_seen(i, frame.held_out, frame.shot);
    const FaceBox* face = &found.front();
    if (found.size() == 1) {
      if (before && overlap(*face, *before) < 0.15 && alike(main_, look_at(pending.rgb, *face)) < kSamePerson)
        return;  // somebody else, or a false hit: the person is carried over for a while
    } else {
      double largest = 0, best = -1e9;
      for (const FaceBox& b : found) largest = std::max(largest, b.width);
      for (const FaceBox& b : found)
        if (const double score = claim(pending.rgb, b, before, largest); score > best)
          best = score, face = &b;
    }
    raw_[i] = *face;
    frame.detected = true;
    for (const FaceBox& b : found) frame.rival |= &b != face && b.width > kRival * face->width;
    if (frame.held_out || (i % kScanEvery != 0 && found.size() == 1)) return;
    // The person's looks, a slow mean: lighting and pose change.
    const FaceLook look = look_at(pending.rgb, *face);
    if (look.values.empty()) return;
    if (main_.values.empty()) main_ = look;
    double norm = 0;
    for (std::size_t k = 0; k < look.values.size(); ++k) {
      main_.values[k] = 0.9F * main_.values[k] + 0.1F * look.values[k];
      norm += static_cast<double>(main_.values[k]) * main_.values[k];
    }
    if (norm > 0)
      for (float& v : main_.values) v /= static_cast<float>(std::sqrt(norm));
  }

  // The median of the boxes around, then their mean: the detector jumps between pyramid levels.
  std::optional<FaceBox> smooth_box(std::size_t i) const {
    const bool held_out = clip_.frames[i].held_out;
    std::vector<double> x, y, w;
    const auto use = [&](std::size_t j) {
      if (!raw_[j] || clip_.frames[j].shot != clip_.frames[i].shot ||
          (held_out ? j > i : clip_.frames[j].held_out))
        return;
      x.push_back(raw_[j]->x + 0.5 * raw_[j]->width);
      y.push_back(raw_[j]->y + 0.5 * raw_[j]->height);
      w.push_back(std::log(raw_[j]->width));
    };
    for (std::size_t reach = 2; reach <= kBridge && x.empty(); reach += 2)
      for (std::size_t j = i - std::min(i, reach);
           j <= std::min(raw_.size() - 1, i + std::min(reach, kLookAhead)); ++j)
        use(j);
    if (x.empty()) return std::nullopt;
    // The position follows the frame itself where it was seen; only the size is steadied strongly.
    double cx = median(x), cy = median(y);
    const double width = std::exp(median(w));
    if (raw_[i]) {
      const double dx = raw_[i]->x + 0.5 * raw_[i]->width - cx, dy = raw_[i]->y + 0.5 * raw_[i]->height - cy;
      const double limit = 0.15 * width, d = std::hypot(dx, dy);
      if (d < limit) cx += 0.5 * dx, cy += 0.5 * dy;
    }
    return FaceBox{cx - 0.5 * width, cy - 0.5 * width, width, width, raw_[i] ? raw_[i]->score : 0};
  }

  void find_landmarks(std::size_t i) {
    ClipFrame& frame = clip_.frames[i];
    const std::optional<FaceBox> box = smooth_box(i);
    if (!box) return;
    const Image8& rgb = pending_[i - done_].rgb;
    Landmarks found = detector_.landmarks(rgb, *box, 0, nullptr, kEffort);
    const double s = static_cast<double>(clip_.region.width) / rgb.width;
    const Vec2d corner(clip_.region.x, clip_.region.y);
    for (int k = 0; k < kLandmarkCount; ++k) {
      found.points[k] = found.points[k] * s + corner;
      found.spread[k] *= s;
    }
    frame.box = {box->x * s + corner.x(), box->y * s + corner.y(), box->width * s, box->height * s,
                 box->score};
    frame.landmarks = found;
  }

  const FaceDetector& detector_;
  ClipFrames& clip_;
  std::vector<std::optional<FaceBox>> raw_;  // every frame's own detection
  std::vector<Pending> pending_;             // of frames done_ ..
  std::size_t sought_ = 0, done_ = 0;
  FaceLook main_;       // the main person's, from training frames
  bool crowd_[2] = {};  // several people: known to training frames, to held-out ones
};

Image8 to_grey_image(const Image8& rgb) {
  if (rgb.channels == 1) return rgb;
  Image8 grey(rgb.width, rgb.height, 1);
  const std::uint8_t* p = rgb.data.data();
  for (std::uint8_t& g : grey.data) {
    g = static_cast<std::uint8_t>((77 * p[0] + 150 * p[1] + 29 * p[2] + 128) >> 8);
    p += rgb.channels;
  }
  return grey;
}

Image8 reduced_to(const Image8& image, double longer_side) {
  const double s = longer_side / std::max(image.width, image.height);
  const int w = std::max(1, static_cast<int>(std::lround(image.width * s))),
            h = std::max(1, static_cast<int>(std::lround(image.height * s)));
  return w == image.width && h == image.height ? image : resize(image, w, h);
}

// No frame yet, but what of the source is looked at.
Result<ClipFrames> empty_clip(const std::filesystem::path& video, const VideoInfo& info,
                              const TrackRegion& region, const TrackOptions& options) {
  ClipFrames clip;
  const int x0 = std::clamp(region.x, 0, info.width), y0 = std::clamp(region.y, 0, info.height);
  clip.region = {x0, y0, std::min(region.width, info.width - x0), std::min(region.height, info.height - y0)};
  if (region.width <= 0 || region.height <= 0) clip.region = {0, 0, info.width, info.height};
  if (clip.region.width < 64 || clip.region.height < 64)
    return Error{ErrorCode::bad_input,
                 fmt::format("The region to track is {} x {} px in a picture of {} x {}.", clip.region.width,
                             clip.region.height, info.width, info.height),
                 "Choose a region of at least 64 px inside the picture.", video.string()};
  clip.scale = static_cast<double>(options.working_size) / std::max(clip.region.width, clip.region.height);
  return clip;
}

Image8 part_of(const VideoFrame& source, const TrackRegion& region) {
  return source.rgb.width == region.width && source.rgb.height == region.height
             ? source.rgb
             : crop(source.rgb, region.x, region.y, region.width, region.height);
}

ClipFrame grey_frame(const VideoFrame& source, const Image8& part, const std::set<int>& held_out,
                     const TrackOptions& options) {
  ClipFrame frame;
  frame.frame = source.index;
  frame.time_s = source.time_s;
  frame.held_out = held_out.contains(source.index);
  frame.shot = span_of(options.shots, source.index);
  frame.grey = to_grey_image(reduced_to(part, options.working_size));
  return frame;
}

}  // namespace

struct ClipFollower::State {
  State(FaceDetector loaded, std::filesystem::path path, std::set<int> numbers, TrackOptions chosen,
        ClipFrames empty)
      : detector(std::move(loaded)),
        video(std::move(path)),
        held_out(std::move(numbers)),
        options(std::move(chosen)),
        clip(std::move(empty)),
        faces(detector, clip) {}

  FaceDetector detector;
  std::filesystem::path video;
  std::set<int> held_out;
  TrackOptions options;
  ClipFrames clip;
  ClipReader faces;
};

ClipFollower::ClipFollower(std::unique_ptr<State> state) : state_(std::move(state)) {}
ClipFollower::~ClipFollower() = default;
ClipFollower::ClipFollower(ClipFollower&&) noexcept = default;
ClipFollower& ClipFollower::operator=(ClipFollower&&) noexcept = default;

Result<ClipFollower> ClipFollower::create(const VideoInfo& info, const std::filesystem::path& video,
                                          const TrackRegion& region, const std::set<int>& held_out,
                                          const TrackOptions& options) {
  auto detector = FaceDetector::load(options.predictor);
  if (!detector) return detector.error();
  detector->keep_in(options.kept_work);
  auto empty = empty_clip(video, info, region, options);
  if (!empty) return empty.error();
  return ClipFollower(
      std::make_unique<State>(std::move(*detector), video, held_out, options, std::move(*empty)));
}

void ClipFollower::add(const VideoFrame& frame, const std::stop_token& stop) {
  State& s = *state_;
  const Image8 part = part_of(frame, s.clip.region);
  s.faces.add(grey_frame(frame, part, s.held_out, s.options),
              std::max(part.width, part.height) > kFaceSide ? reduced_to(part, kFaceSide) : part);
  if (s.faces.waiting() >= kBatch) s.faces.advance(false, stop);
}

Image8 ClipFollower::take_grey() { return std::exchange(state_->clip.frames.back().grey, {}); }

const ClipFrames& ClipFollower::so_far() const { return state_->clip; }

Result<ClipFrames> ClipFollower::finish(const std::stop_token& stop) {
  State& s = *state_;
  s.faces.advance(true, stop);
  if (stop.stop_requested()) return cancelled_error();
  if (s.clip.frames.empty())
    return Error{ErrorCode::bad_input, "The video holds no frame.", "Choose another video.",
                 s.video.string()};
  return std::move(s.clip);
}

Result<ClipFrames> read_clip_frames(const std::filesystem::path& video, const TrackRegion& region,
                                    const std::set<int>& held_out, const TrackOptions& options,
                                    const Progress& progress, std::stop_token stop) {
  auto reader = VideoReader::open(video, VideoPixels::rgb,
                                  options.every_frame ? VideoFrames::all : VideoFrames::sampled);
  if (!reader) return reader.error();
  if (options.part) reader->start_at(options.part->first), reader->end_at(options.part->last);
  const VideoInfo info = reader->info();
  auto follower = ClipFollower::create(info, video, region, held_out, options);
  if (!follower) return follower.error();
  const auto look = [&](const VideoFrame& frame) {
    follower->add(frame, stop);
    const std::size_t count = follower->so_far().frames.size();
    if (count % kBatch == 0)
      progress.report(info.frame_count > 0 ? static_cast<double>(frame.index) / info.frame_count : 0.5,
                      fmt::format("faces in {} frames", count));
    return Result<void>();
  };
  const FrameListener listener{VideoPixels::rgb, look};
  if (const auto decoded = decode_for(*reader, {&listener, 1}, stop); !decoded) return decoded.error();
  auto clip = follower->finish(stop);
  if (clip) progress.report(1);
  return clip;
}

Result<ClipFrames> read_grey_frames(const std::filesystem::path& video, const TrackRegion& region,
                                    const std::set<int>& held_out, const TrackOptions& options, int first,
                                    int last, const Progress& progress, std::stop_token stop) {
  auto reader = VideoReader::open(video, VideoPixels::rgb,
                                  options.every_frame ? VideoFrames::all : VideoFrames::sampled);
  if (!reader) return reader.error();
  auto clip = empty_clip(video, reader->info(), region, options);
  if (!clip) return clip.error();
  progress.report(0, "reading the pictures");
  constexpr int kLook = 32;  // frames passed over between two looks at the stop token
  for (int passed = kLook; passed < first; passed += kLook) {
    if (stop.stop_requested()) return cancelled_error();
    reader->start_at(passed);
    auto next = reader->next();
    if (!next) return next.error();
    if (!next->has_value() || (*next)->index >= first) break;
  }
  reader->start_at(first);
  while (true) {
    if (stop.stop_requested()) return cancelled_error();
    auto next = reader->next();
    if (!next) return next.error();
    if (!next->has_value() || (*next)->index > last) break;
    clip->frames.push_back(grey_frame(**next, part_of(**next, clip->region), held_out, options));
    progress.report(static_cast<double>((*next)->index - first + 1) / std::max(1, last - first + 1));
  }
  progress.report(1);
  return clip;
}

}  // namespace likeness
