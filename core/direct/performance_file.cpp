// performance.json: see performance.h.
#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/json_text.h"
#include "core/direct/performance.h"

namespace likeness {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kVersion = 1;
constexpr const char* kFormat = "likeness performance";
constexpr const char* kUnits =
    "seconds, degrees, metres; actions: 1 = full; camera distance and zoom: 1 = as captured";
constexpr std::size_t kMaxKeys = 2'000'000;

// What is wrong with which field; caught where the file is read.
struct Wrong {
  std::string field, what;
};

void check_fields(const json& object, const std::set<std::string>& known, const std::string& where) {
  if (!object.is_object()) throw Wrong{where, "is not an object"};
  for (const auto& [name, value] : object.items())
    if (!known.contains(name)) throw Wrong{where.empty() ? name : where + "." + name, "is not a known field"};
}

const json& field(const json& object, const char* name, std::string_view where) {
  const auto found = object.find(name);
  if (found == object.end()) throw Wrong{std::string(where) + name, "is missing"};
  return *found;
}

double number(const json& object, const char* name, const std::string& where, double low, double high) {
  const json& value = field(object, name, where);
  if (!value.is_number()) throw Wrong{where + name, "is not a number"};
  const double x = value.get<double>();
  if (!(x >= low && x <= high))
    throw Wrong{where + name, fmt::format("is {}, which is not from {} to {}", x, low, high)};
  return x;
}

Easing easing(const json& key, const std::string& where) {
  const json& value = field(key, "easing", where);
  for (std::size_t i = 0; i < std::size(kEasings); ++i)
    if (value == kEasings[i]) return Easing(i);
  throw Wrong{where + "easing",
              fmt::format("is {}, not one of linear, smooth, hold, ease_in, ease_out", json_text(value))};
}

std::vector<Key> read_keys(const json& list, const std::string& channel) {
  const std::string name = "channels.\"" + channel + "\"";
  if (!is_channel(channel)) throw Wrong{name, "is not a channel; actions are written as \"action NAME\""};
  if (!list.is_array() || list.empty()) throw Wrong{name, "is not a list of keys"};
  if (list.size() > kMaxKeys) throw Wrong{name, fmt::format("has {} keys", list.size())};
  std::vector<Key> keys;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string where = fmt::format("{}[{}]", name, i);
    check_fields(list[i], {"time_s", "value", "easing"}, where);
    Key key;
    key.time_s = number(list[i], "time_s", where + ".", 0, kLongest_s);
    key.value = float(number(list[i], "value", where + ".", -1e4, 1e4));
    key.easing = easing(list[i], where + ".");
    if (!keys.empty() && key.time_s <= keys.back().time_s + kSameTime_s)
      throw Wrong{where + ".time_s", "is not after the key before it"};
    keys.push_back(key);
  }
  return keys;
}

Performance from_json(const json& file) {
  check_fields(file, {"format", "version", "units", "duration_s", "frames_per_second", "channels"}, "");
  if (field(file, "format", "") != kFormat) throw Wrong{"format", fmt::format("is not \"{}\"", kFormat)};
  if (field(file, "version", "") != kVersion) throw Wrong{"version", fmt::format("is not {}", kVersion)};
  Performance performance;
  performance.duration_s = number(file, "duration_s", "", 1e-3, kLongest_s);
  performance.frames_per_second = number(file, "frames_per_second", "", 1, 240);
  const json& channels = field(file, "channels", "");
  if (!channels.is_object()) throw Wrong{"channels", "is not an object"};
  for (const auto& [name, list] : channels.items()) performance.channels[name] = read_keys(list, name);
  return performance;
}

}  // namespace

Result<void> write_performance(const fs::path& path, const Performance& performance) {
  json channels = json::object();
  for (const auto& [name, keys] : performance.channels) {
    json& list = channels[name] = json::array();
    for (const Key& key : keys)
      list.push_back(
          {{"time_s", key.time_s}, {"value", key.value}, {"easing", kEasings[std::size_t(key.easing)]}});
  }
  const json file = {{"format", kFormat},
                     {"version", kVersion},
                     {"units", kUnits},
                     {"duration_s", performance.duration_s},
                     {"frames_per_second", performance.frames_per_second},
                     {"channels", std::move(channels)}};
  return write_text(path, json_text(file, 1) + "\n");
}

Result<Performance> read_performance(const fs::path& path) {
  const auto text = read_text(path);
  if (!text) return text.error();
  const auto refused = [&](std::string what) {
    return Error{ErrorCode::bad_input, std::move(what),
                 "Correct the file, or save the performance again from Likeness.", path.string()};
  };
  try {
    return from_json(parse_json(*text));
  } catch (const Wrong& wrong) {
    return refused(fmt::format("{}: {} {}.", path.string(), wrong.field, wrong.what));
  } catch (const json::exception& e) {
    return refused(fmt::format("{} is not a performance: {}.", path.string(), e.what()));
  }
}

}  // namespace likeness
