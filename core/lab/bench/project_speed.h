// What an avatar costs on this machine: pictures a second of both qualities beside what the quicker one
// loses, and rays a second of its training. What `likeness bench PROJECT` reports.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/field/precision.h"
#include "core/project/project.h"
#include "core/render/backend.h"

namespace likeness {

struct ProjectSpeedOptions {
  int frames = 6;                                   // held out that are rendered, evenly chosen; 0: all
  double train_seconds = 8;                         // of training that is measured
  FieldPrecision precision = FieldPrecision::bf16;  // of its products, by the processor
  std::shared_ptr<Backend> backend;                 // null: the processor
};

struct ProjectSpeed {
  int size = 0, frames = 0;               // px; rendered
  std::string backend;                    // cpu, cuda
  double final_fps = 0, preview_fps = 0;  // with the pose
  double final_ms = 0, preview_ms = 0;    // of a picture, without it
  // Mean PSNR against the truth that `preview` has less than `final`: of the whole picture, where the
  // background is known, and of the head.
  std::optional<double> preview_loss_db;
  double preview_loss_head_db = 0;
  double rays_per_s = 0;  // of training
};

// The project must hold an avatar and is not changed: the training goes on from a copy of its checkpoint, so
// that occupancy is as it is late in a training, or starts anew where there is none.
Result<ProjectSpeed> measure_project_speed(const Project& project, const ProjectSpeedOptions& options,
                                           const Progress& progress, std::stop_token stop);

}  // namespace likeness
