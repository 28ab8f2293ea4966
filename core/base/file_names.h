// Names of files and folders that fit: a file system takes 255 bytes, and what is made of another name - a
// clip's, one that a user gave - often adds to it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace likeness {

inline constexpr std::size_t kLongestName = 255;  // bytes

// Its first bytes, at most so many, cut between two letters: marks, joiners and the like stay with the letter
// before them. Of bytes that are no UTF-8, wherever it is.
std::string cut_name(std::string_view name, std::size_t most);
// STEM and ENDING, the stem cut so that both fit.
std::string name_with(std::string_view stem, std::string_view ending);

// Whether a file or folder of this name, and what a project holds below it, can be made where it says, as far
// as lengths go.
Result<void> check_can_be_named(const std::filesystem::path& path);

}  // namespace likeness
