// likeness study cameras: the camera stage beside known cameras.
#include <algorithm>
#include <cstdlib>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/tables.h"
#include "app/terminal.h"
#include "app/view_tables.h"
#include "core/base/parallel.h"
#include "core/base/temporary_folder.h"
#include "core/face/landmarks.h"
#include "core/lab/truth/camera_truth.h"
#include "core/matte/coarse_mask.h"

namespace likeness::app {
namespace {

namespace fs = std::filesystem;

struct CameraStudyArguments {
  CommonOptions common;
  TableOptions output;
  fs::path folder, landmark_model;
  std::vector<std::string> masks;
};

Table cameras_table(const std::vector<CameraRow>& rows) {
  Table table{.name = "cameras", .title = "The camera stage, beside known cameras"};
  table.columns = {{"masks", "masks"},
                   {"found", "found", 0},
                   {"wanted", "of", 0},
                   {"position_median_percent", "position, %", 3},
                   {"position_max_percent", "worst"},
                   {"turn_median_deg", "turn, °", 3},
                   {"turn_max_deg", "worst", 3},
                   {"shared_turn_deg", "shared", 3},
                   {"own_turn_median_deg", "own", 3},
                   {"focal_percent", "focal length, %"},
                   {"seconds", "", 0},
                   {"processor_seconds", "processor, s", 0},
                   {"outcome", ""}};
  for (const CameraRow& row : rows) {
    std::vector<TableCell>& cells = table.rows.emplace_back();
    cells = {row.masks};
    if (row.errors) {
      const CameraErrors& e = *row.errors;
      for (const TableCell& cell :
           {TableCell(e.found), TableCell(e.wanted), TableCell(e.position_median_percent),
            TableCell(e.position_max_percent), TableCell(e.turn_median_deg), TableCell(e.turn_max_deg),
            TableCell(e.shared_turn_deg), TableCell(e.own_turn_median_deg), TableCell(e.focal_percent)})
        cells.push_back(cell);
    } else {
      cells.resize(10);  // no path was found
    }
    cells.insert(cells.end(),
                 {TableCell(row.seconds), TableCell(row.processor_seconds), TableCell(row.outcome)});
    table.notes.push_back(fmt::format("{}: {}", row.masks, row.outcome));
  }
  table.notes.push_back(
      "median and worst camera after one similarity; position in % of the path's extent; shared: the turn\n"
      "that all cameras have in common, own: the median without it");
  return table;
}

int run(const CameraStudyArguments& arguments) {
  const ThreadLimit limit(arguments.common.threads);
  const auto truth = read_camera_truth(arguments.folder);
  if (!truth) return report_failure(truth.error());
  std::vector<NamedMask> masks;
  for (const std::string& name : arguments.masks) {
    NamedMask mask{name, {}};
    if (name == "person") {
      auto person = coarse_person_mask(arguments.landmark_model,
                                       truth->photographs ? Pictures::single : Pictures::in_sequence);
      if (!person) return report_failure(person.error());
      mask.person = std::move(*person);
    }
    masks.push_back(std::move(mask));
  }
  const auto work = TemporaryFolder::make("cameras");
  if (!work) return report_failure(work.error());
  AlignOptions options;
  options.seed = int(arguments.common.seed);
  std::optional<Result<std::vector<CameraRow>>> rows;
  {
    const ProgressLine line(quiet_if_csv(arguments.common, arguments.output));
    rows = study_cameras(*truth, masks, work->path(), options, line.progress(), stop_on_signals());
  }
  if (!*rows) return report_failure(rows->error());
  std::vector<Table> tables = {cameras_table(**rows), views_table("masks")};
  for (const CameraRow& row : **rows) add_views(tables.back(), row.masks, row.kind, truth->kind, row.views);
  return report_tables(arguments.common, arguments.output, tables);
}

}  // namespace

void add_camera_study(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<CameraStudyArguments>();
  a->masks = {"person"};
  CLI::App* verb = study.add_subcommand("cameras", "The camera stage beside known cameras");
  verb->add_option("folder", a->folder,
                   "A folder of `likeness demo`, or photographs with their transforms.json")
      ->required();
  verb->add_option("--masks", a->masks,
                   "What is kept out of the solve, a row for each: person, none; default: person")
      ->check(CLI::IsMember({"person", "none"}));
  verb->add_option("--landmark-model", a->landmark_model, kLandmarkModelHelp);
  add_common_options(*verb, a->common);
  add_table_options(*verb, a->output);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
