// Tables of a trained avatar, of which nothing is trained: what empty cells save, and what the landmark loss
// measures.
#pragma once

#include <optional>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/base/table.h"
#include "core/project/project.h"

namespace likeness::app {

// frames: of the held-out ones, evenly chosen; 0: all; nullopt: 12 and 24.
Result<std::vector<Table>> occupancy_tables(const Project& project, const std::optional<int>& frames,
                                            const Progress& progress, std::stop_token stop);
Result<std::vector<Table>> landmark_tables(const Project& project, const std::optional<int>& frames,
                                           const Progress& progress, std::stop_token stop);

}  // namespace likeness::app
