// See options_json.h.
#include "core/project/options_json.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json_text.h"
#include "core/base/path_text.h"
#include "core/capture/split.h"
#include "core/project/option_table.h"

namespace likeness {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

// The mode's second key: whether the user asked for it. Versions that did not choose read the default.
constexpr const char* kModeAsked = "mode_asked";
constexpr const char* kFoundOut = "auto";         // a camera's kind that the user did not state
constexpr const char* kRests = "resting_camera";  // what older projects have instead of the kind

struct WriteOption {
  json& object;
  const char* key;

  void operator()(const fs::path& path) const { object[key] = text_of_path(path); }
  void operator()(const Split& split) const { object[key] = split_name(split); }
  void operator()(const std::optional<CameraKind>& kind) const {
    object[key] = kind ? camera_kind_name(*kind) : kFoundOut;
  }
  void operator()(const std::optional<FieldMode>& mode) const {
    object[key] = mode_name(mode.value_or(kDefaultMode));
    object[kModeAsked] = mode.has_value();
  }
  void operator()(const std::vector<RefitSpan>& spans) const {
    json list = json::array();
    for (const RefitSpan& span : spans) list.push_back({span.first, span.last});
    object[key] = std::move(list);
  }
  template <class Plain>
  void operator()(const Plain& value) const {
    object[key] = value;
  }
};

// The mode of a project of version 1, which always gave the field the expression.
FieldMode mode_of_switches(const json& object) {
  const ModeParts parts{
      .expression = true, .ambient = object.at("use_ambient"), .warp = object.value("use_warp", true)};
  return *std::ranges::find(kFieldModes, parts, mode_parts);
}

// Reads one row's value; false if the file has something that it cannot be.
struct ReadOption {
  const json& object;
  const OptionRow& row;
  int version;

  const json& value() const { return object.at(row.key); }

  bool operator()(fs::path& path) const {
    if (!value().is_string()) return false;
    path = path_of_text(value().get<std::string>());
    return true;
  }
  bool operator()(bool& on) const {
    if (!value().is_boolean()) return false;
    on = value().get<bool>();
    return true;
  }
  bool operator()(double& number) const {
    if (!value().is_number() || !is_in_range(row, value().get<double>())) return false;
    number = value().get<double>();
    return true;
  }
  template <class Whole>
  bool whole(Whole& number) const {
    if (!value().is_number()) return false;
    const auto as_double = value().get<double>();
    const bool fits = value().is_number_unsigned()
                          ? value().get<std::uint64_t>() <= std::uint64_t(std::numeric_limits<Whole>::max())
                          : std::abs(as_double) <= double(std::numeric_limits<int>::max());
    if (!fits || !is_in_range(row, as_double)) return false;
    number = value().get<Whole>();
    return true;
  }
  bool operator()(int& number) const { return whole(number); }
  bool operator()(std::uint64_t& number) const { return whole(number); }
  bool operator()(Split& split) const {
    const auto named = value().is_string() ? split_named(value().get<std::string>()) : std::nullopt;
    if (named) split = *named;
    return named.has_value();
  }
  bool operator()(std::optional<CameraKind>& kind) const {
    if (!object.contains(row.key)) {  // from before a camera could be anything but at rest or moving
      if (!object.at(kRests).is_boolean()) return false;
      kind = object.at(kRests).get<bool>() ? std::optional(CameraKind::resting) : std::nullopt;
      return true;
    }
    const auto name = value().get<std::string>();
    kind = camera_kind_named(name);
    return kind || name == kFoundOut;
  }
  // In a project from before parts were chosen, the default mode was not the user's choice.
  bool operator()(std::optional<FieldMode>& mode) const {
    const auto named = version == 1          ? std::optional(mode_of_switches(object))
                       : value().is_string() ? mode_named(value().get<std::string>())
                                             : std::nullopt;
    if (!named) return false;
    mode = object.value(kModeAsked, *named != kDefaultMode) ? named : std::nullopt;
    return true;
  }
  bool operator()(std::vector<int>& frames) const {
    frames = whole_numbers_in(value());
    std::ranges::sort(frames);
    return true;
  }
  // Spans that run backwards are dropped.
  bool operator()(std::vector<RefitSpan>& spans) const {
    spans.clear();
    for (const json& span : value())
      spans.push_back({whole_number_in(span.at(0)), whole_number_in(span.at(1))});
    std::erase_if(spans, [](const RefitSpan& s) { return s.first < 0 || s.last < s.first; });
    spans = merged_spans(std::move(spans));
    return true;
  }
};

bool is_there(const json& object, const OptionRow& row, int version) {
  const bool by_switches = version == 1 && std::string_view(row.key) == "mode",
             by_rest = std::string_view(row.key) == "camera_kind" && object.contains(kRests);
  return by_switches || by_rest || object.contains(row.key);
}

Error refusal(std::string what) { return {ErrorCode::bad_input, std::move(what), "", "options"}; }

// As the file has it, cut to a length that a message can hold.
std::string shown(const json& value) {
  constexpr std::size_t kMaxLength = 60;
  const std::string text = json_text(value);
  return text.size() <= kMaxLength ? text : text.substr(0, kMaxLength) + "...";
}

}  // namespace

json options_to_json(const ProjectOptions& options) {
  json object = json::object();
  for (const OptionRow& row : option_table()) with_option(row, options, WriteOption{object, row.key});
  return object;
}

Result<ProjectOptions> options_from_json(const json& object, int version) {
  if (!object.is_object()) return refusal("its options are missing");
  ProjectOptions options;
  for (const OptionRow& row : option_table()) {
    if (!is_there(object, row, version)) {
      if (row.in_every_project) return refusal(fmt::format("its {} is missing", row.key));
      continue;
    }
    try {
      if (with_option(row, options, ReadOption{object, row, version})) continue;
    } catch (
        const json::exception&) {  // of a list, or of the first version's switches: refused like the rest
    }
    const json value = object.value(row.key, json());
    return refusal(fmt::format("its {} is {}, which is not {}", row.key, shown(value), option_domain(row)));
  }
  return options;
}

}  // namespace likeness
