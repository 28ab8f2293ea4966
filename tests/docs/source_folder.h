// Where the repository lies that is checked.
#pragma once

#include <filesystem>

namespace likeness::test {

inline const std::filesystem::path kSource = LIKENESS_SOURCE;

}  // namespace likeness::test
