// Running a project: each stage whose inputs changed or whose result is absent, in order.
#pragma once

#include <stop_token>
#include <utility>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/project/project.h"
#include "core/project/run_observer.h"

namespace likeness {

// The part of a run's progress that a stage takes, from and to in [0, 1].
std::pair<double, double> stage_span(const ProjectOptions& options, Stage last, Stage stage);

// Runs all stages up to and including `last` that are not current. A stop or a failure leaves finished stages
// and the interrupted stage's checkpoint; calling again continues. Takes the project's lock.
Result<void> run_stages(Project& project, Stage last, const Progress& progress, const RunObserver& observer,
                        std::stop_token stop, const TrainingPlace& place = {});

}  // namespace likeness
