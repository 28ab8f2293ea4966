// Tables of `likeness bench PROJECT` beside the engine's: what the renderer's settings cost and lose, and how
// soon an avatar follows a clip that is fed in real time.
#pragma once

#include <memory>
#include <stop_token>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/base/table.h"
#include "core/lab/bench/live_figures.h"
#include "core/project/project.h"
#include "core/render/backend.h"

namespace likeness::app {

// frames: of the held-out ones, evenly chosen; 0: all. backend: null, the processor.
Result<Table> settings_table(const Project& project, int frames, std::shared_ptr<Backend> backend,
                             const Progress& progress, std::stop_token stop);

// Takes as long as the clip.
Result<Table> live_table(const std::filesystem::path& project, const std::filesystem::path& clip,
                         const LiveStudyOptions& options, const Progress& progress, std::stop_token stop);

}  // namespace likeness::app
