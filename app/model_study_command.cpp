// likeness study PROJECT: the papers' models and ours side by side on one capture, in tables.
#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/lab/study/model_report.h"
#include "core/lab/study/model_study.h"

namespace likeness::app {
namespace {

struct ModelStudyArguments {
  CommonOptions common;
  std::filesystem::path project, out, replay;
  ModelStudyOptions options;
};

template <class Named>
std::string names_of(const std::vector<Named>& list) {
  std::vector<std::string> names;
  for (const Named& one : list) names.push_back(one.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string number(const std::optional<double>& value, int digits) {
  return value && std::isfinite(*value) ? fmt::format("{:.{}f}", *value, digits) : "-";
}

void print_rows(const ModelStudy& study, const std::filesystem::path& folder) {
  fmt::print("{:<16} {:>4} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>9} {:>8} {:>7}\n", "model", "seed", "full",
             "person", "head", "face", "SSIM", "lmk px", "s a frame", "train s", "steps");
  for (const ModelRow& row : study.rows)
    for (const ModelScore& s : row.scores)
      fmt::print("{:<16} {:>4} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>9.3f} {:>8.0f} {:>7}\n", row.spec.name,
                 s.seed, number(s.psnr_db, 2), number(s.psnr_person_db, 2), number(s.psnr_head_db, 2),
                 number(s.psnr_face_db, 2), number(s.ssim, 4), number(s.landmark_error_px, 2),
                 s.frame_seconds, s.train_seconds, s.steps);
  for (const ModelRow& row : study.rows)
    if (!row.failed.empty()) fmt::print("{:<16} not trained: {}\n", row.spec.name, row.failed);
  if (const auto r = study_ratios(study)) {
    fmt::print(
        "head {:.2f} dB; the baseline {:.2f} after {:.0f} times the time, {:.2f} less after {:.0f} s\n",
        r->ours_db, r->baseline_db, r->times_longer, r->equal_time_db, r->equal_seconds);
    if (!r->sooner.empty())
      fmt::print("its long training is reached by {} in 1/{:.1f} of its time\n", r->sooner, r->times_sooner);
    fmt::print("a picture takes 1/{:.1f} of its time", r->times_faster);
    if (r->times_faster_full) fmt::print(", at {} px 1/{:.1f}", study.full_size, *r->times_faster_full);
    fmt::print("\n");
  }
  if (const ModelRow* ours = find_row(study, kDefaultModel); ours != nullptr)
    for (const PictureCost& q : ours->scores.front().qualities)
      fmt::print("{:<32} full {:>6}  head {:>6}  face {:>6}  {:>7.4f} s a frame  {:>6.1f} MB\n", q.name,
                 number(q.psnr_db, 2), number(q.psnr_head_db, 2), number(q.psnr_face_db, 2), q.frame_seconds,
                 double(q.bytes) / 1e6);
  fmt::print("dB on {} held-out frames of {} px, seconds of processor; {}\n", study.frames.size(), study.size,
             (folder / "report.html").string());
}

int run(const ModelStudyArguments& a) {
  if (a.project.empty() || a.out.empty())
    return report_failure({ErrorCode::bad_input, "Say what to study, and where its report goes.",
                           "likeness study PROJECT --out FOLDER, or one of likeness study --help.", ""});
  const ThreadLimit limit(a.common.threads);
  const auto project = open_project(a.project);
  if (!project) return report_failure(project.error());
  ModelStudyOptions options = a.options;
  options.first_seed = a.common.seed;
  std::erase(options.baked_cells, 0);
  if (!a.replay.empty()) {
    auto steps = read_study_steps(a.replay);
    if (!steps) return report_failure(steps.error());
    options.replay = std::move(*steps);
  }
  std::optional<Result<ModelStudy>> study;
  {
    const ProgressLine line(a.common);
    study = study_models_of(*project, a.out, options, line.progress(), stop_on_signals());
  }
  if (!*study) return report_failure(study->error(), StoppedWork::kept);
  if (a.common.json)
    print_json(nlohmann::json::parse(models_json(**study)));
  else
    print_rows(**study, a.out);
  return kExitDone;
}

}  // namespace

void add_model_study(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<ModelStudyArguments>();
  study.add_option("project", a->project, "A project that was tracked and matted: its models side by side");
  study.add_option("--out", a->out,
                   "Folder for results and report; a second call of the same version goes on there");
  study.add_option("--tables", a->options.tables,
                   fmt::format("Of: {}; default: all", names_of(study_tables())));
  study.add_option("--models", a->options.models,
                   fmt::format("Of: {}; default: all of the tables", names_of(study_models())));
  study
      .add_option("--seconds", a->options.seconds,
                  "Of processor, all threads together, for each training but those that say otherwise")
      ->check(CLI::Range(0.1, 1e6))
      ->capture_default_str();
  study.add_option("--steps", a->options.steps,
                   "Exact steps of each such model with the grid, instead of seconds");
  study.add_option("--mlp-steps", a->options.mlp_steps,
                   "Exact steps of each such model with perceptrons, instead of seconds");
  study.add_option("--replay", a->replay,
                   "results.json of an earlier study: each training takes the steps that it took there");
  study
      .add_option("--lpips", a->options.lpips,
                  "A network (.onnx) that measures perceptual distance, e.g. LPIPS")
      ->check(CLI::ExistingFile);
  study.add_option("--rays", a->options.rays, "Rays of each step of the grid")
      ->check(CLI::Range(1, 1'000'000));
  study.add_option("--size", a->options.size, "Side of the pictures, px; 0: the project's")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  study.add_option("--frames", a->options.frames, "Held-out frames to measure, evenly chosen; 0: all")
      ->check(CLI::Range(0, 100'000))
      ->capture_default_str();
  study
      .add_option(
          "--baked-cells", a->options.baked_cells,
          "Cells along an axis at which the default model's fields are also stored, multiples of 8; 0: "
          "not at all")
      ->check(CLI::Range(0, 512));
  study.add_option("--seeds", a->options.seeds, "Trainings of each, with seeds from --seed on")
      ->check(CLI::Range(1, 20))
      ->capture_default_str();
  add_common_options(study, a->common);
  study.callback([a, &exit_code, &study] {
    if (study.get_subcommands().empty()) exit_code = run(*a);
  });
}

}  // namespace likeness::app
