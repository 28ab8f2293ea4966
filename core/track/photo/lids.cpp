#include "core/track/photo/lids.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/parallel.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/image/bilinear.h"

namespace likeness {
namespace {

constexpr int kEyeColumns = 34, kEyeRows = 30;
constexpr double kChartLift = 1.1;              // of the eyeball's radius: lids lie on it
constexpr double kLow = -0.45, kHigh = 0.55;    // of the eye's width: rows of the grid
constexpr double kLeft = -0.06, kRight = 1.06;  // along the corners' line
constexpr double kMinEyeFacing = 0.3;           // cosine; more slanted eyes are ignored
constexpr double kFrontal = 0.85;   // cosine of the head's axis to the view: the outline is learnt from these
constexpr double kMinEyeWidth = 5;  // px of an eye in the picture
constexpr double kFirstColumn = 0.1, kLastColumn = 0.9;   // that are judged: corners look alike, open or not
constexpr double kLowestJudged = -0.30, kHighest = 0.36;  // rows that are judged, without the brow
constexpr int kTones = 26;
constexpr double kDarkestTone = -1.9, kBrightest = 0.7;  // log of level over the skin's
constexpr int kOpenings = 40, kShifts = 3;
constexpr double kOpeningStep = 0.05, kShiftStep = 0.04, kShiftSigma = 0.02;  // shifts in widths, up and down
constexpr double kTogether = 2.5;  // neighbouring samples err together
constexpr double kEven = 0.12;     // share of a tone family spread over all tones: glints, hair, frames
constexpr double kLashesAbove = 0.03, kLashesBelow = 0.06;  // widths off the upper margin
constexpr double kSafe = 0.02;  // widths from a margin; nothing nearer is learnt from
constexpr int kPasses = 4;
constexpr std::size_t kMinViews = 5, kTurnedAlike = 25;
constexpr double kFarthest = 0.25;       // widths; corners' landmarks farther off are lost
constexpr double kFullBlinks = 0.02;     // quantile of the openings that counts as closed
constexpr double kDeepEnough = 0.65;     // of the usual opening; clips without blinks do not get below it
constexpr double kAssumedClosed = 0.25;  // then, of the usual opening
constexpr double kDoubtfulCorner =
    0.10;                          // widths that corners may be off before their eye's landmarks lose weight
constexpr double kLidDoubt = 2.5;  // times the sigma of landmarks on lids with a better-known opening
constexpr double kEyesTogether = 0.2;             // usual difference of the eyes' openings
constexpr double kWide = 1.3, kWideSigma = 0.12;  // of the usual opening: hardly any eye is open wider

// The chart of an eye (m), and where its corners and lids usually are in it.
struct EyeSite {
  Vec3d centre;
  double radius = 0.0135;
  Vec2d inner, outer;  // corners
  Vec2d upper, lower;  // height over the corners' line, s (1 - s) (a + b s), in widths
  bool known = false;

  Vec3d point(const Vec2d& at) const {
    return centre + Vec3d(at.x(), at.y(), radius - 0.5 * at.squaredNorm() / radius);
  }
  Vec3d normal(const Vec2d& at) const { return Vec3d(at.x() / radius, at.y() / radius, 1).normalized(); }
  Vec2d along() const { return outer - inner; }
  Vec2d up() const {  // as long as the eye is wide
    const Vec2d across(-along().y(), along().x());
    return across.y() < 0 ? Vec2d(-across) : across;
  }
  // s: 0 at the inner corner, 1 at the outer; height over their line in widths.
  Vec2d chart(double s, double height) const { return inner + s * along() + height * up(); }
  static double arc(const Vec2d& c, double s) { return s * (1 - s) * (c[0] + c[1] * s); }
  // Margins at an opening: the upper lid moves most of the way, down to just under the lower one's place.
  double upper_at(double s, double opening) const {
    const double low = 0.85 * arc(lower, s);
    return low + opening * (arc(upper, s) - low);
  }
  double lower_at(double s, double opening) const {
    return (0.85 + 0.15 * std::min(1.0, opening)) * arc(lower, s);
  }
};

// Where the ray of a pixel meets the chart; nullopt beside it.
std::optional<Vec2d> on_chart(const EyeSite& site, const LidView& view, const Vec2d& px) {
  const Pose head_from_cam = inverse(view.cam_from_head);
  const Vec3d from = head_from_cam.translation() - site.centre,
              way = head_from_cam.linear() * ray_direction(view.intrinsics, px);
  if (std::abs(way.z()) < 1e-9) return std::nullopt;
  double height = 0.8 * site.radius;
  Vec2d at = Vec2d::Zero();
  for (int k = 0; k < 8; ++k) {
    at = (from + (height - from.z()) / way.z() * way).head<2>();
    height = site.radius - 0.5 * std::min(at.squaredNorm(), 4 * site.radius * site.radius) / site.radius;
  }
  return at;
}

// Six points of an eye in the chart, from its inner to its outer corner, upper lid first: landmarks run the
// other way round on the subject's right.
using Six = std::array<Vec2d, 6>;  // inner, upper inner, upper outer, outer, lower outer, lower inner
constexpr std::array<std::array<int, 6>, 2> kOrder{{{39, 38, 37, 36, 41, 40}, {42, 43, 44, 45, 46, 47}}};

std::optional<Six> chart_landmarks(const EyeSite& site, const LidView& view, int side) {
  Six six;
  for (int k = 0; k < 6; ++k) {
    const auto at = on_chart(site, view, view.landmarks[kOrder[side][k]]);
    if (!at) return std::nullopt;
    six[k] = *at;
  }
  return six;
}

// s and height in widths of a chart point.
Vec2d in_eye(const EyeSite& site, const Vec2d& at) {
  const Vec2d d = at - site.inner;
  return Vec2d(d.dot(site.along()), d.dot(site.up())) / site.along().squaredNorm();
}

// s (1 - s) (a + b s) through two points.
Vec2d arc_through(const Vec2d& p, const Vec2d& q) {
  const double u = p.y() / (p.x() * (1 - p.x())), v = q.y() / (q.x() * (1 - q.x()));
  const double b = (v - u) / (q.x() - p.x());
  return {u - b * p.x(), b};
}

bool frontal(const LidView& view) {
  const Vec3d to = view.cam_from_head.translation().normalized();
  return -view.cam_from_head.linear().col(2).dot(to) > kFrontal;
}

// The usual outline: medians over training views, the frontal ones if there are enough.
EyeSite find_site(const EyeBalls& eyes, const std::vector<LidView>& views, int side) {
  EyeSite site;
  site.centre = eyes.centre[side];
  site.radius = kChartLift * eyes.radius;
  std::vector<Six> seen;
  for (bool any : {false, true}) {
    if (seen.size() >= kMinViews) break;
    seen.clear();
    for (const LidView& v : views)
      if (v.grey && !v.held_out && (any || frontal(v)))
        if (const auto six = chart_landmarks(site, v, side)) seen.push_back(*six);
  }
  if (seen.size() < kMinViews) return site;
  const auto middle = [&](int k) {
    std::vector<double> x, y;
    for (const Six& s : seen) x.push_back(s[k].x()), y.push_back(s[k].y());
    return Vec2d(median(x), median(y));
  };
  site.inner = middle(0), site.outer = middle(3);
  const std::array<Vec2d, 4> lids{in_eye(site, middle(1)), in_eye(site, middle(2)), in_eye(site, middle(5)),
                                  in_eye(site, middle(4))};
  for (const Vec2d& p : lids)
    if (p.x() < 0.05 || p.x() > 0.95) return site;
  if (lids[1].x() - lids[0].x() < 0.1 || lids[3].x() - lids[2].x() < 0.1) return site;
  site.upper = arc_through(lids[0], lids[1]);
  site.lower = arc_through(lids[2], lids[3]);
  site.known =
      site.along().norm() > 0.01 && EyeSite::arc(site.upper, 0.5) - EyeSite::arc(site.lower, 0.5) > 0.05;
  return site;
}

// The site as each view shows it. Errors of the head's shape and pose move an eye in its chart, slowly with
// the turn of the head: corrected by the median of the corners' landmarks in training views with a similar
// turn, which single lost landmarks do not affect.
std::vector<EyeSite> sites_in_views(const EyeSite& usual, const std::vector<LidView>& views, int side) {
  struct Seen {
    Mat3d turn;
    Vec2d offset;
  };
  std::vector<Seen> training;
  for (const LidView& v : views) {
    if (!v.grey || v.held_out) continue;
    const auto six = chart_landmarks(usual, v, side);
    if (!six) continue;
    const Vec2d offset = 0.5 * ((*six)[0] - usual.inner + (*six)[3] - usual.outer);
    if (offset.norm() < kFarthest * usual.along().norm())
      training.push_back({v.cam_from_head.linear(), offset});
  }
  std::vector<EyeSite> sites(views.size(), usual);
  parallel_for(views.size(), [&](std::size_t i) {
    if (!views[i].grey || training.size() < kMinViews) return;
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t k = 0; k < training.size(); ++k)
      order.push_back({(training[k].turn - views[i].cam_from_head.linear()).squaredNorm(), k});
    const std::size_t count = std::min(kTurnedAlike, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end());
    std::vector<double> x, y;
    for (std::size_t k = 0; k < count; ++k) {
      x.push_back(training[order[k].second].offset.x());
      y.push_back(training[order[k].second].offset.y());
    }
    const Vec2d offset(median(x), median(y));
    sites[i].inner += offset, sites[i].outer += offset;
  });
  return sites;
}

double row_height(int j) { return kLow + (kHigh - kLow) * (j + 0.5) / kEyeRows; }
double column_along(int i) { return kLeft + (kRight - kLeft) * (i + 0.5) / kEyeColumns; }

// The picture of an eye in its chart.
struct EyePatch {
  std::vector<float>
      tone;           // (kEyeRows, kEyeColumns) log of the level over the skin's around; NaN where not seen
  double facing = 0;  // cosine
  bool seen = false;
};

// Surely skin, whatever the lids do: above the fold and below the lower lid.
bool beside_lids(const EyeSite& site, double s, double h) {
  const double at = std::clamp(s, 0.0, 1.0), above = h - EyeSite::arc(site.upper, at),
               below = EyeSite::arc(site.lower, at) - h;
  return (above > 0.10 && above < 0.24) || (below > 0.07 && below < 0.22);
}

// Subtracts the skin's tone, a level and a slope along the eye, from the patch. False if too little is seen.
bool relate_to_skin(const EyeSite& site, std::vector<float>& tone) {
  std::array<std::vector<double>, 3> part;
  std::vector<double> all;
  for (int j = 0; j < kEyeRows; ++j)
    for (int i = 0; i < kEyeColumns; ++i) {
      const float t = tone[j * kEyeColumns + i];
      const double s = column_along(i);
      if (std::isnan(t) || !beside_lids(site, s, row_height(j))) continue;
      part[std::clamp(static_cast<int>(3 * s), 0, 2)].push_back(t);
      all.push_back(t);
    }
  if (all.size() < 40) return false;
  const double level = median(all);
  const bool sloped = part[0].size() > 10 && part[2].size() > 10;
  const double slope = sloped ? 1.5 * (median(part[2]) - median(part[0])) : 0;
  for (int j = 0; j < kEyeRows; ++j)
    for (int i = 0; i < kEyeColumns; ++i)
      tone[j * kEyeColumns + i] -= static_cast<float>(level + slope * (column_along(i) - 0.5));
  return true;
}

EyePatch look_at(const EyeSite& site, const LidView& view) {
  EyePatch patch;
  if (!site.known || !view.grey) return patch;
  const auto cosine = [&](const Vec2d& at) {
    const Vec3d in_cam = view.cam_from_head * site.point(at);
    return in_cam.z() < 0.05 ? -1 : -(view.cam_from_head.linear() * site.normal(at)).dot(in_cam.normalized());
  };
  const auto pixel = [&](const Vec2d& at) {
    return project<double>(view.intrinsics, Vec3d(view.cam_from_head * site.point(at)));
  };
  patch.facing = cosine(site.chart(0.5, 0));
  if (patch.facing < kMinEyeFacing || (pixel(site.inner) - pixel(site.outer)).norm() < kMinEyeWidth)
    return patch;
  patch.tone.assign(kEyeColumns * kEyeRows, std::numeric_limits<float>::quiet_NaN());
  int found = 0;
  for (int j = 0; j < kEyeRows; ++j)
    for (int i = 0; i < kEyeColumns; ++i) {
      const Vec2d at = site.chart(column_along(i), row_height(j));
      if (cosine(at) < 0.5 * kMinEyeFacing) continue;
      const Vec2d px = pixel(at);
      if (!inside_bilinear(*view.grey, px.x(), px.y())) continue;
      patch.tone[j * kEyeColumns + i] =
          static_cast<float>(std::log(bilinear(*view.grey, px.x(), px.y()) + 5));
      ++found;
    }
  patch.seen = found > kEyeColumns * kEyeRows / 2 && relate_to_skin(site, patch.tone);
  return patch;
}

enum Family { kEyeball, kSkin, kLashes, kFamilies };

// Where a column of the chart passes from family to family, heights from above: skin, lashes, eyeball, skin.
struct Cut {
  double lashes_from, lashes_to, eyeball_to;
};
Cut cut_at(const EyeSite& site, double s, double opening, double shift) {
  const double upper = site.upper_at(s, opening) + shift, lower = site.lower_at(s, opening) + shift;
  return {upper + kLashesAbove, upper - kLashesBelow, std::min(lower, upper - kLashesBelow)};
}

bool judged(double s, double h) {
  return s > kFirstColumn && s < kLastColumn && h > kLowestJudged && h < kHighest;
}

struct ToneModel {
  std::array<std::array<double, kTones>, kFamilies> count{}, cost{};

  static int bin(float tone) {
    return std::clamp(static_cast<int>((tone - kDarkestTone) / (kBrightest - kDarkestTone) * kTones), 0,
                      kTones - 1);
  }
  void learn(const EyeSite& site, const EyePatch& patch, double opening, double shift) {
    for (int i = 0; i < kEyeColumns; ++i) {
      const double s = column_along(i);
      const Cut cut = cut_at(site, s, opening, shift);
      for (int j = 0; j < kEyeRows; ++j) {
        const float t = patch.tone[j * kEyeColumns + i];
        const double h = row_height(j);
        if (std::isnan(t) || !judged(s, h)) continue;
        if (h > cut.lashes_from + kSafe || h < cut.eyeball_to - kSafe)
          count[kSkin][bin(t)] += 1;
        else if (h < cut.lashes_from && h > cut.lashes_to)
          count[kLashes][bin(t)] += 1;
        else if (h < cut.lashes_to - kSafe && h > cut.eyeball_to + kSafe)
          count[kEyeball][bin(t)] += 1;
      }
    }
  }
  void finish() {
    for (int f = 0; f < kFamilies; ++f) {
      double total = 1e-9;
      for (double c : count[f]) total += c;
      for (int t = 0; t < kTones; ++t) {
        const double before = count[f][std::max(0, t - 1)], after = count[f][std::min(kTones - 1, t + 1)];
        const double share = (0.25 * before + 0.5 * count[f][t] + 0.25 * after) / total;
        cost[f][t] = -std::log((1 - kEven) * share + kEven / kTones);
      }
    }
  }
};

// An eye's opening before the person's scale is known.
struct RawOpening {
  double opening = 1, shift = 0;
  std::array<double, kOpenings> cost{};  // of each opening, whatever the shift: minus the log likelihood
};

RawOpening explain(const EyeSite& site, const EyePatch& patch, const ToneModel& tones) {
  std::array<std::array<double, kShifts>, kOpenings> cost{};
  for (int i = 0; i < kEyeColumns; ++i) {
    const double s = column_along(i);
    if (s <= kFirstColumn || s >= kLastColumn) continue;
    // Costs summed up from the lowest row, so that a stretch of a column is one difference.
    std::array<std::array<double, kEyeRows + 1>, kFamilies> sum{};
    for (int j = 0; j < kEyeRows; ++j) {
      const float t = patch.tone[j * kEyeColumns + i];
      const bool counts = !std::isnan(t) && judged(s, row_height(j));
      for (int f = 0; f < kFamilies; ++f)
        sum[f][j + 1] = sum[f][j] + (counts ? tones.cost[f][ToneModel::bin(t)] / kTogether : 0);
    }
    const auto below = [&](Family f, double h) {
      const double at =
          std::clamp((h - kLow) / (kHigh - kLow) * kEyeRows, 0.0, static_cast<double>(kEyeRows));
      const int j = std::min(static_cast<int>(at), kEyeRows - 1);
      return sum[f][j] + (at - j) * (sum[f][j + 1] - sum[f][j]);
    };
    for (int a = 0; a < kOpenings; ++a)
      for (int k = 0; k < kShifts; ++k) {
        const Cut cut = cut_at(site, s, a * kOpeningStep, (k - kShifts / 2) * kShiftStep);
        cost[a][k] += below(kSkin, kHigh) - below(kSkin, cut.lashes_from) + below(kLashes, cut.lashes_from) -
                      below(kLashes, cut.lashes_to) + below(kEyeball, cut.lashes_to) -
                      below(kEyeball, cut.eyeball_to) + below(kSkin, cut.eyeball_to);
      }
  }
  double least = 1e300;
  for (int a = 0; a < kOpenings; ++a)
    for (int k = 0; k < kShifts; ++k) {
      const double shift = (k - kShifts / 2) * kShiftStep / kShiftSigma;
      const double wide = std::max(0.0, a * kOpeningStep - kWide) / kWideSigma;
      cost[a][k] += 0.5 * shift * shift + 0.5 * wide * wide;
      least = std::min(least, cost[a][k]);
    }
  RawOpening raw;
  double sum = 0, first = 0, shifted = 0;
  for (int a = 0; a < kOpenings; ++a) {
    double any = 0;
    for (int k = 0; k < kShifts; ++k) {
      const double w = std::exp(least - cost[a][k]);
      any += w, first += w * a * kOpeningStep, shifted += w * (k - kShifts / 2) * kShiftStep;
    }
    sum += any;
    raw.cost[a] = -std::log(std::max(any, 1e-300));
  }
  raw.opening = first / sum;
  raw.shift = shifted / sum;
  return raw;
}

// The evidence of one eye's picture for its opening, in the person's own scale.
struct Belief {
  bool known = false;
  std::array<double, kOpenings> opening{}, cost{};
  double min_sigma = 0.03;
  double corners_off = 0;
};

// Mean distance of the corners' landmarks from where the corners are: corners do not move.
double corner_error(const EyeSite& site, const LidView& view, int side) {
  const auto six = chart_landmarks(site, view, side);
  if (!six) return 1;
  return 0.5 * (in_eye(site, (*six)[0]).norm() + (in_eye(site, (*six)[3]) - Vec2d(1, 0)).norm());
}

using Beliefs = std::array<Belief, 2>;

void read_side(const EyeSite& site, const std::vector<LidView>& views, int side,
               std::vector<Beliefs>& readings, std::stop_token stop) {
  const std::size_t n = views.size();
  const std::vector<EyeSite> sites = sites_in_views(site, views, side);
  std::vector<EyePatch> patches(n);
  parallel_for(n, [&](std::size_t i) {
    if (!stop.stop_requested()) patches[i] = look_at(sites[i], views[i]);
  });
  std::vector<RawOpening> raw(n);
  for (int pass = 0; pass < kPasses && !stop.stop_requested(); ++pass) {
    ToneModel tones;
    for (std::size_t i = 0; i < n; ++i)
      if (patches[i].seen && !views[i].held_out) tones.learn(site, patches[i], raw[i].opening, raw[i].shift);
    tones.finish();
    parallel_for(n, [&](std::size_t i) {
      if (patches[i].seen) raw[i] = explain(site, patches[i], tones);
    });
  }
  // -- The person's own scale.
  std::vector<double> training;
  for (std::size_t i = 0; i < n; ++i)
    if (patches[i].seen && !views[i].held_out) training.push_back(raw[i].opening);
  if (training.size() < kMinViews) return;
  std::sort(training.begin(), training.end());
  const double usual = training[training.size() / 2],
               least = training[static_cast<std::size_t>(kFullBlinks * training.size())];
  const double closed = least < kDeepEnough * usual ? least : kAssumedClosed * usual;
  const double scale = 1 / std::max(0.05, usual - closed);
  for (std::size_t i = 0; i < n; ++i) {
    if (!patches[i].seen) continue;
    Belief& out = readings[i][side];
    out.known = true;
    // A slanted eye is seen through its corner, and a small error of the pose moves it.
    const double slant = std::max(1.0, std::pow(0.7 / patches[i].facing, 2));
    for (int a = 0; a < kOpenings; ++a) {
      out.opening[a] = std::clamp((a * kOpeningStep - closed) * scale, 0.0, 1.6);
      out.cost[a] = raw[i].cost[a] / (slant * slant);
    }
    out.min_sigma = 0.03 * scale * slant;
    out.corners_off = corner_error(sites[i], views[i], side);
  }
}

// The eyes inform each other: apart from winks they open and close together. Their whole likelihoods are
// combined, not just the most likely openings: a shut eye whose skin is as bright as the white of the eye
// looks shut or wide open, and only the other one shows which.
LidOpening opening_of(const Belief& own, const Belief& other) {
  if (!own.known) return {};
  double sum = 0, first = 0, second = 0;
  for (int a = 0; a < kOpenings; ++a) {
    double heard = other.known ? 0 : 1;
    for (int b = 0; other.known && b < kOpenings; ++b) {
      const double apart = (own.opening[a] - other.opening[b]) / kEyesTogether;
      heard += std::exp(-other.cost[b] - 0.5 * apart * apart);
    }
    const double w = std::exp(-own.cost[a]) * heard, x = own.opening[a];
    sum += w, first += w * x, second += w * x * x;
  }
  if (!(sum > 0)) return {};
  const double mean = first / sum;
  const double sigma = std::sqrt(std::max(0.0, second / sum - mean * mean)) + own.min_sigma;
  return {true, mean, sigma, own.corners_off};
}

}  // namespace

Result<LidReadings> read_lids(const EyeBalls& eyes, const std::vector<LidView>& views, std::stop_token stop) {
  LidReadings out;
  std::vector<Beliefs> beliefs(views.size());
  for (int side = 0; side < 2; ++side) {
    if (stop.stop_requested()) return cancelled_error();
    const EyeSite site = find_site(eyes, views, side);
    if (!site.known) continue;
    read_side(site, views, side, beliefs, stop);
    for (double s : {0.33, 0.67})  // about where the predictor's lid points are
      out.usual_gap_m[side] +=
          0.5 * (EyeSite::arc(site.upper, s) - EyeSite::arc(site.lower, s)) * site.along().norm();
  }
  if (stop.stop_requested()) return cancelled_error();
  for (const Beliefs& b : beliefs) out.frames.push_back({opening_of(b[0], b[1]), opening_of(b[1], b[0])});
  return out;
}

void observe_lids(const LidOpenings& seen, const std::array<double, 2>& usual_gap_m, FaceObservation* out) {
  for (int side = 0; side < 2; ++side) {
    const LidOpening& lid = seen[side];
    if (!lid.known) continue;
    out->lids[side] = {true, lid.opening * usual_gap_m[side], lid.sigma * usual_gap_m[side]};
    const double lost = 1 + std::pow(lid.corners_off / kDoubtfulCorner, 2);
    for (int k = 0; k < 6; ++k) {
      const bool corner = k == 0 || k == 3;
      out->sigma_px[36 + 6 * side + k] *= lost * (corner ? 1 : kLidDoubt);
    }
  }
}

}  // namespace likeness
