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

void print_project_speed(const ProjectSpeed& s) {
  fmt::print(
      "\n{} held-out frames of {} px, {}: final {:.2f} pictures/s ({:.2f} ms without the pose), "
      "preview {:.2f} ({:.2f} ms) for ",
      s.frames, s.size, s.backend == "cpu" ? fmt::format("{} threads", current_thread_limit()) : s.backend,
      s.final_fps, s.final_ms, s.preview_fps, s.preview_ms);
  if (s.preview_loss_db) fmt::print("{:.2f} dB less, ", *s.preview_loss_db);
  fmt::print("{:.2f} dB less at the head; {:.0f} rays/s of training\n", s.preview_loss_head_db, s.rays_per_s);
}

}  // namespace likeness::app
