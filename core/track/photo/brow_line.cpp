#include "core/track/photo/brow_line.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/base/parallel.h"
#include "core/base/quantile.h"
#include "core/image/bilinear.h"

namespace likeness {
namespace {

constexpr int kFirstBrow = 17, kBrowPoints = 5;
constexpr int kBrowColumns = 20, kBrowRows = 61;
constexpr double kRowStep = 0.0006, kLowestRow = -0.010;  // m along the forehead from the model's brow
constexpr double kHalfBrow = 0.007;                       // m, half height of a brow's strip
constexpr double kSlideDown = -0.008, kSlideUp = 0.014;   // m searched
constexpr double kNearRest = 0.0015;                      // m: frames that show the brows at rest
constexpr std::size_t kMaxReferences = 60, kFewestReferences = 5;
constexpr double kMinLikeness = 0.60, kMinGain = 0.15;  // correlations
constexpr double kMinMove = 0.002;                      // m from the predictor's points
constexpr double kSigma_px = 1.0;                       // of a point placed by the picture
constexpr int kHalfColumns[2][2] = {{0, 11}, {9, 20}};  // of the points' order: 0..2 and 2..4

using Strip = std::array<float, kBrowColumns * kBrowRows>;  // (row, column), levels; rows go up the forehead

Vec3d up_the_forehead() { return Vec3d(0, 1, -0.25).normalized(); }

double row_place(int row) { return kLowestRow + row * kRowStep; }

struct BrowFrame {
  bool known = false;
  std::array<double, kBrowPoints> rise{}, aside{};  // of the predictor's points, m up the forehead and to +x
  Strip strip{};
};

struct Brow {
  std::array<Vec3d, kBrowPoints> rest;  // the model's, head frame
};

BrowFrame look_at(const Brow& brow, int first, const BrowPicture& picture, const FaceFrame& face) {
  BrowFrame frame;
  const Pose& pose = face.state.cam_from_head;
  const Vec3d up = up_the_forehead();
  for (int k = 0; k < kBrowPoints; ++k) {
    // The point's offset from the model's resting brow, in the plane of `up` and the head's x.
    const Vec3d in_cam = pose * brow.rest[k];
    if (in_cam.z() < 0.05) return frame;
    Eigen::Matrix2d by;
    const Vec3d directions[2] = {up, Vec3d::UnitX()};
    for (int d = 0; d < 2; ++d) {
      const Vec3d moved = pose * (brow.rest[k] + 0.001 * directions[d]);
      by.col(d) = (moved.hnormalized() - in_cam.hnormalized()) / 0.001;
    }
    if (std::abs(by.determinant()) < 0.1 * by.col(0).squaredNorm()) return frame;  // seen from the side
    const Vec2d offset = by.inverse() * (face.observation.rays[first + k] - in_cam.hnormalized());
    frame.rise[k] = offset.x(), frame.aside[k] = offset.y();
  }
  for (int c = 0; c < kBrowColumns; ++c) {
    const double at = (kBrowPoints - 1) * (c + 0.5) / kBrowColumns;
    const int k = std::min(static_cast<int>(at), kBrowPoints - 2);
    const Vec3d base = brow.rest[k] + (at - k) * (brow.rest[k + 1] - brow.rest[k]);
    for (int r = 0; r < kBrowRows; ++r) {
      const Vec2d at = project<double>(picture.intrinsics, pose * (base + row_place(r) * up));
      if (!inside_bilinear(*picture.grey, at.x(), at.y())) return frame;
      frame.strip[r * kBrowColumns + c] = static_cast<float>(bilinear(*picture.grey, at.x(), at.y()));
    }
  }
  frame.known = true;
  return frame;
}

double mean_rise(const BrowFrame& frame, int half) {
  return (frame.rise[2 * half] + frame.rise[2 * half + 1] + frame.rise[2 * half + 2]) / 3;
}

// The resting brow: mean strip of training frames, and the predictor's points in them.
struct Reference {
  Strip strip{};
  std::array<double, kBrowPoints> rise{}, aside{};
};

std::optional<Reference> resting_brow(const std::vector<BrowFrame>& frames,
                                      const std::vector<FaceFrame>& faces) {
  std::vector<double> heights;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (frames[i].known && !faces[i].held_out)
      heights.push_back(0.5 * (mean_rise(frames[i], 0) + mean_rise(frames[i], 1)));
  if (heights.size() < kFewestReferences) return std::nullopt;
  const double usual = median(heights);
  std::vector<const BrowFrame*> at_rest;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (frames[i].known && !faces[i].held_out &&
        std::abs(0.5 * (mean_rise(frames[i], 0) + mean_rise(frames[i], 1)) - usual) < kNearRest)
      at_rest.push_back(&frames[i]);
  if (at_rest.size() < kFewestReferences) return std::nullopt;
  const std::size_t step = (at_rest.size() + kMaxReferences - 1) / kMaxReferences;
  Reference reference;
  std::array<std::vector<double>, kBrowPoints> rise, aside;
  double count = 0;
  for (std::size_t i = 0; i < at_rest.size(); i += step, ++count) {
    for (std::size_t p = 0; p < reference.strip.size(); ++p) reference.strip[p] += at_rest[i]->strip[p];
    for (int k = 0; k < kBrowPoints; ++k)
      rise[k].push_back(at_rest[i]->rise[k]), aside[k].push_back(at_rest[i]->aside[k]);
  }
  for (float& v : reference.strip) v /= static_cast<float>(count);
  for (int k = 0; k < kBrowPoints; ++k)
    reference.rise[k] = median(rise[k]), reference.aside[k] = median(aside[k]);
  return reference;
}

// Correlation of half a resting brow, slid by `rows`, with the frame; -1 if too little of it lies inside.
double likeness_at(const Reference& reference, const BrowFrame& frame, int half, int rows) {
  const double centre =
      (reference.rise[2 * half] + reference.rise[2 * half + 1] + reference.rise[2 * half + 2]) / 3;
  const int from = static_cast<int>(std::lround((centre - kHalfBrow - kLowestRow) / kRowStep)),
            to = static_cast<int>(std::lround((centre + kHalfBrow - kLowestRow) / kRowStep));
  double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  for (int r = std::max(from, 0); r <= std::min(to, kBrowRows - 1); ++r) {
    if (r + rows < 0 || r + rows >= kBrowRows) continue;
    for (int c = kHalfColumns[half][0]; c < kHalfColumns[half][1]; ++c) {
      const double x = reference.strip[r * kBrowColumns + c], y = frame.strip[(r + rows) * kBrowColumns + c];
      ++n, a += x, b += y, aa += x * x, bb += y * y, ab += x * y;
    }
  }
  const double whole = (to - from + 1.0) * (kHalfColumns[half][1] - kHalfColumns[half][0]);
  const double va = aa - a * a / n, vb = bb - b * b / n;
  if (n < 0.7 * whole || va < 4 * n || vb < 4 * n) return -1;  // 2 levels of contrast
  return (ab - a * b / n) / std::sqrt(va * vb);
}

// How far half a brow is above its rest, m, if the picture shows it clearly and the predictor disagrees.
std::optional<double> raised_by(const Reference& reference, const BrowFrame& frame, int half) {
  const double rest =
      (reference.rise[2 * half] + reference.rise[2 * half + 1] + reference.rise[2 * half + 2]) / 3;
  const double predicted = mean_rise(frame, half) - rest;
  constexpr int lowest = static_cast<int>(kSlideDown / kRowStep),
                highest = static_cast<int>(kSlideUp / kRowStep);
  int best = 0;
  double most = -1;
  for (int rows = lowest; rows <= highest; ++rows)
    if (const double like = likeness_at(reference, frame, half, rows); like > most) most = like, best = rows;
  if (best == lowest || best == highest)
    return std::nullopt;  // still rising: not a brow, but a shadow beyond
  const double rise = best * kRowStep;
  if (most < kMinLikeness || std::abs(rise - predicted) < kMinMove) return std::nullopt;
  const int there = std::clamp(static_cast<int>(std::lround(predicted / kRowStep)), lowest, highest);
  if (most - likeness_at(reference, frame, half, there) < kMinGain) return std::nullopt;
  return rise;
}

// Moves the observation's points of one brow; returns how many halves were moved.
int move_points(const Brow& brow, int first, const Reference& reference, const BrowFrame& frame,
                FaceFrame& face) {
  int moved = 0;
  std::array<double, kBrowPoints> rise{}, votes{};
  for (int half = 0; half < 2; ++half)
    if (const auto raised = raised_by(reference, frame, half)) {
      ++moved;
      for (int k = 2 * half; k < 2 * half + 3; ++k) rise[k] += *raised, ++votes[k];
    }
  for (int k = 0; k < kBrowPoints; ++k) {
    if (votes[k] == 0) continue;
    const Vec3d place = brow.rest[k] + (reference.rise[k] + rise[k] / votes[k]) * up_the_forehead() +
                        reference.aside[k] * Vec3d::UnitX();
    face.observation.rays[first + k] = (face.state.cam_from_head * place).hnormalized();
    face.observation.sigma_px[first + k] = kSigma_px;
  }
  return moved;
}

}  // namespace

Result<BrowSummary> correct_brows(const ReducedHead& head, const ReducedPerson& person,
                                  const std::vector<BrowPicture>& pictures, std::vector<FaceFrame>& faces,
                                  std::stop_token stop) {
  BrowSummary summary;
  const Eigen::VectorXd neutral = Eigen::VectorXd::Zero(head.expression_count());
  for (int side = 0; side < 2; ++side) {
    const int first = kFirstBrow + side * kBrowPoints;
    Brow brow;
    for (int k = 0; k < kBrowPoints; ++k) brow.rest[k] = reduced_point(head, person, first + k, neutral, 0);
    std::vector<BrowFrame> frames(faces.size());
    parallel_for(faces.size(), [&](std::size_t i) {
      if (faces[i].seen && faces[i].pose_given && pictures[i].grey && !stop.stop_requested())
        frames[i] = look_at(brow, first, pictures[i], faces[i]);
    });
    if (stop.stop_requested()) return cancelled_error();
    const auto reference = resting_brow(frames, faces);
    if (!reference) continue;
    summary.known = true;
    std::vector<int> moved(faces.size(), 0);
    parallel_for(faces.size(), [&](std::size_t i) {
      if (frames[i].known) moved[i] = move_points(brow, first, *reference, frames[i], faces[i]);
    });
    for (int m : moved) summary.corrected += m;
  }
  return summary;
}

}  // namespace likeness
