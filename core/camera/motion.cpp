// Pyramidal Lucas-Kanade from an anchor frame (not from frame to frame: no drift), median displacement over
// the tracks.
#include "core/camera/motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <utility>

#include "core/base/quantile.h"
#include "core/video/decode_for.h"

namespace likeness {
namespace {

constexpr int kWorkingWidth = 480;
constexpr double kKeptMargin = 0.015;  // of the longer side: what a person moves until the next mask
constexpr int kKeptSide = 480, kKeptSideOfMany = 320;  // px, the longer one of the pictures that are kept
constexpr int kMany = 2400;                            // frames, which would take more than some 300 MB
constexpr double kTravelStep = 0.02, kLeap = 0.09;     // of the width
constexpr double kPersonMargin = 0.14;                 // of the side of a square with the mask's area
constexpr int kPatience =
    3;  // frames off its place after which a rest has ended; fewer are a glitch (an arm, a flash)

// Tracks features from an anchor frame and measures how far the background is from where it was there.
class AnchorTracker {
 public:
  // Median displacement since the anchor, px; nullopt when too few tracks are left.
  std::optional<double> displacement(const cv::Mat& grey, const cv::Mat& background) {
    follow(grey, background);
    if (anchor_points_.size() < std::size_t(kLeastTracks)) return std::nullopt;
    std::vector<double> lengths;
    for (std::size_t i = 0; i < anchor_points_.size(); ++i)
      lengths.push_back(cv::norm(points_[i] - anchor_points_[i]));
    return median(std::move(lengths));
  }
  void set_anchor(const cv::Mat& grey, const cv::Mat& background) {
    anchor_ = grey.clone();
    anchor_points_.clear();
    cv::goodFeaturesToTrack(grey, anchor_points_, 200, 0.01, grey.cols / 48.0, background, 5);
    // Noise has corners, too; a real one's smaller eigenvalue stands out from a flat wall's.
    cv::Mat strength;
    cv::cornerMinEigenVal(grey, strength, 5);
    std::erase_if(anchor_points_,
                  [&](const cv::Point2f& p) { return strength.at<float>(cv::Point(p)) < 2e-4f; });
    points_ = anchor_points_;
    started_with_ = anchor_points_.size();
  }
  // Median shift since the anchor, px; as displacement() left the tracks.
  cv::Point2d shift() const {
    std::vector<double> x, y;
    for (std::size_t i = 0; i < anchor_points_.size(); ++i) {
      x.push_back(points_[i].x - anchor_points_[i].x);
      y.push_back(points_[i].y - anchor_points_[i].y);
    }
    return x.empty() ? cv::Point2d() : cv::Point2d(median(std::move(x)), median(std::move(y)));
  }
  bool worn_out() const {
    return points_.size() < started_with_ * 0.5 || points_.size() < std::size_t(kLeastTracks);
  }
  std::size_t tracks() const { return points_.size(); }

 private:
  void follow(const cv::Mat& grey, const cv::Mat& background) {
    if (points_.empty()) return;
    std::vector<cv::Point2f> next = points_, back = anchor_points_;
    std::vector<unsigned char> found, returned;
    std::vector<float> error;
    const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.01);
    cv::calcOpticalFlowPyrLK(anchor_, grey, anchor_points_, next, found, error, {15, 15}, 3, until,
                             cv::OPTFLOW_USE_INITIAL_FLOW);
    cv::calcOpticalFlowPyrLK(grey, anchor_, next, back, returned, error, {15, 15}, 3, until,
                             cv::OPTFLOW_USE_INITIAL_FLOW);
    std::vector<cv::Point2f> kept_anchor, kept;
    const cv::Rect inside(0, 0, grey.cols, grey.rows);
    for (std::size_t i = 0; i < next.size(); ++i) {
      if (!found[i] || !returned[i] || cv::norm(back[i] - anchor_points_[i]) > 0.7) continue;
      const cv::Point pixel(cvRound(next[i].x), cvRound(next[i].y));
      if (!inside.contains(pixel) || !background.at<unsigned char>(pixel)) continue;
      kept_anchor.push_back(anchor_points_[i]);
      kept.push_back(next[i]);
    }
    anchor_points_ = std::move(kept_anchor);
    points_ = std::move(kept);
  }

  cv::Mat anchor_;
  std::vector<cv::Point2f> anchor_points_, points_;
  std::size_t started_with_ = 0;
};

// Variance of the Laplacian over the background.
double sharpness_of(const cv::Mat& grey, const cv::Mat& background) {
  cv::Mat laplacian;
  cv::Laplacian(grey, laplacian, CV_32F);
  cv::Scalar mean, deviation;
  cv::meanStdDev(laplacian, mean, deviation, background);
  return deviation[0] * deviation[0];
}

// The path so far and the rests, frame by frame.
class PathRecorder {
 public:
  PathRecorder(double rest_px, double per_px) : rest_px_(rest_px), per_px_(per_px) {}

  void add(int frame, const cv::Mat& grey, const cv::Mat& background, BackgroundMotion& out) {
    if (out.frames.empty()) begin(frame, grey, background);
    const auto moved = tracker_.displacement(grey, background);
    tracks_ += double(tracker_.tracks());
    const double displacement = carried_ + moved.value_or(last_displacement_);
    last_displacement_ = moved.value_or(last_displacement_);
    out.frames.push_back({frame, (base_ + displacement) * per_px_, 0, sharpness_of(grey, background)});
    if (displacement <= rest_px_) {
      last_good_ = frame;
      misses_ = 0;
      // Worn out by occlusion or light: new features, same rest.
      if (tracker_.worn_out()) {
        carried_ = displacement, last_displacement_ = 0;
        tracker_.set_anchor(grey, background);
      }
    } else if (++misses_ > kPatience || tracker_.worn_out()) {
      base_ += displacement;
      close(out);
      begin(frame, grey, background);
    }
  }
  void close(BackgroundMotion& out) const { out.rests.push_back({first_, last_good_}); }
  double tracks() const { return tracks_; }

 private:
  void begin(int frame, const cv::Mat& grey, const cv::Mat& background) {
    tracker_.set_anchor(grey, background);
    first_ = last_good_ = frame;
    carried_ = last_displacement_ = 0;
    misses_ = 0;
  }

  AnchorTracker tracker_;
  double rest_px_, per_px_;
  double base_ = 0, carried_ = 0, last_displacement_ = 0, tracks_ = 0;
  int first_ = 0, last_good_ = 0, misses_ = 0;
};

// How far the background has come, in px: steps of a set length, so that shaking about one place adds none.
class TravelRecorder {
 public:
  explicit TravelRecorder(double step_px, double leap_px) : step_px_(step_px), leap_px_(leap_px) {}

  double add(const cv::Mat& grey, const cv::Mat& background) {
    if (!started_) return anchor(grey, background), 0;
    const bool could_tell = tracker_.tracks() >= std::size_t(kLeastTracks);
    const auto moved = tracker_.displacement(grey, background);
    if (moved) {
      const cv::Point2d shift = tracker_.shift();
      if (shift != shift_) heading_ = shift - shift_;
      shift_ = shift;
      farthest_ = std::max(farthest_, *moved);
    } else if (could_tell) {
      farthest_ = std::max(farthest_, leap_px_);  // lost at once: a leap, or blur; it wants a keyframe
      if (const double length = cv::norm(heading_); length > 0) shift_ += heading_ * (leap_px_ / length);
    }
    const double now = base_ + farthest_;
    if (farthest_ >= step_px_ || tracker_.worn_out()) {
      base_ = now;
      base_place_ += shift_;
      anchor(grey, background);
    }
    return now;
  }

  // Where the background is, against its start, px.
  cv::Point2d place() const { return base_place_ + shift_; }

 private:
  void anchor(const cv::Mat& grey, const cv::Mat& background) {
    tracker_.set_anchor(grey, background);
    farthest_ = 0;
    shift_ = {};
    started_ = true;
  }

  AnchorTracker tracker_;
  double step_px_, leap_px_;
  double base_ = 0, farthest_ = 0;
  cv::Point2d base_place_, shift_, heading_;
  bool started_ = false;
};

// 255 = person, grown by `margin` px.
cv::Mat person_at(const Image8& mask, cv::Size size, int margin) {
  cv::Mat person(size, CV_8U, cv::Scalar(0));
  if (mask.empty()) return person;
  const cv::Mat full(mask.height, mask.width, CV_8U, const_cast<std::uint8_t*>(mask.data.data()));
  cv::resize(full, person, size, 0, 0, cv::INTER_AREA);
  if (margin < 0) margin = int(kPersonMargin * std::sqrt(double(cv::countNonZero(person))));
  cv::dilate(person, person, cv::getStructuringElement(cv::MORPH_RECT, {2 * margin + 1, 2 * margin + 1}));
  return person != 0;
}

Image8 copied(const cv::Mat& grey) {
  Image8 picture(grey.cols, grey.rows, 1);
  for (int y = 0; y < grey.rows; ++y) std::copy_n(grey.ptr(y), grey.cols, picture.at(0, y));
  return picture;
}

}  // namespace

struct MotionMeter::State {
  State(const VideoInfo& info, std::filesystem::path path, std::function<Image8(int, const Image8&)> mask_of,
        double rest_px_per_1000)
      : video(std::move(path)),
        person(std::move(mask_of)),
        size(working_size(info)),
        kept_size(size_of_kept(info)),
        recorder(rest_px_per_1000 * size.width / 1000, 1000.0 / size.width),
        travel(kTravelStep * size.width, kLeap * size.width) {
    out.stride = sampling_stride(info);
    out.width = info.width;
    out.height = info.height;
  }

  static cv::Size working_size(const VideoInfo& info) {
    const double scale = std::min(1.0, double(kWorkingWidth) / info.width);
    return {std::max(16, int(std::lround(info.width * scale))),
            std::max(16, int(std::lround(info.height * scale)))};
  }

  static cv::Size size_of_kept(const VideoInfo& info) {
    const int side = info.frame_count / sampling_stride(info) > kMany ? kKeptSideOfMany : kKeptSide;
    const double scale = std::min(1.0, double(side) / std::max(info.width, info.height));
    return {std::max(16, int(std::lround(info.width * scale))),
            std::max(16, int(std::lround(info.height * scale)))};
  }

  void add(const VideoFrame& frame) {
    // OpenCV has no type for pixels that are only read.
    const cv::Mat rgb(frame.rgb.height, frame.rgb.width, CV_8UC3,
                      const_cast<std::uint8_t*>(frame.rgb.data.data()));
    cv::Mat grey, small;
    cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);
    cv::resize(grey, small, size, 0, 0, cv::INTER_AREA);
    cv::Mat kept;
    cv::resize(grey, kept, kept_size, 0, 0, cv::INTER_AREA);
    if (out.frames.size() % BackgroundPictures::kMaskEvery == 0 || background.empty()) {
      const Image8 mask = person ? person(frame.index, frame.rgb) : Image8();
      // A head that turns or nods leaves a coarse mask for a while, and a few features on hair are enough to
      // make a plain wall move: for them a margin costs nothing. A dense solve needs what background there
      // is.
      background = person_at(mask, size, -1) == 0;
      if (person)
        pictures.person.push_back(copied(
            person_at(mask, kept_size, int(kKeptMargin * std::max(kept_size.width, kept_size.height)))));
    }
    pictures.frames.push_back(frame.index);
    pictures.grey.push_back(copied(kept));
    recorder.add(frame.index, small, background, out);
    FrameMotion& entry = out.frames.back();
    entry.travel = travel.add(small, background) * 1000 / size.width;
    entry.x = travel.place().x * 1000 / size.width;
    entry.y = travel.place().y * 1000 / size.width;
    last_time = entry.time_s = frame.time_s;
  }

  std::filesystem::path video;
  std::function<Image8(int, const Image8&)> person;
  BackgroundMotion out;
  cv::Size size, kept_size;
  BackgroundPictures pictures;
  PathRecorder recorder;
  TravelRecorder travel;
  cv::Mat background;
  double last_time = 0;
};

MotionMeter::MotionMeter(const VideoInfo& info, const std::filesystem::path& video,
                         std::function<Image8(int, const Image8&)> person, double rest_px_per_1000)
    : state_(std::make_unique<State>(info, video, std::move(person), rest_px_per_1000)) {}
MotionMeter::~MotionMeter() = default;

Result<void> MotionMeter::add(const VideoFrame& frame) {
  try {
    state_->add(frame);
    return {};
  } catch (const cv::Exception& fault) {
    if (fault.code == cv::Error::StsNoMem) throw std::bad_alloc();
    return Error{ErrorCode::failed, fmt::format("The background could not be tracked: {}.", fault.what()),
                 "Convert the video to H.264 (`ffmpeg -i VIDEO out.mp4`) and try again.",
                 state_->video.string()};
  }
}

Result<BackgroundMotion> MotionMeter::finish() {
  BackgroundMotion out = std::move(state_->out);
  const double last_time = state_->last_time;
  if (out.frames.empty())
    return Error{ErrorCode::bad_input, "The video holds no frame.", "Choose another file.",
                 state_->video.string()};
  state_->recorder.close(out);
  out.seconds = last_time;
  out.tracks = state_->recorder.tracks() / double(out.frames.size());
  const double rate = last_time > 0 ? double(out.frames.back().frame) / last_time : 25;
  std::erase_if(out.rests, [&](const RestStretch& s) {
    return s.last - s.first + out.stride < std::max(8.0 * out.stride, rate);
  });
  std::vector<double> path;
  for (const auto& frame : out.frames) path.push_back(frame.path);
  out.motion = quantile(std::move(path), 0.95);
  return out;
}

BackgroundPictures MotionMeter::take_pictures() { return std::move(state_->pictures); }

Result<BackgroundMotion> measure_background_motion(const std::filesystem::path& video,
                                                   const std::function<Image8(int, const Image8&)>& person,
                                                   double rest_px_per_1000, const Progress& progress,
                                                   std::stop_token stop, BackgroundPictures* pictures,
                                                   const PixelRect& film,
                                                   const std::vector<FrameSpan>& stretches) {
  auto reader = VideoReader::open(video, VideoPixels::rgb, VideoFrames::sampled);
  if (!reader) return reader.error();
  reader->show_part(film);
  if (!stretches.empty()) reader->start_at(stretches.front().first), reader->end_at(stretches.back().last);
  const VideoInfo info = reader->info();
  MotionMeter meter(info, video, person, rest_px_per_1000);
  int count = 0;
  const FrameListener listener{VideoPixels::rgb, [&](const VideoFrame& frame) {
                                 if (span_of(stretches, frame.index) < 0) return Result<void>();
                                 auto added = meter.add(frame);
                                 if (++count % 10 == 0)
                                   progress.report(double(frame.index) / std::max(1, info.frame_count),
                                                   fmt::format("frame {}", frame.index));
                                 return added;
                               }};
  if (const auto decoded = decode_for(*reader, {&listener, 1}, stop); !decoded) return decoded.error();
  auto motion = meter.finish();
  if (pictures) *pictures = meter.take_pictures();
  if (motion) progress.report(1);
  return motion;
}

Sway measure_sway(const BackgroundMotion& motion) {
  Sway sway;
  if (motion.frames.empty()) return sway;
  // Along the axis on which the background strays most.
  std::vector<double> x, y;
  for (const FrameMotion& frame : motion.frames) x.push_back(frame.x), y.push_back(frame.y);
  constexpr double kUsual = 0.02;  // of the frames to either side are strays
  const auto span = [](const std::vector<double>& v) {
    return quantile(v, 1 - kUsual) - quantile(v, kUsual);
  };
  const double width = span(x), height = span(y);
  sway.reach = std::hypot(width, height);
  const std::vector<double>& along = width >= height ? x : y;
  const double low = quantile(along, kUsual), reach = std::max(width, height);
  int side = 0, crossings = 0;
  for (const double place : along) {
    const int now = place < low + 0.25 * reach ? -1 : place > low + 0.75 * reach ? 1 : 0;
    if (now == 0) continue;
    crossings += side != 0 && now != side;
    side = now;
  }
  // Parts of a film that are left out do not count.
  const double rate = motion.seconds > 0 ? motion.frames.back().frame / motion.seconds : 25;
  const double seconds = double(motion.frames.size()) * motion.stride / std::max(1e-9, rate);
  sway.crossings = crossings / std::max(1.0, seconds);
  return sway;
}

std::optional<MovingStretch> moving_stretch(const BackgroundMotion& motion) {
  std::optional<MovingStretch> longest;
  std::optional<MovingStretch> open;
  for (const FrameMotion& frame : motion.frames) {
    const bool rests = std::ranges::any_of(
        motion.rests, [&](const RestStretch& r) { return frame.frame >= r.first && frame.frame <= r.last; });
    if (rests) {
      open.reset();
      continue;
    }
    open = MovingStretch{open ? open->first : frame.frame, frame.frame};
    if (!longest || open->last - open->first > longest->last - longest->first) longest = open;
  }
  return longest;
}

bool is_shaking(const Sway& sway) {
  constexpr double kSweep = 120;   // 1/1000 of the width: less shows no side of a head that another does not
  constexpr double kRestless = 1;  // crossings a second: nobody walks round a head in a second
  return sway.reach < kSweep || sway.crossings > kRestless;
}

std::vector<int> choose_keyframes(const BackgroundMotion& motion, int count) {
  std::vector<int> chosen;
  if (motion.frames.empty() || count < 1) return chosen;
  const double total = motion.frames.back().travel;
  constexpr double kWide = 90, kNarrow = 35;  // 1/1000 of the width
  constexpr double kUsual = 20;               // keyframes that a short sweep is cut into
  const int slots =
      std::clamp(int(std::max(total / kWide, std::min(kUsual, total / kNarrow))), std::min(3, count), count);
  std::size_t begin = 0;
  for (int slot = 0; slot < slots; ++slot) {
    const double end_path = total * (slot + 1) / slots;
    std::size_t end = begin;
    while (end < motion.frames.size() && (motion.frames[end].travel < end_path || slot + 1 == slots)) ++end;
    if (end == begin) continue;  // the camera leapt over this slot
    const auto sharper = [](const FrameMotion& a, const FrameMotion& b) { return a.sharpness < b.sharpness; };
    const auto best =
        std::max_element(motion.frames.begin() + long(begin), motion.frames.begin() + long(end), sharper);
    chosen.push_back(best->frame);
    begin = end;
  }
  return chosen;
}

}  // namespace likeness
