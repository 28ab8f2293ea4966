// dlib's frontal HOG detector and its 68-point shape predictor, stabilised by a consensus of perturbed
// starts.
//
// One run of the predictor depends on its start box and jitters by several pixels from frame to frame; a bad
// start snaps the jaw to a collar. So it is run from 4 scales x up to 8 shifts of the box; the runs that
// agree best form a cluster, and each point is that cluster's trimmed mean, with the cluster's rms as its
// uncertainty. If the first few runs already agree, the others are skipped.
#include "core/face/landmarks.h"

#include <dlib/array2d.h>
#include <dlib/image_processing/frontal_face_detector.h>
#include <dlib/image_processing/shape_predictor.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <mutex>
#include <new>
#include <numbers>
#include <span>

#include "core/base/check.h"
#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/kept_work.h"
#include "core/base/program_files.h"
#include "core/base/quantile.h"
#include "core/face/network_landmarks.h"
#include "core/face/predictor_file.h"
#include "core/network/installed_networks.h"

namespace likeness {
namespace {

constexpr const char* kSystemPredictor = "/usr/share/dlib/shape_predictor_68_face_landmarks.dat";
constexpr const char* kBundledPredictor = "share/likeness/shape_predictor_68_face_landmarks.dat";
constexpr double kDetectionSide =
    1024;  // px; larger pictures are reduced first, faces of 80 px remain findable
// For faces where one was before. Of 107 pictures of nine people, six held a chance pattern with a higher
// score, none in the face's place; a bearded face with spectacles by lamplight scores below 0 in four of
// five.
constexpr double kMinScore = -0.5, kSamePlace = 0.35;
constexpr int kScales = 4, kShifts = 8;
constexpr double kCalmShare = 0.7, kCalmSpread = 0.012;  // of the runs, of the box's width: enough agreement

constexpr InstalledNetwork kFaceNetworks[] = {InstalledNetwork::face_detector, InstalledNetwork::face468,
                                              InstalledNetwork::iris};

using Grey = dlib::array2d<unsigned char>;
using Shape = std::array<Vec2d, kLandmarkCount>;

Grey to_grey(const Image8& picture, int width, int height) {
  Image8 reduced;
  const Image8* source = &picture;
  if (width != picture.width || height != picture.height) {
    reduced = resize(picture, width, height);
    source = &reduced;
  }
  Grey grey(height, width);
  for (int y = 0; y < height; ++y) {
    auto row = grey[y];
    const std::uint8_t* p = source->at(0, y);
    for (int x = 0; x < width; ++x, p += source->channels)
      row[x] = source->channels >= 3
                   ? static_cast<unsigned char>((77 * p[0] + 150 * p[1] + 29 * p[2] + 128) >> 8)
                   : p[0];
  }
  return grey;
}

// Inner points only: the jaw line is the least certain part and would split genuine clusters.
double shape_distance(const Shape& a, const Shape& b) {
  double sum = 0;
  for (int i = 17; i < kLandmarkCount; ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / (kLandmarkCount - 17));
}

// Start boxes on rings round a slightly raised centre: a bowed head needs a smaller, raised box. Every
// kScales consecutive boxes hold all scales, and even a few of them lie on different sides.
std::vector<FaceBox> perturbed_boxes(const FaceBox& box, std::uint32_t seed) {
  static constexpr double kScale[kScales] = {0.84, 0.93, 1.02, 1.11};
  static constexpr int kOrder[kShifts] = {0, 5, 2, 7, 4, 1, 6, 3};
  std::vector<FaceBox> boxes;
  for (int k : kOrder)
    for (int s = 0; s < kScales; ++s) {
      const double turn = (k + 0.25 * s + 0.1 * (seed % 10)) / kShifts * 2 * std::numbers::pi +
                          (s % 2 ? std::numbers::pi : 0);
      const double radius = (k % 2 ? 0.035 : 0.075) * box.width;
      FaceBox start;
      start.width = box.width * kScale[s];
      start.height = box.height * kScale[s];
      start.x = box.x + 0.5 * (box.width - start.width) + radius * std::cos(turn);
      start.y = box.y + 0.5 * (box.height - start.height) + radius * std::sin(turn) - 0.02 * box.height;
      boxes.push_back(start);
    }
  return boxes;
}

// Distance of a run from the hint over points that no expression moves: nose and eye corners.
double hint_distance(const Shape& run, const LandmarkHint& hint) {
  static constexpr int kRigid[] = {27, 28, 29, 30, 31, 33, 35, 36, 39, 42, 45};
  double sum = 0;
  for (int i : kRigid) sum += (run[i] - hint.points[i]).squaredNorm();
  return std::sqrt(sum / std::size(kRigid));
}

Landmarks consensus(const std::vector<Shape>& runs, double box_width, const LandmarkHint* hint) {
  const int n = static_cast<int>(runs.size());
  const double kernel = 0.02 * box_width;
  int centre = 0;
  double best = -1;
  for (int i = 0; i < n; ++i) {
    double density = 0;
    for (int j = 0; j < n; ++j) {
      const double d = shape_distance(runs[i], runs[j]) / kernel;
      density += std::exp(-0.5 * d * d);
    }
    if (hint) {
      const double d = hint_distance(runs[i], *hint) / hint->sigma;
      density *= 1e-6 + std::exp(-0.5 * std::min(d * d, 60.0));
    }
    if (density > best) best = density, centre = i;
  }
  std::vector<int> members;
  for (int i = 0; i < n; ++i)
    if (shape_distance(runs[centre], runs[i]) <= 2 * kernel) members.push_back(i);

  Landmarks result;
  result.runs = n;
  result.cluster_share = static_cast<double>(members.size()) / n;
  std::vector<std::pair<double, int>> by_distance(members.size());
  for (int p = 0; p < kLandmarkCount; ++p) {
    // The median is the centre; the furthest quarter is left out of the mean but not of the uncertainty.
    std::vector<double> xs, ys;
    for (int m : members) xs.push_back(runs[m][p].x()), ys.push_back(runs[m][p].y());
    const Vec2d centre(median(std::move(xs)), median(std::move(ys)));
    double spread = 0;
    for (std::size_t k = 0; k < members.size(); ++k) {
      const double d = (runs[members[k]][p] - centre).norm();
      by_distance[k] = {d, members[k]};
      spread += d * d;
    }
    std::sort(by_distance.begin(), by_distance.end());
    const std::size_t kept = std::max<std::size_t>(1, members.size() - members.size() / 4);
    Vec2d mean = Vec2d::Zero();
    for (std::size_t k = 0; k < kept; ++k) mean += runs[by_distance[k].second][p];
    result.points[p] = mean / static_cast<double>(kept);
    result.spread[p] = std::sqrt(spread / static_cast<double>(members.size()));
  }
  return result;
}

bool is_calm(const Landmarks& found, double box_width, const LandmarkHint* hint) {
  if (found.cluster_share < kCalmShare || inner_spread(found) > kCalmSpread * box_width) return false;
  return !hint || hint_distance(found.points, *hint) <= 2 * hint->sigma;
}

// What was found in a picture, as it is kept: 8 bytes a number.
std::string kept_numbers(std::span<const double> numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()};
}

std::vector<double> numbers_kept(const std::string& bytes) {
  std::vector<double> numbers(bytes.size() / sizeof(double));
  std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(double));
  return numbers;
}

std::string kept_boxes(const std::vector<FaceBox>& boxes) {
  std::vector<double> numbers;
  for (const FaceBox& b : boxes)
    for (const double n : {b.x, b.y, b.width, b.height, b.score}) numbers.push_back(n);
  return kept_numbers(numbers);
}

std::vector<FaceBox> boxes_kept(const std::string& bytes) {
  const std::vector<double> n = numbers_kept(bytes);
  std::vector<FaceBox> boxes;
  for (std::size_t i = 0; i + 5 <= n.size(); i += 5)
    boxes.push_back({n[i], n[i + 1], n[i + 2], n[i + 3], n[i + 4]});
  return boxes;
}

std::string kept_landmarks(const Landmarks& found) {
  std::vector<double> numbers{found.cluster_share, double(found.runs)};
  for (std::size_t k = 0; k < found.points.size(); ++k)
    for (const double n : {found.points[k].x(), found.points[k].y(), found.spread[k]}) numbers.push_back(n);
  return kept_numbers(numbers);
}

std::optional<Landmarks> landmarks_kept(const std::string& bytes) {
  const std::vector<double> n = numbers_kept(bytes);
  if (n.size() != 2 + 3 * kLandmarkCount) return std::nullopt;
  Landmarks found;
  found.cluster_share = n[0], found.runs = int(n[1]);
  for (std::size_t k = 0; k < found.points.size(); ++k)
    found.points[k] = {n[2 + 3 * k], n[3 + 3 * k]}, found.spread[k] = n[4 + 3 * k];
  return found;
}

std::string picture_text(const Image8& picture) {
  return fmt::format("{}x{}x{} {}", picture.width, picture.height, picture.channels,
                     hash_bytes(std::as_bytes(std::span(picture.data))));
}

std::string box_text(const FaceBox& b) {
  return fmt::format(" {} {} {} {} {}", b.x, b.y, b.width, b.height, b.score);
}

// Unpacking it takes longer than using it, so it is done once.
const dlib::frontal_face_detector& frontal_detector() {
  static const dlib::frontal_face_detector detector = dlib::get_frontal_face_detector();
  return detector;
}

}  // namespace

LandmarkSource landmark_source(const std::filesystem::path& choice) {
  if (choice == kNetworkLandmarks) return LandmarkSource::network;
  if (!choice.empty()) return LandmarkSource::dlib;
  const bool installed = std::ranges::all_of(
      kFaceNetworks, [](InstalledNetwork network) { return find_installed_network(network).ok(); });
  return installed ? LandmarkSource::network : LandmarkSource::dlib;
}

std::string landmark_source_hash(const std::filesystem::path& choice) {
  if (landmark_source(choice) == LandmarkSource::network) {
    std::string text = "network " + std::to_string(kNetworkLandmarksVersion);
    for (const InstalledNetwork network : kFaceNetworks) text += " " + installed_network_hash(network);
    return text;
  }
  if (choice.empty() || choice == kDlibLandmarks) return "";
  const auto hash = hash_file(choice);
  return hash ? *hash : "absent";
}

struct FaceDetector::Impl {
  std::optional<FaceNetwork> network;  // or
  dlib::shape_predictor predictor;
};

LandmarkSource FaceDetector::source() const {
  return impl_->network ? LandmarkSource::network : LandmarkSource::dlib;
}

FaceDetector::FaceDetector(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
FaceDetector::~FaceDetector() = default;
FaceDetector::FaceDetector(FaceDetector&&) noexcept = default;
FaceDetector& FaceDetector::operator=(FaceDetector&&) noexcept = default;

Result<FaceDetector> FaceDetector::load(const std::filesystem::path& choice) {
  if (landmark_source(choice) == LandmarkSource::network) {
    auto network = FaceNetwork::installed();
    if (!network) return network.error();
    auto impl = std::make_shared<Impl>();
    impl->network = std::move(*network);
    return FaceDetector(std::move(impl));
  }
  const std::filesystem::path predictor = choice == kDlibLandmarks ? std::filesystem::path() : choice;
  const std::filesystem::path path =
      predictor.empty() ? bundled_file(kBundledPredictor).value_or(kSystemPredictor) : predictor;
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    if (predictor.empty())
      return Error{
          ErrorCode::missing_dependency, "The face landmark model " + path.string() + " is not installed.",
          "Run packaging/networks for the face network, install the package libdlib-data (sudo apt install "
          "libdlib-data), or name another 68-point dlib model.",
          path.string()};
    return Error{ErrorCode::not_found, "The face landmark model " + path.string() + " does not exist.",
                 "Check the path, or leave it out to use the system's model (package libdlib-data).",
                 path.string()};
  }
  // The file is 100 MB: detectors of the same path share what was read.
  static std::mutex mutex;
  static std::filesystem::path loaded_path;
  static std::weak_ptr<const Impl> loaded;
  const std::lock_guard lock(mutex);
  if (auto impl = loaded.lock(); impl && loaded_path == path) return FaceDetector(std::move(impl));
  const auto unreadable = [&](const std::string& why) {
    return Error{
        ErrorCode::bad_input, "The landmark model could not be read: " + why,
        "Use an unpacked 68-point dlib shape predictor (.dat), or reinstall the package libdlib-data.",
        path.string()};
  };
  if (auto plain = check_not_endless(path); !plain) return plain.error();
  try {
    if (!predictor.empty()) {  // the system's is trusted, and reading it twice would take half a second
      std::ifstream file(path, std::ios::binary);
      if (const auto sound = check_predictor(file, std::filesystem::file_size(path)); !sound)
        return unreadable(sound.error().what);
    }
    auto impl = std::make_shared<Impl>();
    dlib::deserialize(path.string()) >> impl->predictor;
    if (impl->predictor.num_parts() != kLandmarkCount)
      return Error{ErrorCode::bad_input,
                   "The landmark model predicts " + std::to_string(impl->predictor.num_parts()) +
                       " points; 68 (iBUG order) are needed.",
                   "Use a 68-point dlib shape predictor.", path.string()};
    loaded_path = path;
    loaded = impl;
    return FaceDetector(std::move(impl));
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    return unreadable(e.what());
  }
}

std::vector<FaceBox> FaceDetector::detect(const Image8& rgb, const FaceBox* before) const {
  if (rgb.empty()) return {};
  if (!kept_) return seek_faces(rgb, before);
  std::string asked = "faces " + picture_text(rgb);
  if (before) asked += box_text(*before);
  if (const auto kept = kept_->find(asked)) return boxes_kept(*kept);
  std::vector<FaceBox> found = seek_faces(rgb, before);
  kept_->keep(asked, kept_boxes(found));
  return found;
}

Landmarks FaceDetector::landmarks(const Image8& rgb, const FaceBox& box, std::uint32_t seed,
                                  const LandmarkHint* hint, const LandmarkEffort& effort) const {
  LIKENESS_CHECK(!rgb.empty() && box.width > 0 && box.height > 0, "picture %dx%d, box %gx%g", rgb.width,
                 rgb.height, box.width, box.height);
  if (!kept_) return seek_landmarks(rgb, box, seed, hint, effort);
  std::string asked = fmt::format("landmarks {}{} {} {} {}", picture_text(rgb), box_text(box), seed,
                                  effort.first, effort.most);
  if (hint) {
    asked += fmt::format(" {}", hint->sigma);
    for (const Vec2d& p : hint->points) asked += fmt::format(" {} {}", p.x(), p.y());
  }
  asked = "landmarks " + hash_text(asked);
  if (const auto kept = kept_->find(asked))
    if (const auto found = landmarks_kept(*kept)) return *found;
  const Landmarks found = seek_landmarks(rgb, box, seed, hint, effort);
  kept_->keep(asked, kept_landmarks(found));
  return found;
}

std::vector<FaceBox> FaceDetector::seek_faces(const Image8& rgb, const FaceBox* before) const {
  if (impl_->network) return network_faces(*impl_->network, rgb, before);
  // dlib's detector finds faces of 80 px and more. Small pictures are enlarged so that 60 px suffice.
  const double longer = std::max(rgb.width, rgb.height);
  const double scale = longer > kDetectionSide ? kDetectionSide / longer : longer < 300 ? 1.5 : 1.0;
  std::vector<FaceBox> boxes;
  const auto detect_at = [&](double s) {
    const Grey grey = to_grey(rgb, std::max(1, static_cast<int>(std::lround(rgb.width * s))),
                              std::max(1, static_cast<int>(std::lround(rgb.height * s))));
    dlib::frontal_face_detector detector = frontal_detector();  // its scan keeps state: one copy a call
    std::vector<dlib::rect_detection> found;
    detector(grey, found, before ? kMinScore : 0.0);
    const double sx = static_cast<double>(rgb.width) / static_cast<double>(grey.nc()),
                 sy = static_cast<double>(rgb.height) / static_cast<double>(grey.nr());
    std::optional<FaceBox> doubted;  // in the place of the one before
    bool in_place = false;
    for (const auto& d : found) {
      const FaceBox box{d.rect.left() * sx, d.rect.top() * sy, static_cast<double>(d.rect.width()) * sx,
                        static_cast<double>(d.rect.height()) * sy, d.detection_confidence};
      const bool there = before && overlap(box, *before) >= kSamePlace;
      if (box.score >= 0) {
        boxes.push_back(box);
        in_place |= there;
      } else if (there && (!doubted || box.score > doubted->score)) {
        doubted = box;
      }
    }
    if (doubted && !in_place) boxes.push_back(*doubted);
  };
  try {
    detect_at(scale);
    if (boxes.empty() && scale <= 1) detect_at(std::min(1.5, scale * 2));  // small faces
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {
    return {};  // dlib throws only when out of memory here; no face is then the best answer
  }
  std::sort(boxes.begin(), boxes.end(), [](const FaceBox& a, const FaceBox& b) { return a.score > b.score; });
  return boxes;
}

Landmarks FaceDetector::seek_landmarks(const Image8& rgb, const FaceBox& box, std::uint32_t seed,
                                       const LandmarkHint* hint, const LandmarkEffort& effort) const {
  if (impl_->network) return network_landmarks(*impl_->network, rgb, box, hint, effort);
  // Only the surroundings of the face are converted; faces over 300 px are reduced, as the predictor gains
  // nothing from them.
  const int x0 = static_cast<int>(std::floor(box.x - 0.75 * box.width)),
            y0 = static_cast<int>(std::floor(box.y - 0.75 * box.height));
  const int w = static_cast<int>(std::ceil(2.5 * box.width)),
            h = static_cast<int>(std::ceil(2.5 * box.height));
  const double scale = std::min(1.0, 300.0 / box.width);
  const Image8 part = crop(rgb, x0, y0, w, h);
  const Grey grey = to_grey(part, std::max(1, static_cast<int>(std::lround(w * scale))),
                            std::max(1, static_cast<int>(std::lround(h * scale))));
  const double sx = static_cast<double>(grey.nc()) / w, sy = static_cast<double>(grey.nr()) / h;

  const std::vector<FaceBox> starts = perturbed_boxes(box, seed);
  const auto whole_rings = [&](int runs) {
    return std::clamp((runs + kScales - 1) / kScales * kScales, kScales, static_cast<int>(starts.size()));
  };
  const int most = whole_rings(effort.most), first = std::min(most, whole_rings(effort.first));
  std::vector<Shape> runs;
  const auto run_from = [&](const FaceBox& b) {
    const auto px = [](double v) { return static_cast<long>(std::lround(v)); };
    const dlib::rectangle start(px((b.x - x0) * sx), px((b.y - y0) * sy), px((b.x + b.width - x0) * sx) - 1,
                                px((b.y + b.height - y0) * sy) - 1);
    const dlib::full_object_detection shape = impl_->predictor(grey, start);
    // dlib counts from pixel centres; our pixel (0,0) covers [0,1] x [0,1].
    Shape points;
    for (int p = 0; p < kLandmarkCount; ++p)
      points[p] = Vec2d((static_cast<double>(shape.part(p).x()) + 0.5) / sx + x0,
                        (static_cast<double>(shape.part(p).y()) + 0.5) / sy + y0);
    runs.push_back(points);
  };
  while (static_cast<int>(runs.size()) < first) run_from(starts[runs.size()]);
  Landmarks found = consensus(runs, box.width, hint);
  if (first == most || is_calm(found, box.width, hint)) return found;
  while (static_cast<int>(runs.size()) < most) run_from(starts[runs.size()]);
  return consensus(runs, box.width, hint);
}

}  // namespace likeness
