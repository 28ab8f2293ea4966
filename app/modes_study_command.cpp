// likeness study modes: the papers' models side by side on one capture.
#include <cmath>
#include <map>
#include <memory>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/study/modes_report.h"
#include "core/study/modes_study.h"

namespace likeness::app {
namespace {

struct ModesStudyArguments {
  CommonOptions common;
  std::filesystem::path project, out;
  ModesOptions options;
};

void print_rows(const ModesStudy& study, const std::filesystem::path& folder) {
  fmt::print("{:<17} {:>7} {:>7} {:>7} {:>7} {:>7} {:>9} {:>8} {:>7}\n", "model", "full", "person", "head",
             "face", "SSIM", "ms/frame", "train s", "steps");
  for (const ModelRow& row : study.rows)
    for (const ModelScore& s : row.scores)
      fmt::print("{:<17} {:>7} {:>7.2f} {:>7.2f} {:>7.2f} {:>7} {:>9.0f} {:>8.0f} {:>7}\n",
                 model_name(row.kind), s.psnr_db ? fmt::format("{:.2f}", *s.psnr_db) : "-", s.psnr_person_db,
                 s.psnr_head_db, s.psnr_face_db, s.ssim ? fmt::format("{:.4f}", *s.ssim) : "-", s.frame_ms,
                 s.train_seconds, s.steps);
  fmt::print("dB on {} held-out frames of {} px; {}\n", study.frames.size(), study.size,
             (folder / "report.html").string());
}

int run(const ModesStudyArguments& a) {
  const ThreadLimit limit(a.common.threads);
  const auto project = open_project(a.project);
  if (!project) return report_failure(project.error());
  std::optional<Result<ModesStudy>> study;
  {
    const ProgressLine line(a.common);
    study = study_modes(*project, a.out, a.options, line.progress(), stop_on_signals());
  }
  if (!*study) return report_failure(study->error(), StoppedWork::kept);
  if (a.common.json)
    print_json(nlohmann::json::parse(modes_json(**study)));
  else
    print_rows(**study, a.out);
  return kExitDone;
}

}  // namespace

void add_modes_study(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<ModesStudyArguments>();
  CLI::App* verb = study.add_subcommand("modes", "The papers' models side by side on one capture");
  verb->add_option("project", a->project, "A project that was tracked and matted")->required();
  verb->add_option("--out", a->out,
                   "Folder for results and report; a second call of the same version goes on there")
      ->required();
  std::map<std::string, FieldMode> modes;
  for (const FieldMode mode : kFieldModes) modes.emplace(mode_name(mode), mode);
  verb->add_option("--modes", a->options.modes, "Of: static, concat, hyper, warp, warp+hyper; default: all")
      ->transform(CLI::CheckedTransformer(std::move(modes)));
  verb->add_option("--encoders", a->options.encoders,
                   "grid: hash grids; mlp: positional encoding and perceptrons; default: both")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, Encoder>{{kEncoders[0], Encoder::grid}, {kEncoders[1], Encoder::mlp}}));
  verb->add_option("--seconds", a->options.seconds, "Of training, each")->check(CLI::Range(0.1, 1e6));
  verb->add_option("--steps", a->options.steps,
                   "Exact steps of each model with the grid, instead of seconds");
  verb->add_option("--mlp-steps", a->options.baseline_steps,
                   "Exact steps of each model with perceptrons, instead of seconds");
  verb->add_option("--rays", a->options.rays, "Rays of each step of the grid")
      ->check(CLI::Range(1, 1'000'000));
  verb->add_option("--size", a->options.size,
                   "Side of the pictures, px; default: the project's. Perceptrons want 128")
      ->check(CLI::Range(16, 1024));
  verb->add_option("--frames", a->options.frames, "Held-out frames to measure, evenly chosen; 0: all")
      ->check(CLI::Range(0, 100'000));
  verb->add_option("--seeds", a->options.seeds, "Trainings of each, with seeds from --seed on")
      ->check(CLI::Range(1, 20));
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] {
    a->options.first_seed = a->common.seed;
    exit_code = run(*a);
  });
}

}  // namespace likeness::app
