// Which of a project's results were made from what is there now.
#pragma once

#include <array>
#include <string>

#include "core/project/project.h"

namespace likeness {

// Everything that the stage's result depends on, as one hash. Results of earlier stages count by content. One
// that was altered since is made again first (core/project/stage_results.h).
std::string input_hash(const Project& project, Stage stage);

// That of the fit as if no span had been fitted again, and without the maps, which are read beside the
// finished track: what the whole clip's track, and the person's shape in it, are made from.
std::string first_track_hash(const Project& project);

// Whether the stage's result is there and made from what is there now, for further clips, too.
bool is_current(const Project& project, Stage stage);
// The same of this clip by itself.
bool is_current_alone(const Project& project, Stage stage);

// Of all stages at once: every input is read and hashed a few times only.
struct Freshness {
  std::array<bool, kStages.size()> current{};  // as is_current
  // A result is there that was made from other choices or inputs than those there are now, or builds on one
  // that was: a new run replaces it.
  std::array<bool, kStages.size()> stale{};
};
Freshness read_freshness(const Project& project);

}  // namespace likeness
