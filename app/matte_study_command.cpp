// likeness study mattes: a project's mattes beside the true ones of its demo.
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/lab/truth/matte_truth.h"

namespace likeness::app {
namespace {

namespace fs = std::filesystem;

struct MatteStudyArguments {
  CommonOptions common;
  fs::path project, demo;
};

int run(const MatteStudyArguments& arguments) {
  const ThreadLimit limit(arguments.common.threads);
  const auto project = open_project(arguments.project);
  if (!project) return report_failure(project.error());
  std::optional<Result<std::vector<MatteRow>>> rows;
  {
    const ProgressLine line(arguments.common);
    rows = study_mattes(*project, arguments.demo, line.progress(), stop_on_signals());
  }
  if (!*rows) return report_failure(rows->error());
  if (arguments.common.json) {
    nlohmann::json list = nlohmann::json::array();
    for (const MatteRow& row : **rows)
      list.push_back({{"part", row.part},
                      {"frames", row.frames},
                      {"iou_mean", row.iou_mean},
                      {"iou_worst", row.iou_worst},
                      {"worst_frame", row.worst_frame},
                      {"border_error", row.border},
                      {"hair_error", row.hair}});
    print_json({{"rows", list}});
    return kExitDone;
  }
  fmt::print("{:<14} {:>6} {:>8} {:>8} {:>8} {:>8} {:>8}\n", "", "frames", "IoU", "worst", "frame", "border",
             "hair");
  for (const MatteRow& row : **rows)
    fmt::print("{:<14} {:>6} {:>8.4f} {:>8.4f} {:>8} {:>8.3f} {:>8.3f}\n", row.part, row.frames, row.iou_mean,
               row.iou_worst, row.worst_frame, row.border, row.hair);
  fmt::print("border: mean difference of alpha along the true border; hair: of the border above the ears\n");
  return kExitDone;
}

}  // namespace

void add_matte_study(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<MatteStudyArguments>();
  CLI::App* verb = study.add_subcommand("mattes", "A project's mattes beside the true ones of its demo");
  verb->add_option("project", a->project, "The project folder, fitted at least")->required();
  verb->add_option("demo", a->demo, "The folder of `likeness demo` whose clip it imported")->required();
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
