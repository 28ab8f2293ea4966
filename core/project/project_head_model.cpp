// See project_head_model.h.
#include "core/project/project_head_model.h"

#include "core/head/builtin_head.h"
#include "core/head/load_head_model.h"

namespace likeness {

Result<HeadModel> project_head_model(const ProjectOptions& options) {
  return head_model_at(options.shared.head_model);
}

Result<HeadModel> head_model_at(const std::filesystem::path& path) {
  if (path.empty()) return make_builtin_head();
  return load_head_model(path);
}

}  // namespace likeness
