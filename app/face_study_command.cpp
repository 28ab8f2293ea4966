// likeness study faces: the sources of landmarks beside each other.
#include <memory>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/tables.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/lab/truth/landmark_sources.h"

namespace likeness::app {
namespace {

namespace fs = std::filesystem;

struct FaceStudyArguments {
  CommonOptions common;
  TableOptions output;
  std::vector<fs::path> clips;
  std::vector<std::string> sources{"network", "dlib"};
  fs::path marks;
  int frames = 300;
};

constexpr double kPercent = 100;

Table found_table() {
  return {.name = "found",
          .title = "Frames, and the time of one processor",
          .columns = {{"clip", "clip"},
                      {"source", "landmarks"},
                      {"frames", "frames", 0},
                      {"lost", "without a face", 0},
                      {"detect_ms", "face, ms", 1},
                      {"landmarks_ms", "landmarks, ms", 1},
                      {"live_fps", "live, frames/s", 1},
                      {"live_lost", "lost live", 0}}};
}

Table marks_table_of_sources() {
  return {.name = "marks",
          .title = "Mouth and eyes, by landmarks alone, beside what was seen by eye",
          .columns = {{"clip", "clip"},
                      {"source", "landmarks"},
                      {"mouths", "mouths", 0},
                      {"wrong_mouths", "wrong", 0},
                      {"eyes", "eyes", 0},
                      {"wrong_eyes", "wrong", 0}}};
}

Table part_table(const char* name, const char* title) {
  Table table{.name = name, .title = title, .columns = {{"clip", "clip"}, {"source", "landmarks"}}};
  for (std::size_t p = 0; p < kFaceParts; ++p)
    table.columns.push_back({face_part_name(FacePart(p)), face_part_name(FacePart(p))});
  return table;
}

std::vector<Table> tables_of(const std::vector<SourceRow>& rows) {
  Table found = found_table(), marks = marks_table_of_sources();
  Table still = part_table("tremble",
                           "Tremble while the head is still, % of the distance between the eyes' "
                           "outer corners");
  Table whole = part_table("truth", "Distance to the true landmarks, the same unit");
  Table moving = part_table("moving", "The same without each landmark's usual offset");
  for (const SourceRow& row : rows) {
    found.rows.push_back({row.clip, row.source, row.frames, row.lost, row.detect_ms, row.landmarks_ms,
                          row.live_fps, row.live_lost});
    std::vector<TableCell> cells{row.clip, row.source};
    for (const auto& noise : row.tremble)
      cells.push_back(noise ? std::optional(kPercent * *noise) : std::nullopt);
    still.rows.push_back(std::move(cells));
    if (row.errors) {
      std::vector<TableCell> far{row.clip, row.source}, off{row.clip, row.source};
      for (std::size_t p = 0; p < kFaceParts; ++p)
        far.push_back(kPercent * row.errors->whole[p]), off.push_back(kPercent * row.errors->moving[p]);
      whole.rows.push_back(std::move(far)), moving.rows.push_back(std::move(off));
    }
    if (row.marks)
      marks.rows.push_back({row.clip, row.source, row.marks->mouths, int(row.marks->wrong_mouths.size()),
                            row.marks->eyes, int(row.marks->wrong_eyes.size())});
  }
  std::vector<Table> tables{std::move(found), std::move(still)};
  for (Table* more : {&whole, &moving, &marks})
    if (!more->rows.empty()) tables.push_back(std::move(*more));
  return tables;
}

Result<std::vector<Table>> compare(const FaceStudyArguments& a) {
  const ProgressLine line(quiet_if_csv(a.common, a.output));
  std::vector<SourceRow> rows;
  const double n = double(a.clips.size());
  for (std::size_t i = 0; i < a.clips.size(); ++i) {
    std::vector<FaceMark> marks;
    const fs::path file = a.marks / (a.clips[i].stem().string() + ".json");
    std::error_code ignored;
    if (!a.marks.empty() && fs::exists(file, ignored)) {
      auto read = read_face_marks(file);
      if (!read) return read.error();
      marks = std::move(*read);
    }
    const auto more = study_landmark_sources(
        a.clips[i], a.sources, marks, a.frames,
        line.progress().stage(double(i) / n, double(i + 1) / n, a.clips[i].stem().string()),
        stop_on_signals());
    if (!more) return more.error();
    rows.insert(rows.end(), more->begin(), more->end());
  }
  return tables_of(rows);
}

int run(const FaceStudyArguments& a) {
  const ThreadLimit limit(a.common.threads);
  const auto tables = compare(a);
  return tables ? report_tables(a.common, a.output, *tables) : report_failure(tables.error());
}

}  // namespace

void add_face_study(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<FaceStudyArguments>();
  CLI::App* verb = study.add_subcommand(
      "faces", "The sources of landmarks beside each other: tremble, truth, marks, time, faces lost");
  verb->add_option("clips", a->clips, "Clips, and folders of `likeness demo`, whose truth is known")
      ->required();
  verb->add_option("--sources", a->sources,
                   "What --landmark-model takes: network, dlib, files; default: network dlib");
  verb->add_option("--marks", a->marks,
                   "A folder of files CLIP.json: how mouth and eyes were seen in the clips "
                   "(core/lab/truth/face_marks.h)");
  verb->add_option("--frames", a->frames, "At most so many from a clip's start")->check(CLI::Range(10, 9000));
  add_common_options(*verb, a->common);
  add_table_options(*verb, a->output);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
