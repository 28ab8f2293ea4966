// likeness study displacement: the detail maps a perfect estimator would give for a demo.
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/lab/truth/true_detail.h"

namespace likeness::app {
namespace {

namespace fs = std::filesystem;

struct TrueDetailArguments {
  CommonOptions common;
  fs::path project, demo, out;
  TrueDetailOptions options;
};

int run(const TrueDetailArguments& a) {
  const ThreadLimit limit(a.common.threads);
  const auto project = open_project(a.project);
  if (!project) return report_failure(project.error());
  std::optional<Result<TrueDetailReport>> report;
  {
    const ProgressLine line(a.common);
    report = write_true_detail(*project, a.demo, a.out, a.options, line.progress(), stop_on_signals());
  }
  if (!*report) return report_failure(report->error());
  const TrueDetailReport& r = **report;
  if (a.common.json)
    print_json({{"frames", r.frames}, {"rms_mm", r.rms_mm}, {"varying_mm", r.varying_mm}});
  else
    fmt::print("{} maps; the true face lies {:.2f} mm rms off the tracked one, {:.2f} of it come and go\n",
               r.frames, r.rms_mm, r.varying_mm);
  return kExitDone;
}

}  // namespace

void add_true_detail(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<TrueDetailArguments>();
  CLI::App* verb = study.add_subcommand(
      "displacement",
      "The detail maps that a perfect estimator would give for a demo, for fit --displacement");
  verb->add_option("project", a->project, "A project fitted to the demo's clip")->required();
  verb->add_option("--demo", a->demo, "The demo's folder, as `likeness demo` writes it")->required();
  verb->add_option("--out", a->out, "Folder for the maps")->required();
  verb->add_option("--person", a->options.person, "The demo's person")->check(CLI::Range(0, 5));
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
