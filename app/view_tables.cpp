// See view_tables.h.
#include "app/view_tables.h"

#include <vector>

namespace likeness::app {

Table views_table(const std::string& first) {
  Table table{.name = "views", .title = "Where cameras look, beside known ones"};
  table.columns = {{first, first},
                   {"kind", "camera"},
                   {"true_kind", "truly"},
                   {"found", "found", 0},
                   {"wanted", "of", 0},
                   {"turn_median_deg", "turn, °", 3},
                   {"turn_max_deg", "worst", 3},
                   {"zoom_median_percent", "zoom, %"},
                   {"zoom_max_percent", "worst"},
                   {"focal_percent", "focal length, %"},
                   {"mapping_median_px", "mapping, px"},
                   {"mapping_p95_px", "p95"}};
  table.notes = {
      "turn: after one rotation of the world for every place of the film; zoom: of the focal length "
      "relative\n"
      "to the film's usual one; mapping: where distant pixels lie in the first frame of their place"};
  return table;
}

void add_views(Table& table, const std::string& first, std::optional<CameraKind> kind, CameraKind true_kind,
               const std::optional<ViewErrors>& errors) {
  std::vector<TableCell>& cells = table.rows.emplace_back();
  cells = {first, kind ? camera_kind_name(*kind) : "", camera_kind_name(true_kind)};
  if (errors) {
    const ViewErrors& e = *errors;
    for (const TableCell& cell :
         {TableCell(e.found), TableCell(e.wanted), TableCell(e.turn_median_deg), TableCell(e.turn_max_deg),
          TableCell(e.zoom_median_percent), TableCell(e.zoom_max_percent), TableCell(e.focal_percent),
          TableCell(e.mapping_median_px), TableCell(e.mapping_p95_px)})
      cells.push_back(cell);
  }
  cells.resize(table.columns.size());
}

}  // namespace likeness::app
