// See attribute_courses.h.
#include "core/project/attribute_courses.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/json_text.h"

namespace likeness {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kValuesVersion = 1;

}  // namespace

fs::path attribute_values_path(const Project& project) { return project.folder / "attribute_values.json"; }
fs::path next_attribute_values_path(const Project& project) {
  return project.folder / "attribute_values.next.json";
}

std::string course_words(const AttributeCourse& course) {
  std::string words = fmt::format("{}: {} painted frames, predicted by each other to {:.2f}", course.name,
                                  course.painted_frames, course.left_out_error);
  if (course.skipped_frames > 0) words += fmt::format("; {} others do not train", course.skipped_frames);
  if (course.unlike_any > 0)
    words += fmt::format("; {} of {} frames look like none of them", course.unlike_any, course.frames.size());
  return words + ".";
}

Result<void> write_attribute_values(const fs::path& path, std::span<const AttributeCourse> courses) {
  json list = json::array();
  for (const AttributeCourse& course : courses)
    list.push_back({{"name", course.name},
                    {"frames", course.frames},
                    {"values", course.values},
                    {"doubts", course.doubts},
                    {"annotated", course.annotated},
                    {"painted_frames", course.painted_frames},
                    {"skipped_frames", course.skipped_frames},
                    {"left_out_error", course.left_out_error},
                    {"unlike_any", course.unlike_any}});
  const json all = {
      {"format", "likeness-attribute-values"}, {"version", kValuesVersion}, {"attributes", list}};
  return write_text(path, json_text(all, 1) + "\n");
}

Result<std::vector<AttributeCourse>> read_attribute_values(const fs::path& path) {
  const auto refused = [&](const std::string& why) {
    return Error{ErrorCode::bad_input,
                 fmt::format("The attributes' values in {} cannot be read: {}.", path.string(), why),
                 "Delete the file and run likeness train: they are found again.", path.string()};
  };
  if (!path_exists(path)) return refused("there is no such file");
  const auto text = read_text(path);
  if (!text) return text.error();
  try {
    const json j = parse_json(*text);
    if (j.at("format").get<std::string>() != "likeness-attribute-values")
      return refused("the file holds something else");
    const int version = whole_number_in(j.at("version"));
    if (version > kValuesVersion) return refused("they were made by a newer Likeness");
    if (version < 1) return refused("they are damaged");
    std::vector<AttributeCourse> courses;
    for (const json& entry : j.at("attributes")) {
      AttributeCourse& course = courses.emplace_back();
      course.name = entry.at("name").get<std::string>();
      course.frames = whole_numbers_in(entry.at("frames"));
      course.values = numbers_in(entry.at("values"));
      course.doubts = numbers_in(entry.at("doubts"));
      course.annotated = entry.at("annotated").get<std::vector<std::uint8_t>>();
      course.painted_frames = whole_number_in(entry.at("painted_frames"));
      course.skipped_frames = whole_number_in(entry.at("skipped_frames"));
      course.left_out_error = entry.at("left_out_error").get<double>();
      course.unlike_any = whole_number_in(entry.at("unlike_any"));
      const std::size_t count = course.frames.size();
      const auto fine = [](float v) { return std::isfinite(v) && std::abs(v) <= 1; };
      const auto finite = [](float v) { return std::isfinite(v); };  // a number can be too large for a float
      if (course.values.size() != count || course.doubts.size() != count ||
          course.annotated.size() != count || !std::ranges::all_of(course.values, fine) ||
          !std::ranges::all_of(course.doubts, finite) || !std::ranges::is_sorted(course.frames))
        return refused("they are damaged");
    }
    return courses;
  } catch (const json::exception&) {
    return refused("they are damaged");
  }
}

float amount_at(const AttributeCourse& course, int frame) {
  const auto at = std::ranges::lower_bound(course.frames, frame);
  return at != course.frames.end() && *at == frame ? course.values[std::size_t(at - course.frames.begin())]
                                                   : 0;
}

std::vector<float> frame_amounts(const Avatar& avatar, std::span<const AttributeCourse> courses, int frame) {
  std::vector<float> amounts(avatar.attributes.size(), 0.f);
  for (std::size_t a = 0; a < amounts.size(); ++a)
    for (const AttributeCourse& course : courses)
      if (course.name == avatar.attributes[a].name) amounts[a] = amount_at(course, frame);
  return amounts;
}

AvatarPose frame_pose(const Avatar& avatar, std::span<const AttributeCourse> courses,
                      const TrackedFrame& tracked) {
  AvatarPose pose = tracked.pose;
  pose.attributes = frame_amounts(avatar, courses, tracked.frame);
  return pose;
}

Result<std::vector<AttributeCourse>> read_courses(const Project& project, const Avatar& avatar) {
  if (avatar.attributes.empty()) return std::vector<AttributeCourse>{};
  return read_attribute_values(attribute_values_path(project));
}

}  // namespace likeness
