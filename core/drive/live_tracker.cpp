// See live_tracker.h.
#include "core/drive/live_tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <vector>

#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/camera/clip_camera.h"
#include "core/face/fit_clip.h"
#include "core/face/observe_face.h"
#include "core/track/clip/frame_verdict.h"
#include "core/track/fit/rest.h"
#include "core/track/photo/gaze.h"

namespace likeness {
namespace {

constexpr int kLongestWeak = 10;      // pictures before the detector is asked whether a face is there at all
constexpr int kDirections = 40;       // of the identity: landmarks say nothing about the finer ones
constexpr int kMinSettled = 5;        // frames needed to settle a person
constexpr std::size_t kMaxRest = 12;  // more only takes longer
constexpr double kLongAgo_s = 0.35;   // frames further back say nothing about this one
constexpr double kSameFace = 0.3;     // overlap of the detector's box with the expected one
constexpr std::size_t kErrorsKept = 60;  // frames from which the usual error is taken

struct Sight {
  double time_s = 0;
  FaceState state;
};

struct SettlingFrame {
  FaceFrame face;
  std::optional<Gaze> gaze;
};

Image8 to_grey(const Image8& rgb) {
  Image8 grey(rgb.width, rgb.height, 1);
  const std::uint8_t* p = rgb.data.data();
  for (std::uint8_t& g : grey.data) {
    g = std::uint8_t((77 * p[0] + 150 * p[1] + 29 * p[2] + 128) >> 8);
    p += rgb.channels;
  }
  return grey;
}

}  // namespace

struct LiveTracker::Impl {
  const HeadModel* model = nullptr;
  LiveTrackOptions options;
  std::optional<FaceDetector> detector;
  ReducedHead head;
  ReducedPerson person;
  Eigen::VectorXd identity;
  ExpressionPrior usual, prior;
  EyeBalls eyes;
  Intrinsics intrinsics;         // of the working picture
  std::deque<Sight> before;      // the newest last, at most two
  std::deque<double> errors_px;  // of good frames
  std::vector<SettlingFrame> rest;
  bool resting = false;
  int number = 0, since_look = 0, weak_run = 0;

  void become(const Eigen::VectorXd& who) {
    identity = who;
    person = reduced_person(head, identity);
    eyes = eye_balls(*model, shape_head(*model, full_person()));
  }
  PersonShape full_person() const {
    Eigen::VectorXf full = Eigen::VectorXf::Zero(model->identity_count());
    full.head(identity.size()) = identity.cast<float>();
    return {full, {}};
  }

  // The pull of the last frames: the face stays as it is, the head keeps its motion.
  FramePull pull_from(double time_s) const {
    FramePull pull;
    if (before.empty() || time_s - before.back().time_s > kLongAgo_s) return pull;
    const ClipFitOptions usual_pull;
    const Sight& last = before.back();
    pull.expression = last.state.expression, pull.jaw = last.state.jaw;
    pull.expression_weight = usual_pull.expression_change;
    pull.jaw_weight = 2 * usual_pull.expression_change;
    if (before.size() < 2 || time_s - before.front().time_s > 2 * kLongAgo_s) return pull;
    const Sight& older = before.front();
    const double ahead = (time_s - last.time_s) / std::max(1e-3, last.time_s - older.time_s);
    const Vec3d turn =
        vector_from_turn(last.state.cam_from_head.linear() * older.state.cam_from_head.linear().transpose());
    const Vec3d shift = last.state.cam_from_head.translation() - older.state.cam_from_head.translation();
    pull.cam_from_head.linear() = turn_from_vector(ahead * turn) * last.state.cam_from_head.linear();
    pull.cam_from_head.translation() = last.state.cam_from_head.translation() + ahead * shift;
    // A prediction over a longer gap has less weight.
    const double worth = std::min(1.0, 0.04 / std::max(1e-3, time_s - last.time_s));
    pull.turn_weight = worth * usual_pull.turn_change, pull.shift_weight = worth * usual_pull.shift_change;
    return pull;
  }

  // Where the face is expected, unless the detector, which is asked now and then, sees it elsewhere.
  std::optional<ExpectedFace> expected(const Image8& picture) {
    if (before.empty()) return std::nullopt;
    ExpectedFace face = expect_face(head, person, intrinsics, before.back().state.cam_from_head);
    const FaceBox& box = face.box;
    if (!(box.width > 20) || box.x + box.width < 0 || box.y + box.height < 0 || box.x > picture.width ||
        box.y > picture.height)
      return std::nullopt;
    if (++since_look < options.look_again) return face;
    since_look = 0;
    const auto found = detector->detect(picture, &box);
    const bool there =
        std::ranges::any_of(found, [&](const FaceBox& seen) { return overlap(seen, box) > kSameFace; });
    // The detector misses a face turned far away: then the fit is believed.
    return there || found.empty() ? std::optional(face) : std::nullopt;
  }

  struct Found {
    Landmarks landmarks;
    FaceObservation observation;
    FaceState state;
    FrameVerdict verdict;
    double error_px = 0;
  };

  void judge(Found& found) const {
    FrameEvidence evidence;
    evidence.camera_known = evidence.seen = evidence.detected = true;
    evidence.inner_error_px = found.error_px = inner_error(head, person, found.observation, found.state);
    evidence.cluster_share = found.landmarks.cluster_share;
    evidence.spread = inner_spread(found.landmarks) /
                      std::max(1.0, (found.landmarks.points[36] - found.landmarks.points[45]).norm());
    const double usual_px =
        errors_px.empty() ? 3 : median(std::vector<double>(errors_px.begin(), errors_px.end()));
    found.verdict = judge_frame(evidence, usual_px);
  }

  Found follow(const Image8& picture, const ExpectedFace& face, double time_s) const {
    Found found;
    found.landmarks = detector->landmarks(picture, face.box, std::uint32_t(number), &face.hint,
                                          {options.runs, options.runs});
    found.observation = observe_face(found.landmarks, intrinsics, 1, intrinsics.fx);
    found.state =
        fit_frame(head, person, found.observation, prior, pull_from(time_s), {}, before.back().state);
    judge(found);
    return found;
  }

  std::optional<Found> start(const Image8& picture) {
    since_look = 0;
    before.clear();
    const std::vector<FaceBox> faces = detector->detect(picture);
    if (faces.empty()) return std::nullopt;
    const auto largest = std::ranges::max_element(faces, {}, &FaceBox::width);
    Found found;
    found.landmarks = detector->landmarks(picture, *largest, 0, nullptr, {options.runs, 2 * options.runs});
    found.observation = observe_face(found.landmarks, intrinsics, 1, intrinsics.fx);
    found.state = start_frame(head, person, found.observation, prior);
    found.state = fit_frame(head, person, found.observation, prior, {}, {}, found.state);
    judge(found);
    return found;
  }

  TrackedFrame describe(const Found& found, const std::optional<Gaze>& gaze, double scale) const {
    TrackedFrame frame;
    frame.status = found.verdict.status, frame.reason = found.verdict.reason;
    frame.pose.articulation = neutral_articulation(*model);
    frame.pose.articulation.expression = found.state.expression.cast<float>();
    frame.pose.articulation.jaw.x() = float(found.state.jaw);
    if (gaze) frame.pose.articulation.left_eye = frame.pose.articulation.right_eye = eye_rotation(*gaze);
    frame.pose.world_from_head = found.state.cam_from_head;
    frame.inner_error_px = found.error_px / scale;
    for (int k = 0; k < kLandmarkCount; ++k) frame.landmarks[k] = found.landmarks.points[k] / scale;
    return frame;
  }

  std::optional<Gaze> last_gaze;

  TrackedFrame next(const Image8& rgb, double time_s, double focal_35mm) {
    const double scale = std::min(1.0, double(options.working_size) / std::max(rgb.width, rgb.height));
    const int w = std::max(1, int(std::lround(rgb.width * scale))),
              h = std::max(1, int(std::lround(rgb.height * scale)));
    const Image8 grey = to_grey(w == rgb.width && h == rgb.height ? rgb : resize(rgb, w, h));
    if (intrinsics.width != w || intrinsics.height != h) {
      before.clear();
      intrinsics =
          assumed_camera({.width = w, .height = h, .focal_35mm = focal_35mm}).cameras.front().intrinsics;
    }
    TrackedFrame lost;
    lost.frame = number++, lost.time_s = time_s;
    lost.status = FrameStatus::lost;
    lost.pose.articulation = neutral_articulation(*model);
    lost.reason = "no face found";
    std::optional<Found> found;
    const auto face = expected(grey);
    if (face) found = follow(grey, *face, time_s);
    // After a while of weak tracking there may be no face any more.
    weak_run = found && found->verdict.status == FrameStatus::weak ? weak_run + 1 : 0;
    if (weak_run >= kLongestWeak && detector->detect(grey, face ? &face->box : nullptr).empty()) {
      before.clear();
      return lost;
    }
    if (!found || found->verdict.status == FrameStatus::lost) found = start(grey);
    if (!found || found->verdict.status == FrameStatus::lost) {
      before.clear();
      if (found) lost.reason = found->verdict.reason;
      return lost;
    }
    if (const auto gaze =
            measure_gaze(grey, intrinsics, found->state.cam_from_head, eyes, found->landmarks.points))
      last_gaze = gaze;  // during a blink the last one is kept
    before.push_back({time_s, found->state});
    if (before.size() > 2) before.pop_front();
    if (found->verdict.status == FrameStatus::good) {
      errors_px.push_back(found->error_px);
      if (errors_px.size() > kErrorsKept) errors_px.pop_front();
    }
    if (resting)
      rest.push_back(
          {{.frame = lost.frame, .seen = true, .observation = found->observation, .state = found->state},
           last_gaze});
    TrackedFrame frame = describe(*found, last_gaze, scale);
    frame.frame = lost.frame, frame.time_s = time_s;
    return frame;
  }

  Result<DriveSubject> settle() {
    resting = false;
    if (int(rest.size()) < kMinSettled) {
      return Error{ErrorCode::no_face,
                   fmt::format("The face was found in only {} of the pictures taken at rest.", rest.size()),
                   "Move closer to the camera, look into it in even light, and try again.", "live"};
    }
    std::vector<FaceFrame> faces;
    std::vector<const SettlingFrame*> used;
    const std::size_t step = std::max<std::size_t>(1, rest.size() / kMaxRest);
    for (std::size_t i = 0; i < rest.size(); i += step)
      faces.push_back(rest[i].face), used.push_back(&rest[i]);
    ClipFitOptions fit;
    fit.identity_frames = int(kMaxRest);
    auto who = fit_identity(head, usual, fit, identity, faces, Progress(), {});
    if (!who) return who.error();
    become(who->identity);
    DriveSubject subject{model, full_person(), neutral_articulation(*model), {}};
    std::vector<double> jaws, yaws, pitches;
    std::vector<std::vector<double>> shapes(std::size_t(head.expression_count()));
    for (std::size_t i = 0; i < faces.size(); ++i) {
      FaceState& state = faces[i].state;
      state = fit_frame(head, person, faces[i].observation, usual, {}, {}, state);
      jaws.push_back(state.jaw);
      for (std::size_t e = 0; e < shapes.size(); ++e) shapes[e].push_back(state.expression[Eigen::Index(e)]);
      if (used[i]->gaze) yaws.push_back(used[i]->gaze->yaw), pitches.push_back(used[i]->gaze->pitch);
    }
    Eigen::VectorXd still(head.expression_count());
    for (std::size_t e = 0; e < shapes.size(); ++e) still[Eigen::Index(e)] = median(shapes[e]);
    prior = prior_from_rest(usual, still);
    subject.neutral.expression = still.cast<float>();
    subject.neutral.jaw.x() = float(median(jaws));
    if (!yaws.empty())
      subject.neutral.left_eye = subject.neutral.right_eye = eye_rotation({median(yaws), median(pitches), 0});
    subject.world_from_head = faces[faces.size() / 2].state.cam_from_head;
    before.clear();
    before.push_back({-1e9, faces.back().state});  // its place, but not its motion
    errors_px.clear();
    rest.clear();
    return subject;
  }
};

LiveTracker::LiveTracker(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LiveTracker::~LiveTracker() = default;
LiveTracker::LiveTracker(LiveTracker&&) noexcept = default;

Result<LiveTracker> LiveTracker::create(const HeadModel& model, const LiveTrackOptions& options) {
  auto detector = FaceDetector::load(options.predictor);
  if (!detector) return detector.error();
  auto impl = std::make_unique<Impl>();
  impl->model = &model;
  impl->options = options;
  impl->detector = std::move(*detector);
  impl->head = reduce_head(model, kDirections);
  impl->usual = impl->prior = expression_prior(model);
  impl->become(Eigen::VectorXd::Zero(impl->head.identity_count()));
  return LiveTracker(std::move(impl));
}

TrackedFrame LiveTracker::next(const Image8& rgb, double time_s, double focal_35mm) {
  return impl_->next(rgb, time_s, focal_35mm);
}

void LiveTracker::begin_rest() {
  impl_->rest.clear();
  impl_->resting = true;
}

int LiveTracker::rest_frames() const { return int(impl_->rest.size()); }

Result<DriveSubject> LiveTracker::settle() { return impl_->settle(); }

}  // namespace likeness
