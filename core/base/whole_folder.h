// A folder written whole or not at all: filled under a hidden name beside its place, which it takes when it
// is complete.
#pragma once

#include <filesystem>

#include "core/base/result.h"

namespace likeness {

class WholeFolder {
 public:
  // target: the place. Nothing is made yet.
  explicit WholeFolder(std::filesystem::path target);
  // What was not committed goes.
  ~WholeFolder();
  WholeFolder(const WholeFolder&) = delete;
  WholeFolder& operator=(const WholeFolder&) = delete;

  // Where to write until then; ".NAME....part..." beside the place.
  const std::filesystem::path& temporary() const { return temporary_; }
  // Puts the folder in its place; one that stood there is removed, or stays where this fails.
  Result<void> commit();

 private:
  std::filesystem::path target_, temporary_;
};

}  // namespace likeness
