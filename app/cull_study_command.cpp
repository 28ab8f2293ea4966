// likeness study occupancy: what looking empty cells up culls, and what is lost with it.
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/lab/study/cull_study.h"

namespace likeness::app {
namespace {

namespace fs = std::filesystem;

struct CullStudyArguments {
  CommonOptions common;
  fs::path project;
  int frames = 12;
};

nlohmann::json to_json(const CullTable& table) {
  nlohmann::json rows = nlohmann::json::array();
  for (std::size_t i = 0; i < table.size(); ++i)
    rows.push_back({{"lookup", kCullLookups[i]},
                    {"samples_per_ray", table[i].kept_per_ray()},
                    {"dense_lost", table[i].share_dense_lost()},
                    {"density_lost", table[i].share_density_lost()},
                    {"light_lost", table[i].share_light_lost()}});
  return rows;
}

void print(const std::string& title, const CullTable& table) {
  fmt::print("{:<44} {:>11} {:>15} {:>15} {:>12}\n", title, "samples/ray", "dense lost, %", "density lost, %",
             "light lost, %");
  for (std::size_t i = 0; i < table.size(); ++i)
    fmt::print("  {:<42} {:>11.2f} {:>15.3f} {:>15.3f} {:>12.3f}\n", kCullLookups[i], table[i].kept_per_ray(),
               100 * table[i].share_dense_lost(), 100 * table[i].share_density_lost(),
               100 * table[i].share_light_lost());
}

int run(const CullStudyArguments& a) {
  const ThreadLimit limit(a.common.threads);
  const auto project = open_project(a.project);
  if (!project) return report_failure(project.error());
  std::optional<Result<CullStudy>> study;
  {
    const ProgressLine line(a.common);
    study = study_culling(*project, a.frames, line.progress(), stop_on_signals());
  }
  if (!*study) return report_failure(study->error());
  const CullStudy& s = **study;
  if (a.common.json) {
    print_json({{"frames", s.frames},
                {"actions", s.actions},
                {"spacing_m", s.spacing},
                {"threshold", s.threshold},
                {"held_out", to_json(s.held_out)},
                {"acted", to_json(s.acted)}});
    return kExitDone;
  }
  print(fmt::format("{} held-out frames", s.frames), s.held_out);
  print(fmt::format("{} actions, each at full", s.actions), s.acted);
  fmt::print(
      "The head's samples every {:.1f} mm; dense: over {:g} a cube's side. none: no look-up; trained: the "
      "avatar's\ncells of the posed head; posed, canonical: learnt from the same looks, of the posed head "
      "and "
      "of the canonical\nface by the head model's deformation alone; resting: of the canonical face at "
      "rest.\n",
      1000 * s.spacing, s.threshold);
  return kExitDone;
}

}  // namespace

void add_cull_study(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<CullStudyArguments>();
  CLI::App* verb = study.add_subcommand(
      "occupancy", "What looking empty cells up culls, posed or in the canonical face, and what is lost");
  verb->add_option("project", a->project, "A project with a trained avatar")->required();
  verb->add_option("--frames", a->frames, "Held-out frames, evenly chosen; 0: all")
      ->check(CLI::Range(0, 1'000'000));
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
