// Mattes as the matte stage of a project makes them - the user's strokes, the networks, the room behind a
// moving camera - into any folder, so that a study can make others beside the project's own.
#pragma once

#include <filesystem>
#include <stop_token>

#include "core/base/kept_work.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/head/head_model.h"
#include "core/matte/matte_result.h"
#include "core/project/project.h"
#include "core/project/project_views.h"
#include "core/project/stage_inputs.h"

namespace likeness {

// folder: holds frames/ of `read`'s capture, and gets what matte_clip writes (core/matte/matte.h). The
// strokes are the project's; the room is written to room.bin in the folder,
// unless it does not show the background (core/matte/matte_report.h). kept: as MatteOptions has it.
Result<MatteResult> make_mattes(const Project& project, const MatteInputs& inputs,
                                const std::filesystem::path& folder, const TrackedCapture& read,
                                const HeadModel& model, const Progress& progress, std::stop_token stop,
                                std::shared_ptr<KeptWork> kept = nullptr);

}  // namespace likeness
