// One training a model and seed, measured as it learns: see modes_study.h.
#include "core/study/modes_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/parallel.h"
#include "core/baseline/train_nerf.h"
#include "core/image/files.h"
#include "core/image/metrics.h"
#include "core/render/render.h"
#include "core/study/finished_rows.h"
#include "core/study/frame_score.h"
#include "core/study/modes_report.h"
#include "core/study/sized_clip.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double kMarks[] = {1.0 / 16, 1.0 / 8, 1.0 / 4, 1.0 / 2};  // of the training
constexpr std::size_t kMarkFrames = 4, kShownFrames = 3;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// What all trainings share.
struct Bench {
  const ModesOptions& options;
  const fs::path& folder;
  SizedClip clip;
  FaceDetector detector;
  std::vector<std::size_t> measured;       // of clip.held_out
  std::vector<std::size_t> marked, shown;  // of `measured`
};

using Paint = std::function<Image(const HeldOutFrame&)>;  // premultiplied

struct PaintedFrames {
  std::vector<FrameScore> scores;
  std::vector<Image8> pictures;
  double seconds = 0;
  bool background_known = true;
};

PaintedFrames paint_frames(const Bench& bench, const std::vector<std::size_t>& which, const Paint& paint) {
  PaintedFrames out;
  for (const std::size_t i : which) {
    const HeldOutFrame& frame = bench.clip.held_out[bench.measured[i]];
    const Clock::time_point start = Clock::now();
    const Image rgba = paint(frame);
    out.seconds += seconds_since(start);
    out.background_known &= !frame.plate.empty();
    out.pictures.push_back(to_bytes(composite(rgba, frame.plate)));  // scored as exported: 8 bits
    out.scores.push_back(
        score_picture(to_float(frame.truth), to_float(out.pictures.back()), frame.regions, frame.frame));
  }
  return out;
}

double mean_db(std::span<const FrameScore> scores) {
  return mean_finite(scores, [](const FrameScore& f) { return psnr_from_mse(f.mse); });
}
double mean_head_db(std::span<const FrameScore> scores) {
  return mean_finite(scores, [](const FrameScore& f) { return psnr_from_mse(f.head_mse); });
}

ModelMark mark_of(std::span<const FrameScore> scores, bool background_known, double seconds,
                  std::uint64_t step) {
  ModelMark mark{.seconds = seconds, .step = step, .psnr_head_db = mean_head_db(scores)};
  if (background_known) mark.psnr_db = mean_db(scores);
  return mark;
}

std::vector<std::size_t> all_of(const Bench& bench) { return evenly_chosen(bench.measured.size(), 0); }

// The finished model's figures.
Result<ModelScore> score_model(const Bench& bench, const std::string& name, const Paint& paint,
                               const Avatar& told, std::vector<ModelMark> marks) {
  const std::vector<std::size_t> every = all_of(bench);
  PaintedFrames painted = paint_frames(bench, every, paint);
  ModelScore s{.seed = told.seed, .steps = told.steps, .frames = int(every.size())};
  double ssims = 0, gmsds = 0;
  for (std::size_t k = 0; k < every.size(); ++k) {
    const HeldOutFrame& frame = bench.clip.held_out[bench.measured[k]];
    painted.scores[k].landmarks_px = landmark_errors(bench.detector, frame.truth, painted.pictures[k]);
    ssims += ssim(to_float(frame.truth), to_float(painted.pictures[k]));
    gmsds += gmsd(to_float(frame.truth), to_float(painted.pictures[k]));
  }
  const std::vector<FrameScore>& scores = painted.scores;
  if (painted.background_known) {
    s.psnr_db = mean_db(scores);
    s.ssim = ssims / double(every.size());
    s.gmsd = gmsds / double(every.size());
  }
  s.psnr_head_db = mean_head_db(scores);
  s.psnr_person_db = mean_finite(scores, [](const FrameScore& f) { return psnr_from_mse(f.person_mse); });
  s.psnr_face_db = mean_finite(scores, [](const FrameScore& f) { return psnr_from_mse(f.face_mse); });
  s.landmark_error_px = mean_finite(scores, [](const FrameScore& f) { return f.landmarks_px.inner; });
  s.frame_ms = 1000 * painted.seconds / double(every.size());
  s.train_seconds = told.train_seconds;
  std::vector<FrameScore> marked;
  for (const std::size_t i : bench.marked) marked.push_back(scores[i]);
  s.marks = std::move(marks);
  s.marks.push_back(mark_of(marked, painted.background_known, told.train_seconds, told.steps));
  for (const std::size_t i : bench.shown)
    if (const auto written = write_image(bench.folder / fmt::format("{}-{:06}.png", name, scores[i].frame),
                                         painted.pictures[i]);
        !written)
      return written.error();
  return s;
}

// Which marks of a training are due.
class MarkPlan {
 public:
  bool is_due(double share) const { return next_ < std::size(kMarks) && share >= kMarks[next_]; }
  void pass(double share) {
    while (is_due(share)) ++next_;
  }

 private:
  std::size_t next_ = 0;
};

Paint paint_with(const Avatar& avatar, const AvatarRig& rig) {
  return [&](const HeldOutFrame& f) { return render_frame(avatar, f.camera, pose_avatar(rig, f.pose)).rgba; };
}
Paint paint_with(const NerfAvatar& avatar, const AvatarRig& rig) {
  return [&](const HeldOutFrame& f) { return render_nerf(avatar, f.camera, pose_avatar(rig, f.pose)); };
}

// Looks at a running training when a mark is due.
template <class Model>
void take_mark(const Bench& bench, const Model& model, const Avatar& told, std::vector<ModelMark>& marks) {
  const AvatarRig rig = make_rig(told, bench.clip.set.model);
  const PaintedFrames painted = paint_frames(bench, bench.marked, paint_with(model, rig));
  marks.push_back(mark_of(painted.scores, painted.background_known, told.train_seconds, told.steps));
}

Result<ModelScore> run_grid(const Bench& bench, FieldMode mode, std::uint64_t seed, const std::string& name,
                            const Progress& progress, std::stop_token stop) {
  TrainOptions options;
  options.mode = mode;
  options.budget_s = bench.options.seconds;
  options.steps = bench.options.steps;
  options.rays_per_step = bench.options.rays;
  options.seed = seed;
  MarkPlan plan;
  std::vector<ModelMark> marks;
  std::uint64_t step = 0;
  const Clock::time_point start = Clock::now();
  double held = 0, share = 0;
  const AvatarTap tap{[&] {
                        ++step;
                        share = options.steps > 0 ? double(step) / double(options.steps)
                                                  : (seconds_since(start) - held) / options.budget_s;
                        return plan.is_due(share);
                      },
                      [&](const Avatar& avatar) {
                        const Clock::time_point look = Clock::now();
                        take_mark(bench, avatar, avatar, marks);
                        plan.pass(share);
                        held += seconds_since(look);
                      }};
  auto avatar = train_avatar(bench.clip.set, options, {}, progress, {}, stop, tap);
  if (!avatar) return avatar.error();
  const AvatarRig rig = make_rig(*avatar, bench.clip.set.model);
  auto score = score_model(bench, name, paint_with(*avatar, rig), *avatar, std::move(marks));
  if (!score) return score.error();
  score->parameters = avatar->head.field.parameters.size();
  if (avatar->torso) score->parameters += avatar->torso->field.parameters.size();
  return score;
}

Result<ModelScore> run_mlp(const Bench& bench, FieldMode mode, std::uint64_t seed, const std::string& name,
                           const Progress& progress, std::stop_token stop) {
  NerfOptions options;
  options.mode = mode;
  options.budget_s = bench.options.seconds;
  options.steps = bench.options.baseline_steps;
  options.seed = seed;
  MarkPlan plan;
  std::vector<ModelMark> marks;
  const auto share = [&](const TrainStatus& status) {
    return options.steps > 0 ? double(status.step) / double(options.steps)
                             : status.seconds / options.budget_s;
  };
  const NerfTap tap{[&](const TrainStatus& status) { return plan.is_due(share(status)); },
                    [&](const NerfAvatar& avatar, const TrainStatus& status) {
                      take_mark(bench, avatar, avatar.scene, marks);
                      plan.pass(share(status));
                    }};
  const auto avatar = train_nerf(bench.clip.set, options, progress, stop, tap);
  if (!avatar) return avatar.error();
  const AvatarRig rig = make_rig(avatar->scene, bench.clip.set.model);
  auto score = score_model(bench, name, paint_with(*avatar, rig), avatar->scene, std::move(marks));
  if (score) score->parameters = parameter_count(*avatar);
  return score;
}

nlohmann::json to_json(const ModelScore& s) {
  nlohmann::json marks = nlohmann::json::array();
  for (const ModelMark& m : s.marks)
    marks.push_back({{"seconds", m.seconds},
                     {"step", m.step},
                     {"psnr_db", finite_or_null(m.psnr_db)},
                     {"psnr_head_db", finite_or_null(m.psnr_head_db)}});
  return {{"format", "likeness-mode"},
          {"version", 1},
          {"seed", s.seed},
          {"steps", s.steps},
          {"parameters", s.parameters},
          {"frames", s.frames},
          {"psnr_db", finite_or_null(s.psnr_db)},
          {"ssim", finite_or_null(s.ssim)},
          {"gmsd", finite_or_null(s.gmsd)},
          {"psnr_person_db", finite_or_null(s.psnr_person_db)},
          {"psnr_head_db", finite_or_null(s.psnr_head_db)},
          {"psnr_face_db", finite_or_null(s.psnr_face_db)},
          {"lmk_error_px", finite_or_null(s.landmark_error_px)},
          {"frame_ms", s.frame_ms},
          {"train_seconds", s.train_seconds},
          {"marks", marks}};
}

std::optional<ModelScore> read_score(const fs::path& path, const std::string& content) {
  const auto j = read_finished(path, content);
  if (!j) return std::nullopt;
  try {
    ModelScore s;
    j->at("seed").get_to(s.seed), j->at("steps").get_to(s.steps);
    j->at("parameters").get_to(s.parameters), j->at("frames").get_to(s.frames);
    s.psnr_db = optional_number(j->at("psnr_db"));
    s.ssim = optional_number(j->at("ssim"));
    s.gmsd = optional_number(j->at("gmsd"));
    s.psnr_person_db = number_or_nan(j->at("psnr_person_db"));
    s.psnr_head_db = number_or_nan(j->at("psnr_head_db"));
    s.psnr_face_db = number_or_nan(j->at("psnr_face_db"));
    s.landmark_error_px = number_or_nan(j->at("lmk_error_px"));
    j->at("frame_ms").get_to(s.frame_ms), j->at("train_seconds").get_to(s.train_seconds);
    for (const nlohmann::json& m : j->at("marks"))
      s.marks.push_back({.seconds = m.at("seconds").get<double>(),
                         .step = m.at("step").get<std::uint64_t>(),
                         .psnr_db = optional_number(m.at("psnr_db")),
                         .psnr_head_db = number_or_nan(m.at("psnr_head_db"))});
    return s;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

Result<ModelScore> run_model(const Bench& bench, const ModelKind& kind, std::uint64_t seed,
                             const std::string& name, const Progress& progress, std::stop_token stop) {
  const ModesOptions& o = bench.options;
  const std::uint64_t steps = kind.encoder == Encoder::grid ? o.steps : o.baseline_steps;
  const std::string content = hash_text(
      fmt::format("{} {} {} {} {} {} {} {}", bench.clip.content, model_name(kind), steps,
                  steps > 0 ? 0 : o.seconds, bench.clip.set.size, bench.measured.size(), o.rays, seed));
  const fs::path path = bench.folder / (name + ".json");
  if (auto done = read_score(path, content)) return *done;
  auto score =
      (kind.encoder == Encoder::grid ? run_grid : run_mlp)(bench, kind.mode, seed, name, progress, stop);
  if (!score) return score.error();
  if (const auto written = write_finished(path, content, to_json(*score)); !written) return written.error();
  return score;
}

template <class T>
bool is_chosen(const std::vector<T>& chosen, T value) {
  return chosen.empty() || std::ranges::find(chosen, value) != chosen.end();
}

Result<Bench> prepare(const Project& project, const fs::path& folder, const ModesOptions& options) {
  auto clip = read_sized_clip(project, options.size);
  if (!clip) return clip.error();
  auto detector = FaceDetector::load(project.options.landmark_model);
  if (!detector) return detector.error();
  if (const auto made = make_writable_folder(folder); !made) return made.error();
  Bench bench{options, folder, std::move(*clip), std::move(*detector), {}, {}, {}};
  bench.measured = evenly_chosen(bench.clip.held_out.size(), std::size_t(options.frames));
  bench.marked = evenly_chosen(bench.measured.size(), std::min(kMarkFrames, bench.measured.size()));
  bench.shown = evenly_chosen(bench.measured.size(), std::min(kShownFrames, bench.measured.size()));
  return bench;
}

}  // namespace

std::string model_name(const ModelKind& kind) {
  return fmt::format("{}, {}", mode_name(kind.mode), kEncoders[int(kind.encoder)]);
}

std::vector<ModelKind> model_kinds() {
  std::vector<ModelKind> kinds;
  for (const Encoder encoder : {Encoder::grid, Encoder::mlp})
    for (const FieldMode mode : kFieldModes)
      if (encoder == Encoder::grid || mode != FieldMode::warp_hyper) kinds.push_back({mode, encoder});
  return kinds;
}

Result<ModesStudy> study_modes(const Project& project, const fs::path& folder, const ModesOptions& options,
                               const Progress& progress, std::stop_token stop) {
  const auto bench = prepare(project, folder, options);
  if (!bench) return bench.error();
  ModesStudy study{.clip = project.options.video.filename().string(),
                   .size = bench->clip.set.size,
                   .training_frames = int(bench->clip.set.views.size()),
                   .threads = current_thread_limit()};
  for (const std::size_t i : bench->measured) study.frames.push_back(bench->clip.held_out[i].frame);
  for (const std::size_t i : bench->shown) {
    const HeldOutFrame& frame = bench->clip.held_out[bench->measured[i]];
    study.shown.push_back(frame.frame);
    study.truths.push_back(fmt::format("truth-{:06}.png", frame.frame));
    if (const auto written = write_image(folder / study.truths.back(), frame.truth); !written)
      return written.error();
  }
  std::vector<ModelKind> kinds;
  for (const ModelKind& kind : model_kinds())
    if (is_chosen(options.modes, kind.mode) && is_chosen(options.encoders, kind.encoder))
      kinds.push_back(kind);
  const double runs = double(kinds.size()) * options.seeds;
  double done = 0;
  for (const ModelKind& kind : kinds) {
    ModelRow& row = study.rows.emplace_back(ModelRow{kind, {}, {}});
    for (int k = 0; k < options.seeds; ++k, ++done) {
      const std::uint64_t seed = options.first_seed + std::uint64_t(k);
      const std::string name =
          fmt::format("{}-{}-{}", mode_name(kind.mode), kEncoders[int(kind.encoder)], seed);
      const auto score = run_model(*bench, kind, seed, name,
                                   progress.stage(done / runs, (done + 1) / runs, model_name(kind)), stop);
      if (!score) return score.error();
      row.scores.push_back(*score);
      if (k > 0) continue;
      for (const int frame : study.shown) row.pictures.push_back(fmt::format("{}-{:06}.png", name, frame));
    }
  }
  if (const auto written = write_modes_report(study, folder); !written) return written.error();
  progress.report(1);
  return study;
}

}  // namespace likeness
