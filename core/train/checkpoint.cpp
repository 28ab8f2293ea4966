// Writing and reading checkpoints.
#include "core/train/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/hash.h"
#include "core/base/json_text.h"
#include "core/base/parallel.h"
#include "core/render/section_file.h"

namespace likeness {
namespace {

using json = nlohmann::json;

constexpr SectionFormat kFormat{"LKNSCKPT", 5, "checkpoint",
                                "Training starts over; nothing needs to be done."};

template <class T>
void add_hash(std::string& text, const std::vector<T>& values) {
  text += hash_bytes(std::as_bytes(std::span<const T>(values))) + "\n";
}

void add_pose(std::string& text, const Pose& pose) {
  for (int i = 0; i < 12; ++i) text += fmt::format("{} ", pose.matrix()(i / 4, i % 4));
  text += "\n";
}

void add_camera(std::string& text, const Camera& camera) {
  const Intrinsics& k = camera.intrinsics;
  text += fmt::format("{} {} {} {} {} {}\n", k.width, k.height, k.fx, k.fy, k.cx, k.cy);
  add_pose(text, camera.cam_from_world);
}

std::string view_fingerprint(const TrainingView& view) {
  const Intrinsics& k = view.camera.intrinsics;
  std::string text = fmt::format("{} {} {} {} {} {} {} {} {} {} {} {}\n", view.camera.frame, k.width,
                                 k.height, k.fx, k.fy, k.cx, k.cy, k.k1, k.k2, k.p1, k.p2, view.has_plate);
  add_pose(text, view.camera.cam_from_world);
  add_pose(text, view.pose.world_from_head);
  add_pose(text, view.pose.world_from_torso);
  for (const float v : articulation_vector(view.pose.articulation)) text += fmt::format("{} ", v);
  for (const float v : view.pose.torso_shape) text += fmt::format("{} ", v);
  add_hash(text, view.rgb.data);
  add_hash(text, to_image(view.alpha).data);
  if (view.further_clip != 0) text += fmt::format("clip {}\n", view.further_clip);
  if (view.part != LearntPart::person) text += fmt::format("part {}\n", int(view.part));
  if (!view.teaches.empty()) add_hash(text, to_image(view.teaches).data);
  return hash_text(text);
}

std::string detail_fingerprint(const TrainingSet& set) {
  const ExpressionDetail& d = set.detail;
  std::string text;
  add_hash(text, d.vertices);
  for (const auto& [data, size] : {std::pair(d.mean.data(), d.mean.size()),
                                   {d.basis.data(), d.basis.size()},
                                   {d.middle.data(), d.middle.size()},
                                   {d.rows.data(), d.rows.size()},
                                   {d.low.data(), d.low.size()},
                                   {d.high.data(), d.high.size()}})
    add_hash(text, std::vector<float>(data, data + size));
  for (const TrainingView& view : set.views)
    add_hash(text, std::vector<float>(view.pose.detail.begin(), view.pose.detail.end()));
  return hash_text(text);
}

void add_field(Sections& sections, const std::string& name, const TrainedField& field) {
  sections[name + ".params"] = to_section(field.part.field.parameters);
  sections[name + ".first"] = to_section(field.adam.first);
  sections[name + ".second"] = to_section(field.adam.second);
  sections[name + ".lines"] = to_section(field.adam.line_steps);
  sections[name + ".learnt"] = to_section(field.learnt.density);
  sections[name + ".occ"] = to_section(field.part.occupancy.bits);
  sections[name + ".opacity"] = to_section(field.part.opacity);  // empty until the first update
  if (!field.canonical) return;
  sections[name + ".canon"] = to_section(field.canonical->density);
  sections[name + ".canocc"] = to_section(field.canonical->occupancy.bits);
  sections[name + ".canopac"] = to_section(field.canonical->opacity);
}

std::size_t cells(const OccupancyGrid& grid) {
  return std::size_t(grid.resolution) * grid.resolution * grid.resolution;
}

bool read_canonical(const Sections& sections, const std::string& name, CanonicalState& state) {
  return from_section(sections, name + ".canon", state.density.size(), state.density) &&
         from_section(sections, name + ".canocc", state.occupancy.bits.size(), state.occupancy.bits) &&
         (from_section(sections, name + ".canopac", state.density.size(), state.opacity) ||
          from_section(sections, name + ".canopac", 0, state.opacity));
}

bool read_field(const Sections& sections, const std::string& name, TrainedField& field) {
  return (!field.canonical || read_canonical(sections, name, *field.canonical)) &&
         from_section(sections, name + ".params", field.part.field.parameters.size(),
                      field.part.field.parameters) &&
         from_section(sections, name + ".first", field.adam.first.size(), field.adam.first) &&
         from_section(sections, name + ".second", field.adam.second.size(), field.adam.second) &&
         from_section(sections, name + ".lines", field.adam.line_steps.size(), field.adam.line_steps) &&
         from_section(sections, name + ".learnt", field.learnt.density.size(), field.learnt.density) &&
         from_section(sections, name + ".occ", field.part.occupancy.bits.size(), field.part.occupancy.bits) &&
         (from_section(sections, name + ".opacity", cells(field.part.occupancy), field.part.opacity) ||
          from_section(sections, name + ".opacity", 0, field.part.opacity));
}

bool read_corrections(const Sections& sections, std::size_t views, TrainingState& state) {
  state.corrections.clear();
  if (views == 0) return true;
  const auto found = sections.find("corrections");
  if (found == sections.end() || views > found->second.size()) return false;
  const std::size_t count = found->second.size() / sizeof(double);
  std::vector<double> flat;
  if (count % views != 0 || !from_section(sections, "corrections", count, flat)) return false;
  if (!std::ranges::all_of(flat, [](double v) { return std::isfinite(v); })) return false;
  const auto n = Eigen::Index(count / views);
  for (std::size_t v = 0; v < views; ++v)
    state.corrections.emplace_back(Eigen::Map<const Eigen::VectorXd>(flat.data() + std::ptrdiff_t(v) * n, n));
  return true;
}

Error unusable(const std::filesystem::path& path, const std::string& detail) {
  return {ErrorCode::bad_input, fmt::format("Training cannot continue from the checkpoint: {}.", detail),
          std::string(kFormat.remedy), path.string()};
}

}  // namespace

std::string training_fingerprint(const TrainingSet& set, const TrainOptions& options) {
  std::vector<std::string> views(pictured(set));
  parallel_for(views.size(), [&](std::size_t v) { views[v] = view_fingerprint(picture_at(set, v)); });
  // All of them by name, so that a new option does not compile until it is listed here: either it changes
  // what is learnt, or it does not, like the run's length, its device and when it is saved.
  const auto& [seed, schedule, rays, fields, losses, refine_track, place] = options;
  const auto& [budget_s, steps, rate, checkpoint_every_s, clock] = schedule;
  const auto& [rays_per_step, even_samples, use_occupancy, canonical_occupancy] = rays;
  const auto& [mode, sizes, use_latent, use_gaze, use_expression, use_still] = fields;
  const auto& [landmark_weight] = losses;
  std::string text = fmt::format("{} {} {} {} {} {} {} {} {} {} {} {} {}\n", set.size, set.model.hash,
                                 set.has_torso, set.views.size(), rays_per_step, seed, mode_name(mode),
                                 use_latent, use_occupancy, use_still, refine_track, rate, even_samples);
  if (landmark_weight > 0) text += fmt::format("landmarks {}\n", landmark_weight);
  // Only if they differ, so that earlier checkpoints stay valid.
  if (!use_gaze) text += "no gaze\n";
  if (!use_expression) text += "no expression\n";
  if (const FieldSizes& s = sizes; s != FieldSizes{})
    text += fmt::format("sizes {} {} {} {} {}\n", s.head_log2_entries, s.head_finest, s.torso_log2_entries,
                        s.torso_finest, s.code_length);
  for (std::size_t a = 0; a < set.attributes.size(); ++a) {
    const AttributeRegion& region = set.attributes[a];
    text += fmt::format("attribute {} {} {} {} {}", region.cell, region.origin.x(), region.origin.y(),
                        region.origin.z(), fmt::join(region.count, " "));
    add_hash(text, set.attributes[a].weights);
    for (const TrainingView& view : set.views)
      text += fmt::format("{} ", view.pose.attributes.empty() ? 0.f : view.pose.attributes[a]);
  }
  if (canonical_occupancy) text += "canonical occupancy\n";
  if (!set.detail.empty()) text += "detail " + detail_fingerprint(set) + "\n";
  for (const std::string& view : views) text += view + "\n";
  for (const float v : set.person.identity) text += fmt::format("{} ", v);
  // The canonical face is the resting one.
  for (const float v : set.neutral.expression) text += fmt::format("{} ", v);
  text += fmt::format("{} {} {}\n", set.neutral.jaw.x(), set.neutral.jaw.y(), set.neutral.jaw.z());
  for (const Vec3f& v : set.person.offsets) text += fmt::format("{} {} {} ", v.x(), v.y(), v.z());
  const TorsoGrid& grid = set.torso_modes.grid;
  text +=
      fmt::format("{} {} {} {} {} ", grid.origin.x(), grid.origin.y(), grid.cell, grid.columns, grid.rows);
  for (const float v : set.torso_modes.mean) text += fmt::format("{} ", v);
  for (const auto& mode : set.torso_modes.modes)
    for (const float v : mode) text += fmt::format("{} ", v);
  add_hash(text, set.plate.data);
  add_hash(text, set.plate_known.data);
  if (set.plate_camera) add_camera(text, *set.plate_camera);
  for (const auto& [clip, plate] : set.further_plates) {
    add_hash(text, plate.rgb.data);
    add_hash(text, plate.known.data);
    if (plate.camera) add_camera(text, *plate.camera);
  }
  return hash_text(text);
}

Result<void> write_checkpoint(const std::filesystem::path& path, const TrainingState& state,
                              const std::string& fingerprint) {
  Sections sections;
  add_field(sections, "head", state.head);
  if (state.torso) add_field(sections, "torso", *state.torso);
  sections["codes"] = to_section(state.codes);
  std::vector<double> corrections;
  for (const Eigen::VectorXd& change : state.corrections)
    corrections.insert(corrections.end(), change.begin(), change.end());
  sections["corrections"] = to_section(corrections);
  sections["codes.first"] = to_section(state.codes_adam.first);
  sections["codes.second"] = to_section(state.codes_adam.second);
  const json meta = {{"fingerprint", fingerprint},
                     {"step", state.step},
                     {"seconds", state.seconds},
                     {"pass_seconds", state.pass_seconds},
                     {"total_steps", state.schedule.total_steps},
                     {"budget_s", state.schedule.budget_s},
                     {"refinements", state.refinements},
                     {"corrected_views", state.corrections.size()},
                     {"rate_scale", state.schedule.rate_scale},
                     {"head_steps", state.head.adam.step},
                     {"torso_steps", state.torso ? state.torso->adam.step : 0},
                     {"codes_steps", state.codes_adam.step},
                     {"codes_moments", state.codes_adam.first.size()}};
  const std::string text = json_text(meta);
  sections["meta"] = to_section(std::span<const char>(text.data(), text.size()));
  return write_sections(path, kFormat, sections);
}

Result<void> read_checkpoint(const std::filesystem::path& path, const std::string& fingerprint,
                             TrainingState& state) {
  auto sections = read_sections(path, kFormat);
  if (!sections) return sections.error();
  const auto meta = sections->find("meta");
  if (meta == sections->end()) return unusable(path, "section 'meta' is missing");
  TrainingState read;
  try {
    const char* text = reinterpret_cast<const char*>(meta->second.data());
    const json j = parse_json({text, meta->second.size()});
    if (j.at("fingerprint").get<std::string>() != fingerprint)
      return unusable(path, "it belongs to other pictures, another track or other options");
    read = state;
    read.step = j.at("step").get<std::uint64_t>();
    read.seconds = j.at("seconds").get<double>();
    read.pass_seconds = j.value("pass_seconds", 0.0);
    read.schedule.total_steps = j.at("total_steps").get<std::uint64_t>();
    read.schedule.budget_s = j.at("budget_s").get<double>();
    read.schedule.rate_scale = j.at("rate_scale").get<double>();
    read.head.adam.step = j.at("head_steps").get<std::uint64_t>();
    if (read.torso) read.torso->adam.step = j.at("torso_steps").get<std::uint64_t>();
    read.codes_adam.step = j.at("codes_steps").get<std::uint64_t>();
    read.refinements = whole_number_in(j.at("refinements"));
    if (!read_corrections(*sections, j.at("corrected_views").get<std::size_t>(), read))
      return unusable(path, "the corrections of the track have the wrong size");
    const auto moments = j.at("codes_moments").get<std::size_t>();
    if (!from_section(*sections, "codes.first", moments, read.codes_adam.first) ||
        !from_section(*sections, "codes.second", moments, read.codes_adam.second))
      return unusable(path, "the moments of the codes have the wrong size");
  } catch (const json::exception& e) {
    return unusable(path, e.what());
  }
  if (!(read.seconds >= read.pass_seconds && read.pass_seconds >= 0) || !std::isfinite(read.seconds))
    return unusable(path, "its time is not a number");
  if (!read_field(*sections, "head", read.head) ||
      (read.torso && !read_field(*sections, "torso", *read.torso)) ||
      !from_section(*sections, "codes", state.codes.size(), read.codes))
    return unusable(path, "its parts differ in size from this training's");
  if (!is_finite(read)) return unusable(path, "a parameter is not a finite number");
  state = std::move(read);
  return {};
}

}  // namespace likeness
