// likeness study camera-kinds: made clips with every kind of camera, and whether it is found rightly.
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/commands.h"
#include "app/tables.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/base/temporary_folder.h"
#include "core/face/landmarks.h"
#include "core/lab/truth/kind_study.h"

namespace likeness::app {
namespace {

namespace fs = std::filesystem;

struct KindStudyArguments {
  CommonOptions common;
  TableOptions output;
  fs::path landmark_model;
  std::vector<std::string> clips;
};

Table kinds_table() {
  Table table{.name = "kinds", .title = "The camera's kind, beside the true one"};
  table.columns = {{"clip", "clip"},
                   {"film", ""},
                   {"wall", "wall"},
                   {"true_kind", "truly"},
                   {"kind", "found"},
                   {"assumed", ""},
                   {"outcome", "outcome"},
                   {"turn_median_deg", "turn, °", 3},
                   {"turn_max_deg", "worst", 3},
                   {"zoom_median_percent", "zoom, %"},
                   {"zoom_max_percent", "worst"},
                   {"focal_percent", "focal length, %", 1},
                   {"mapping_median_px", "mapping, px"},
                   {"mapping_p95_px", "p95"},
                   {"seconds", "seconds", 1},
                   {"processor_seconds", "processor, s", 1},
                   {"evidence", ""},
                   {"warnings", ""}};
  return table;
}

void add_row(Table& table, const KindRow& row) {
  std::vector<TableCell>& cells = table.rows.emplace_back();
  cells = {row.clip.name,
           demo_words(row.clip.film),
           demo_wall_name(row.clip.film.wall),
           camera_kind_name(row.truth),
           row.found ? camera_kind_name(row.found->kind) : "none",
           row.found && row.found->assumed ? "yes" : "no",
           kind_outcome_name(row.outcome)};
  if (row.views) {
    const ViewErrors& e = *row.views;
    for (const double number : {e.turn_median_deg, e.turn_max_deg, e.zoom_median_percent, e.zoom_max_percent,
                                e.focal_percent, e.mapping_median_px, e.mapping_p95_px})
      cells.emplace_back(number);
  } else {
    cells.resize(cells.size() + 7);
  }
  cells.insert(cells.end(),
               {TableCell(row.align.wall), TableCell(row.align.processor), TableCell(row.evidence),
                TableCell(fmt::format("{}", fmt::join(row.warnings, " ")))});
}

// Beneath the table: the rules, what the stage said where it was not right, and at last the count.
void add_notes(Table& table, const std::vector<KindRow>& rows) {
  table.notes = kind_rules();
  table.notes.push_back(
      "turn: after one rotation of the world; zoom: of the focal length relative to the film's usual one;\n"
      "mapping: where distant pixels lie in the first frame");
  KindCount count;
  for (const KindRow& row : rows) {
    count.add(row.outcome);
    if (row.outcome == KindOutcome::right && row.warnings.empty()) continue;
    table.notes.push_back(fmt::format("{} ({}): {} {}", row.clip.name, kind_outcome_name(row.outcome),
                                      row.evidence, fmt::join(row.warnings, " ")));
  }
  table.notes.push_back(kind_count_words(count));
}

int run(const KindStudyArguments& a) {
  const ThreadLimit limit(a.common.threads);
  const auto clips = kind_clips_named(a.clips);
  if (!clips) return report_failure(clips.error());
  std::optional<TemporaryFolder> work;
  if (a.output.out.empty()) {
    auto made = TemporaryFolder::make("kinds");
    if (!made) return report_failure(made.error());
    work.emplace(std::move(*made));
  }
  KindStudyOptions options;
  options.landmark_model = a.landmark_model;
  options.align.seed = int(a.common.seed);
  std::optional<Result<std::vector<KindRow>>> rows;
  {
    const ProgressLine line(quiet_if_csv(a.common, a.output));
    rows = study_camera_kinds(*clips, work ? work->path() : a.output.out, options, line.progress(),
                              stop_on_signals());
  }
  if (!*rows) return report_failure(rows->error(), work ? StoppedWork::lost : StoppedWork::kept);
  Table table = kinds_table();
  for (const KindRow& row : **rows) add_row(table, row);
  add_notes(table, **rows);
  return report_tables(a.common, a.output, std::vector<Table>{std::move(table)});
}

}  // namespace

void add_kind_study(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<KindStudyArguments>();
  CLI::App* verb = study.add_subcommand(
      "camera-kinds", "Whether the camera's kind is found rightly, on made clips with every kind");
  std::vector<std::string> names;
  for (const KindClip& clip : kind_clips()) names.push_back(clip.name);
  verb->add_option("--clips", a->clips,
                   fmt::format("Some of them only, of: {}; default: all", fmt::join(names, ", ")))
      ->delimiter(',')
      ->check(CLI::IsMember(names).description(""));
  verb->add_option("--out", a->output.out,
                   "Folder for clips, cameras and tables; a second call films nothing again");
  verb->add_option("--landmark-model", a->landmark_model, kLandmarkModelHelp);
  add_common_options(*verb, a->common);
  add_table_options(*verb, a->output);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
