// See bench_tables.h.
#include "app/bench_tables.h"

#include <cmath>

#include <fmt/format.h>

#include "core/export/write_film.h"
#include "core/lab/bench/render_study.h"

namespace likeness::app {
namespace {

std::vector<TableCell> setting_cells(const RenderRow& row) {
  const RenderOptions& o = row.setting.options;
  return {row.setting.name,
          row.psnr_db,
          row.psnr_head_db,
          row.psnr_face_db,
          std::isfinite(row.to_final_db) ? TableCell(row.to_final_db) : TableCell("same"),
          row.samples_per_ray,
          row.milliseconds,
          row.processor_milliseconds,
          row.frames_per_second,
          o.max_samples,
          o.strata,
          o.block,
          o.max_rays > 0 ? TableCell() : TableCell(o.reduce),
          o.edge_contrast,
          o.max_rays,
          o.stop_transmittance,
          o.shade_weight,
          int(row.setting.opacities),
          int(o.precision == FieldPrecision::exact)};
}

}  // namespace

Result<Table> settings_table(const Project& project, int frames, std::shared_ptr<Backend> backend,
                             const Progress& progress, std::stop_token stop) {
  const auto study = study_rendering(project, frames, render_settings(), std::move(backend), progress, stop);
  if (!study) return study.error();
  Table table{.name = "settings",
              .title = fmt::format("The renderer's settings, on {} held-out frames of {} px", study->frames,
                                   study->size)};
  table.columns = {{"name", "setting"},
                   {"psnr_db", "full, dB"},
                   {"psnr_head_db", "head"},
                   {"psnr_face_db", "face"},
                   {"to_final_db", "to final", 1},
                   {"samples_per_ray", "samples per ray", 1},
                   {"milliseconds", "ms", 1},
                   {"processor_milliseconds", "work, ms", 1},
                   {"frames_per_second", "pictures/s"}};
  for (const char* key : {"max_samples", "strata", "block", "reduce", "edge_contrast", "max_rays",
                          "stop_transmittance", "shade_weight", "opacities", "exact"})
    table.columns.push_back({key, ""});
  for (const RenderRow& row : study->rows) table.rows.push_back(setting_cells(row));
  table.notes = {
      fmt::format("ms per picture, work: ms of all threads; pictures/s with the pose, which takes {:.1f} ms",
                  study->pose_milliseconds)};
  return table;
}

Result<Table> live_table(const std::filesystem::path& project, const std::filesystem::path& clip,
                         const LiveStudyOptions& options, const Progress& progress, std::stop_token stop) {
  const auto opened = open_avatar(project);
  if (!opened) return opened.error();
  const auto figures = measure_live(opened->avatar, opened->model, clip, options, progress, stop);
  if (!figures) return figures.error();
  const LiveFigures& f = *figures;
  Table table{.name = "live", .title = fmt::format("Driven live by {}", clip.filename().string())};
  table.columns = {{"seconds", "seconds", 1},
                   {"captured", "captured", 0},
                   {"dropped", "dropped", 0},
                   {"driven", "driven", 0},
                   {"lost", "without a face", 0},
                   {"shown", "rendered", 0},
                   {"frames_per_second", "pictures/s", 1},
                   {"latency_median_ms", "ms from capture to picture", 0},
                   {"latency_p95_ms", "95 %", 0},
                   {"render_median_ms", "of which rendering", 0}};
  table.rows = {{f.seconds, f.captured, f.dropped, f.driven, f.lost, f.shown, f.frames_per_second,
                 1000 * f.latency_median_s, 1000 * f.latency_p95_s, 1000 * f.render_median_s}};
  return table;
}

}  // namespace likeness::app
