// Normal equations in tiles, laid out so that plain loops become vector instructions.
#include "core/camera/align_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/dense_solves.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"

namespace likeness {
namespace {

constexpr int kUnknowns = kViewParameters + 2;  // and gain and bias
constexpr int kPairs = kUnknowns * (kUnknowns + 1) / 2;
constexpr int kMostTile = 16;                       // px
constexpr int kTilePixels = kMostTile * kMostTile;  // each tile's arrays
constexpr float kTukey = 4.685f;                    // 95 % efficiency for normal noise
// Eight bits and a codec make less noise than this look like more information than there is.
constexpr float kLeastNoise = 1;
// Neighbouring residuals go together (codec blocks, blur): so many level-0 pixels count as one.
constexpr double kAlike = 16;
constexpr double kGainScale = 100;  // grey values: a gain is solved for as its effect on these
// Exposure multiplies; what light it adds to black (a flare) is little. Grey values.
constexpr double kGainPrior = 15, kBiasPrior = 0.5;
constexpr int kGainLevel = 2;  // the finest at which a gain is looked for: noise, which the mosaic lacks,
                               // makes every gain look less than it is
constexpr float kResidualCap = 30;  // grey values
constexpr float kNoPlace = std::numeric_limits<float>::quiet_NaN();

using Matrix8 = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Vector8 = Eigen::Matrix<double, kUnknowns, 1>;

int tile_side(int level) { return level == 0 ? 16 : 8; }
// Of an edge's place, px of the level: how exactly it is thought to be known.
float edge_px(int level) { return level >= 2 ? 0.5f : level == 1 ? 0.3f : 0.2f; }

// The mosaic's value and slopes between its pixels; false where one of the four is not known.
inline bool read_target(const GreyPicture& m, float u, float v, float& value, float& du, float& dv) {
  if (!(u >= 0.5f && v >= 0.5f && u < float(m.width) - 0.5f && v < float(m.height) - 0.5f)) return false;
  u -= 0.5f, v -= 0.5f;
  const int x = std::min(int(u), m.width - 2), y = std::min(int(v), m.height - 2);
  const float fx = u - float(x), fy = v - float(y);
  const float* p = m.data.data() + std::size_t(y) * std::size_t(m.width) + std::size_t(x);
  const float a = p[0], b = p[1], c = p[m.width], d = p[m.width + 1];
  const float top = a + fx * (b - a), low = c + fx * (d - c);
  value = top + fy * (low - top);
  du = (b - a) + fy * ((d - c) - (b - a));
  dv = low - top;
  return value == value;
}

// One tile's pixels, column after column of what the products need.
struct Tile {
  int count = 0;  // padded to a multiple of 8 with zeros
  int known = 0, background = 0;
  alignas(32) float x[kTilePixels], y[kTilePixels], grey[kTilePixels];
  alignas(32) float value[kTilePixels], du[kTilePixels], dv[kTilePixels];
  alignas(32) float slopes[kUnknowns][kTilePixels];
  alignas(32) float residual[kTilePixels], weight[kTilePixels];
};

// What an iteration is made with.
struct LevelTerms {
  const GreyPicture *picture, *target;
  ViewMap<float> map;
  float gain, bias;
  float noise, edge;      // scale of the robust loss
  double light;           // variance of the tiles' light, grey values squared
  double share;           // how many independent observations a pixel of this level stands for
  float unit[kUnknowns];  // of each unknown, in its slopes' unit
};

// Known pixels of the tile at (x0, y0), with their mosaic values.
void read_tile(const LevelTerms& t, int x0, int y0, int side, Tile& tile) {
  const GreyPicture& picture = *t.picture;
  const int x1 = std::min(x0 + side, picture.width), y1 = std::min(y0 + side, picture.height);
  int n = 0;
  tile.background = 0;
  for (int y = y0; y < y1; ++y) {
    const float* row = picture.at(0, y);
    for (int x = x0; x < x1; ++x) {
      if (row[x] != row[x]) continue;
      ++tile.background;
      const auto place = view_place(t.map, float(x) + 0.5f, float(y) + 0.5f);
      if (place.depth < 0.1f) continue;
      if (!read_target(*t.target, place.u, place.v, tile.value[n], tile.du[n], tile.dv[n])) continue;
      tile.x[n] = float(x) + 0.5f, tile.y[n] = float(y) + 0.5f, tile.grey[n] = row[x];
      ++n;
    }
  }
  tile.known = n;
  tile.count = (n + 7) / 8 * 8;
  for (; n < tile.count; ++n)
    tile.x[n] = tile.y[n] = tile.grey[n] = tile.value[n] = tile.du[n] = tile.dv[n] = 0;
}

// Residuals, slopes and weights.
void weigh_tile(const LevelTerms& t, Tile& tile) {
  for (int i = 0; i < tile.count; ++i) {
    float slopes[kViewParameters];
    view_slopes(t.map, tile.x[i], tile.y[i], t.gain * tile.du[i], t.gain * tile.dv[i], slopes);
    for (int k = 0; k < kViewParameters; ++k) tile.slopes[k][i] = slopes[k] * t.unit[k];
    tile.slopes[6][i] = tile.value[i] * t.unit[6];
    tile.slopes[7][i] = t.unit[7];
    const float r = t.gain * tile.value[i] + t.bias - tile.grey[i];
    const float steep = slopes[4] * slopes[4] + slopes[5] * slopes[5];
    const float variance = t.noise * t.noise + t.edge * t.edge * steep;
    const float u = r * r / (kTukey * kTukey * variance), inside = u < 1 ? 1 - u : 0;
    tile.residual[i] = r;
    tile.weight[i] = inside * inside / variance;
  }
  for (int i = tile.known; i < tile.count; ++i) tile.weight[i] = tile.residual[i] = 0;
}

inline float dot(const float* a, const float* b, int count) {
  float sum[8] = {};
  for (int i = 0; i < count; i += 8)
    for (int k = 0; k < 8; ++k) sum[k] += a[i + k] * b[i + k];
  return ((sum[0] + sum[4]) + (sum[1] + sum[5])) + ((sum[2] + sum[6]) + (sum[3] + sum[7]));
}

// A tile's share of the normal equations.
struct TileSums {
  float products[kPairs];  // rows of the lower triangle
  float along[kUnknowns], slopes[kUnknowns];
  float weight, residual;
  float spread;  // variance of the residuals, each counted the same
  float steep;   // mean square of the slopes in both directions, grey values a px of level 0
};

void sum_tile(Tile& tile, TileSums& sums) {
  alignas(32) float weighted[kTilePixels], ones[kTilePixels];
  std::fill(ones, ones + tile.count, 1.0f);
  int pair = 0;
  for (int a = 0; a < kUnknowns; ++a) {
    for (int i = 0; i < tile.count; ++i) weighted[i] = tile.weight[i] * tile.slopes[a][i];
    for (int b = 0; b <= a; ++b) sums.products[pair++] = dot(weighted, tile.slopes[b], tile.count);
    sums.along[a] = dot(weighted, tile.residual, tile.count);
    sums.slopes[a] = dot(weighted, ones, tile.count);
  }
  sums.weight = dot(tile.weight, ones, tile.count);
  sums.residual = dot(tile.weight, tile.residual, tile.count);
  const float count = float(std::max(1, tile.known)), mean = dot(tile.residual, ones, tile.count) / count;
  sums.spread = dot(tile.residual, tile.residual, tile.count) / count - mean * mean;
  sums.steep =
      (dot(tile.slopes[4], tile.slopes[4], tile.count) + dot(tile.slopes[5], tile.slopes[5], tile.count)) /
      count;
}

// Sums over a level, and what they say about the next iteration's scales.
struct LevelSums {
  Matrix8 a = Matrix8::Zero();  // of the data alone
  Vector8 b = Vector8::Zero();
  int known = 0, background = 0, inliers = 0;
  double squares = 0;  // of capped residuals
  float noise = 0;     // robust deviation of the residuals
  double light = 0;
};

// Adds a tile with its light eliminated: with prior variance L, the light's own row is removed from the
// equations (Schur complement).
void add_tile(const TileSums& t, double light, double share, Matrix8& a, Vector8& b) {
  const double row = t.weight * share + (light > 0 ? 1 / light : 0);
  const double shade = light > 0 && row > 0 ? share * share / row : 0;
  int pair = 0;
  for (int i = 0; i < kUnknowns; ++i) {
    for (int j = 0; j <= i; ++j) a(i, j) += share * t.products[pair++] - shade * t.slopes[i] * t.slopes[j];
    b[i] += share * t.along[i] - shade * t.slopes[i] * t.residual;
  }
}

class ResidualCounts {
 public:
  void add(float residual) { ++counts_[std::size_t(std::min(255.0f, std::abs(residual) * kBins))]; }
  // Of residuals about zero, by their median.
  float deviation() const {
    int all = 0, so_far = 0;
    for (const int n : counts_) all += n;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      if (2 * (so_far += counts_[i]) >= all) return 1.4826f * (float(i) + 0.5f) / kBins;
    }
    return 0;
  }

 private:
  static constexpr float kBins = 4;  // a grey value
  std::array<int, 256> counts_{};
};

LevelSums sum_level(const LevelTerms& terms, int side, std::vector<TileSums>* parts) {
  LevelSums sums;
  ResidualCounts counts;
  std::vector<double> tile_light;
  Tile tile;
  TileSums tile_sums;
  double tile_noise = 0;
  for (int y = 0; y < terms.picture->height; y += side)
    for (int x = 0; x < terms.picture->width; x += side) {
      read_tile(terms, x, y, side, tile);
      sums.background += tile.background;
      sums.known += tile.known;
      if (tile.known < 8) continue;
      weigh_tile(terms, tile);
      sum_tile(tile, tile_sums);
      for (int i = 0; i < tile.known; ++i) {
        counts.add(tile.residual[i]);
        sums.inliers += tile.weight[i] > 0;
        const float r = std::min(kResidualCap, std::abs(tile.residual[i]));
        sums.squares += double(r) * r;
      }
      add_tile(tile_sums, terms.light, terms.share, sums.a, sums.b);
      if (parts) parts->push_back(tile_sums);
      if (tile.known * 2 > side * side && tile_sums.weight > 0) {
        const double mean = tile_sums.residual / tile_sums.weight;
        tile_light.push_back(mean * mean);
        tile_noise += 1 / (tile_sums.weight * terms.share);
      }
    }
  sums.a.triangularView<Eigen::StrictlyUpper>() = sums.a.transpose();
  sums.noise = std::max(kLeastNoise, counts.deviation());
  if (const double tiles = double(tile_light.size()); tiles > 0) {
    // The median of squares of normal values is 0.455 of their variance.
    sums.light = std::max(0.0, median(std::move(tile_light)) / 0.455 - tile_noise / tiles);
  }
  return sums;
}

// How far a unit of each unknown moves the picture is about a pixel, or changes it by about a grey value.
Vector8 unknown_units(const Intrinsics& reference) {
  Vector8 unit;
  unit << 1 / reference.fx, 1 / reference.fx, 2.0 / reference.width, 2.0 / reference.width, 1, 1,
      1 / kGainScale, 1;
  return unit;
}

LevelTerms level_terms(const std::vector<GreyPicture>& picture, const Intrinsics& reference,
                       const ViewTarget& target, const AlignedView& at, int level) {
  LevelTerms t;
  const std::size_t l = std::size_t(level);
  t.picture = &picture[l], t.target = &target.levels[l];
  const double scale = std::ldexp(1.0, -level);
  HandheldView view = at.view;
  view.shift *= scale;
  t.map = view_map<float>(at_level(target.intrinsics, level), at_level(reference, level), view);
  t.gain = float(at.gain), t.bias = float(at.bias);
  t.noise = kLeastNoise, t.edge = edge_px(level), t.light = 0;
  t.share = std::min(1.0, std::ldexp(1.0, 2 * level) / kAlike);
  const Vector8 unit = unknown_units(reference);
  for (int i = 0; i < kUnknowns; ++i) t.unit[i] = float(unit[i]);
  t.unit[4] *= float(scale), t.unit[5] *= float(scale);  // slopes are along px of the level
  return t;
}

// Slope and curvature of Cauchy's log(1 + (d / s)^2) / 2 ... as a quadratic with its weight.
double cauchy_weight(double distance, double scale) { return 1 / (scale * scale + distance * distance); }

void add_priors(const AlignedView& at, const ViewPrior& prior, const Vector8& unit, Matrix8& a, Vector8& b) {
  const auto pull = [&](int i, double off, double weight) {
    a(i, i) += weight;
    b[i] += weight * off;
  };
  const double zoom_unit = unit[3];
  if (prior.shift_px > 0)
    for (int i = 0; i < 2; ++i) {
      const double weight = cauchy_weight(at.view.shift.norm(), prior.shift_px);
      pull(4 + i, at.view.shift[i], weight);
    }
  if (prior.log_zoom > 0)
    pull(3, at.view.log_zoom / zoom_unit,
         cauchy_weight(at.view.log_zoom / zoom_unit, prior.log_zoom / zoom_unit));
  if (prior.smooth_px > 0) {
    const ViewStep off = view_step(prior.expected, at.view);
    for (int i = 0; i < kViewParameters; ++i) {
      const double px = off[i] / unit[i];
      pull(i, px, cauchy_weight(px, prior.smooth_px));
    }
  }
  pull(6, (at.gain - 1) * kGainScale, 1 / (kGainPrior * kGainPrior));
  pull(7, at.bias, 1 / (kBiasPrior * kBiasPrior));
}

// One Gauss-Newton step; the largest part of it in px of the level, or nothing where it has none.
std::optional<double> take_step(const LevelSums& sums, const ViewPrior& prior, const Intrinsics& reference,
                                int level, int coarsest, AlignedView& at) {
  const Vector8 unit = unknown_units(reference);
  Matrix8 a = sums.a;
  Vector8 b = sums.b;
  add_priors(at, prior, unit, a, b);
  const auto hold = [&](int i) { a(i, i) += 1e9, b[i] = 0; };
  if (level < std::min(kGainLevel, coarsest)) hold(6);
  if (!prior.shifts) hold(4), hold(5);
  a.diagonal().array() += 1e-9;
  Eigen::VectorXd step = solve_symmetric(Eigen::MatrixXd(a), Eigen::VectorXd(-b));
  if (!step.allFinite()) return std::nullopt;
  // Farther than a few pixels of the level nothing is known about the slopes.
  const double most = std::ldexp(4.0, level);
  const double size = std::max(std::hypot(step[0], step[1]), std::max(std::abs(step[2]), std::abs(step[3])));
  if (size > most) step.head<kViewParameters>() *= most / size;
  ViewStep view = (step.array() * unit.array()).head<kViewParameters>();
  at.view = stepped(at.view, view);
  at.view.log_zoom = std::clamp(at.view.log_zoom, -1.5, 1.5);
  at.gain = std::clamp(at.gain + step[6] * unit[6], 0.3, 3.0);
  at.bias += step[7];
  // A turn and a shift move the picture alike, and may cancel: what counts is their sum.
  const double moved = std::hypot(step[1] + step[4], step[5] - step[0]);
  return std::max({std::min(moved, size), std::abs(step[2]), std::abs(step[3])}) * std::ldexp(1.0, -level);
}

}  // namespace

AlignedView align_view(const std::vector<GreyPicture>& picture, const Intrinsics& reference,
                       const ViewTarget& target, const AlignedView& start, const ViewPrior& prior,
                       int coarsest, int finest) {
  AlignedView at = start;
  float noise = 0;
  for (int level = coarsest; level >= finest; --level) {
    const int most = level == coarsest ? 10 : level > 0 ? 5 : 4;
    double light = 0;
    for (int i = 0; i < most; ++i) {
      LevelTerms terms = level_terms(picture, reference, target, at, level);
      // The first look finds the scale; until then nothing is an outlier.
      const bool first = noise == 0;
      terms.noise = first ? 1e4f : noise;
      terms.light = light;
      LevelSums sums = sum_level(terms, tile_side(level), nullptr);
      if (first) {
        terms.noise = sums.noise;
        sums = sum_level(terms, tile_side(level), nullptr);
      }
      noise = sums.noise;
      light = sums.light;
      const auto moved = take_step(sums, prior, reference, level, coarsest, at);
      if (!moved || (*moved < 0.02 && i > 0)) break;
    }
  }
  return at;
}

namespace {

// Of where the background is: the larger axis of its covariance, px of level 0. A turn and a shift move it
// alike, so their sum counts.
double place_deviation(const LevelSums& sums, const ViewPrior& prior, const Intrinsics& reference,
                       const AlignedView& at) {
  ViewPrior own = prior;
  own.smooth_px = 0;
  Matrix8 a = sums.a;
  Vector8 b = sums.b;
  add_priors(at, own, unknown_units(reference), a, b);
  if (!prior.shifts) a(4, 4) += 1e9, a(5, 5) += 1e9;
  a.diagonal().array() += 1e-9;  // nothing known: so many px that it is plain
  Eigen::MatrixXd moves = Eigen::MatrixXd::Zero(kUnknowns, 2);
  moves(1, 0) = moves(4, 0) = 1;
  moves(0, 1) = -1, moves(5, 1) = 1;
  const Eigen::MatrixXd c = moves.transpose() * solve_symmetric_columns(Eigen::MatrixXd(a), moves);
  const double mean = (c(0, 0) + c(1, 1)) / 2, apart = std::hypot((c(0, 0) - c(1, 1)) / 2, c(0, 1));
  return std::sqrt(std::max(0.0, mean + apart));
}

// Parts with texture enough to be found by themselves: of the shift, in its best direction.
int parts_with_texture(const std::vector<TileSums>& parts, const LevelTerms& terms) {
  // An edge's pixel, known to a pixel of level 1, has a strength of 1/16: so much is a fifth of a part.
  constexpr double kLeastStrength = 3;
  int count = 0;
  for (const TileSums& part : parts) {
    const double row = part.weight * terms.share + (terms.light > 0 ? 1 / terms.light : 0);
    if (row <= 0) continue;
    const double shade = terms.light > 0 ? terms.share * terms.share / row : 0;
    const auto product = [&](int i, int j) {
      return terms.share * part.products[i * (i + 1) / 2 + j] - shade * part.slopes[i] * part.slopes[j];
    };
    const double xx = product(4, 4), xy = product(5, 4), yy = product(5, 5);
    count += (xx + yy) / 2 + std::hypot((xx - yy) / 2, xy) >= kLeastStrength;
  }
  return count;
}

// How far off its place a part must be to differ so much, in a direction of which nothing is known: where its
// pictures disagree entirely, too, which no search for the right place survives.
double misplaced_px(const std::vector<TileSums>& parts, const Intrinsics& reference) {
  constexpr float kNoise = 2;  // variance, grey values: of two coded pictures, one level down
  const float limit = float(misfit_limit_px(reference));
  std::vector<double> off;
  for (const TileSums& part : parts) {
    const float slope = part.steep / 2;
    // So far off, a part would differ by twice the noise: less texture tells nothing.
    if (slope * limit * limit < 4 * kNoise) continue;
    off.push_back(std::sqrt(std::max(0.0f, part.spread - kNoise) / slope));
  }
  constexpr std::size_t kFew = 4;
  return off.size() < kFew ? -1 : median(std::move(off));
}

}  // namespace

void measure_view(const std::vector<GreyPicture>& picture, const Intrinsics& reference,
                  const ViewTarget& target, const ViewPrior& prior, AlignedView& aligned) {
  constexpr float kUsualNoise =
      3;  // grey values: beyond five times that, or its place in pixels, is an outlier
  LevelTerms terms = level_terms(picture, reference, target, aligned, 0);
  terms.noise = kUsualNoise, terms.edge = 0.5f;
  const LevelSums whole = sum_level(terms, tile_side(0), nullptr);
  aligned.overlap = whole.background ? double(whole.known) / whole.background : 0;
  aligned.inliers = whole.known ? double(whole.inliers) / whole.known : 0;
  aligned.residual = whole.known ? std::sqrt(whole.squares / whole.known) : 0;

  // One level down noise is little, and a part of 16 px is 32 of the picture.
  const int level = std::min(1, int(picture.size()) - 1);
  terms = level_terms(picture, reference, target, aligned, level);
  LevelSums sums = sum_level(terms, kMostTile, nullptr);
  terms.noise = sums.noise, terms.light = sums.light;
  sums = sum_level(terms, kMostTile, nullptr);
  aligned.sigma_px = place_deviation(sums, prior, reference, aligned);
  terms.edge = 1;  // so that a part that is a few pixels off is none of the outliers
  std::vector<TileSums> parts;
  sum_level(terms, kMostTile, &parts);
  aligned.parts = parts_with_texture(parts, terms);
  aligned.misfit_px = misplaced_px(parts, reference);
}

double grey_contrast(const GreyPicture& grey) {
  double sum = 0, squares = 0;
  int count = 0;
  for (const float value : grey.data)
    if (value == value) sum += value, squares += double(value) * value, ++count;
  return count ? std::sqrt(std::max(0.0, squares / count - sum / count * sum / count)) : 0;
}

ViewDifferences view_differences(const std::vector<GreyPicture>& picture, const Intrinsics& reference,
                                 const ViewTarget& target, const AlignedView& aligned, int level,
                                 double cap) {
  const LevelTerms terms = level_terms(picture, reference, target, aligned, level);
  const GreyPicture& grey = *terms.picture;
  ViewDifferences differences;
  for (int y = 0; y < grey.height; ++y)
    for (int x = 0; x < grey.width; ++x) {
      const float own = *grey.at(x, y);
      if (own != own) continue;
      ++differences.background;
      const auto place = view_place(terms.map, float(x) + 0.5f, float(y) + 0.5f);
      float value, du, dv;
      if (place.depth < 0.1f || !read_target(*terms.target, place.u, place.v, value, du, dv)) continue;
      ++differences.placed;
      const double off = std::min(cap, std::abs(double(terms.gain * value + terms.bias - own)));
      differences.squares += off * off;
    }
  return differences;
}

double view_badness(const std::vector<GreyPicture>& picture, const Intrinsics& reference,
                    const ViewTarget& target, const AlignedView& aligned, int level) {
  const double cap = std::max(4.0, 0.5 * grey_contrast(picture[std::size_t(level)]));
  const ViewDifferences d = view_differences(picture, reference, target, aligned, level, cap);
  if (d.background == 0) return 1;
  constexpr double kNoPlaceBadness = 0.7;
  return (d.squares / (cap * cap) + kNoPlaceBadness * (d.background - d.placed)) / d.background;
}

GreyPicture seen_from(const ViewTarget& target, const Intrinsics& reference, const HandheldView& view,
                      int level) {
  const Intrinsics k = at_level(reference, level);
  HandheldView scaled = view;
  scaled.shift *= std::ldexp(1.0, -level);
  const auto map = view_map<float>(at_level(target.intrinsics, level), k, scaled);
  GreyPicture seen(k.width, k.height, 1, kNoPlace);
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const auto place = view_place(map, float(x) + 0.5f, float(y) + 0.5f);
      float value, du, dv;
      if (place.depth > 0.1f &&
          read_target(target.levels[std::size_t(level)], place.u, place.v, value, du, dv))
        *seen.at(x, y) = value;
    }
  return seen;
}

namespace {

// Correlation of two pictures, the second moved by (dx, dy), where both are known; -1 where that is too
// little.
double moved_correlation(const GreyPicture& a, const GreyPicture& b, int dx, int dy, int least) {
  double n = 0, sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
  for (int y = std::max(0, dy); y < std::min(a.height, b.height + dy); ++y)
    for (int x = std::max(0, dx); x < std::min(a.width, b.width + dx); ++x) {
      const float p = *a.at(x, y), q = *b.at(x - dx, y - dy);
      if (p != p || q != q) continue;
      ++n, sa += p, sb += q, saa += double(p) * p, sbb += double(q) * q, sab += double(p) * q;
    }
  if (n < least) return -1;
  const double va = saa - sa * sa / n, vb = sbb - sb * sb / n, cov = sab - sa * sb / n;
  constexpr double kFlat = 1;  // grey value squared: what is flat correlates with everything
  if (va < kFlat * n || vb < kFlat * n) return -1;
  return cov / std::sqrt(va * vb);
}

}  // namespace

std::optional<HandheldView> search_view(const std::vector<GreyPicture>& picture, const Intrinsics& reference,
                                        const ViewTarget& target, const HandheldView& start) {
  const int level = int(picture.size()) - 1;
  const GreyPicture& grey = picture.back();
  const GreyPicture seen = seen_from(target, reference, start, level);
  int background = 0;
  for (const float value : grey.data) background += value == value;
  const int far_x = grey.width / 3, far_y = grey.height / 3, least = std::max(16, background / 3);
  double best = 0.3;  // less is no likeness
  std::optional<Vec2d> move;
  for (int dy = -far_y; dy <= far_y; ++dy)
    for (int dx = -far_x; dx <= far_x; ++dx)
      if (const double c = moved_correlation(grey, seen, dx, dy, least); c > best) best = c, move = {dx, dy};
  if (!move) return std::nullopt;
  // The turn that carries the ray through the middle to where it is now.
  HandheldView scaled = start;
  scaled.shift *= std::ldexp(1.0, -level);
  const Intrinsics k = view_intrinsics(at_level(reference, level), scaled);
  const Vec3d from =
      Vec3d((grey.width / 2.0 - k.cx) / k.fx, (grey.height / 2.0 - k.cy) / k.fy, 1).normalized();
  const Vec3d to =
      Vec3d((grey.width / 2.0 + move->x() - k.cx) / k.fx, (grey.height / 2.0 + move->y() - k.cy) / k.fy, 1)
          .normalized();
  HandheldView found = start;
  const Vec3d axis = from.cross(to);
  if (axis.norm() > 1e-12)
    found.turn = rotation_about(axis.normalized(), std::asin(std::min(1.0, axis.norm()))) * start.turn;
  return found;
}

}  // namespace likeness
