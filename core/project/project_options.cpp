// See project_options.h.
#include "core/project/project_options.h"

#include <utility>

namespace likeness {

void restore_budget(ProjectOptions& options) {
  if (options.train.full_budget_s > 0) options.train.budget_s = std::exchange(options.train.full_budget_s, 0);
}

}  // namespace likeness
