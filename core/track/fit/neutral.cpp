// The mode of a face: see neutral.h.
#include "core/track/fit/neutral.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/mean_rotation.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/head/action_amounts.h"
#include "core/track/frame_spacing.h"

namespace likeness {
namespace {

constexpr std::size_t kFewestFrames = 10;
constexpr int kNeighbours = 5;          // frames before and after that distinguish speech from rest
constexpr float kSpeechMotion = 0.06f;  // of the jaw's full opening, mean change: half weight
constexpr float kOpenMouth = 0.12f;     // of the jaw's full opening beyond its lower tenth: half weight
constexpr float kShutLids = 0.3f;       // of eyeBlink beyond its lower tenth: half weight
constexpr double kFacing = 0.2;         // rad from the typical head turn: half weight for the eyes

struct Weighted {
  float value = 0, weight = 1;
};

float total(const std::vector<Weighted>& samples) {
  float sum = 0;
  for (const Weighted& s : samples) sum += s.weight;
  return sum;
}

// The shortest stretch of sorted samples that holds `share` of their weight.
std::vector<Weighted> shortest_stretch(const std::vector<Weighted>& sorted, float share) {
  const float wanted = share * total(sorted);
  std::size_t best_from = 0, best_to = sorted.size();
  float held = 0, best_length = sorted.back().value - sorted.front().value;
  for (std::size_t from = 0, to = 0; from < sorted.size(); held -= sorted[from++].weight) {
    while (to < sorted.size() && held < wanted) held += sorted[to++].weight;
    if (held < wanted) break;
    const float length = sorted[to - 1].value - sorted[from].value;
    if (length < best_length) best_length = length, best_from = from, best_to = to;
  }
  return {sorted.begin() + std::ptrdiff_t(best_from), sorted.begin() + std::ptrdiff_t(best_to)};
}

// Mode by halving twice, then the median of the rest: as robust as a median, but of the densest quarter.
float mode_of(std::vector<Weighted> samples) {
  std::erase_if(samples, [](const Weighted& s) { return !(s.weight > 0); });
  if (samples.empty()) return 0;
  std::ranges::sort(samples, {}, &Weighted::value);
  for (int halving = 0; halving < 2 && samples.size() > 8; ++halving)
    samples = shortest_stretch(samples, 0.5f);
  const float middle = 0.5f * total(samples);
  float held = 0;
  for (const Weighted& s : samples) {
    held += s.weight;
    if (held >= middle) return s.value;
  }
  return samples.back().value;
}

// 1 at zero, one half at `half`.
float falling(float value, float half) {
  const float t = std::max(0.0f, value) / half;
  return 1 / (1 + t * t);
}

// Signs of rest or action, per frame.
struct Signs {
  std::vector<float> jaw, lids, motion;
};

Signs signs_of(const HeadModel& model, const std::vector<const TrackedFrame*>& frames) {
  const ActionBasis basis = action_basis(model);
  const int jaw = action_index(basis, "jawOpen"), left = action_index(basis, "eyeBlink_L"),
            right = action_index(basis, "eyeBlink_R");
  const std::size_t n = frames.size();
  struct Moment {
    int frame;
    double time_s;
  };
  std::vector<Moment> moments;
  for (const TrackedFrame* frame : frames) moments.push_back({frame->frame, frame->time_s});
  const int spacing = frame_spacing(moments);
  Signs signs{std::vector<float>(n), std::vector<float>(n), std::vector<float>(n)};
  std::vector<Eigen::VectorXf> mouth(n);
  for (std::size_t i = 0; i < n; ++i) {
    Eigen::VectorXf amounts = face_amounts(basis, frames[i]->pose.articulation);
    signs.jaw[i] = jaw >= 0 ? amounts[jaw] : frames[i]->pose.articulation.jaw.norm();
    signs.lids[i] = std::max(left >= 0 ? amounts[left] : 0, right >= 0 ? amounts[right] : 0);
    // Speech is detected by jaw and mouth alone: brows and lids move at rest too.
    for (Eigen::Index a = 0; a < amounts.size(); ++a) {
      const std::string& name = basis.actions[std::size_t(a)].name;
      if (!name.starts_with("mouth") && !name.starts_with("jaw")) amounts[a] = 0;
    }
    mouth[i] = amounts.size() > 0 ? amounts : Eigen::VectorXf(frames[i]->pose.articulation.jaw);
  }
  for (std::size_t i = 0; i < n; ++i) {
    float sum = 0;
    int count = 0;
    for (int k = -kNeighbours; k < kNeighbours; ++k) {
      const std::ptrdiff_t j = std::ptrdiff_t(i) + k;
      if (j < 0 || j + 1 >= std::ptrdiff_t(n)) continue;
      const std::size_t a = std::size_t(j);
      if (frames[a + 1]->frame - frames[a]->frame > 2 * spacing) continue;
      sum += (mouth[a + 1] - mouth[a]).norm();
      ++count;
    }
    signs.motion[i] = count > 0 ? sum / float(count) : 0;
  }
  return signs;
}

std::vector<float> face_weights(const Signs& signs) {
  const float jaw = quantile(signs.jaw, 0.1), lids = quantile(signs.lids, 0.1),
              still = quantile(signs.motion, 0.1);
  std::vector<float> weights(signs.jaw.size());
  for (std::size_t i = 0; i < weights.size(); ++i)
    weights[i] = falling(signs.jaw[i] - jaw, kOpenMouth) * falling(signs.lids[i] - lids, kShutLids) *
                 falling(signs.motion[i] - still, kSpeechMotion);
  return weights;
}

// Expression and jaw of a face that was chosen frame by frame.
void read_rest(const std::vector<const TrackedFrame*>& frames, double trust, Articulation& neutral) {
  std::vector<float> values;
  const auto middle = [&](auto&& value) {
    values.clear();
    for (const TrackedFrame* frame : frames) values.push_back(value(frame->pose.articulation));
    return float(trust) * median(values);
  };
  for (Eigen::Index e = 0; e < neutral.expression.size(); ++e)
    neutral.expression[e] = middle([&](const Articulation& a) { return a.expression[e]; });
  for (int k = 0; k < 3; ++k) neutral.jaw[k] = middle([&](const Articulation& a) { return a.jaw[k]; });
}

// How far each frame's head is turned from the usual: their chordal mean, rad.
std::vector<double> turns_from_usual(const std::vector<const TrackedFrame*>& frames) {
  std::vector<Mat3d> rotations;
  for (const TrackedFrame* frame : frames) rotations.push_back(frame->pose.world_from_head.linear());
  const Mat3d usual = mean_rotation(rotations);
  std::vector<double> turns;
  for (const TrackedFrame* frame : frames)
    turns.push_back(rotation_angle(usual.transpose() * frame->pose.world_from_head.linear()));
  return turns;
}

}  // namespace

Articulation calibrate_neutral(const HeadModel& model, std::span<const TrackedFrame> frames,
                               const std::set<int>& held_out, const RestChoice& rest) {
  Articulation neutral = neutral_articulation(model);
  std::vector<const TrackedFrame*> chosen, usable, resting;
  for (const TrackedFrame& frame : frames) {
    if (held_out.contains(frame.frame) || frame.status == FrameStatus::lost) continue;
    usable.push_back(&frame);
    if (std::ranges::binary_search(rest.frames, frame.frame)) resting.push_back(&frame);
    if (frame.status == FrameStatus::good) chosen.push_back(&frame);
  }
  if (chosen.size() < kFewestFrames) chosen = usable;
  if (chosen.empty()) return neutral;
  const std::vector<float> weights = face_weights(signs_of(model, chosen));
  std::vector<Weighted> samples(chosen.size());
  const auto mode = [&](const std::vector<float>& weight, auto&& value) {
    for (std::size_t i = 0; i < chosen.size(); ++i)
      samples[i] = {value(chosen[i]->pose.articulation), weight[i]};
    return mode_of(samples);
  };
  if (!resting.empty()) read_rest(resting, rest.trust, neutral);
  for (Eigen::Index e = 0; resting.empty() && e < neutral.expression.size(); ++e)
    neutral.expression[e] = mode(weights, [&](const Articulation& a) { return a.expression[e]; });
  std::vector<float> facing = weights;
  const std::vector<double> turns = turns_from_usual(chosen);
  for (std::size_t i = 0; i < facing.size(); ++i) facing[i] *= falling(float(turns[i]), float(kFacing));
  for (int k = 0; k < 3; ++k) {
    if (resting.empty()) neutral.jaw[k] = mode(weights, [&](const Articulation& a) { return a.jaw[k]; });
    neutral.left_eye[k] = mode(facing, [&](const Articulation& a) { return a.left_eye[k]; });
    neutral.right_eye[k] = mode(facing, [&](const Articulation& a) { return a.right_eye[k]; });
  }
  return neutral;
}

}  // namespace likeness
