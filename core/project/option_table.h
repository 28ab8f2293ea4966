// Every choice of a project's, a row each: how project.json and the command line name it, what it may be,
// what it makes stale, and how the studio shows it. The command line (app/project_options.h), project.json
// (options_json.h), the manual page and the studio's fields are made from these rows. A new choice is a row
// here, a member in project_options.h, and its use where a stage reads it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "core/capture/split.h"
#include "core/project/project_options.h"
#include "core/project/stage.h"
#include "core/track/clip/refit_options.h"
#include "core/train/mode.h"

namespace likeness {

// Where a choice lies in the options.
template <class T>
using OptionMember = T& (*)(ProjectOptions& options);
using AnyOptionMember =
    std::variant<OptionMember<std::filesystem::path>, OptionMember<bool>, OptionMember<int>,
                 OptionMember<double>, OptionMember<std::uint64_t>, OptionMember<Split>,
                 OptionMember<std::optional<CameraKind>>, OptionMember<std::optional<FieldMode>>,
                 OptionMember<std::vector<int>>, OptionMember<std::vector<RefitSpan>>>;

// From low to high, both of them included.
struct OptionRange {
  double low = 0, high = std::numeric_limits<double>::infinity();
  bool or_zero = false;  // 0, too
};

// The verbs of the command line whose --help has the flag.
struct OptionVerbs {
  bool build = false, import = false, align = false, fit = false, train = false;
};

// Among the studio's further choices, as a row of buttons.
struct StudioField {
  const char* label = "";  // empty: not shown there
  const char* hint = "";
  const char* unit = "";
  double one_unit = 1;  // in the choice's own unit
  std::vector<double> offered{};
};

struct OptionRow {
  const char* key;  // in project.json; another name there is another choice
  AnyOptionMember member;
  // Stages whose result another value makes stale by itself, of a project with the usual options. Those after
  // them build on their results.
  std::vector<Stage> stale{};
  const char* flag = "";  // with its dashes; empty: none. Of a switch that is usually on, it turns it off
  const char* help = "";
  OptionVerbs verbs{};
  OptionRange range{};            // of a number, wherever it comes from
  std::vector<int> choices{};     // of a whole number on the command line; empty: all in the range
  bool in_every_project = false;  // project.json had it from the first version on: without it, it is damaged
  bool of_the_person = false;     // further clips of the person follow the project's first clip
  bool kept_with_clip = false;    // a build of the same clip keeps it unless the flag is given
  const char* taken_back = "none";  // the word that takes back what is kept with the clip
  bool none_is_a_choice = false;    // of a path: "none" is no file's name, but a value other than empty
  StudioField studio{};
};

const std::vector<OptionRow>& option_table();
const OptionRow& option_row(std::string_view key);  // of a key that there is

// Calls use(member's value) with the row's value in `options`, of its own type.
template <class Options, class Use>
decltype(auto) with_option(const OptionRow& row, Options& options, Use&& use) {
  return std::visit(
      [&](auto member) -> decltype(auto) {
        // The accessors only say where a member lies.
        auto& value = member(const_cast<ProjectOptions&>(options));
        if constexpr (std::is_const_v<Options>) {
          return use(std::as_const(value));
        } else {
          return use(value);
        }
      },
      row.member);
}

void copy_option(const OptionRow& row, const ProjectOptions& from, ProjectOptions& to);

// Whether `value` may be the row's number.
bool is_in_range(const OptionRow& row, double value);
// What the row's value may be, to end a sentence: "a number from 1 to 1000000", "tail, views or random30".
std::string option_domain(const OptionRow& row);

}  // namespace likeness
