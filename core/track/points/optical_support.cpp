#include "core/track/points/optical_support.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <optional>

#include "core/base/parallel.h"
#include "core/base/quantile.h"
#include "core/track/frame_spacing.h"
#include "core/track/points/point_tracks.h"

namespace likeness {
namespace {

constexpr int kFirstInner = 17;      // the jaw line slides along the silhouette: flow says nothing about it
constexpr double kOwnFloor = 0.4;    // working px: the predictor rounds to whole pixels
constexpr double kVoteWeight = 0.5;  // voters repeat the predictor's own systematic errors
constexpr double kDoubtfulWeight = 0.1;  // of points found beside a carried-over box, instead of 1
constexpr double kGate = 3;              // sigmas beyond which a vote is counted but not followed
constexpr double kMinShare = 0.4;        // of the runs that must agree before a frame may vote
constexpr std::size_t kChunk = 16;       // frames whose pyramids are in memory at once

struct Vote {
  Vec2d point = Vec2d::Zero();  // working px
  double sigma = 0;             // working px
};

// A weighted mean of points, with the sums needed for its spread.
struct Sum {
  Vec2d point = Vec2d::Zero();
  double weight = 0, square = 0, doubt = 0;

  void add(const Vec2d& p, double share, double sigma) {
    const double w = share / (sigma * sigma);
    point += w * p, weight += w, square += w * p.squaredNorm(), doubt += share;
  }
};

class Support {
 public:
  Support(ClipFrames& clip, const OpticalOptions& options)
      : clip_(clip), options_(options), spacing_(frame_spacing(clip.frames)) {
    for (std::size_t i = 0; i < clip.frames.size(); ++i) {
      const ClipFrame& f = clip.frames[i];
      before_.push_back(f.landmarks);
      if (f.landmarks && !f.held_out) training_.push_back(static_cast<int>(i));
      const bool trusted = f.landmarks && f.detected && f.landmarks->cluster_share >= kMinShare;
      level_.push_back(trusted ? 0 : options.carry + 1);
    }
    verdicts_.resize(clip.frames.size());
  }

  Result<std::vector<OpticalVerdict>> run(const Progress& progress, std::stop_token stop) {
    for (std::size_t from = 0; from < training_.size(); from += kChunk) {
      if (stop.stop_requested()) return cancelled_error();
      progress.report(static_cast<double>(from) / training_.size(), "landmarks followed between frames");
      steady(from, std::min(training_.size(), from + kChunk), stop);
    }
    // Uncertain frames depend on the nearest certain frames, one frame further each round.
    for (int round = 1; round <= options_.carry; ++round) {
      if (stop.stop_requested()) return cancelled_error();
      before_.clear();
      for (const ClipFrame& f : clip_.frames) before_.push_back(f.landmarks);
      if (!carry(round)) break;
    }
    if (stop.stop_requested()) return cancelled_error();
    progress.report(1);
    return std::move(verdicts_);
  }

 private:
  bool near(std::size_t a, std::size_t b) const {
    const ClipFrame &one = clip_.frames[training_[a]], &other = clip_.frames[training_[b]];
    return one.shot == other.shot && std::abs(one.frame - other.frame) <= options_.reach * spacing_;
  }

  // Votes of one frame's landmarks in another's picture, per inner point.
  std::vector<std::optional<Vote>> votes_of(const TrackPicture& from, const TrackPicture& to,
                                            int voter) const {
    const Vec2d corner(clip_.region.x, clip_.region.y);
    std::vector<Vec2d> points;
    for (int k = kFirstInner; k < kLandmarkCount; ++k)
      points.push_back((before_[voter]->points[k] - corner) * clip_.scale);
    const auto found = follow_points(from, to, points, {}, options_.forward_backward_px);
    std::vector<std::optional<Vote>> votes(found.size());
    for (std::size_t k = 0; k < found.size(); ++k)
      if (found[k])
        votes[k] = Vote{
            *found[k],
            std::hypot(before_[voter]->spread[k + kFirstInner] * clip_.scale + kOwnFloor, options_.drift_px)};
    return votes;
  }

  void steady(std::size_t from, std::size_t to, std::stop_token stop) {
    const std::size_t first = from > 0 ? from - 1 : 0, last = std::min(training_.size(), to + 1);
    std::vector<TrackPicture> pictures(last - first);
    parallel_for(pictures.size(),
                 [&](std::size_t k) { pictures[k] = TrackPicture(clip_.frames[training_[first + k]].grey); });
    parallel_for(to - from, [&](std::size_t k) {
      const std::size_t at = from + k;
      if (stop.stop_requested() || level_[training_[at]] != 0) return;
      std::vector<std::vector<std::optional<Vote>>> votes;
      for (std::size_t other : {at - 1, at + 1})
        if (other >= first && other < last && near(at, other) && level_[training_[other]] == 0)
          votes.push_back(votes_of(pictures[other - first], pictures[at - first], training_[other]));
      blend(training_[at], votes, false);
    });
  }

  // False if no frame was left to carry over to.
  bool carry(int round) {
    std::vector<std::size_t> due;
    for (std::size_t at = 0; at < training_.size(); ++at) {
      if (level_[training_[at]] <= options_.carry) continue;
      for (std::size_t other : {at - 1, at + 1})
        if (other < training_.size() && near(at, other) && level_[training_[other]] == round - 1) {
          due.push_back(at);
          break;
        }
    }
    parallel_for(due.size(), [&](std::size_t d) {
      const std::size_t at = due[d];
      const TrackPicture here(clip_.frames[training_[at]].grey);
      std::vector<std::vector<std::optional<Vote>>> votes;
      for (std::size_t other : {at - 1, at + 1})
        if (other < training_.size() && near(at, other) && level_[training_[other]] == round - 1)
          votes.push_back(
              votes_of(TrackPicture(clip_.frames[training_[other]].grey), here, training_[other]));
      const int i = training_[at];
      blend(i, votes, true);
      verdicts_[i].carried = 2 * verdicts_[i].votes >= kLandmarkCount - kFirstInner;
    });
    for (std::size_t at : due)
      if (verdicts_[training_[at]].carried) level_[training_[at]] = round;
    return !due.empty();
  }

  // doubtful: the frame's own points count little, and not at all where they contradict its voters.
  void blend(int i, const std::vector<std::vector<std::optional<Vote>>>& votes, bool doubtful) {
    const Vec2d corner(clip_.region.x, clip_.region.y);
    Landmarks& own = *clip_.frames[i].landmarks;
    OpticalVerdict& verdict = verdicts_[i];
    verdict.votes = 0;
    std::vector<double> distances;
    for (int k = kFirstInner; k < kLandmarkCount; ++k) {
      const Vec2d at = (own.points[k] - corner) * clip_.scale;
      const double sigma = own.spread[k] * clip_.scale + kOwnFloor;
      Sum sum;
      bool voted = false, agrees = !doubtful;
      for (const auto& voter : votes) {
        if (!voter[k - kFirstInner]) continue;
        const Vote& vote = *voter[k - kFirstInner];
        const double distance = (vote.point - at).norm();
        distances.push_back(distance / clip_.scale);
        voted = true;
        const bool near = distance <= kGate * std::hypot(sigma, vote.sigma);
        agrees |= near;
        if (near || doubtful) sum.add(vote.point, kVoteWeight, vote.sigma);
      }
      verdict.votes += voted;
      if (!voted || agrees) sum.add(at, doubtful ? kDoubtfulWeight : 1, sigma);
      const Vec2d mean = sum.point / sum.weight;
      // The voters' own uncertainties, and how far apart they are.
      const double apart = std::max(0.0, sum.square / sum.weight - mean.squaredNorm());
      own.points[k] = mean / clip_.scale + corner;
      own.spread[k] = std::max(0.0, std::sqrt(sum.doubt / sum.weight + apart) - kOwnFloor) / clip_.scale;
    }
    if (!distances.empty()) verdict.disagreement_px = median(std::move(distances));
  }

  ClipFrames& clip_;
  const OpticalOptions options_;
  const int spacing_;
  std::vector<int> training_;  // frames that have landmarks and are not held out
  std::vector<int> level_;     // 0: certain; n: carried over n frames; more than carry: uncertain
  std::vector<std::optional<Landmarks>> before_;  // source of the votes: not the landmarks being changed
  std::vector<OpticalVerdict> verdicts_;
};

}  // namespace

Result<std::vector<OpticalVerdict>> support_landmarks(ClipFrames& clip, const OpticalOptions& options,
                                                      const Progress& progress, std::stop_token stop) {
  try {
    return Support(clip, options).run(progress, stop);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    return Error{ErrorCode::failed, "Following landmarks between frames failed: " + std::string(e.what()),
                 "Run the fit again; if it fails again, report this message.", "landmarks"};
  }
}

}  // namespace likeness
