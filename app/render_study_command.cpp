// likeness study render: what the renderer's settings cost and what they lose.
#include <cmath>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/lab/bench/render_study.h"

namespace likeness::app {
namespace {

namespace fs = std::filesystem;

struct RenderStudyArguments {
  CommonOptions common;
  fs::path project;
  int frames = 12;
};

nlohmann::json to_json(const RenderRow& row) {
  const RenderOptions& o = row.setting.options;
  return {{"name", row.setting.name},
          {"max_samples", o.max_samples},
          {"strata", o.strata},
          {"block", o.block},
          {"reduce", o.max_rays > 0 ? nlohmann::json(nullptr) : nlohmann::json(o.reduce)},
          {"edge_contrast", o.edge_contrast},
          {"max_rays", o.max_rays},
          {"stop_transmittance", o.stop_transmittance},
          {"shade_weight", o.shade_weight},
          {"opacities", row.setting.opacities},
          {"exact", o.precision == FieldPrecision::exact},
          {"psnr_db", finite_or_null(row.psnr_db)},
          {"psnr_head_db", finite_or_null(row.psnr_head_db)},
          {"psnr_face_db", finite_or_null(row.psnr_face_db)},
          {"to_final_db", finite_or_null(row.to_final_db)},
          {"milliseconds", row.milliseconds},
          {"processor_milliseconds", row.processor_milliseconds},
          {"frames_per_second", row.frames_per_second},
          {"samples_per_ray", row.samples_per_ray}};
}

void print(const RenderStudy& study) {
  fmt::print("{:<56} {:>6} {:>6} {:>6} {:>8} {:>8} {:>8} {:>8} {:>8}\n", "setting", "full", "head", "face",
             "to final", "samples", "ms", "work ms", "fps");
  for (const RenderRow& row : study.rows)
    fmt::print("{:<56} {:>6} {:>6.2f} {:>6.2f} {:>8} {:>8.1f} {:>8.1f} {:>8.1f} {:>8.2f}\n", row.setting.name,
               row.psnr_db ? fmt::format("{:.2f}", *row.psnr_db) : "-", row.psnr_head_db, row.psnr_face_db,
               std::isfinite(row.to_final_db) ? fmt::format("{:.1f}", row.to_final_db) : "same",
               row.samples_per_ray, row.milliseconds, row.processor_milliseconds, row.frames_per_second);
  fmt::print(
      "dB on {} held-out frames of {} px; samples evaluated a ray; ms of a picture, work ms of all threads; "
      "fps "
      "with the pose, which takes {:.1f} ms\n",
      study.frames, study.size, study.pose_milliseconds);
}

int run(const RenderStudyArguments& a) {
  const ThreadLimit limit(a.common.threads);
  const auto project = open_project(a.project);
  if (!project) return report_failure(project.error());
  std::optional<Result<RenderStudy>> study;
  {
    const ProgressLine line(a.common);
    study =
        study_rendering(*project, a.frames, render_settings(), nullptr, line.progress(), stop_on_signals());
  }
  if (!*study) return report_failure(study->error());
  if (!a.common.json) {
    print(**study);
    return kExitDone;
  }
  nlohmann::json rows = nlohmann::json::array();
  for (const RenderRow& row : (*study)->rows) rows.push_back(to_json(row));
  print_json({{"size", (*study)->size},
              {"frames", (*study)->frames},
              {"pose_milliseconds", (*study)->pose_milliseconds},
              {"rows", rows}});
  return kExitDone;
}

}  // namespace

void add_render_study(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<RenderStudyArguments>();
  CLI::App* verb = study.add_subcommand("render", "What the renderer's settings cost and what they lose");
  verb->add_option("project", a->project, "A project with a trained avatar")->required();
  verb->add_option("--frames", a->frames, "Held-out frames to render, evenly chosen; 0: all")
      ->check(CLI::Range(0, 1'000'000));
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
