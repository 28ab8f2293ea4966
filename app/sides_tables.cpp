// See sides_tables.h.
#include "app/sides_tables.h"

#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "app/terminal.h"

namespace likeness::app {
namespace {

const char* angle_name(SidesAngle angle) {
  switch (angle) {
    case SidesAngle::off:
      return "off";
    case SidesAngle::yaw:
      return "yaw";
    case SidesAngle::pitch:
      return "pitch";
  }
  return "";
}

std::vector<TableColumn> score_columns() {
  return {{"frames", "frames", 0},      {"psnr_head_db", "head, dB"}, {"psnr_face_db", "face"},
          {"psnr_person_db", "person"}, {"drift", "colour drift", 1}, {"iou", "IoU", 3},
          {"specks", "specks, %", 3}};
}

void add_score_cells(const SidesScore& s, std::vector<TableCell>& row) {
  row.insert(row.end(), {TableCell(double(s.frames)), TableCell(s.score.psnr_head_db),
                         TableCell(s.score.psnr_face_db), TableCell(s.score.psnr_person_db),
                         TableCell(s.drift), TableCell(s.iou), TableCell(100 * s.specks)});
}

Table rows_table(std::string name, std::string title, const std::vector<SidesRow>& rows) {
  Table table{.name = std::move(name), .title = std::move(title)};
  table.columns = {{"of", "angle"},
                   {"from_deg", "from, °", 0},
                   {"to_deg", "to", 0},
                   {"yaw", "yaw, °", 0},
                   {"pitch", "pitch", 0}};
  for (TableColumn& column : score_columns()) table.columns.push_back(std::move(column));
  for (const SidesRow& row : rows) {
    std::vector<TableCell>& cells = table.rows.emplace_back();
    cells = {std::string(angle_name(row.angle)), row.from_deg, row.to_deg, row.yaw_deg, row.pitch_deg};
    add_score_cells(row.score, cells);
  }
  return table;
}

nlohmann::json score_json(const SidesScore& s) {
  return {{"frames", s.frames},
          {"psnr_head_db", finite_or_null(s.score.psnr_head_db)},
          {"psnr_face_db", finite_or_null(s.score.psnr_face_db)},
          {"psnr_person_db", finite_or_null(s.score.psnr_person_db)},
          {"drift", finite_or_null(s.drift)},
          {"iou", finite_or_null(s.iou)},
          {"depth_mm", nullptr},
          {"specks", finite_or_null(s.specks)}};
}

nlohmann::json rows_json(const std::vector<SidesRow>& rows) {
  nlohmann::json list = nlohmann::json::array();
  for (const SidesRow& row : rows) {
    nlohmann::json own = score_json(row.score);
    own["of"] = angle_name(row.angle);
    own["from_deg"] = row.from_deg, own["to_deg"] = row.to_deg;
    own["yaw"] = row.yaw_deg, own["pitch"] = row.pitch_deg;
    list.push_back(std::move(own));
  }
  return list;
}

}  // namespace

std::vector<Table> sides_tables(const SidesStudy& study) {
  Table inside{.name = "inside",
               .title = fmt::format("Within {:g}° of the typical side: held out of the training",
                                    study.sides.inside_deg)};
  inside.columns = score_columns();
  add_score_cells(study.within, inside.rows.emplace_back());
  inside.notes = {fmt::format(
      "Of {} frames {} trained; {} were held out inside and {} beyond, {} of them lost; {} kept apart.\n"
      "{} steps in {:.0f} s.",
      study.frames, study.trained, study.inside, study.beyond, study.lost, study.apart, study.steps,
      study.train_seconds)};
  Table off = rows_table(
      "off", fmt::format("Beyond {:g}°, by the angle off the typical side", study.sides.beyond_deg),
      study.off);
  Table views = rows_table("views", "The same, by where they lie", study.views);
  views.notes = {
      "Rows are by yaw, or by pitch of what is turned farther up or down; yaw and pitch are means.\n"
      "colour drift: of the face's mean, of 255, less that inside;\n"
      "specks: more than 48 of 255 off the truth and off the median of their neighbours"};
  return {std::move(inside), std::move(off), std::move(views)};
}

nlohmann::json sides_json(const SidesStudy& study) {
  return {{"inside", score_json(study.within)},
          {"views", rows_json(study.views)},
          {"off", rows_json(study.off)},
          {"inside_deg", study.sides.inside_deg},
          {"beyond_deg", study.sides.beyond_deg},
          {"frames",
           {{"all", study.frames},
            {"trained", study.trained},
            {"inside", study.inside},
            {"beyond", study.beyond},
            {"lost", study.lost},
            {"apart", study.apart}}},
          {"steps", study.steps},
          {"train_seconds", study.train_seconds}};
}

}  // namespace likeness::app
