// Learning the maps: places of the landmarks, random offsets around them, ridge regressions.
#include "core/train/landmark_patches.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/parallel.h"
#include "core/base/quantile.h"
#include "core/image/bilinear.h"
#include "core/render/patch_loss.h"
#include "core/train/random_stream.h"

namespace likeness {
namespace {

constexpr double kPatchWidth = 0.6;      // of the interocular distance
constexpr double kReach = 0.06;          // longest random shift, interocular distances
constexpr double kShear = 0.03;          // largest change of a patch's axes
constexpr double kNeighbourhood = 0.15;  // within which landmarks move alike, interocular distances
constexpr double kBrightness = 0.05;     // largest change of the contrast
constexpr double kNoise = 0.02;          // of a rendered picture's grey values
constexpr double kSoft_px = 1;           // of the softest patches
constexpr double kMinInterocular_px = 8;
constexpr int kDraws = 8;  // random offsets of a landmark in a view
constexpr std::size_t kMaxViews = 240, kMinViews = 8;
constexpr int kFolds = 4;
constexpr int kRightEyeCorner = 36, kLeftEyeCorner = 45, kRightEarPoint = 0, kLeftEarPoint = 16;

using PatchMatrix = Eigen::Matrix<double, kPatchRays, kPatchRays>;
using PatchRow = Eigen::Matrix<float, 1, kPatchRays>;
using Landmarks3 = std::array<Vec3f, kLandmarkCount>;

float grey_at(const Image8& image, int x, int y) {
  const std::uint8_t* p = image.at(x, y);
  return (kGreyOfRgb[0] * float(p[0]) + kGreyOfRgb[1] * float(p[1]) + kGreyOfRgb[2] * float(p[2])) / 255.f;
}

Image grey_picture(const Image8& rgb) {
  Image grey(rgb.width, rgb.height, 1);
  for (int y = 0; y < rgb.height; ++y)
    for (int x = 0; x < rgb.width; ++x) *grey.at(x, y) = grey_at(rgb, x, y);
  return grey;
}

// By a Gaussian of kSoft_px, whose tails are cut at two pixels.
Image softened(const Image& grey) {
  std::array<float, 5> kernel{};
  float sum = 0;
  for (int i = -2; i <= 2; ++i)
    sum += kernel[std::size_t(i + 2)] = float(std::exp(-0.5 * i * i / (kSoft_px * kSoft_px)));
  const auto along = [&](const Image& from, int dx, int dy) {
    Image to(from.width, from.height, 1);
    for (int y = 0; y < to.height; ++y)
      for (int x = 0; x < to.width; ++x)
        for (int i = -2; i <= 2; ++i)
          *to.at(x, y) +=
              kernel[std::size_t(i + 2)] / sum *
              *from.at(std::clamp(x + i * dx, 0, to.width - 1), std::clamp(y + i * dy, 0, to.height - 1));
    return to;
  };
  return along(along(grey, 1, 0), 0, 1);
}

// A view's landmarks: in the head's frame, m, and in the picture.
struct ViewLandmarks {
  Landmarks3 in_head{};
  std::array<Vec2d, kLandmarkCount> px{};
  std::array<float, kLandmarkCount> visibility{};
  double interocular_px = 0;  // as seen from the front; 0: the face is not before the camera
};

// Visible if in front of the head's middle and facing the camera. Coarse: a nose may still hide the far eye.
float visibility_of(const Vec3d& point, const Vec3d& middle) {
  constexpr double kHidden = 0.2, kSeen = 0.5;  // cosines
  const double facing = (point - middle).normalized().dot(-point.normalized());
  return float(std::clamp((facing - kHidden) / (kSeen - kHidden), 0.0, 1.0));
}

ViewLandmarks view_landmarks(const HeadModel& model, const HeadShape& shape, const TrainingView& view) {
  ViewLandmarks out;
  out.in_head = landmark_positions(model, pose_head(model, shape, view.pose.articulation));
  const Pose cam_from_head = view.camera.cam_from_world * view.pose.world_from_head;
  const auto in_camera = [&](int k) {
    return Vec3d(cam_from_head * out.in_head[std::size_t(k)].cast<double>());
  };
  const Vec3d middle = 0.5 * (in_camera(kRightEarPoint) + in_camera(kLeftEarPoint));
  for (int k = 0; k < kLandmarkCount; ++k) {
    const Vec3d p = in_camera(k);
    if (p.z() < 1e-3) return out;
    out.px[std::size_t(k)] = project(view.camera.intrinsics, p);
    out.visibility[std::size_t(k)] = visibility_of(p, middle);
  }
  const Vec3d right = in_camera(kRightEyeCorner), left = in_camera(kLeftEyeCorner);
  out.interocular_px = view.camera.intrinsics.fx * (right - left).norm() / (0.5 * (right + left)).z();
  return out;
}

// Whether a whole patch lies in the picture and is trained on.
bool is_whole(const TrainingView& view, const PatchPlace& place, int stride) {
  for (int i = 0; i < kPatchRays; ++i) {
    const PatchPixel p = patch_pixel(place, stride, i);
    if (p.x < 0 || p.y < 0 || p.x >= view.rgb.width || p.y >= view.rgb.height) return false;
    if (!view.teaches.empty() && view.teaches.at(p.x, p.y) == 0) return false;
  }
  return true;
}

std::vector<PatchPlace> places_in(const TrainingView& view, const ViewLandmarks& landmarks, int stride) {
  std::vector<PatchPlace> places;
  if (landmarks.interocular_px < kMinInterocular_px) return places;
  for (int k = kFirstPatchLandmark; k < kLandmarkCount; ++k) {
    const Vec2d& at = landmarks.px[std::size_t(k)];
    const PatchPlace place{k, int(std::floor(at.x())), int(std::floor(at.y())),
                           landmarks.visibility[std::size_t(k)]};
    if (place.visibility > 0 && is_whole(view, place, stride)) places.push_back(place);
  }
  return places;
}

// The value at x is read from the picture at c + axes (x - c) + shift.
struct PatchWarp {
  Eigen::Matrix2d axes = Eigen::Matrix2d::Identity();
  Vec2d shift = Vec2d::Zero();  // px
};

// How the landmarks around `at` would move, px, if the view's expression moved part of the way to another
// view's. A smooth field through the landmarks' displacements, and its slope.
PatchWarp expression_warp(const ViewLandmarks& view, const Landmarks3& other, const Pose& cam_from_head,
                          const Intrinsics& intrinsics, float way, const Vec2d& at) {
  std::array<Vec2d, kLandmarkCount> moves;
  for (std::size_t k = 0; k < moves.size(); ++k) {
    const Vec3f moved = view.in_head[k] + way * (other[k] - view.in_head[k]);
    const Vec3d p = cam_from_head * moved.cast<double>();
    moves[k] = p.z() < 1e-3 ? Vec2d::Zero().eval() : Vec2d(project(intrinsics, p) - view.px[k]);
  }
  const double width = kNeighbourhood * view.interocular_px;
  const auto field = [&](const Vec2d& x) {
    Vec2d sum = Vec2d::Zero();
    double weights = 1e-12;
    for (std::size_t k = 0; k < moves.size(); ++k) {
      const double w = std::exp(-0.5 * (x - view.px[k]).squaredNorm() / (width * width));
      sum += w * moves[k], weights += w;
    }
    return Vec2d(sum / weights);
  };
  PatchWarp warp;
  const Vec2d here = field(at);
  warp.axes.col(0) -= field(at + Vec2d::UnitX()) - here;
  warp.axes.col(1) -= field(at + Vec2d::UnitY()) - here;
  warp.shift = -here;
  return warp;
}

// One random offset: the patches' difference, its mean removed, and the landmark's displacement.
struct Example {
  PatchRow difference;
  Vec2f offset;  // interocular distances
};

struct ExampleSource {
  const std::vector<ViewLandmarks>& all;
  const TrainingSet& set;
  int stride = 1;
  std::uint64_t seed = 0;

  PatchWarp draw_warp(std::size_t view, const Vec2d& centre, bool expression, RandomStream& random) const {
    const ViewLandmarks& own = all[view];
    const double reach = kReach * own.interocular_px;
    PatchWarp warp;
    if (expression) {
      const std::size_t other = random.below(std::uint32_t(all.size()));
      const float way = random.uniform() - 0.5f;
      const TrainingView& of = set.views[view];
      warp = expression_warp(own, all[other].in_head, of.camera.cam_from_world * of.pose.world_from_head,
                             of.camera.intrinsics, way, centre);
      const double share = std::min(1.0, reach / std::max(1e-9, warp.shift.norm()));
      warp.shift *= share;
      warp.axes = Eigen::Matrix2d::Identity() + share * (warp.axes - Eigen::Matrix2d::Identity());
    }
    const double length = reach * std::sqrt(double(random.uniform()));
    const double angle = 2 * std::numbers::pi * double(random.uniform());
    warp.shift += length * Vec2d(std::cos(angle), std::sin(angle));
    for (int i = 0; i < 4; ++i) warp.axes(i / 2, i % 2) += kShear * (2 * double(random.uniform()) - 1);
    return warp;
  }

  Example draw(std::size_t view, const PatchPlace& place, int number, const Image& grey,
               const Image& soft) const {
    RandomStream random(seed ^ 0x1a4dull, view, std::uint64_t(place.landmark * kDraws + number));
    const Vec2d centre(place.x + 0.5, place.y + 0.5);
    const PatchWarp warp = draw_warp(view, centre, number % 2 == 1, random);
    const double softness = random.uniform();
    const double contrast = 1 + kBrightness * (2 * double(random.uniform()) - 1);
    Example example;
    for (int i = 0; i < kPatchRays; ++i) {
      const PatchPixel p = patch_pixel(place, stride, i);
      const Vec2d from = centre + warp.axes * (Vec2d(p.x + 0.5, p.y + 0.5) - centre) + warp.shift;
      const double value =
          (1 - softness) * bilinear(grey, from.x(), from.y()) + softness * bilinear(soft, from.x(), from.y());
      example.difference[i] = float(contrast * value) - *grey.at(p.x, p.y);
    }
    example.difference.array() -= example.difference.mean();
    // The centre has moved to where the warp reads it.
    example.offset = (-warp.axes.inverse() * warp.shift / all[view].interocular_px).cast<float>();
    return example;
  }
};

// The examples of one landmark, in the order of the views.
struct Examples {
  Eigen::Matrix<float, Eigen::Dynamic, kPatchRays, Eigen::RowMajor> differences;
  Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor> offsets;
};

std::vector<Examples> make_examples(const ExampleSource& source, std::span<const std::size_t> views,
                                    const std::vector<std::vector<PatchPlace>>& places) {
  std::vector<Examples> examples(kLandmarkCount);
  std::vector<Eigen::Index> count(kLandmarkCount, 0);
  std::vector<std::vector<Eigen::Index>> first(views.size());
  for (std::size_t i = 0; i < views.size(); ++i)
    for (const PatchPlace& place : places[views[i]]) {
      first[i].push_back(count[std::size_t(place.landmark)]);
      count[std::size_t(place.landmark)] += kDraws;
    }
  for (std::size_t k = 0; k < examples.size(); ++k)
    examples[k].differences.resize(count[k], kPatchRays), examples[k].offsets.resize(count[k], 2);
  parallel_for(views.size(), [&](std::size_t i) {
    const Image grey = grey_picture(source.set.views[views[i]].rgb), soft = softened(grey);
    for (std::size_t p = 0; p < first[i].size(); ++p) {
      const PatchPlace& place = places[views[i]][p];
      Examples& of = examples[std::size_t(place.landmark)];
      for (int n = 0; n < kDraws; ++n) {
        const Example example = source.draw(views[i], place, n, grey, soft);
        of.differences.row(first[i][p] + n) = example.difference;
        of.offsets.row(first[i][p] + n) = example.offset.transpose();
      }
    }
  });
  return examples;
}

// Sums that a ridge regression needs of some examples.
struct Normal {
  PatchMatrix squares = PatchMatrix::Zero();
  Eigen::Matrix<double, kPatchRays, 2> products = Eigen::Matrix<double, kPatchRays, 2>::Zero();
  double count = 0;

  void add(const Normal& other, double sign) {
    squares += sign * other.squares, products += sign * other.products, count += sign * other.count;
  }
  // (P^2, 2); noise on the pixels is the ridge.
  Eigen::Matrix<double, kPatchRays, 2> solve() const {
    PatchMatrix ridged = squares;
    ridged.diagonal().array() += std::max(1.0, count) * kNoise * kNoise;
    return ridged.llt().solve(products);
  }
};

// Folds are stretches of the clip: neighbouring pictures are nearly the same.
LandmarkMap learn_map(const Examples& examples) {
  const Eigen::Index count = examples.offsets.rows();
  LandmarkMap learnt;
  if (count < Eigen::Index(kMinViews) * kDraws) return learnt;
  const auto end = [&](int fold) { return count / kDraws * fold / kFolds * kDraws; };
  std::array<Normal, kFolds> folds;
  Normal all;
  for (int f = 0; f < kFolds; ++f) {
    const Eigen::Index first = end(f), rows = (f + 1 == kFolds ? count : end(f + 1)) - first;
    const Eigen::MatrixXd x = examples.differences.middleRows(first, rows).cast<double>();
    const Eigen::MatrixXd y = examples.offsets.middleRows(first, rows).cast<double>();
    folds[std::size_t(f)].squares = x.transpose() * x;
    folds[std::size_t(f)].products = x.transpose() * y;
    folds[std::size_t(f)].count = double(rows);
    all.add(folds[std::size_t(f)], 1);
  }
  double both = 0, predicted = 0, truth = 0, error = 0;
  for (int f = 0; f < kFolds; ++f) {
    Normal others = all;
    others.add(folds[std::size_t(f)], -1);
    const auto map = others.solve();
    const Eigen::Index first = end(f), rows = (f + 1 == kFolds ? count : end(f + 1)) - first;
    const Eigen::MatrixXd guess = examples.differences.middleRows(first, rows).cast<double>() * map;
    const Eigen::MatrixXd y = examples.offsets.middleRows(first, rows).cast<double>();
    both += guess.cwiseProduct(y).sum(), predicted += guess.squaredNorm(), truth += y.squaredNorm();
    error += (guess - y).squaredNorm();
  }
  learnt.correlation = both / std::max(1e-12, std::sqrt(predicted * truth));
  learnt.spread = std::sqrt(error / (2 * double(count)));
  if (learnt.correlation >= kMinCorrelation)
    learnt.weight = float(1 / (1 + std::pow(learnt.spread / kUsualSpread, 2)));
  const Eigen::Matrix<float, 2, kPatchRays, Eigen::RowMajor> map = all.solve().transpose().cast<float>();
  learnt.map.assign(map.data(), map.data() + map.size());
  return learnt;
}

// Evenly over the clip.
std::vector<std::size_t> learning_views(const std::vector<std::vector<PatchPlace>>& places) {
  std::vector<std::size_t> all, chosen;
  for (std::size_t v = 0; v < places.size(); ++v)
    if (!places[v].empty()) all.push_back(v);
  const std::size_t count = std::min(all.size(), kMaxViews);
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(all[i * all.size() / count]);
  return chosen;
}

Error unmeasurable(double interocular_px) {
  return {ErrorCode::failed,
          fmt::format("No landmark of the face can be measured by its patch of the training pictures, in "
                      "which the eyes are {:.0f} px apart.",
                      interocular_px),
          "Train without --landmark-loss, or with a larger --size.", "training"};
}

}  // namespace

int LandmarkPatches::accepted() const {
  return int(std::ranges::count_if(maps, [](const LandmarkMap& map) { return map.weight > 0; }));
}

std::vector<PatchPlace> patch_places(const HeadModel& model, const HeadShape& shape, const TrainingView& view,
                                     int stride) {
  return places_in(view, view_landmarks(model, shape, view), stride);
}

PatchPixel patch_pixel(const PatchPlace& place, int stride, int i) {
  return {place.x + stride * (i % kPatchSide - kPatchSide / 2),
          place.y + stride * (i / kPatchSide - kPatchSide / 2)};
}

Vec2f landmark_offset(const LandmarkMap& map, const PatchPlace& place, int stride, const Image8& rendered,
                      const Image8& truth) {
  Vec2f offset = Vec2f::Zero();
  for (int i = 0; i < kPatchRays; ++i) {
    const PatchPixel p = patch_pixel(place, stride, i);
    const float difference = grey_at(rendered, p.x, p.y) - grey_at(truth, p.x, p.y);
    for (int o = 0; o < 2; ++o) offset[o] += map.map[std::size_t(o * kPatchRays + i)] * difference;
  }
  return offset;
}

Result<LandmarkPatches> learn_landmark_patches(const TrainingSet& set, const HeadShape& shape,
                                               std::uint64_t seed) {
  const std::span<const TrainingView> own = own_views(set);
  std::vector<ViewLandmarks> landmarks(own.size());
  parallel_for(own.size(), [&](std::size_t v) { landmarks[v] = view_landmarks(set.model, shape, own[v]); });

  LandmarkPatches patches;
  std::vector<double> interocular;
  for (const ViewLandmarks& view : landmarks) interocular.push_back(view.interocular_px);
  patches.interocular_px = interocular.empty() ? 0 : median(interocular);
  patches.stride = std::max(1, int(std::lround(kPatchWidth * patches.interocular_px / (kPatchSide - 1))));
  patches.places.resize(own.size());
  parallel_for(own.size(),
               [&](std::size_t v) { patches.places[v] = places_in(own[v], landmarks[v], patches.stride); });

  const std::vector<std::size_t> views = learning_views(patches.places);
  const std::vector<Examples> examples =
      make_examples({landmarks, set, patches.stride, seed}, views, patches.places);
  parallel_for(examples.size(), [&](std::size_t k) { patches.maps[k] = learn_map(examples[k]); });

  for (std::size_t v = 0; v < own.size(); ++v) {
    std::erase_if(patches.places[v], [&](const PatchPlace& place) {
      return patches.maps[std::size_t(place.landmark)].weight <= 0;
    });
    if (!patches.places[v].empty()) patches.views.push_back(v);
  }
  if (patches.views.empty()) return unmeasurable(patches.interocular_px);
  return patches;
}

}  // namespace likeness
