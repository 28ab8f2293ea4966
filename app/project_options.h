// A project's choices as options of the verbs that run its stages, by the rows of
// core/project/option_table.h.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "core/base/result.h"
#include "core/project/option_table.h"

namespace likeness::app {

// What the command line says of a project's choices.
struct GivenOptions {
  ProjectOptions options;
  // By key, of choices that are kept with the clip: as they stand on the command line. What they mean depends
  // on the project.
  std::map<std::string, std::vector<std::string>, std::less<>> words;
};

// The flags of one verb, in the table's order. Before add_common_options, which adds --seed where it is not.
void add_project_options(CLI::App& verb, bool OptionVerbs::*takes, GivenOptions& given);

// --camera-kind and its short form for a camera at rest. The last of them on the command line counts.
CLI::Option* add_camera_kind_option(CLI::App& verb, std::optional<CameraKind>& kind,
                                    const std::string& flag = "--camera-kind",
                                    const std::string& help = "What the camera of the added clip does");
CLI::Option* add_resting_flag(CLI::App& verb, std::optional<CameraKind>& kind);

// Whether a choice's flag stands on the command line.
bool is_given(const CLI::App& verb, std::string_view key);

// Choices that are given replace those in `options`; the others stay.
Result<void> apply_given(const CLI::App& verb, const GivenOptions& given, ProjectOptions& options);

}  // namespace likeness::app
