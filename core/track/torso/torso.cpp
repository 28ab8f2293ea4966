// Rigid alignment of all frames to one picture, then twice: the median of the aligned training pictures
// becomes the template, pixels that the torso's motion does not explain lose weight, and the training frames
// are aligned again with a free grid of displacements. Components of those grids initialise the modes; they
// are fitted to all learning frames at once, the template renewed between. Every frame is then aligned once
// more with only the motion and the modes' coefficients. Frames in which the torso rests while the camera
// goes round (torso_rest.h) are not learnt from if there are others, and share one state.
#include "core/track/torso/torso.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>

#include "core/base/parallel.h"
#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/track/torso/torso_align.h"
#include "core/track/torso/torso_modes.h"
#include "core/track/torso/torso_picture.h"
#include "core/track/torso/torso_refine.h"
#include "core/track/torso/torso_rest.h"
#include "core/track/torso/torso_state.h"

namespace likeness {
namespace {

constexpr double kCell = 0.042;     // m between nodes
constexpr double kUnexplained = 8;  // grey levels: a pixel of this spread after alignment counts half
constexpr std::size_t kMinViews = 8;
constexpr int kRefineRounds = 3, kRefineSteps = 3;

// The training frame among `teaching` whose head position and direction are the most usual. There the neck is
// taken as straight, so that it bends least over the clip; and the choice does not depend on a head model's
// notion of facing forward.
int reference_frame(const std::vector<TorsoFrame>& frames, const std::vector<std::uint8_t>& teaching) {
  using Vec6d = Eigen::Matrix<double, 6, 1>;
  constexpr double kPerMetre = 4;  // rad equivalent to 1 m
  // Turn (rad, from facing the camera) and place (m).
  const auto stance = [&](const TorsoFrame& f) {
    const Mat3d facing = Vec3d(1, -1, -1).asDiagonal();
    Vec6d numbers;
    numbers << vector_from_turn((f.cam_from_world * f.world_from_head).linear() * facing.transpose()),
        kPerMetre * f.world_from_head.translation();
    return numbers;
  };
  std::vector<double> all[6];
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (teaching[i])
      for (int k = 0; k < 6; ++k) all[k].push_back(stance(frames[i])[k]);
  if (all[0].empty()) return -1;
  Vec6d usual;
  for (int k = 0; k < 6; ++k) usual[k] = median(std::move(all[k]));
  int best = -1;
  double least = 1e30;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!teaching[i]) continue;
    const Vec6d off = stance(frames[i]) - usual;
    const double score = off.head<3>().norm() + off.tail<3>().norm();
    if (score < least) least = score, best = static_cast<int>(i);
  }
  return best;
}

struct Work {
  const std::vector<TorsoFrame>* frames;
  std::size_t reference_frame;
  Pose reference;  // world_from_torso
  bool approaches;
  TorsoTemplate body;
  TorsoGrid grid;
  std::vector<std::vector<GreyLevel>> pictures;   // (frames); empty but for those in use
  std::vector<std::optional<TorsoState>> states;  // (frames)
  std::vector<std::size_t> learning;              // indices of frames

  TorsoView view(std::size_t frame, std::size_t level) const {
    return {&pictures[frame][level], &(*frames)[frame], reference, approaches, head_moved(frame).z()};
  }
  // Of the head against the reference, in the reference torso's axes, m.
  Vec3d head_moved(std::size_t frame) const {
    return (inverse(reference) * (*frames)[frame].world_from_head).translation();
  }
  // Where a frame's torso is looked for first: where another frame has it, or, with a camera that may have
  // come nearer, as far from there as the head went.
  TorsoState start(std::size_t frame, std::optional<std::size_t> from) const {
    TorsoState state = from ? *states[*from] : TorsoState{};
    if (!approaches) return state;
    const Vec3d way = head_moved(frame) - (from ? head_moved(*from) : Vec3d::Zero());
    state.motion.shift += way.head<2>();
    state.motion.depth += way.z();
    return state;
  }
  double align(std::size_t frame, std::size_t level, TorsoFreedom freedom, const TorsoModes* modes,
               int iterations, TorsoState* state) const {
    return align_torso(body.levels[level], view(frame, level), body.pivot, grid, modes, freedom, iterations,
                       state);
  }
};

TorsoGrid grid_over(const std::vector<TorsoPixel>& pixels) {
  Vec2d low = Vec2d::Constant(1e9), high = -low;
  for (const TorsoPixel& t : pixels)
    low = low.cwiseMin(t.place.head<2>()), high = high.cwiseMax(t.place.head<2>());
  TorsoGrid grid;
  grid.cell = float(kCell);
  grid.origin = low.cast<float>();
  grid.columns = std::max(2, int(std::ceil((high.x() - low.x()) / kCell)) + 1);
  grid.rows = std::max(2, int(std::ceil((high.y() - low.y()) / kCell)) + 1);
  return grid;
}

bool believable(const TorsoMotion& m, double difference) {
  return difference < 1e8 && m.shift.norm() < 0.5 && std::abs(m.depth) < 0.8 && std::abs(m.angle) < 0.7;
}

// A frame starts from the last one: a training frame from the last training frame. After a cut it starts
// there and in the middle, and the better end counts.
template <typename Align>
Result<void> follow(Work& work, const Progress& progress, std::stop_token stop, const Align& align) {
  std::optional<std::size_t> last, last_training;
  const auto& frames = *work.frames;
  int shot = 0, training_shot = 0;  // of the last ones
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (stop.stop_requested()) return cancelled_error();
    if (i % 8 == 0) progress.report(double(i) / double(frames.size()), "following the torso");
    if (!frames[i].usable) continue;
    const bool known = work.states[i].has_value();
    const bool cut = !known && frames[i].shot != (frames[i].held_out ? shot : training_shot);
    TorsoState state = known ? *work.states[i] : work.start(i, frames[i].held_out ? last : last_training);
    work.states[i].reset();
    const bool keep = !work.pictures[i].empty();
    if (!keep) work.pictures[i] = relief_pyramid(*frames[i].grey);
    double difference = align(i, &state);
    if (cut) {
      TorsoState middle = work.start(i, std::nullopt);
      if (const double other = align(i, &middle); other < difference) difference = other, state = middle;
    }
    if (!keep) work.pictures[i].clear();
    // A motion impossible for a body while the head is still in the picture: keep the last good one.
    if (!believable(state.motion, difference)) continue;
    work.states[i] = state;
    last = i, shot = frames[i].shot;
    if (!frames[i].held_out) last_training = i, training_shot = shot;
  }
  return {};
}

// Values of the learning frames that show one template pixel, unmoved or as aligned.
void values_at(const Work& work, const std::vector<Pose>& poses, std::size_t level, const TorsoPixel& t,
               bool moved, std::vector<float>* values) {
  values->clear();
  for (std::size_t k = 0; k < work.learning.size(); ++k) {
    const std::size_t i = work.learning[k];
    const TorsoState& state = *work.states[i];
    const Vec3d posed = moved ? displaced(work.grid, state.displacement, t.place) : t.place;
    Vec2d px;
    float value;
    if (seen_at(work.view(i, level), moved ? poses[k] : Pose::Identity(), posed, &px) &&
        work.pictures[i][level].sample(px.x(), px.y(), &value, nullptr))
      values->push_back(value);
  }
}

// Median and mean absolute deviation from it.
std::pair<float, float> agree(const std::vector<float>& values) {
  const float usual = median(values);
  float spread = 0;
  for (const float v : values) spread += std::abs(v - usual);
  return {usual, spread / float(values.size())};
}

// The median of the aligned training pictures. Pixels that still differ count less; those that agree better
// unmoved are background and get no weight.
void renew_template(Work& work) {
  std::vector<Pose> poses;
  for (const std::size_t i : work.learning)
    poses.push_back(motion_pose(work.states[i]->motion, work.body.pivot));
  for (std::size_t level = 0; level < work.body.levels.size(); ++level) {
    auto& pixels = work.body.levels[level];
    parallel_for(pixels.size(), [&](std::size_t p) {
      std::vector<float> values;
      TorsoPixel& t = pixels[p];
      values_at(work, poses, level, t, false, &values);
      const float still = values.size() < kMinViews ? 1e9f : agree(values).second;
      values_at(work, poses, level, t, true, &values);
      t.weight = 0;
      if (values.size() < std::max(kMinViews, work.learning.size() / 4)) return;
      const auto [median, spread] = agree(values);
      t.value = median;
      if (spread > 1.15f * still + 1) return;
      t.weight = float(1 / (1 + std::pow(spread / kUnexplained, 2)));
    });
  }
}

// Alternates modes, template and the learning frames' states. Returns the displacements of the frames that
// the modes explain; the others are no longer learnt from.
Result<std::vector<std::vector<float>>> refine(Work& work, TorsoModes* modes, const Progress& progress,
                                               std::stop_token stop) {
  for (const std::size_t i : work.learning) work.states[i]->shape = {};
  for (int round = 0; round < kRefineRounds; ++round) {
    std::vector<std::uint8_t> explained(work.learning.size(), 0);
    parallel_for(work.learning.size(), [&](std::size_t k) {
      if (stop.stop_requested()) return;
      TorsoState tried = *work.states[work.learning[k]];
      const double difference = work.align(work.learning[k], 0, TorsoFreedom::modes, modes, 8, &tried);
      if (!believable(tried.motion, difference)) return;
      *work.states[work.learning[k]] = std::move(tried);
      explained[k] = 1;
    });
    if (stop.stop_requested()) return cancelled_error();
    std::vector<std::size_t> kept;
    for (std::size_t k = 0; k < explained.size(); ++k)
      if (explained[k]) kept.push_back(work.learning[k]);
    if (kept.size() < std::size_t(kMinimumTorsoFrames)) return std::vector<std::vector<float>>{};  // rigid
    work.learning = std::move(kept);
    renew_template(work);
    std::vector<TorsoView> views;
    std::vector<TorsoState*> states;
    for (const std::size_t i : work.learning)
      views.push_back(work.view(i, 0)), states.push_back(&*work.states[i]);
    refine_torso_modes(work.body.levels[0], views, work.body.pivot, kRefineSteps, stop, states, modes);
    if (stop.stop_requested()) return cancelled_error();
    progress.report(double(round + 1) / kRefineRounds, "learning how the torso deforms");
  }
  renew_template(work);
  std::vector<std::vector<float>> displacements;
  for (const std::size_t i : work.learning) {
    displacements.push_back(work.states[i]->displacement);
    work.states[i]->shape = {};
  }
  return displacements;
}

Result<TorsoModes> learn(Work& work, const Progress& progress, std::stop_token stop) {
  for (int round = 0; round < 2; ++round) {
    renew_template(work);
    if (stop.stop_requested()) return cancelled_error();
    parallel_for(work.learning.size(), [&](std::size_t k) {
      if (stop.stop_requested()) return;
      TorsoState& state = *work.states[work.learning[k]];
      TorsoState tried = state;
      double difference = 0;
      for (const std::size_t level : {1, 0})
        difference = work.align(work.learning[k], level, TorsoFreedom::nodes, nullptr, 5, &tried);
      if (believable(tried.motion, difference)) state = tried;
    });
    if (stop.stop_requested()) return cancelled_error();
    progress.report(0.25 * (round + 1), "learning how the torso deforms");
  }
  renew_template(work);
  std::vector<std::vector<float>> displacements;
  for (const std::size_t i : work.learning)
    if (!work.states[i]->displacement.empty()) displacements.push_back(work.states[i]->displacement);
  const auto reference = std::find_if(work.learning.begin(), work.learning.end(),
                                      [&](std::size_t i) { return !work.states[i]->displacement.empty(); });
  if (reference == work.learning.end()) return TorsoModes{};
  const Eigen::MatrixXd metric = picture_metric(work.body.levels[0], work.view(*reference, 0), work.grid);
  TorsoModes modes = learn_torso_modes(work.grid, displacements, metric, work.body.pivot);
  if (modes.empty()) return modes;
  const auto refined = refine(work, &modes, progress.stage(0.5, 1, ""), stop);
  if (!refined) return refined.error();
  // Makes them orthogonal again, in standard deviations.
  return learn_torso_modes(work.grid, *refined, metric, work.body.pivot);
}

void choose_learning(Work& work, const std::vector<std::uint8_t>& teaching, int count) {
  std::vector<std::size_t> training;
  for (std::size_t i = 0; i < work.states.size(); ++i)
    if (work.states[i] && teaching[i]) training.push_back(i);
  const std::size_t kept = std::min(training.size(), std::size_t(std::max(0, count)));
  for (std::size_t k = 0; k < kept; ++k) work.learning.push_back(training[k * training.size() / kept]);
}

// Training frames from which template and modes are learnt.
struct Teaching {
  std::vector<std::uint8_t> frames;  // those in which the torso moves, if there are enough
  bool deforms = true;               // whether they show how the torso moves
};

Teaching teaching_frames(const std::vector<TorsoFrame>& frames, const std::vector<int>& rests) {
  std::vector<std::uint8_t> training(frames.size(), 0), moving = training;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    training[i] = frames[i].usable && !frames[i].held_out;
    moving[i] = training[i] && rests[i] < 0;
  }
  if (std::ranges::count(moving, 1) >= kMinimumTorsoFrames) return {moving, true};
  return {training, moving == training};
}

// The state of a torso at rest, from the frames whose cameras are nearest to the reference's, for which the
// template's depth matters least. nullopt if no training frame has one.
std::optional<TorsoState> state_at_rest(const Work& work, const std::vector<std::size_t>& stretch) {
  constexpr std::size_t kNearest = 5;
  const auto& frames = *work.frames;
  const auto direction = [&](std::size_t i) {
    return Vec3d((inverse(work.reference) * inverse(frames[i].cam_from_world)).translation().normalized());
  };
  std::vector<std::pair<double, std::size_t>> near;
  for (const std::size_t i : stretch)
    if (work.states[i] && !frames[i].held_out)
      near.emplace_back(1 - direction(i).dot(direction(work.reference_frame)), i);
  if (near.empty()) return std::nullopt;
  std::ranges::sort(near);
  near.resize(std::min(near.size(), kNearest));
  const auto usual = [&](const auto& number) {
    std::vector<double> values;
    for (const auto& [angle, i] : near) values.push_back(number(*work.states[i]));
    return median(std::move(values));
  };
  TorsoState state;
  state.motion.angle = usual([](const TorsoState& s) { return s.motion.angle; });
  for (int k = 0; k < 2; ++k)
    state.motion.shift[k] = usual([k](const TorsoState& s) { return s.motion.shift[k]; });
  state.motion.depth = usual([](const TorsoState& s) { return s.motion.depth; });
  for (std::size_t m = 0; m < state.shape.size(); ++m)
    state.shape[m] = float(usual([m](const TorsoState& s) { return double(s.shape[m]); }));
  return state;
}

void rest(Work& work, const std::vector<int>& rests) {
  std::map<int, std::vector<std::size_t>> stretches;
  for (std::size_t i = 0; i < rests.size(); ++i)
    if (rests[i] >= 0) stretches[rests[i]].push_back(i);
  for (const auto& [number, stretch] : stretches)
    if (const auto state = state_at_rest(work, stretch))
      for (const std::size_t i : stretch) work.states[i] = state;
}

// Frames without a result keep the torso's last known pose.
void describe(const Work& work, TorsoTrack* track) {
  const auto& frames = *work.frames;
  const TorsoState* last = nullptr;
  const TorsoState* last_training = nullptr;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const TorsoState* state = work.states[i] ? &*work.states[i] : (frames[i].held_out ? last : last_training);
    if (work.states[i]) {
      last = state;
      if (!frames[i].held_out) last_training = state;
    }
    if (!state) continue;
    track->world_from_torso[i] = work.reference * motion_pose(state->motion, work.body.pivot);
    if (!track->modes.empty()) track->shapes[i] = state->shape;
  }
}

}  // namespace

Result<TorsoTrack> track_torso(const std::vector<TorsoFrame>& frames, const Vec3d& chin,
                               const Progress& progress, std::stop_token stop, const TorsoOptions& options) {
  TorsoTrack track;
  track.world_from_torso.assign(frames.size(), Pose::Identity());
  track.shapes.assign(frames.size(), TorsoShape{});
  const std::vector<int> rests = resting_torso(frames);
  const Teaching teaching = teaching_frames(frames, rests);
  track.reference = reference_frame(frames, teaching.frames);
  if (track.reference < 0) return track;
  const TorsoFrame& reference = frames[std::size_t(track.reference)];
  track.world_from_torso.assign(frames.size(), reference.world_from_head);
  Work work{&frames,
            std::size_t(track.reference),
            reference.world_from_head,
            options.approaches,
            make_torso_template(reference, chin),
            {},
            {},
            {},
            {}};
  track.has_torso = work.body.picture_share > kLeastTorsoShare;
  if (!track.has_torso) return track;
  work.pictures.resize(frames.size()), work.states.resize(frames.size());
  work.grid = grid_over(work.body.levels[1]);

  // -- Rigid, to the reference picture.
  const auto rigid = [&](std::size_t i, TorsoState* state) {
    double difference = 0;
    for (const std::size_t level : {2, 1, 0})
      difference = work.align(i, level, TorsoFreedom::rigid, nullptr, level == 0 ? 5 : 10, state);
    return difference;
  };
  if (auto followed = follow(work, progress.stage(0, 0.25, ""), stop, rigid); !followed)
    return followed.error();
  choose_learning(work, teaching.frames, options.learning_frames);
  if (work.learning.empty()) return track;
  parallel_for(work.learning.size(), [&](std::size_t k) {
    work.pictures[work.learning[k]] = relief_pyramid(*frames[work.learning[k]].grey);
  });
  if (options.deform && teaching.deforms) {
    auto modes = learn(work, progress.stage(0.25, 0.7, ""), stop);
    if (!modes) return modes.error();
    track.modes = std::move(*modes);
  } else {
    renew_template(work);
  }

  // -- Every frame against the now frozen template and modes.
  double before = 0, moved = 0, after = 0;
  int counted = 0;
  const auto all = [&](std::size_t i, TorsoState* state) {
    state->displacement.clear();
    TorsoState still;
    const double unmoved = work.align(i, 0, TorsoFreedom::rigid, nullptr, 1, &still);
    double difference = 0;
    for (const std::size_t level : {1, 0})
      difference = work.align(i, level, TorsoFreedom::rigid, nullptr, 6, state);
    const double only_rigid = difference;
    if (!track.modes.empty())
      for (const std::size_t level : {1, 0})
        difference = work.align(i, level, TorsoFreedom::modes, &track.modes, 8, state);
    if (difference < 1e8 && unmoved < 1e8)
      before += unmoved, moved += only_rigid, after += difference, ++counted;
    return difference;
  };
  if (auto followed = follow(work, progress.stage(0.7, 1, ""), stop, all); !followed) return followed.error();
  if (counted > 0) {
    track.residual_before = before / counted;
    track.residual_rigid = moved / counted;
    track.residual_after = after / counted;
  }
  rest(work, rests);
  describe(work, &track);
  progress.report(1);
  return track;
}

}  // namespace likeness
