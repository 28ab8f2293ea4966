// The densest plausible calm: see choose_rest.h.
#include "core/track/fit/choose_rest.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/quantile.h"

namespace likeness {
namespace {

// In eye gaps (face_measures.h), of which one is about 33 mm.
constexpr double kCalm = 0.04;     // standard deviation of the mouth's measures around a frame: half weight
constexpr double kRelaxed = 0.02;  // closed lips may be apart by this, beyond pressed ones
constexpr double kParted = 0.04;   // further apart than that: half weight
constexpr double kRaised = 0.08;   // brows above the middle of those of calm frames: half weight
constexpr double kAskew = 0.05;    // a mouth further to one side, or more oblique, than usual: half weight
constexpr double kUnsure = 0.05;   // uncertainty of the mouth's width beyond the usual: half weight
constexpr double kAlikeWidth = 0.05, kAlikeLift = 0.035, kAlikeBrows = 0.07;  // of K

// A smile widens a mouth at rest by a quarter, a pucker or a round vowel narrows it by as much: natural
// logarithms, the second beyond which it becomes unlikely.
constexpr double kStretch = 0.25, kStretchSigma = 0.06;

constexpr double kAround_s = 0.1;   // before and after a frame: a syllable's half
constexpr double kLids = 0.3;       // of the usual opening, more or less: half weight
constexpr double kFaces = 0.2;      // rad beyond the tenth that faces the camera most: half weight
constexpr double kTakesPart = 0.2;  // least weight of a frame of the rest
constexpr double kAlike = 2;        // standard deviations of K within which frames show the same rest
constexpr double kNeverMet = 0.12;  // lips apart at rest by this: they were never closed
constexpr double kUnlikely = 2.5;   // standard deviations from people's mouths at rest
constexpr double kLeastTrust = 0.2;

// 1 at zero, one half at `half`.
double fading(double value, double half) {
  const double t = std::max(0.0, value) / half;
  return 1 / (1 + t * t);
}

using Usable = std::vector<const RestFrame*>;

template <class Value>
std::vector<double> all(const Usable& frames, Value value) {
  std::vector<double> values;
  for (const RestFrame* f : frames) values.push_back(value(*f));
  return values;
}

// The middle of the values by weight.
double weighted_median(std::vector<double> values, const std::vector<double>& weights) {
  std::vector<std::size_t> order(values.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::sort(order, {}, [&](std::size_t i) { return values[i]; });
  double sum = 0, held = 0;
  for (const double w : weights) sum += w;
  for (const std::size_t i : order)
    if ((held += weights[i]) >= 0.5 * sum) return values[i];
  return 0;
}

// How much the mouth moves around each frame: the standard deviation of its width, opening and corners within
// kAround_s. Frames further apart in time say nothing of each other.
std::vector<double> motions(const Usable& frames) {
  std::vector<double> motion(frames.size(), 0);
  for (std::size_t i = 0, first = 0, end = 0; i < frames.size(); ++i) {
    while (frames[first]->time_s < frames[i]->time_s - kAround_s) ++first;
    while (end < frames.size() && frames[end]->time_s <= frames[i]->time_s + kAround_s) ++end;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero(), squares = Eigen::Vector3d::Zero();
    for (std::size_t k = first; k < end; ++k) {
      const FaceMeasures& m = frames[k]->face;
      const Eigen::Vector3d v(m.mouth_width, m.mouth_open, m.corner_lift);
      sum += v, squares += v.cwiseAbs2();
    }
    const double n = double(end - first);
    motion[i] = std::sqrt(std::max(0.0, (squares / n - (sum / n).cwiseAbs2()).sum()));
  }
  return motion;
}

// Of each usable frame: how likely it is that the face rests there, 0..1, whatever it looks like at rest.
std::vector<double> calm_weights(const Usable& frames, const std::vector<double>& motion) {
  const auto opens = all(frames, [](const RestFrame& f) { return f.face.mouth_open; });
  const double aside = median(all(frames, [](const RestFrame&f) { return f.face.mouth_aside; })),
               tilt = median(all(frames, [](const RestFrame&f) { return f.face.mouth_tilt; }));
  const double closed = quantile(opens, 0.05);
  const double still = std::min(quantile(motion, 0.1), 0.5 * kCalm),
               sigma = median(all(frames, [](const RestFrame&f) { return f.face.sigma; })),
               facing = quantile(all(frames, [](const RestFrame&f) { return f.face.turn; }), 0.1);
  std::vector<double> weights;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const RestFrame& f = *frames[i];
    weights.push_back(fading(motion[i] - still, kCalm) *
                      fading(f.face.mouth_open - closed - kRelaxed, kParted) *
                      fading(f.lids_known ? std::abs(1 - f.lids) : 0, kLids) *
                      fading(std::hypot(f.face.mouth_aside - aside, f.face.mouth_tilt - tilt), kAskew) *
                      fading(f.face.sigma - sigma, kUnsure) * fading(f.face.turn - facing, kFaces));
  }
  const double brows =
      weighted_median(all(frames, [](const RestFrame& f) { return f.face.brow_height; }), weights);
  for (std::size_t i = 0; i < frames.size(); ++i)
    weights[i] *= fading(frames[i]->face.brow_height - brows, kRaised);
  return weights;
}

// Squared distance in standard deviations of K.
double apart(const FaceMeasures& a, const FaceMeasures& b) {
  const double width = (a.mouth_width - b.mouth_width) / kAlikeWidth,
               lift = (a.corner_lift - b.corner_lift) / kAlikeLift,
               brows = (a.brow_height - b.brow_height) / kAlikeBrows;
  return width * width + lift * lift + brows * brows;
}

// How unlikely it is, in squared standard deviations, that a mouth at rest looks like this, where the clip
// shows mouths from `narrow` to `wide`.
double strangeness(const FaceMeasures& face, const UsualMouth& usual, double narrow, double wide) {
  const double width = (face.mouth_width - usual.width) / usual.width_sigma,
               lift = (face.corner_lift - usual.lift) / usual.lift_sigma;
  const double w = std::max(0.1, face.mouth_width);
  const double too_wide = std::max(0.0, std::log(w / narrow) - kStretch) / kStretchSigma,
               too_narrow = std::max(0.0, std::log(wide / w) - kStretch) / kStretchSigma;
  return width * width + lift * lift + too_wide * too_wide + too_narrow * too_narrow;
}

// The frame that shows the rest best. needed: frames like it that make a rest certain.
std::size_t find_centre(const Usable& frames, const std::vector<double>& weight, const UsualMouth& usual,
                        int needed) {
  const auto widths = all(frames, [](const RestFrame& f) { return f.face.mouth_width; });
  const double narrow = std::max(0.1, quantile(widths, 0.02)), wide = std::max(0.1, quantile(widths, 0.98));
  const double least = kTakesPart * *std::ranges::max_element(weight);
  std::size_t centre = 0;
  double best = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (weight[i] < least) continue;
    // What the frames like it look like: a single one's noise makes no rest of a smile.
    FaceMeasures mean;
    double support = 0;
    for (std::size_t j = 0; j < frames.size(); ++j) {
      const double w = weight[j] * std::exp(-0.5 * apart(frames[i]->face, frames[j]->face));
      support += w;
      mean.mouth_width += w * frames[j]->face.mouth_width;
      mean.corner_lift += w * frames[j]->face.corner_lift;
    }
    mean.mouth_width /= support, mean.corner_lift /= support;
    const double score =
        -0.5 * strangeness(mean, usual, narrow, wide) + std::log(support / (support + needed));
    if (score > best) best = score, centre = i;
  }
  return centre;
}

// The frames that the rest is read from: indices of usable ones, the best first.
std::vector<std::size_t> like_centre(const Usable& frames, const std::vector<double>& weight,
                                     std::size_t centre, int fewest, int most) {
  const double least = kTakesPart * *std::ranges::max_element(weight);
  std::vector<std::size_t> order(frames.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto likeness = [&](std::size_t i) {
    return weight[i] * std::exp(-0.5 * apart(frames[i]->face, frames[centre]->face));
  };
  std::ranges::stable_sort(order, std::ranges::greater(), likeness);
  std::vector<std::size_t> chosen;
  for (const std::size_t i : order) {
    if (int(chosen.size()) >= most) break;
    const bool alike = weight[i] >= least && apart(frames[i]->face, frames[centre]->face) <= kAlike * kAlike;
    if (alike || int(chosen.size()) < fewest) chosen.push_back(i);
  }
  return chosen;
}

// Frames that show the rest if it was held for long enough.
int frames_held(const Usable& frames, const RestOptions& options) {
  std::vector<double> gaps;
  for (std::size_t i = 1; i < frames.size(); ++i) gaps.push_back(frames[i]->time_s - frames[i - 1]->time_s);
  const double gap = median(gaps);
  const int held = gap > 0 ? int(std::lround(options.hold_s / gap)) : 0;
  return std::max(options.fewest, held);
}

RestChoice as_asked(const Usable& frames, std::span<const int> asked) {
  RestChoice choice;
  for (const RestFrame* f : frames)
    if (std::ranges::find(asked, f->frame) != asked.end()) choice.frames.push_back(f->frame);
  choice.asked = !choice.frames.empty();
  if (choice.asked) choice.why = "You named them.";
  return choice;
}

// What is wrong with the rest that was found: its trust, and the warning. motion: of the mouth in it.
void judge(const FaceMeasures& rest, double motion, const UsualMouth& usual, RestChoice& choice) {
  const double width = (rest.mouth_width - usual.width) / usual.width_sigma,
               lift = (rest.corner_lift - usual.lift) / usual.lift_sigma;
  const double smile = std::hypot(std::max(0.0, width), std::max(0.0, lift));
  std::string what;
  if (rest.mouth_open - usual.open > kNeverMet) {
    what = "The lips are never closed in a calm moment of this clip";
    choice.trust *= 0.5;
  } else if (smile > kUnlikely) {
    what = "The person seems to smile in all of this clip";
    choice.trust *= kUnlikely / smile;
  } else if (motion > kCalm) {
    what = "The mouth is never closed and calm for a moment in this clip";
    choice.trust *= kCalm / motion;
  }
  choice.trust = std::clamp(choice.trust, kLeastTrust, 1.0);
  if (!what.empty())
    choice.warning = what +
                     ": its resting face is partly a guess. Film two seconds with the mouth closed and the "
                     "face at ease, or name a frame that shows it.";
}

}  // namespace

RestChoice choose_rest(std::span<const RestFrame> frames, const UsualMouth& usual, std::span<const int> asked,
                       const RestOptions& options) {
  Usable usable;
  for (const RestFrame& f : frames)
    if (f.usable) usable.push_back(&f);
  if (usable.empty()) return {};
  if (RestChoice named = as_asked(usable, asked); named.asked) return named;
  const int needed = std::min(frames_held(usable, options), int(usable.size()));
  const std::vector<double> motion = motions(usable), weight = calm_weights(usable, motion);
  const auto chosen = like_centre(usable, weight, find_centre(usable, weight, usual, needed), needed,
                                  std::max(needed, options.most));
  RestChoice choice;
  Usable rest;
  for (const std::size_t i : chosen) rest.push_back(usable[i]), choice.frames.push_back(usable[i]->frame);
  std::ranges::sort(choice.frames);
  FaceMeasures middle;
  middle.mouth_width = median(all(rest, [](const RestFrame& f) { return f.face.mouth_width; }));
  middle.mouth_open = median(all(rest, [](const RestFrame& f) { return f.face.mouth_open; }));
  middle.corner_lift = median(all(rest, [](const RestFrame& f) { return f.face.corner_lift; }));
  std::vector<double> moved;
  for (const std::size_t i : chosen) moved.push_back(motion[i]);
  judge(middle, median(moved), usual, choice);
  if (!asked.empty())
    choice.warning =
        "None of the frames named as the resting face can be used: in each the face is held out, "
        "covered or not found. The fit has chosen others; name a frame that trains.";
  const double usually = median(all(usable, [](const RestFrame& f) { return f.face.mouth_width; }));
  choice.why = fmt::format(
      "The calmest of {} frames with a closed mouth: it is {:.0f} % {} than in the clip's middle frame.",
      usable.size(), 100 * std::abs(middle.mouth_width / usually - 1),
      middle.mouth_width <= usually ? "narrower" : "wider");
  return choice;
}

}  // namespace likeness
