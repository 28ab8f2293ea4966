// See kept_fit.h. One list of members serves for writing and for reading.
#include "core/track/clip/kept_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <vector>

namespace likeness {
namespace {

class StateWriter {
 public:
  static constexpr bool kReads = false;
  void raw(const void* data, std::size_t count) { bytes.append(static_cast<const char*>(data), count); }
  bool count(std::size_t& n) {
    const std::uint64_t wide = n;
    raw(&wide, sizeof wide);
    return true;
  }
  std::string bytes;
};

class StateReader {
 public:
  static constexpr bool kReads = true;
  explicit StateReader(std::string_view bytes) : left(bytes) {}
  void raw(void* data, std::size_t count) {
    if (count > left.size()) whole = false;
    if (!whole) return;
    std::memcpy(data, left.data(), count);
    left.remove_prefix(count);
  }
  // Nothing has more members than bytes are left.
  bool count(std::size_t& n) {
    std::uint64_t wide = 0;
    raw(&wide, sizeof wide);
    if (wide > left.size()) whole = false;
    n = whole ? std::size_t(wide) : 0;
    return whole;
  }
  std::string_view left;
  bool whole = true;
};

template <class S, class T>
requires std::is_arithmetic_v<T>
void state(S& s, T& value) { s.raw(&value, sizeof value); }

template <class S, class T, int R, int C>
void state(S& s, Eigen::Matrix<T, R, C>& m) {
  if constexpr (R == Eigen::Dynamic) {
    auto rows = std::size_t(m.rows());
    if (!s.count(rows)) return;
    if constexpr (S::kReads) m.resize(Eigen::Index(rows));
  }
  s.raw(m.data(), sizeof(T) * std::size_t(m.size()));
}

template <class S>
void state(S& s, Pose& pose) {
  s.raw(pose.matrix().data(), 16 * sizeof(double));
}

template <class S, class T>
void state(S& s, std::optional<T>& value) {
  bool there = value.has_value();
  state(s, there);
  if constexpr (S::kReads) {
    value.reset();
    if (there) value.emplace();
  }
  if (value) state(s, *value);
}

template <class S, class T, std::size_t N>
void state(S& s, std::array<T, N>& values) {
  for (T& value : values) state(s, value);
}

template <class S, class T>
void state(S& s, std::vector<T>& values) {
  auto size = values.size();
  if (!s.count(size)) return;
  if constexpr (S::kReads) {
    // One by one: a number of members that is only claimed takes no memory.
    values.clear();
    for (std::size_t i = 0; i < size && s.whole; ++i) state(s, values.emplace_back());
  } else {
    for (T& value : values) state(s, value);
  }
}

template <class S, class... T>
void states(S& s, T&... values) {
  (state(s, values), ...);
}

template <class S>
void state(S& s, FaceBox& b) {
  states(s, b.x, b.y, b.width, b.height, b.score);
}
template <class S>
void state(S& s, Landmarks& l) {
  states(s, l.points, l.spread, l.cluster_share, l.runs);
}
template <class S>
void state(S& s, LidEvidence& e) {
  states(s, e.known, e.gap_m, e.sigma_m);
}
template <class S>
void state(S& s, LipEvidence& e) {
  states(s, e.known, e.gap_m, e.sigma_m);
}
template <class S>
void state(S& s, FaceObservation& o) {
  states(s, o.rays, o.sigma_px, o.focal_px, o.lids, o.lips);
}
template <class S>
void state(S& s, FaceState& f) {
  states(s, f.cam_from_head, f.jaw, f.expression);
}
template <class S>
void state(S& s, FaceFrame& f) {
  states(s, f.seen, f.pose_given, f.observation, f.state, f.rest);
}
template <class S>
void state(S& s, DenseFrame& f) {
  states(s, f.known, f.solved, f.cam_from_head, f.points, f.median_px);
}
template <class S>
void state(S& s, EyeGaze& e) {
  states(s, e.yaw, e.pitch, e.confidence);
}
template <class S>
void state(S& s, Gaze& g) {
  states(s, g.yaw, g.pitch, g.openness, g.eye);
}
template <class S>
void state(S& s, OpticalVerdict& v) {
  states(s, v.votes, v.disagreement_px, v.carried);
}
template <class S>
void state(S& s, LidOpening& l) {
  states(s, l.known, l.opening, l.sigma, l.corners_off);
}
template <class S>
void state(S& s, std::string& text) {
  auto size = text.size();
  if (!s.count(size)) return;
  if constexpr (S::kReads) text.assign(size, ' ');
  s.raw(text.data(), size);
}
template <class S>
void state(S& s, RestChoice& r) {
  states(s, r.frames, r.asked, r.trust, r.why, r.warning);
}
template <class S>
void state(S& s, ExpressionPrior& p) {
  states(s, p.weight, p.rest, p.low, p.high, p.change, p.pairs, p.pair_weight, p.jaw_weight, p.jaw_high);
}
template <class S>
void state(S& s, BundleObservation& o) {
  states(s, o.frame, o.ray);
}
template <class S>
void state(S& s, HeadPoint& p) {
  states(s, p.track.point, p.track.seen, p.track.kept, p.on_skin);
}

// One after the other, as all frames of a clip have them.
struct WorkState {
  std::vector<std::optional<Landmarks>> landmarks;
  std::vector<FaceBox> boxes;
  std::vector<DenseFrame> dense;
  std::vector<FaceFrame> faces;
  std::vector<std::optional<Gaze>> gaze;
  std::vector<OpticalVerdict> optical;
  std::vector<LidOpenings> lids;
  std::vector<double> look;
  RestChoice rest;
  ExpressionPrior prior;
  Eigen::VectorXd identity;
  std::vector<HeadPoint> points;
  std::vector<Vec3f> offsets;
};

template <class S>
void state(S& s, WorkState& w) {
  states(s, w.landmarks, w.boxes, w.dense, w.faces, w.gaze, w.optical, w.lids, w.look, w.rest, w.prior,
         w.identity, w.points, w.offsets);
}

bool fits_work(const WorkState& w, const HeadModel& model, const ClipWork& work) {
  const std::size_t n = work.faces.size();
  const auto of_all = [&](std::size_t size) { return size == n; };
  const auto of_all_or_none = [&](std::size_t size) { return size == n || size == 0; };
  const Eigen::Index e = work.head.expression_count();
  return of_all(w.landmarks.size()) && of_all(w.boxes.size()) && of_all(w.dense.size()) &&
         of_all(w.faces.size()) && of_all(w.gaze.size()) && of_all_or_none(w.optical.size()) &&
         of_all_or_none(w.lids.size()) && of_all_or_none(w.look.size()) &&
         std::ranges::all_of(w.faces, [&](const FaceFrame& f) { return f.state.expression.size() == e; }) &&
         w.prior.weight.size() == e && w.prior.rest.size() == e && w.prior.low.size() == e &&
         w.prior.high.size() == e && w.prior.change.size() == e &&
         std::ranges::all_of(
             w.prior.pairs,
             [&](const auto& p) { return p[0] >= 0 && p[0] < int(e) && p[1] >= 0 && p[1] < int(e); }) &&
         w.identity.size() == work.head.identity_count() &&
         (w.offsets.empty() || int(w.offsets.size()) == model.vertex_count()) &&
         std::ranges::all_of(w.points, [&](const HeadPoint& p) {
           return std::ranges::all_of(p.track.seen, [&](const BundleObservation& o) {
             return o.frame >= 0 && std::size_t(o.frame) < n;
           });
         });
}

bool seen_where_known(const WorkState& w, const ClipWork& work) {
  for (std::size_t i = 0; i < w.faces.size(); ++i)
    if (w.faces[i].seen && (!w.landmarks[i] || !work.cameras[i])) return false;
  return true;
}

}  // namespace

std::string bytes_of_work(const ClipWork& work) {
  WorkState w;
  for (const ClipFrame& frame : work.clip.frames)
    w.landmarks.push_back(frame.landmarks), w.boxes.push_back(frame.box);
  w.dense = work.dense, w.faces = work.faces, w.gaze = work.gaze;
  w.optical = work.optical, w.lids = work.lids, w.look = work.look;
  w.rest = work.rest, w.prior = work.prior, w.identity = work.identity;
  w.points = work.points, w.offsets = work.offsets;
  StateWriter s;
  state(s, w);
  return std::move(s.bytes);
}

bool take_work(const std::string& bytes, const HeadModel& model, bool person_known, ClipWork& work) {
  StateReader s(bytes);
  WorkState w;
  state(s, w);
  if (!s.whole || !s.left.empty() || !fits_work(w, model, work) || !seen_where_known(w, work)) return false;
  for (std::size_t i = 0; i < work.faces.size(); ++i) {
    ClipFrame& frame = work.clip.frames[i];
    frame.landmarks = std::move(w.landmarks[i]), frame.box = w.boxes[i];
    FaceFrame& face = w.faces[i];
    face.frame = work.faces[i].frame, face.held_out = work.faces[i].held_out, face.shot = work.faces[i].shot;
    w.dense[i].intrinsics = work.intrinsics[i];
  }
  work.dense = std::move(w.dense), work.faces = std::move(w.faces), work.gaze = std::move(w.gaze);
  work.optical = std::move(w.optical), work.lids = std::move(w.lids), work.look = std::move(w.look);
  work.rest = std::move(w.rest), work.prior = std::move(w.prior), work.identity = std::move(w.identity);
  work.points = std::move(w.points);
  if (!person_known && !w.offsets.empty()) work.head = reduce_head(model, kIdentityDirections, w.offsets);
  work.offsets = std::move(w.offsets);
  return true;
}

void KeptFit::go_on(std::initializer_list<const char*> parts) {
  if (!kept_) return;
  for (auto name = std::rbegin(parts); name != std::rend(parts); ++name) {
    const auto bytes = kept_->find(std::string("after ") + *name);
    if (!bytes || !take_work(*bytes, model_, person_known_, work_)) continue;
    until_ = *name;
    return;
  }
}

Result<void> KeptFit::part(const char* name, const std::function<Result<void>()>& run) {
  if (!until_.empty()) {
    if (until_ == name) until_.clear();
    return {};
  }
  if (auto done = run(); !done) return done;
  if (kept_) kept_->keep(std::string("after ") + name, bytes_of_work(work_));
  return {};
}

}  // namespace likeness
