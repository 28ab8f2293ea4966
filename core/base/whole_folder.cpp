// Folders renamed into place: see whole_folder.h.
#include "core/base/whole_folder.h"

#include <system_error>
#include <utility>

#include "core/base/files.h"
#include "core/base/unfinished.h"

namespace likeness {

namespace fs = std::filesystem;

WholeFolder::WholeFolder(fs::path target) : target_(std::move(target)), temporary_(temporary_name(target_)) {}

WholeFolder::~WholeFolder() {
  std::error_code ignored;
  fs::remove_all(temporary_, ignored);
  forget_unfinished(temporary_);
}

Result<void> WholeFolder::commit() {
  std::error_code failure;
  // Neither may go once their names change: the new one takes its place, the old one is the only whole one
  // for a moment.
  forget_unfinished(temporary_);
  const fs::path old = temporary_name(target_);
  forget_unfinished(old);
  if (fs::exists(target_, failure)) fs::rename(target_, old, failure);
  if (!failure) fs::rename(temporary_, target_, failure);
  if (failure) {
    std::error_code ignored;
    if (!fs::exists(target_, ignored)) fs::rename(old, target_, ignored);
    return file_error(target_, "replace", failure.value());
  }
  fs::remove_all(old, failure);
  return {};
}

}  // namespace likeness
