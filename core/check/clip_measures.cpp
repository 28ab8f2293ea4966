// Looks at a clip: see clip_measures.h.
#include "core/check/clip_measures.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "core/base/parallel.h"
#include "core/camera/assumed_lens.h"
#include "core/capture/choose_shots.h"
#include "core/capture/find_film.h"
#include "core/capture/repeated_frames.h"
#include "core/capture/scan_clip.h"
#include "core/check/measure_camera.h"
#include "core/face/face_landmarks.h"
#include "core/face/face_patch.h"
#include "core/face/fit_frame.h"
#include "core/face/fit_looks.h"
#include "core/head/action_amounts.h"
#include "core/head/builtin_head.h"
#include "core/matte/coarse_mask.h"

namespace likeness {
namespace {

constexpr std::size_t kBatch = 32;        // patches examined in parallel
constexpr int kDark = 24, kBright = 250;  // luma: beyond these, shadows and highlights have lost their detail
constexpr double kFaceEllipse = 0.42;     // of the box: half axes of the part that is surely skin
constexpr double kHeadAbove = 0.5, kHeadBelow = 0.25, kHeadBeside = 0.3;  // of the box, to the whole head

// The surroundings of a face, waiting for its landmarks.
struct Patch {
  std::size_t look = 0;
  FacePatch face;
};

void measure_light(const FacePatch& patch, Look& look) {
  const double cx = patch.face.x + 0.5 * patch.face.width, cy = patch.face.y + 0.5 * patch.face.height,
               rx = kFaceEllipse * patch.face.width, ry = kFaceEllipse * patch.face.height;
  double sum = 0, dark = 0, bright = 0, count = 0;
  for (int y = 0; y < patch.luma.height; ++y)
    for (int x = 0; x < patch.luma.width; ++x) {
      const double dx = (x + 0.5 - cx) / rx, dy = (y + 0.5 - cy) / ry;
      if (dx * dx + dy * dy > 1) continue;
      const int level = *patch.luma.at(x, y);
      sum += level, dark += level<kDark, bright += level> kBright, ++count;
    }
  if (count == 0) return;
  look.level = sum / count, look.dark_share = dark / count, look.bright_share = bright / count;
}

// Share of the head's box beyond the picture's edges.
double cut_share(const FaceBox& face, int width, int height) {
  const double left = face.x - kHeadBeside * face.width, right = face.x + (1 + kHeadBeside) * face.width,
               top = face.y - kHeadAbove * face.height, bottom = face.y + (1 + kHeadBelow) * face.height;
  const double inside = std::max(0.0, std::min<double>(right, width) - std::max(left, 0.0)) *
                        std::max(0.0, std::min<double>(bottom, height) - std::max(top, 0.0));
  return 1 - inside / ((right - left) * (bottom - top));
}

// Poses and expressions of the looks by a fit of the built-in head to their landmarks, with the focal length
// recorded in the file, or a usual one.
class FaceFit {
 public:
  explicit FaceFit(const VideoInfo& info)
      : model_(make_builtin_head()), lens_(assumed_intrinsics(info.width, info.height, info.focal_35mm)) {}

  void add(std::size_t look, int frame, const Landmarks& landmarks) {
    seen_.push_back({frame, landmarks});
    looks_.push_back(look);
  }

  Result<void> run(std::vector<Look>& looks, const Progress& progress, std::stop_token stop) {
    const auto states = fit_looks(model_, lens_, seen_, progress, stop);
    if (!states) return states.error();
    const ActionBasis basis = action_basis(model_);
    for (std::size_t i = 0; i < states->size(); ++i) describe(basis, (*states)[i], looks[looks_[i]]);
    return {};
  }

 private:
  void describe(const ActionBasis& basis, const FaceState& state, Look& look) const {
    constexpr double kDegree = 180 / std::numbers::pi;
    // A face at the picture's edge is seen partly from the side.
    const Vec3d camera = direction_to_camera(state);
    look.posed = camera.allFinite();
    if (!look.posed) return;
    look.yaw_deg = -kDegree * std::atan2(camera.x(), camera.z());
    look.pitch_deg = -kDegree * std::asin(std::clamp(camera.y(), -1.0, 1.0));
    Articulation articulation = neutral_articulation(model_);
    articulation.expression = state.expression.cast<float>();
    articulation.jaw.x() = static_cast<float>(state.jaw);
    const Eigen::VectorXf amounts = face_amounts(basis, articulation);
    const auto most = [&](std::initializer_list<const char*> names) {
      double amount = 0;
      for (const char* name : names)
        if (const int a = action_index(basis, name); a >= 0) amount = std::max<double>(amount, amounts[a]);
      return amount;
    };
    look.expressions = {
        most({"jawOpen"}), most({"mouthSmile_L", "mouthSmile_R"}), most({"mouthPucker", "mouthFunnel"}),
        most({"browInnerUp", "browInnerUp_L", "browInnerUp_R", "browOuterUp_L", "browOuterUp_R"}),
        most({"eyeBlink_L", "eyeBlink_R"})};
  }

  const HeadModel model_;
  const Intrinsics lens_;
  std::vector<LandmarkLook> seen_;
  std::vector<std::size_t> looks_;  // of which look
};

}  // namespace

ClipFacts clip_facts(const ClipMeasures& measures) {
  const CameraMeasures& camera = measures.camera;
  ClipFacts facts;
  facts.camera = {camera.kind, camera.sure, false, camera.evidence};
  if (measures.has_person_network)
    facts.mask = {MaskPrior::person_network, measures.faces, measures.persons_seen};
  PartsFacts& parts = facts.parts;
  parts.seconds = measures.duration_s;
  const auto faceless =
      std::ranges::count_if(measures.looks, [](const Look& l) { return l.serves && !l.face; });
  parts.faceless_s =
      measures.duration_s * double(faceless) / double(std::max<std::size_t>(1, measures.looks.size()));
  parts.frames = measures.frames, parts.repeated = measures.repeated;
  parts.film = measures.film, parts.shots = measures.shots;
  parts.width = measures.whole_width, parts.height = measures.whole_height;
  return facts;
}

Result<ClipMeasures> measure_clip(const std::filesystem::path& video,
                                  const std::filesystem::path& landmark_model,
                                  const std::filesystem::path& person_network, const Progress& progress,
                                  std::stop_token stop) {
  auto detector = FaceDetector::load(landmark_model);
  if (!detector) return detector.error();
  const auto whole = probe_video(video);
  if (!whole) return whole.error();
  const auto sightings = std::make_shared<PersonSightings>();
  const auto person = coarse_person_mask(landmark_model, Pictures::in_sequence, person_network, sightings);
  if (!person) return person.error();
  const auto film = find_film(video, progress.stage(0, 0.1, "looking for bars"), stop);
  if (!film) return film.error();
  ClipMeasures measures;
  measures.film = *film;
  measures.info = *whole;
  measures.whole_width = whole->width, measures.whole_height = whole->height;
  if (!film->empty()) measures.info.width = film->width, measures.info.height = film->height;
  FaceFit fit(measures.info);

  std::vector<Patch> patches;
  const auto find_landmarks = [&] {
    std::vector<std::optional<Landmarks>> found(patches.size());
    parallel_for(patches.size(), [&](std::size_t i) {
      found[i] = patch_landmarks(*detector, patches[i].face);
      measure_light(patches[i].face, measures.looks[patches[i].look]);
    });
    for (std::size_t i = 0; i < patches.size(); ++i)
      if (found[i]) fit.add(patches[i].look, measures.looks[patches[i].look].frame, *found[i]);
    patches.clear();
  };
  const auto look_at = [&](const VideoFrame& frame, const FaceSample& sample) {
    Look look;
    look.frame = frame.index, look.time_s = frame.time_s;
    look.face = sample.face, look.second_face = sample.second_face;
    if (sample.face) {
      look.sharpness = face_sharpness(frame.rgb, *sample.face);
      look.cut_share = cut_share(*sample.face, frame.rgb.width, frame.rgb.height);
      patches.push_back({measures.looks.size(), cut_face_patch(frame.rgb, *sample.face)});
    }
    measures.looks.push_back(std::move(look));
    if (patches.size() == kBatch) find_landmarks();
  };
  const auto scan = scan_clip(video, *detector, look_at, *film, progress.stage(0.1, 0.5, "face"), stop);
  if (!scan) return scan.error();
  find_landmarks();
  measures.frames = static_cast<int>(scan->frames.size());
  measures.fault = scan->fault;
  measures.repeated = int(std::ranges::count(repeated_frames(scan->difference), char(1)));
  if (!scan->frames.empty())
    measures.duration_s = scan->frames.back().time_s - scan->frames.front().time_s +
                          (whole->frames_per_second > 0 ? 1 / whole->frames_per_second : 0);
  Capture cut;
  cut.frames = scan->frames;
  std::error_code ignored;
  measures.shots = cut.shots = shots_of(*scan, *film, std::filesystem::is_directory(video, ignored));
  const std::vector<FrameSpan> spans = spans_where_cut(cut);
  for (Look& look : measures.looks) look.serves = span_of(spans, look.frame) >= 0;
  if (auto fitted = fit.run(measures.looks, progress.stage(0.5, 0.6, "expressions"), stop); !fitted)
    return fitted.error();
  auto camera = measure_camera(video, *person, *film, measures.info, stretches_that_serve(cut),
                               progress.stage(0.6, 1, "camera"), stop);
  if (!camera) return camera.error();
  measures.camera = std::move(*camera);
  measures.has_person_network = sightings->network;
  measures.faces = sightings->faces, measures.persons_seen = sightings->seen;
  return measures;
}

}  // namespace likeness
