// See project_speed_report.h.
#include "app/project_speed_report.h"

#include <fmt/format.h>

#include "app/terminal.h"
#include "core/base/parallel.h"

namespace likeness::app {

nlohmann::json project_speed_json(const ProjectSpeed& s) {
  return {{"size", s.size},
          {"frames", s.frames},
          {"backend", s.backend},
          {"final_fps", s.final_fps},
          {"preview_fps", s.preview_fps},
          {"final_ms", s.final_ms},
          {"preview_ms", s.preview_ms},
          {"preview_loss_db", finite_or_null(s.preview_loss_db)},
          {"preview_loss_head_db", s.preview_loss_head_db},
          {"rays_per_s", s.rays_per_s}};
}

Table project_speed_table(const ProjectSpeed& s) {
  Table table{.name = "project",
              .title = fmt::format(
                  "The project: {} held-out frames of {} px, {}", s.frames, s.size,
                  s.backend == "cpu" ? fmt::format("{} threads", current_thread_limit()) : s.backend)};
  table.columns = {{"size_px", "", 0},
                   {"backend", ""},
                   {"final_fps", "final, pictures/s"},
                   {"final_ms", "ms without the pose"},
                   {"preview_fps", "preview, pictures/s"},
                   {"preview_ms", "ms without the pose"},
                   {"preview_loss_db", "dB less"},
                   {"preview_loss_head_db", "at the head"},
                   {"rays_per_s", "training, rays/s", 0}};
  table.rows = {{s.size, s.backend, s.final_fps, s.final_ms, s.preview_fps, s.preview_ms, s.preview_loss_db,
                 s.preview_loss_head_db, s.rays_per_s}};
  return table;
}

}  // namespace likeness::app
