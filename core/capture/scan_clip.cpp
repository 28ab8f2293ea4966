// First pass over a clip: see scan_clip.h.
#include "core/capture/scan_clip.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/capture/repeated_frames.h"

namespace likeness {
namespace {

constexpr double kSamplePeriod = 0.2;     // s between two looks for faces
constexpr double kComfortableFace = 140;  // px across; the detector needs about 80, more only costs time
constexpr double kFirstLook = 640, kLastLook = 1920;  // px of the longer side
constexpr double kComparableArea = 0.35;  // of the main face's, from which another counts as a second person
constexpr int kRecall = 10;               // looks for which the detector knows where a face was
constexpr double kSureScore = 0.4;        // of the detector; below it, chance patterns are common
constexpr int kSharpnessSide = 160;       // px

constexpr int kSketchSide = 24;  // px: small enough for noise to vanish, large enough for lips and gaze

double area(const FaceBox& box) { return box.width * box.height; }

std::vector<FaceBox> detect_at(const FaceDetector& detector, const Image8& picture, double scale,
                               const std::optional<FaceBox>& before) {
  const int width = std::max(1, int(std::lround(picture.width * scale)));
  const int height = std::max(1, int(std::lround(picture.height * scale)));
  const double sx = double(picture.width) / width, sy = double(picture.height) / height;
  std::optional<FaceBox> expected = before;
  if (expected)
    expected = FaceBox{before->x / sx, before->y / sy, before->width / sx, before->height / sy, 0};
  const FaceBox* place = expected ? &*expected : nullptr;
  const Image8 small =
      width == picture.width && height == picture.height ? Image8() : resize(picture, width, height);
  const auto look = [&](const FaceBox* at) { return detector.detect(small.empty() ? picture : small, at); };
  // The network only follows the face that was there before, and misses a second one beside it.
  const bool follows = detector.source() == LandmarkSource::network;
  std::vector<FaceBox> faces = look(follows ? nullptr : place);
  if (faces.empty() && follows && place) faces = look(place);
  for (FaceBox& face : faces) face.x *= sx, face.width *= sx, face.y *= sy, face.height *= sy;
  return faces;
}

// The largest of the sure faces; of several unsure ones the surest.
FaceSample judge(int frame, const std::vector<FaceBox>& faces) {
  FaceSample sample{frame, std::nullopt, false};
  for (const FaceBox& face : faces) {
    if (!sample.face) {
      sample.face = face;
      continue;
    }
    const bool surer = face.score >= kSureScore && sample.face->score < kSureScore;
    const bool larger = face.score >= kSureScore && area(face) > area(*sample.face);
    if (surer || larger) sample.face = face;
  }
  int comparable = 0;
  for (const FaceBox& face : faces)
    comparable += face.score >= kSureScore && area(face) > kComparableArea * area(*sample.face);
  sample.second_face = comparable >= 2;
  return sample;
}

// How the face changes from frame to frame, apart from its brightness.
class ChangeMeter {
 public:
  float add(const Image8& picture, const FaceBox& face) {
    const Image8 small =
        resize(crop(picture, int(std::lround(face.x)), int(std::lround(face.y)),
                    std::max(8, int(std::lround(face.width))), std::max(8, int(std::lround(face.height)))),
               kSketchSide, kSketchSide);
    std::vector<float> sketch(small.pixels());
    float mean = 0;
    for (std::size_t i = 0; i < sketch.size(); ++i)
      mean += sketch[i] = float(small.data[i * std::size_t(small.channels)]);
    for (float& value : sketch) value -= mean / float(sketch.size());
    float change = 0;
    if (!before_.empty())
      for (std::size_t i = 0; i < sketch.size(); ++i) change += std::abs(sketch[i] - before_[i]);
    before_ = std::move(sketch);
    return change / float(before_.size());
  }

 private:
  std::vector<float> before_;
};

// Looks at the scale at which the face was last of comfortable size; larger pictures are tried only when that
// fails.
class FaceFinder {
 public:
  explicit FaceFinder(const FaceDetector& detector) : detector_(detector) {}

  FaceSample look(const VideoFrame& frame) {
    const double longer = std::max(frame.rgb.width, frame.rgb.height);
    if (scale_ == 0) scale_ = std::min(1.0, kFirstLook / longer);
    if (++looks_since_ > kRecall) last_.reset();
    for (double scale = scale_; scale * longer < kLastLook + 0.5; scale *= 2) {
      const FaceSample sample = judge(frame.index, detect_at(detector_, frame.rgb, scale, last_));
      if (!sample.face) continue;
      last_ = sample.face, looks_since_ = 0;
      scale_ = std::clamp(kComfortableFace / sample.face->width, 160 / longer, kLastLook / longer);
      return sample;
    }
    scale_ = std::min(1.0, kFirstLook / longer);
    return {frame.index, std::nullopt, false};
  }

 private:
  const FaceDetector& detector_;
  double scale_ = 0;
  std::optional<FaceBox> last_;  // until kRecall looks have missed it
  int looks_since_ = 0;
};

}  // namespace

double face_sharpness(const Image8& picture, const FaceBox& face) {
  const int x = int(std::lround(face.x)), y = int(std::lround(face.y));
  const int width = std::max(8, int(std::lround(face.width))),
            height = std::max(8, int(std::lround(face.height)));
  const Image8 patch = resize(crop(picture, x, y, width, height), kSharpnessSide, kSharpnessSide);
  std::vector<float> luma(patch.pixels());
  for (std::size_t i = 0; i < luma.size(); ++i) {
    const std::uint8_t* p = patch.data.data() + i * patch.channels;
    luma[i] = patch.channels >= 3 ? 0.299f * p[0] + 0.587f * p[1] + 0.114f * p[2] : float(p[0]);
  }
  double sum = 0, squares = 0;
  for (int row = 1; row + 1 < kSharpnessSide; ++row) {
    for (int column = 1; column + 1 < kSharpnessSide; ++column) {
      const float* p = luma.data() + row * kSharpnessSide + column;
      const double laplacian = p[-1] + p[1] + p[-kSharpnessSide] + p[kSharpnessSide] - 4 * p[0];
      sum += laplacian, squares += laplacian * laplacian;
    }
  }
  const double count = double(kSharpnessSide - 2) * (kSharpnessSide - 2), mean = sum / count;
  return squares / count - mean * mean;
}

struct ClipScanner::State {
  State(const VideoInfo& info, const FaceDetector& detector, FaceLookout lookout, const Progress& shown)
      : look(std::move(lookout)), progress(shown), finder(detector), sketcher(info) {
    scan.info = info;
    // Looks by the frames read, which are some of a fast or long clip.
    const double rate = info.frames_per_second / sampling_stride(info);
    stride = std::size_t(std::max(1.0, std::round(kSamplePeriod * rate)));
  }

  void add(const VideoFrame& current) {
    if (scan.frames.size() % stride == 0) {
      scan.samples.push_back(finder.look(current));
      if (scan.samples.back().face) face = scan.samples.back().face;
      if (look) look(current, scan.samples.back());
    }
    CaptureFrame entry;
    entry.frame = current.index;
    entry.time_s = current.time_s;
    entry.sharpness = face ? face_sharpness(current.rgb, *face) : 0;
    scan.frames.push_back(std::move(entry));
    sketcher.add(current, face);
    scan.change.push_back(face ? meter.add(current.rgb, *face) : 0);
    scan.difference.push_back(difference.add(current.rgb));
    const int count = std::max(scan.info.frame_count, current.index + 1);
    progress.report(double(current.index + 1) / count,
                    fmt::format("Looking for the face: frame {} of {}", current.index + 1, count));
  }

  ClipScan scan;
  FaceLookout look;
  Progress progress;
  std::size_t stride = 1;
  FaceFinder finder;
  ChangeMeter meter;
  FilmSketcher sketcher;
  DifferenceMeter difference;
  std::optional<FaceBox> face;  // the last one found; it moves little within the sampling period
};

ClipScanner::ClipScanner(const VideoInfo& info, const FaceDetector& detector, FaceLookout look,
                         const Progress& progress)
    : state_(std::make_unique<State>(info, detector, std::move(look), progress)) {}
ClipScanner::~ClipScanner() = default;

FrameListener ClipScanner::listener() {
  return {VideoPixels::luma, [state = state_.get()](const VideoFrame& frame) {
            state->add(frame);
            return Result<void>();
          }};
}

ClipScan ClipScanner::take(const PixelRect& corner) {
  state_->scan.film = state_->sketcher.take();
  for (FaceSample& sample : state_->scan.samples)
    if (sample.face) sample.face->x += corner.x, sample.face->y += corner.y;
  return std::move(state_->scan);
}

Result<ClipScan> scan_clip(const std::filesystem::path& video, const FaceDetector& detector,
                           const FaceLookout& look, const PixelRect& film, const Progress& progress,
                           std::stop_token stop) {
  auto reader = VideoReader::open(video, VideoPixels::luma, VideoFrames::sampled);
  if (!reader) return reader.error();
  reader->show_part(film);
  ClipScanner scanner(reader->info(), detector, look, progress);
  const FrameListener listener = scanner.listener();
  if (const auto decoded = decode_for(*reader, {&listener, 1}, stop); !decoded) return decoded.error();
  ClipScan scan = scanner.take(film);
  scan.fault = reader->fault();
  return scan;
}

}  // namespace likeness
