// Reads a project's avatar with its head model: see open_avatar.h.
#include "core/project/open_avatar.h"

#include <fmt/format.h>

#include <system_error>

#include "core/base/hash.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"

namespace likeness {

namespace fs = std::filesystem;

Result<OpenedAvatar> open_avatar(const fs::path& folder) {
  auto project = open_project(folder);
  if (!project) return project.error();
  if (std::error_code ignored; !fs::exists(avatar_path(*project), ignored)) {
    return Error{ErrorCode::not_found, fmt::format("{} holds no trained avatar.", folder.string()),
                 "Run: likeness build VIDEO --project DIR", ""};
  }
  auto avatar = read_avatar(avatar_path(*project));
  if (!avatar) return avatar.error();
  auto model = project_head_model(project->options);
  if (!model) return model.error();
  if (const auto fits = check_avatar_fits(*avatar, *model, folder.string()); !fits) return fits.error();
  auto hash = hash_file(avatar_path(*project));
  if (!hash) return hash.error();
  return OpenedAvatar{std::move(*project), std::move(*avatar), std::move(*model), std::move(*hash)};
}

}  // namespace likeness
