// See stage.h.
#include "core/project/stage.h"

#include <cstddef>

namespace likeness {
namespace {

constexpr std::array<const char*, kStages.size()> kStageNames{"import", "align", "fit", "matte", "train"};

}  // namespace

std::string_view stage_name(Stage stage) { return kStageNames[std::size_t(stage)]; }

}  // namespace likeness
