// Flags of a project's choices: see project_options.h.
#include "app/project_options.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include "app/terminal.h"
#include "core/capture/split.h"
#include "core/project/option_text.h"

namespace likeness::app {

namespace {

constexpr const char* kRestingFlag = "--resting-camera";

// Adds one row's flag, by the kind of its value.
struct AddOption {
  CLI::App& verb;
  const OptionRow& row;

  CLI::Option* plain(auto& value) const { return verb.add_option(row.flag, value, row.help); }
  void number(auto& value) const {
    CLI::Option* option = plain(value);
    const auto& [low, high, or_zero] = row.range;
    if (!row.choices.empty())
      option->check(CLI::IsMember(row.choices));
    else if (std::isfinite(high) && or_zero)
      option->check(CLI::Range(low, high) | CLI::Range(0.0, 0.0));
    else
      option->check(
          CLI::Range(low, std::min(high, std::numeric_limits<double>::max())));  // it reads -1 as 2^64 - 1
  }

  void operator()(std::filesystem::path& path) const { plain(path); }
  void operator()(bool& on) const {
    const std::string turns_off = on ? "!" : "";
    verb.add_flag(turns_off + row.flag, on, row.help);
  }
  void operator()(int& value) const { number(value); }
  void operator()(double& value) const { number(value); }
  void operator()(std::uint64_t& value) const { number(value); }
  void operator()(Split& split) const {
    std::map<std::string, Split> names;
    for (const Split known : kSplits) names.emplace(split_name(known), known);
    plain(split)->transform(CLI::CheckedTransformer(std::move(names)));
  }
  void operator()(std::optional<CameraKind>& kind) const {
    add_camera_kind_option(verb, kind, row.flag, row.help);
  }
  void operator()(std::optional<FieldMode>& mode) const { add_mode_option(verb, mode); }
  // Lists are kept with the clip: they are read as words, and parsed once the project is known.
  template <class List>
  void operator()(std::vector<List>&) const {}
};

}  // namespace

CLI::Option* add_camera_kind_option(CLI::App& verb, std::optional<CameraKind>& kind, const std::string& flag,
                                    const std::string& help) {
  return verb
      .add_option_function<std::string>(
          flag, [&kind](const std::string& name) { kind = camera_kind_named(name); }, help)
      ->check(CLI::IsMember({"auto", "resting", "handheld", "walking"}));
}

CLI::Option* add_resting_flag(CLI::App& verb, std::optional<CameraKind>& kind) {
  return verb.add_flag_callback(
      kRestingFlag, [&kind] { kind = CameraKind::resting; }, "Short for --camera-kind resting");
}

void add_project_options(CLI::App& verb, bool OptionVerbs::*takes, GivenOptions& given) {
  for (const OptionRow& row : option_table()) {
    if (!(row.verbs.*takes)) continue;
    if (!row.kept_with_clip) {
      with_option(row, given.options, AddOption{verb, row});
      if (std::string_view(row.key) == "camera_kind") add_resting_flag(verb, given.options.align.camera);
      continue;
    }
    CLI::Option* words = verb.add_option(row.flag, given.words[row.key], row.help)->allow_extra_args(false);
    // Spans add up; any other list is given once.
    if (!std::holds_alternative<OptionMember<std::vector<RefitSpan>>>(row.member)) words->expected(1);
  }
}

bool is_given(const CLI::App& verb, std::string_view key) {
  const auto stands = [&](const char* flag) {
    const CLI::Option* option = verb.get_option_no_throw(flag);
    return option != nullptr && option->count() > 0;
  };
  return stands(option_row(key).flag) || (key == "camera_kind" && stands(kRestingFlag));
}

Result<void> apply_given(const CLI::App& verb, const GivenOptions& given, ProjectOptions& options) {
  for (const OptionRow& row : option_table()) {
    if (std::string_view(row.flag).empty() || !is_given(verb, row.key)) continue;
    if (!row.kept_with_clip) {
      copy_option(row, given.options, options);
      continue;
    }
    for (const std::string& words : given.words.at(row.key))
      if (const auto read = read_option_words(row, words, options); !read) return read.error();
  }
  return {};
}

}  // namespace likeness::app
