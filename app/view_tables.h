// The table of cameras compared by their views, which two verbs print.
#pragma once

#include <optional>
#include <string>

#include "core/base/table.h"
#include "core/lab/truth/view_truth.h"

namespace likeness::app {

// first: heading of the first column. Its key is "views".
Table views_table(const std::string& first);
// kind: of the cameras found; nullopt where there are none.
void add_views(Table& table, const std::string& first, std::optional<CameraKind> kind, CameraKind true_kind,
               const std::optional<ViewErrors>& errors);

}  // namespace likeness::app
