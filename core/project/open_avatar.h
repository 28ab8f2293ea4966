// A finished project's avatar, opened.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"
#include "core/head/head_model.h"
#include "core/project/project.h"
#include "core/render/avatar.h"

namespace likeness {

// A project's avatar with the head model it was made with.
struct OpenedAvatar {
  Project project;
  Avatar avatar;
  HeadModel model;
  std::string avatar_hash;  // of avatar.bin
};
Result<OpenedAvatar> open_avatar(const std::filesystem::path& folder);

}  // namespace likeness
