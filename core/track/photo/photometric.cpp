#include "core/track/photo/photometric.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <new>
#include <string>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/track/photo/photometric_mouth.h"

namespace likeness {
namespace {

constexpr std::size_t kBatch = 16;     // frames between two checks of the stop token
constexpr int kIterations = 4;         // per picture size
constexpr double kOpenMouth = 0.004;   // m: certainly open, its inside may be sampled
constexpr double kMouthMargin = 4;     // log likelihood by which another mouth opening must be better
constexpr double kFarSigmas = 2;       // a reading nearer to the fitted opening adds nothing
constexpr double kWorthAJump = 0.002;  // m: about the error of a reading due to teeth between the lips
constexpr double kParted = 0.0015;     // m over the shut mouth's gap: it may still be shut
constexpr double kShutSigma = 0.001;   // m

class ClipRefiner {
 public:
  ClipRefiner(const HeadModel& model, const HeadShape& person, const ReducedHead& head,
              const ReducedPerson& landmark_person, const ExpressionPrior& prior,
              const std::vector<PhotometricFrame>& pictures, const PhotometricOptions& options,
              std::vector<FaceFrame>& faces)
      : model_(model),
        head_(head),
        landmark_person_(landmark_person),
        prior_(prior),
        pictures_(pictures),
        options_(options),
        faces_(faces),
        landmark_hold_(std::ranges::any_of(faces, &FaceFrame::pose_given) ? options.hold_among_dense
                                                                          : options.hold_without_dense),
        surface_(face_surface(model, person)) {
    for (const FaceFrame& f : faces) given_.push_back(f.state);
    for (std::size_t i = 0; i < faces.size(); ++i)
      if (usable(i) && !faces[i].held_out) training_.push_back(i);
  }

  std::size_t training_frames() const { return training_.size(); }
  const Appearance& appearance() const { return appearance_; }

  // Albedo, light and the mouth's inside from training frames spread over the clip.
  void look(std::stop_token stop) {
    std::vector<std::size_t> chosen;
    const std::size_t n = std::min<std::size_t>(options_.appearance_frames, training_.size());
    for (std::size_t k = 0; k < n; ++k) chosen.push_back(training_[k * training_.size() / n]);
    Appearance found = find_appearance(surface_, head_, landmark_person_, pictures_, faces_, chosen, stop);
    if (!stop.stop_requested()) appearance_ = found;
  }

  // Every frame starts from the states of the previous round, so the order does not matter.
  Result<void> refine_all(int round, const Progress& progress, std::stop_token stop) {
    const std::vector<FaceFrame> before = faces_;
    changed_.assign(faces_.size(), 0);
    try {
      for (std::size_t from = 0; from < faces_.size(); from += kBatch) {
        progress.report(static_cast<double>(from) / static_cast<double>(faces_.size()),
                        "comparing the face with the pictures");
        parallel_for(std::min(kBatch, faces_.size() - from), [&](std::size_t k) {
          if (usable(from + k) && !stop.stop_requested()) refine(from + k, round, before);
        });
        if (stop.stop_requested()) return cancelled_error();
      }
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& e) {
      return Error{ErrorCode::failed, "Comparing the face with the pictures failed: " + std::string(e.what()),
                   "Run the fit again; if it fails again, report this message.", "photometric fit"};
    }
    return {};
  }

  // Mean absolute difference between appearance and picture, training frames, encoded levels.
  double error() const {
    const std::size_t n = std::min<std::size_t>(40, training_.size());
    std::vector<double> sums(n, 0), counts(n, 0);
    parallel_for(n, [&](std::size_t k) {
      const std::size_t i = training_[k * training_.size() / n];
      const FacePicture picture = picture_of(i);
      const FaceTarget target = face_target(surface_, appearance_, picture, 1, surface_.fine,
                                            pictures_[i].world_from_cam, faces_[i].state);
      // With every residual in its linear range, the cost is the scaled absolute difference.
      FrameSystem one;
      add_photometric(surface_, picture, target, 1, faces_[i].state, &one);
      sums[k] = one.cost;
      counts[k] = static_cast<double>(target.point.size());
    });
    double sum = 0, count = 0;
    for (std::size_t k = 0; k < n; ++k) sum += sums[k], count += counts[k];
    return count > 0 ? sum / count : 0;
  }

  int changed() const { return static_cast<int>(std::count(changed_.begin(), changed_.end(), 1)); }

 private:
  bool usable(std::size_t i) const { return faces_[i].seen && pictures_[i].grey; }
  FacePicture picture_of(std::size_t i) const {
    return face_picture(*pictures_[i].grey, pictures_[i].intrinsics);
  }

  FramePull pull_of(std::size_t i, const std::vector<FaceFrame>& before) const {
    const FaceFrame& own = before[i];
    FramePull pull;
    pull.cam_from_head = given_[i].cam_from_head;
    const double certain = own.pose_given ? 1 : landmark_hold_;
    pull.turn_weight = certain * options_.turn_hold;
    pull.shift_weight = certain * options_.shift_hold;
    pull.expression = Eigen::VectorXd::Zero(own.state.expression.size());
    if (own.held_out) {
      pull.expression = given_[i].expression;
      pull.jaw = given_[i].jaw;
      pull.expression_weight = options_.own_hold;
      pull.jaw_weight = 2 * options_.own_hold;
      return pull;
    }
    double count = 0;
    for (std::ptrdiff_t step : {-1, 1}) {
      const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(i) + step;
      if (j < 0 || j >= static_cast<std::ptrdiff_t>(before.size())) continue;
      const FaceFrame& n = before[static_cast<std::size_t>(j)];
      if (!n.seen || n.held_out || n.shot != own.shot || n.frame != own.frame + step * options_.spacing)
        continue;
      pull.expression += n.state.expression, pull.jaw += n.state.jaw, ++count;
    }
    if (count == 0) return pull;
    pull.expression /= count;
    pull.jaw /= count;
    pull.expression_weight = options_.expression_change * std::sqrt(count);
    pull.jaw_weight = 2 * pull.expression_weight;  // a full opening is about half a radian
    return pull;
  }

  void refine(std::size_t i, int round, const std::vector<FaceFrame>& before) {
    const FacePicture picture = picture_of(i);
    const FramePull pull = pull_of(i, before);
    FaceObservation observation = before[i].observation;
    for (double& s : observation.sigma_px) s *= options_.landmark_sigma_factor;
    const auto terms = [&](const FaceObservation& o) {
      return FrameEvidenceTerms{head_,
                                landmark_person_,
                                o,
                                prior_,
                                pull,
                                surface_,
                                appearance_,
                                picture,
                                pictures_[i].world_from_cam,
                                options_.weight};
    };
    const bool last = round + 1 == options_.rounds;
    const int first_level = last && round > 0 ? 1 : 2;
    const auto solve = [&](const FaceObservation& o, FaceState state) {
      for (int level = first_level; level >= first_level - 1; --level)
        state = refine_state(terms(o), level, kIterations, state);
      return state;
    };
    FaceState state = solve(observation, before[i].state);
    if (last && options_.read_mouth) state = with_mouth_read(i, picture, observation, state, solve);
    faces_[i].state = state;
  }

  // The state with the mouth as open as its pixels say: a fit started at closed lips over a lowered chin does
  // not find parted ones, and vice versa, so both are solved for and the pixels decide.
  template <class Solve>
  FaceState with_mouth_read(std::size_t i, const FacePicture& picture, const FaceObservation& observation,
                            FaceState state, const Solve& solve) {
    const Mat3d& turn = pictures_[i].world_from_cam;
    const double fitted = lip_gap(head_, landmark_person_, state);
    const auto try_mouth = [&](const LipEvidence& lips, const FaceState& start) {
      FaceObservation read = observation;
      observe_mouth(lips, fitted, &read);
      const FaceState other = solve(read, start);
      const double gain = mouth_gain(surface_, appearance_, picture, turn, state, other);
      // Reaching it only half way does not count: the fit did not accept the proposed opening.
      const double got = lip_gap(head_, landmark_person_, other);
      const bool arrived = std::abs(got - lips.gap_m) < std::abs(got - fitted);
      if (gain <= kMouthMargin || !arrived || std::abs(got - fitted) < kWorthAJump) return;
      state = other;
      changed_[i] = 1;
    };
    const auto mouth =
        read_mouth(model_, head_, landmark_person_, surface_, appearance_, picture, turn, state);
    if (!mouth) return state;
    faces_[i].observation.lips = mouth->lips;  // for whoever asks how the face looked
    const FaceState shut = with_jaw(model_, state, 0);
    const double least = lip_gap(head_, landmark_person_, shut);
    if (std::abs(fitted - mouth->lips.gap_m) > kFarSigmas * mouth->lips.sigma_m)
      try_mouth(mouth->lips, mouth->likeliest);
    if (std::max(fitted, mouth->lips.gap_m) > least + kParted) try_mouth({true, least, kShutSigma}, shut);
    return state;
  }

  const HeadModel& model_;
  const ReducedHead& head_;
  const ReducedPerson& landmark_person_;
  const ExpressionPrior& prior_;
  const std::vector<PhotometricFrame>& pictures_;
  const PhotometricOptions& options_;
  std::vector<FaceFrame>& faces_;
  const double landmark_hold_;
  const FaceSurface surface_;
  std::vector<FaceState> given_;
  std::vector<std::size_t> training_;
  std::vector<int> changed_;
  Appearance appearance_;
};

}  // namespace

Appearance find_appearance(const FaceSurface& surface, const ReducedHead& head,
                           const ReducedPerson& landmark_person,
                           const std::vector<PhotometricFrame>& pictures, const std::vector<FaceFrame>& faces,
                           const std::vector<std::size_t>& chosen, std::stop_token stop) {
  const std::size_t n = chosen.size();
  std::array<std::vector<std::vector<LightSample>>, kPictureLevels> samples;
  for (auto& s : samples) s.resize(n);
  std::vector<std::array<double, Appearance::kTones>> tones(n);
  parallel_for(n, [&](std::size_t k) {
    tones[k].fill(0);
    if (stop.stop_requested()) return;
    const std::size_t i = chosen[k];
    const FaceState& state = faces[i].state;
    const FacePicture picture = face_picture(*pictures[i].grey, pictures[i].intrinsics);
    for (int l = 0; l < kPictureLevels; ++l)
      samples[l][k] = light_samples(surface, picture, l, pictures[i].world_from_cam, state);
    if (lip_gap(head, landmark_person, state) > kOpenMouth) count_cavity(surface, picture, state, &tones[k]);
  });
  Appearance appearance;
  if (stop.stop_requested()) return appearance;
  const int count = surface.points.points;
  appearance.level[kPictureLevels - 1] = light_points(samples[kPictureLevels - 1], count);
  appearance.light = appearance.level[kPictureLevels - 1].light;
  parallel_for(kPictureLevels - 1, [&](std::size_t l) {
    appearance.level[l] = light_points(samples[l], count, &appearance.light);
  });
  std::array<double, Appearance::kTones> sum{};
  for (const auto& t : tones)
    for (int k = 0; k < Appearance::kTones; ++k) sum[k] += t[k];
  appearance.cavity_known = cavity_from_counts(sum, &appearance.cavity);
  return appearance;
}

Result<PhotometricSummary> refine_photometric(const HeadModel& model, const HeadShape& person,
                                              const ReducedHead& head, const ReducedPerson& landmark_person,
                                              const ExpressionPrior& prior,
                                              const std::vector<PhotometricFrame>& pictures,
                                              const PhotometricOptions& options,
                                              std::vector<FaceFrame>& faces, const Progress& progress,
                                              std::stop_token stop) {
  LIKENESS_CHECK(pictures.size() == faces.size(), "%d pictures for %d faces",
                 static_cast<int>(pictures.size()), static_cast<int>(faces.size()));
  PhotometricSummary summary;
  if (stop.stop_requested()) return cancelled_error();
  ClipRefiner refiner(model, person, head, landmark_person, prior, pictures, options, faces);
  if (refiner.training_frames() < 5) {
    progress.report(1);
    return summary;  // too little to estimate an appearance
  }
  for (int round = 0; round < options.rounds; ++round) {
    const Progress part = progress.stage(static_cast<double>(round) / options.rounds,
                                         static_cast<double>(round + 1) / options.rounds, "pictures");
    part.report(0, "albedo and light");
    refiner.look(stop);
    if (stop.stop_requested()) return cancelled_error();
    if (round == 0) summary.error_before = refiner.error();
    if (auto done = refiner.refine_all(round, part.stage(0.15, 1, "pictures"), stop); !done)
      return done.error();
  }
  summary.error_after = refiner.error();
  summary.mouths_changed = refiner.changed();
  for (std::size_t i = 0; i < faces.size(); ++i) summary.refined += faces[i].seen && pictures[i].grey;
  progress.report(1);
  return summary;
}

}  // namespace likeness
