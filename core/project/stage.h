// The stages of a project, in their order.
#pragma once

#include <array>
#include <string_view>

namespace likeness {

enum class Stage { import, align, fit, matte, train };
inline constexpr std::array kStages{Stage::import, Stage::align, Stage::fit, Stage::matte, Stage::train};
std::string_view stage_name(Stage stage);

}  // namespace likeness
