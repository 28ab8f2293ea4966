// See landmark_sources.h.
#include "core/lab/truth/landmark_sources.h"

#include <algorithm>
#include <cmath>
#include <ctime>

#include "core/base/quantile.h"
#include "core/drive/live_tracker.h"
#include "core/face/landmarks.h"
#include "core/head/builtin_head.h"
#include "core/head/pose_head.h"
#include "core/lab/truth/track_truth.h"
#include "core/video/decode.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;
using Points = std::array<Vec2d, kLandmarkCount>;

constexpr int kFirstOfParts[kFaceParts + 1] = {17, 27, 36, 48, 68};
constexpr int kHalfStill = 4;       // frames on either side
constexpr double kStill = 0.004;    // a frame
constexpr int kFewest = 10;         // frames for a figure
constexpr double kOpenGap = 0.028;  // kOpenLips_m of a face with 90 mm between the corners
constexpr int kLookSide = 960;      // px, longer side that faces are sought in, as the tracker does
constexpr LandmarkEffort kEffort{8, 16};

int part_of(int point) {
  int part = 0;
  while (point >= kFirstOfParts[part + 1]) ++part;
  return part;
}

double eyes_of(const Points& p) { return std::max(1e-6, (p[45] - p[36]).norm()); }

Vec2d middle_of(const Points& p) {
  Vec2d sum = Vec2d::Zero();
  for (int k = kFirstOfParts[0]; k < kLandmarkCount; ++k) sum += p[k];
  return sum / (kLandmarkCount - kFirstOfParts[0]);
}

// Of the whole process: other work on the machine does not count.
double processor_ms() { return 1000.0 * double(std::clock()) / CLOCKS_PER_SEC; }

// What one source finds in the pictures, and its time.
struct Search {
  FoundPoints found;
  std::vector<double> detect_ms, landmarks_ms;
};
Search search(const FaceDetector& detector, const std::vector<Image8>& pictures, const Progress& progress,
              const std::stop_token& stop) {
  Search result;
  std::optional<FaceBox> before;
  for (std::size_t i = 0; i < pictures.size() && !stop.stop_requested(); ++i) {
    progress.report(double(i) / double(pictures.size()));
    const double start = processor_ms();
    const auto faces = detector.detect(pictures[i], before ? &*before : nullptr);
    const double seen = processor_ms();
    result.detect_ms.push_back(seen - start);
    result.found.emplace_back();
    before.reset();
    if (faces.empty()) continue;
    before = *std::ranges::max_element(faces, {}, &FaceBox::width);
    result.found.back() = detector.landmarks(pictures[i], *before, 0, nullptr, kEffort).points;
    result.landmarks_ms.push_back(processor_ms() - seen);
  }
  return result;
}

// The true points in px of pictures that are `scale` times the film's.
FoundPoints true_points(const TrackTruth& truth, const std::vector<int>& frames, double scale) {
  const HeadShape shape = shape_head(truth.model, truth.track.person);
  FoundPoints all(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const TrackedFrame* known = find_tracked(truth.track, frames[i]);
    const Camera* camera = find_camera(truth.cameras, frames[i]);
    if (!known || !camera) continue;
    const auto places =
        landmark_positions(truth.model, pose_head(truth.model, shape, known->pose.articulation));
    Points points;
    for (int k = 0; k < kLandmarkCount; ++k)
      points[k] = scale * project<double>(camera->intrinsics,
                                          Vec3d(camera->cam_from_world * known->pose.world_from_head *
                                                places[std::size_t(k)].cast<double>()));
    all[i] = points;
  }
  return all;
}

Result<void> run_live(const std::string& source, const HeadModel& model, const std::vector<Image8>& pictures,
                      double frames_per_second, SourceRow& row, const std::stop_token& stop) {
  auto tracker = LiveTracker::create(model, {.predictor = source});
  if (!tracker) return tracker.error();
  const double start = processor_ms();
  for (std::size_t i = 0; i < pictures.size() && !stop.stop_requested(); ++i)
    row.live_lost += tracker->next(pictures[i], double(i) / frames_per_second).status == FrameStatus::lost;
  row.live_fps = 1000 * double(pictures.size()) / std::max(1e-3, processor_ms() - start);
  return {};
}

}  // namespace

const char* face_part_name(FacePart part) {
  constexpr const char* kNames[kFaceParts] = {"brows", "nose", "lids", "lips"};
  return kNames[std::size_t(part)];
}

std::vector<bool> still_frames(const std::vector<FoundPoints>& of_sources) {
  const std::size_t n = of_sources.empty() ? 0 : of_sources.front().size();
  std::vector<bool> still(n, false);
  for (std::size_t i = kHalfStill; i + kHalfStill < n; ++i) {
    double speed = 0;
    bool known = true;
    for (const FoundPoints& found : of_sources) {
      for (std::size_t j = i - kHalfStill; j <= i + kHalfStill; ++j) known &= found[j].has_value();
      if (!known) break;
      // Of means over four frames, whose own tremble is small.
      Vec2d early = Vec2d::Zero(), late = Vec2d::Zero();
      for (int j = 1; j <= kHalfStill; ++j)
        early += middle_of(*found[i - std::size_t(j)]) / kHalfStill,
            late += middle_of(*found[i + std::size_t(j)]) / kHalfStill;
      speed += (late - early).norm() / (kHalfStill + 1) / eyes_of(*found[i]) / double(of_sources.size());
    }
    still[i] = known && speed < kStill;
  }
  return still;
}

std::array<std::optional<double>, kFaceParts> tremble(const FoundPoints& found,
                                                      const std::vector<bool>& still) {
  std::array<double, kFaceParts> sum{};
  int frames = 0;
  for (std::size_t i = 1; i + 1 < found.size(); ++i) {
    if (!still[i] || !found[i - 1] || !found[i] || !found[i + 1]) continue;
    ++frames;
    for (int k = kFirstOfParts[0]; k < kLandmarkCount; ++k) {
      const Vec2d second = (*found[i - 1])[k] - 2 * (*found[i])[k] + (*found[i + 1])[k];
      const int part = part_of(k);
      sum[std::size_t(part)] += second.squaredNorm() / 2 / (kFirstOfParts[part + 1] - kFirstOfParts[part]) /
                                std::pow(eyes_of(*found[i]), 2);
    }
  }
  std::array<std::optional<double>, kFaceParts> noise;
  if (frames >= kFewest)
    for (std::size_t p = 0; p < kFaceParts; ++p) noise[p] = std::sqrt(sum[p] / frames / 6);
  return noise;
}

PointErrors point_errors(const FoundPoints& found, const FoundPoints& truth) {
  PointErrors errors;
  for (int k = kFirstOfParts[0]; k < kLandmarkCount; ++k) {
    std::vector<double> x, y;
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (!found[i] || !truth[i]) continue;
      const double eyes = eyes_of(*truth[i]);
      const Vec2d along = ((*truth[i])[45] - (*truth[i])[36]) / eyes, down(-along.y(), along.x());
      const Vec2d apart = ((*found[i])[k] - (*truth[i])[k]) / eyes;
      x.push_back(apart.dot(along)), y.push_back(apart.dot(down));
    }
    if (x.empty()) continue;
    const Vec2d usual(median(std::vector<double>(x)), median(std::vector<double>(y)));
    const int part = part_of(k);
    const double share = 1.0 / double(x.size()) / (kFirstOfParts[part + 1] - kFirstOfParts[part]);
    for (std::size_t i = 0; i < x.size(); ++i) {
      errors.whole[std::size_t(part)] += share * Vec2d(x[i], y[i]).norm();
      errors.moving[std::size_t(part)] += share * (Vec2d(x[i], y[i]) - usual).norm();
    }
  }
  return errors;
}

MarkScore score_points(const FoundPoints& found, const std::vector<int>& frames,
                       const std::vector<FaceMark>& marks) {
  const auto gap = [](const Points& p, std::initializer_list<std::array<int, 2>> pairs) {
    double sum = 0;
    for (const auto& [upper, lower] : pairs) sum += (p[lower] - p[upper]).norm();
    return sum / double(pairs.size()) / eyes_of(p);
  };
  const auto lips = [&](const Points& p) { return gap(p, {{61, 67}, {62, 66}, {63, 65}}); };
  const auto lids = [&](const Points& p) { return gap(p, {{37, 41}, {38, 40}, {43, 47}, {44, 46}}); };
  std::vector<double> openings;
  for (const auto& points : found)
    if (points) openings.push_back(lids(*points));
  const double usual = openings.empty() ? 0 : median(std::move(openings));
  MarkScore score;
  for (const FaceMark& mark : marks) {
    const auto at = std::ranges::find(frames, mark.frame);
    if (at == frames.end()) continue;
    const auto& points = found[std::size_t(at - frames.begin())];
    const auto judge = [&](Marked mark_of, bool is, int& judged, std::vector<int>& wrong) {
      if (mark_of == Marked::unsure) return;
      ++judged;
      if (!points || is != (mark_of == Marked::yes)) wrong.push_back(mark.frame);
    };
    judge(mark.mouth_open, points && lips(*points) > kOpenGap, score.mouths, score.wrong_mouths);
    judge(mark.eyes_shut, points && lids(*points) < kShutLids * usual, score.eyes, score.wrong_eyes);
  }
  return score;
}

Result<std::vector<SourceRow>> study_landmark_sources(const fs::path& clip,
                                                      const std::vector<std::string>& sources,
                                                      const std::vector<FaceMark>& marks, int max_frames,
                                                      const Progress& progress, std::stop_token stop) {
  std::error_code ignored;
  const bool is_demo = fs::is_directory(clip, ignored) && fs::exists(clip / "demo.mp4", ignored);
  std::optional<TrackTruth> truth;
  if (is_demo) {
    auto known = read_track_truth(clip);
    if (!known) return known.error();
    truth = std::move(*known);
  }
  auto reader = VideoReader::open(is_demo ? clip / "demo.mp4" : clip);
  if (!reader) return reader.error();
  // -- The pictures, as large as the tracker looks at them.
  std::vector<Image8> pictures;
  std::vector<int> frames;
  double scale = 1;
  while (int(pictures.size()) < max_frames) {
    if (stop.stop_requested()) return cancelled_error();
    auto next = reader->next();
    if (!next) return next.error();
    if (!next->has_value()) break;
    const Image8& rgb = (**next).rgb;
    scale = std::min(1.0, double(kLookSide) / std::max(rgb.width, rgb.height));
    pictures.push_back(
        scale < 1 ? resize(rgb, int(std::lround(rgb.width * scale)), int(std::lround(rgb.height * scale)))
                  : rgb);
    frames.push_back((**next).index);
  }
  const HeadModel model = make_builtin_head();
  const double rate = reader->info().frames_per_second > 0 ? reader->info().frames_per_second : 25;
  std::vector<SourceRow> rows;
  std::vector<FoundPoints> of_sources;
  for (std::size_t s = 0; s < sources.size(); ++s) {
    const auto detector = FaceDetector::load(sources[s]);
    if (!detector) return detector.error();
    const double n = double(sources.size());
    Search search_of =
        search(*detector, pictures, progress.stage(double(s) / n, (double(s) + 0.6) / n, sources[s]), stop);
    SourceRow row{.clip = clip.stem().string(), .source = sources[s]};
    row.frames = int(pictures.size());
    row.lost = int(std::ranges::count_if(search_of.found, [](const auto& points) { return !points; }));
    row.detect_ms = search_of.detect_ms.empty() ? 0 : median(std::move(search_of.detect_ms));
    row.landmarks_ms = search_of.landmarks_ms.empty() ? 0 : median(std::move(search_of.landmarks_ms));
    if (const auto ran = run_live(sources[s], model, pictures, rate, row, stop); !ran) return ran.error();
    if (stop.stop_requested()) return cancelled_error();
    if (truth) row.errors = point_errors(search_of.found, true_points(*truth, frames, scale));
    if (!marks.empty()) row.marks = score_points(search_of.found, frames, marks);
    rows.push_back(std::move(row));
    of_sources.push_back(std::move(search_of.found));
  }
  const std::vector<bool> still = still_frames(of_sources);
  for (std::size_t s = 0; s < rows.size(); ++s) rows[s].tremble = tremble(of_sources[s], still);
  progress.report(1);
  return rows;
}

}  // namespace likeness
