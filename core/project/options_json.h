// A project's choices as the object "options" of project.json, by the rows of option_table.h.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/base/result.h"
#include "core/project/project_options.h"

namespace likeness {

nlohmann::json options_to_json(const ProjectOptions& options);

// version: of the project.json. A key that version did not have yet leaves the choice at its default, and
// keys of no row are passed over. Of what is refused, the Error's `what` names the key, its value, and what
// it may be, without a full stop.
Result<ProjectOptions> options_from_json(const nlohmann::json& object, int version);

}  // namespace likeness
