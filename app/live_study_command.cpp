// likeness study live: an avatar driven by a clip at the clip's own pace, without a window.
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/export/write_film.h"
#include "core/lab/bench/live_figures.h"

namespace likeness::app {

namespace {

struct LiveStudyArguments {
  CommonOptions common;
  std::filesystem::path project, clip;
  LiveStudyOptions options;
};

Result<LiveFigures> study_live(const LiveStudyArguments& a, const Progress& progress, std::stop_token stop) {
  const auto opened = open_avatar(a.project);
  if (!opened) return opened.error();
  return measure_live(opened->avatar, opened->model, a.clip, a.options, progress.stage(0, 1, "live"), stop);
}

int run(const LiveStudyArguments& a) {
  const ThreadLimit limit(a.common.threads);
  std::optional<Result<LiveFigures>> figures;
  {
    const ProgressLine line(a.common);
    figures = study_live(a, line.progress(), stop_on_signals());
  }
  if (!*figures) return report_failure(figures->error());
  const LiveFigures& f = **figures;
  if (a.common.json) {
    print_json({{"seconds", f.seconds},
                {"captured", f.captured},
                {"dropped", f.dropped},
                {"driven", f.driven},
                {"lost", f.lost},
                {"shown", f.shown},
                {"frames_per_second", f.frames_per_second},
                {"latency_median_ms", 1000 * f.latency_median_s},
                {"latency_p95_ms", 1000 * f.latency_p95_s},
                {"render_median_ms", 1000 * f.render_median_s}});
    return kExitDone;
  }
  fmt::print("{} pictures captured, {} dropped, {} driven ({} without a face), {} rendered in {:.1f} s\n",
             f.captured, f.dropped, f.driven, f.lost, f.shown, f.seconds);
  fmt::print(
      "{:.1f} pictures/s; from capture to picture {:.0f} ms (95 %: {:.0f} ms), of which rendering {:.0f} "
      "ms\n",
      f.frames_per_second, 1000 * f.latency_median_s, 1000 * f.latency_p95_s, 1000 * f.render_median_s);
  return kExitDone;
}

}  // namespace

void add_live_study(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<LiveStudyArguments>();
  CLI::App* verb =
      study.add_subcommand("live", "How soon and how often an avatar follows a clip fed in real time");
  verb->add_option("project", a->project, "Project folder of the avatar")->required();
  verb->add_option("clip", a->clip, "The driving clip")->required();
  verb->add_option("--landmark-model", a->options.track.predictor,
                   "A dlib 68-point shape predictor; default: the system's");
  add_quality_option(*verb, a->options.quality);
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
