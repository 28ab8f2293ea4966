// What a picture costs and what it loses: the same held-out frames rendered under several settings, each
// timed and compared with the truth and with the final picture.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/project/project.h"
#include "core/render/backend.h"
#include "core/render/render.h"

namespace likeness {

struct RenderSetting {
  std::string name;
  RenderOptions options;
  bool opacities = true;  // the grids say how much light their cells are expected to take
};

// The two of the quality ladder, the same with deferred shading, final without each of the things that save
// samples or colours, `exact` - a ray a pixel in single precision - and what lies about them in bf16: samples
// a ray, rays a pixel, rays a preview.
std::vector<RenderSetting> render_settings();
std::vector<RenderSetting> quality_ladder();  // the first two of them

struct RenderRow {
  RenderSetting setting;
  // Means of the frames' dB against the truth; full only where the background is known.
  std::optional<double> psnr_db;
  double psnr_head_db = 0, psnr_face_db = 0;
  double to_final_db = 0;  // against the final picture, over the same background; +inf for the final itself
  double milliseconds = 0, frames_per_second = 0;  // of a picture; its pose included in the latter
  double processor_milliseconds = 0;  // of all threads: what counts where others use the machine, too
  double samples_per_ray = 0;
};

struct RenderStudy {
  int size = 0, frames = 0;
  double pose_milliseconds = 0;  // posing the head model and its lattice, the same for every setting
  std::vector<RenderRow> rows;   // as the settings
};

// `frames` of the held-out frames, evenly chosen; 0: all. Settings take turns frame by frame, so that what
// else the machine does falls on all alike; the first of them is the one that to_final_db compares with. On a
// device (backend; null: the processor) a picture's time is from the pose that goes there to the picture that
// is back.
Result<RenderStudy> study_rendering(const Project& project, int frames, std::vector<RenderSetting> settings,
                                    std::shared_ptr<Backend> backend, const Progress& progress,
                                    std::stop_token stop);

}  // namespace likeness
