// avatar.bin: a JSON section with everything small, and binary sections for parameters, occupancy and plate.
// Never a head model's bases: only its name, hash and the fitted person.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "core/base/json_text.h"
#include "core/field/precision.h"
#include "core/render/avatar.h"
#include "core/render/room_picture.h"
#include "core/render/section_file.h"

namespace likeness {
namespace {

using json = nlohmann::json;

constexpr SectionFormat kFormat{
    "LKNSAVTR", 6, "avatar", "Train the avatar again (likeness build), or restore the file from a backup."};
constexpr SectionFormat kRoomFormat{"LKNSROOM", 1, "room", "Run `likeness fit` again: it relearns the room."};
constexpr int kLargestResolution = 512, kLargestWidth = 512;  // as core/field allows

// -- To JSON

json to_json(const GridConfig& g) {
  return {g.dimensions, g.levels, g.features, g.log2_entries, g.min_resolution, g.max_resolution};
}

json to_json(const Pose& pose) {
  json rows = json::array();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) rows.push_back(pose.matrix()(r, c));
  return rows;
}

template <class Derived>
json vector_to_json(const Eigen::MatrixBase<Derived>& v) {
  json out = json::array();
  for (Eigen::Index i = 0; i < v.size(); ++i) out.push_back(double(v[i]));
  return out;
}

json to_json(const Articulation& a) {
  return {{"expression", vector_to_json(a.expression)},
          {"neck", vector_to_json(a.neck)},
          {"jaw", vector_to_json(a.jaw)},
          {"left_eye", vector_to_json(a.left_eye)},
          {"right_eye", vector_to_json(a.right_eye)}};
}

json to_json(const Intrinsics& k) {
  return {{"width", k.width}, {"height", k.height}, {"fx", k.fx}, {"fy", k.fy}, {"cx", k.cx},
          {"cy", k.cy},       {"k1", k.k1},         {"k2", k.k2}, {"p1", k.p1}, {"p2", k.p2}};
}

json part_to_json(const FieldPart& part) {
  const FieldConfig& c = part.field.config;
  return {{"position", to_json(c.position)},
          {"condition_count", c.condition_count},
          {"ambient", c.ambient},
          {"ambient_grid", to_json(c.ambient_grid)},
          {"slice_width", c.slice_width},
          {"slice_levels", c.slice_levels},
          {"density_width", c.density_width},
          {"density_layers", c.density_layers},
          {"colour_layers", c.colour_layers},
          {"initial_density", c.initial_density},
          {"geometry_features", c.geometry_features},
          {"colour_width", c.colour_width},
          {"view_direction", c.view_direction},
          {"latent_count", c.latent_count},
          {"cube_origin_m", vector_to_json(part.cube.origin)},
          {"cube_side_m", part.cube.side},
          {"occupancy_resolution", part.occupancy.resolution},
          {"core_resolution", part.core.resolution}};
}

// -- From JSON; json exceptions are caught by read_avatar, which also catches Bad.

struct Bad {
  std::string detail;
};

// Most are read as single precision, of which nothing sensible comes near the end.
double finite(const json& value, const char* name) {
  constexpr double kLargest = 1e30;
  const double v = value.get<double>();
  if (!(std::abs(v) <= kLargest)) throw Bad{fmt::format("{} is not a finite number", name)};
  return v;
}

int whole(const json& value, const char* name, int low, int high) {
  const auto v = value.get<std::int64_t>();
  if (v < low || v > high) throw Bad{fmt::format("{} is {}, outside {} to {}", name, v, low, high)};
  return int(v);
}

GridConfig grid_from_json(const json& j) {
  if (!j.is_array() || j.size() != 6) throw Bad{"a grid does not have 6 numbers"};
  GridConfig g;
  g.dimensions = whole(j[0], "grid dimensions", 1, 3);
  g.levels = whole(j[1], "grid levels", 1, 32);
  g.features = whole(j[2], "grid features", 1, 8);
  if ((g.features & (g.features - 1)) != 0) throw Bad{"the features of a grid are not 1, 2, 4 or 8"};
  g.log2_entries = whole(j[3], "grid entries (log2)", 4, 24);
  g.min_resolution = whole(j[4], "coarsest grid", 1, 16384);
  g.max_resolution = whole(j[5], "finest grid", g.min_resolution, 16384);
  return g;
}

Eigen::VectorXf vector_from_json(const json& j, const char* name) {
  if (!j.is_array() || j.size() > 100000) throw Bad{fmt::format("{} is not a list of numbers", name)};
  Eigen::VectorXf v(Eigen::Index(j.size()));
  for (std::size_t i = 0; i < j.size(); ++i) v[Eigen::Index(i)] = float(finite(j[i], name));
  return v;
}

Vec3f vec3_from_json(const json& j, const char* name) {
  const Eigen::VectorXf v = vector_from_json(j, name);
  if (v.size() != 3) throw Bad{fmt::format("{} has {} numbers, not 3", name, v.size())};
  return v;
}

Pose pose_from_json(const json& j, const char* name) {
  if (!j.is_array() || j.size() != 12) throw Bad{fmt::format("{} does not have 12 numbers", name)};
  Pose pose = Pose::Identity();
  for (int i = 0; i < 12; ++i) pose.matrix()(i / 4, i % 4) = finite(j[i], name);
  const Mat3d r = pose.linear();
  if ((r * r.transpose() - Mat3d::Identity()).norm() > 1e-3 || r.determinant() < 0)
    throw Bad{fmt::format("{} is not a rigid pose", name)};
  return pose;
}

Articulation articulation_from_json(const json& j) {
  Articulation a;
  a.expression = vector_from_json(j.at("expression"), "expression");
  a.neck = vec3_from_json(j.at("neck"), "neck");
  a.jaw = vec3_from_json(j.at("jaw"), "jaw");
  a.left_eye = vec3_from_json(j.at("left_eye"), "left eye");
  a.right_eye = vec3_from_json(j.at("right_eye"), "right eye");
  return a;
}

Intrinsics intrinsics_from_json(const json& j) {
  Intrinsics k;
  k.width = whole(j.at("width"), "picture width", 1, 1 << 14);
  k.height = whole(j.at("height"), "picture height", 1, 1 << 14);
  k.fx = finite(j.at("fx"), "fx"), k.fy = finite(j.at("fy"), "fy");
  k.cx = finite(j.at("cx"), "cx"), k.cy = finite(j.at("cy"), "cy");
  k.k1 = finite(j.at("k1"), "k1"), k.k2 = finite(j.at("k2"), "k2");
  k.p1 = finite(j.at("p1"), "p1"), k.p2 = finite(j.at("p2"), "p2");
  if (k.fx <= 0 || k.fy <= 0) throw Bad{"the focal length is not positive"};
  return k;
}

json to_json(const ActionRange& range) {
  return {{"name", range.name},
          {"low", range.low},
          {"high", range.high},
          {"coverage", range.coverage},
          {"histogram", range.histogram}};
}

ActionRange range_from_json(const json& j) {
  ActionRange range{j.at("name").get<std::string>(),
                    float(finite(j.at("low"), "range")),
                    float(finite(j.at("high"), "range")),
                    float(finite(j.at("coverage"), "coverage")),
                    {}};
  const Eigen::VectorXf shares = vector_from_json(j.at("histogram"), "histogram");
  if (shares.size() != Eigen::Index(range.histogram.size())) throw Bad{"a histogram does not have 8 numbers"};
  std::ranges::copy(shares, range.histogram.begin());
  return range;
}

json to_json(const AvatarPart& part) {
  return {{"part", part.name},
          {"on", part.on},
          {"asked", part.asked},
          {"value", part.value},
          {"reason", part.reason}};
}

json to_json(const HoldingRange& range) {
  const auto ends = [](const HeldEnd& low, const HeldEnd& high) {
    return json{{"deg", {low.deg, high.deg}}, {"faults", {low.fault, high.fault}}};
  };
  json actions = json::array();
  for (const HeldAction& action : range.actions)
    actions.push_back({{"name", action.name}, {"amount", action.amount}, {"fault", action.fault}});
  return {{"yaw", ends(range.yaw_low, range.yaw_high)},
          {"pitch", ends(range.pitch_low, range.pitch_high)},
          {"actions", actions}};
}

std::pair<HeldEnd, HeldEnd> held_ends_from_json(const json& j) {
  const auto end = [&](std::size_t which) {
    const double deg = finite(j.at("deg").at(which), "range that holds");
    if (std::abs(deg) > 180) throw Bad{fmt::format("the range that holds goes to {} degrees", deg)};
    return HeldEnd{deg, j.at("faults").at(which).get<std::string>()};
  };
  const std::pair<HeldEnd, HeldEnd> ends{end(0), end(1)};
  if (ends.first.deg > ends.second.deg) throw Bad{"the range that holds ends before it begins"};
  return ends;
}

HoldingRange holding_range_from_json(const json& j) {
  HoldingRange range;
  std::tie(range.yaw_low, range.yaw_high) = held_ends_from_json(j.at("yaw"));
  std::tie(range.pitch_low, range.pitch_high) = held_ends_from_json(j.at("pitch"));
  for (const json& action : j.at("actions"))
    range.actions.push_back({action.at("name").get<std::string>(),
                             float(finite(action.at("amount"), "amount that holds")),
                             action.at("fault").get<std::string>()});
  return range;
}

json to_json(const AttributeRegion& region) {
  return {{"name", region.name},
          {"low", region.low},
          {"high", region.high},
          {"coverage", region.coverage},
          {"origin_m", vector_to_json(region.origin)},
          {"cell_m", region.cell},
          {"count", region.count}};
}

std::string weights_section(std::size_t attribute) { return fmt::format("attr{}.weights", attribute); }

AvatarPart avatar_part_from_json(const json& j) {
  return {j.at("part").get<std::string>(), j.at("on").get<bool>(), j.at("asked").get<bool>(),
          j.at("value").get<std::string>(), j.at("reason").get<std::string>()};
}

OccupancyGrid occupancy_from(const Sections& sections, const std::string& name, int resolution) {
  OccupancyGrid grid;
  grid.resolution = resolution;
  if (resolution == 0) return grid;
  const std::size_t cells = std::size_t(resolution) * resolution * resolution;
  if (!from_section(sections, name, (cells + 7) / 8, grid.bits))
    throw Bad{"section '" + name + "' has the wrong size"};
  return grid;
}

AttributeRegion attribute_from(const json& j, const Sections& sections, std::size_t number) {
  AttributeRegion region;
  region.name = j.at("name").get<std::string>();
  region.low = float(finite(j.at("low"), "attribute")),
  region.high = float(finite(j.at("high"), "attribute"));
  region.coverage = float(finite(j.at("coverage"), "attribute"));
  region.origin = vec3_from_json(j.at("origin_m"), "region of an attribute");
  region.cell = float(finite(j.at("cell_m"), "region of an attribute"));
  if (!(region.cell > 1e-4f && region.cell < 1)) throw Bad{"the region of an attribute is impossible"};
  if (j.at("count").size() != 3) throw Bad{"the region of an attribute does not have 3 axes"};
  for (std::size_t a = 0; a < 3; ++a) region.count[a] = whole(j.at("count").at(a), "region", 2, 256);
  const std::size_t nodes =
      std::size_t(region.count[0]) * std::size_t(region.count[1]) * std::size_t(region.count[2]);
  if (!from_section(sections, weights_section(number), nodes, region.weights))
    throw Bad{"section '" + weights_section(number) + "' has the wrong size"};
  return region;
}

FieldPart part_from(const json& j, const Sections& sections, const std::string& name) {
  FieldPart part;
  FieldConfig& c = part.field.config;
  c.position = grid_from_json(j.at("position"));
  if (c.position.dimensions != 3) throw Bad{"the position grid does not have 3 dimensions"};
  c.condition_count = whole(j.at("condition_count"), "condition count", 0, 256);
  c.ambient = j.at("ambient").get<bool>();
  c.ambient_grid = grid_from_json(j.at("ambient_grid"));
  c.slice_width = whole(j.at("slice_width"), "slice width", 1, kLargestWidth);
  c.slice_levels = j.contains("slice_levels")
                       ? whole(j.at("slice_levels"), "levels of the slice", 1, 64)
                       : c.position.levels;  // an avatar from before this was configurable
  c.density_width = whole(j.at("density_width"), "density width", 1, kLargestWidth);
  c.density_layers = whole(j.at("density_layers"), "density layers", 1, 2);
  c.colour_layers = whole(j.at("colour_layers"), "colour layers", 1, 2);
  c.initial_density = float(finite(j.at("initial_density"), "initial density"));
  if (!(c.initial_density > 0)) throw Bad{"the initial density is not positive"};
  c.geometry_features = whole(j.at("geometry_features"), "geometry features", 1, 255);
  c.colour_width = whole(j.at("colour_width"), "colour width", 1, kLargestWidth);
  c.view_direction = j.at("view_direction").get<bool>();
  c.latent_count = whole(j.at("latent_count"), "code length", 0, 256);
  part.cube.origin = vec3_from_json(j.at("cube_origin_m"), "cube origin");
  part.cube.side = float(finite(j.at("cube_side_m"), "cube side"));
  if (!(part.cube.side > 1e-4f) || part.cube.side > 100)
    throw Bad{"the cube's side is not between 0.1 mm and 100 m"};
  std::size_t expected = 0;
  for (const ParameterBlock& block : parameter_layout(c))
    expected = std::max(expected, block.offset + block.count);
  if (!from_section(sections, name + ".params", expected, part.field.parameters))
    throw Bad{"section '" + name + ".params' has the wrong size"};
  for (const float v : part.field.parameters)
    if (!std::isfinite(v)) throw Bad{"a parameter is not a finite number"};
  part.occupancy =
      occupancy_from(sections, name + ".occ",
                     whole(j.at("occupancy_resolution"), "occupancy resolution", 0, kLargestResolution));
  part.core = occupancy_from(sections, name + ".core",
                             whole(j.at("core_resolution"), "core resolution", 0, kLargestResolution));
  const auto cells =
      std::size_t(part.occupancy.resolution) * part.occupancy.resolution * part.occupancy.resolution;
  if (!from_section(sections, name + ".opacity", cells, part.opacity) &&
      !from_section(sections, name + ".opacity", 0, part.opacity))
    throw Bad{"section '" + name + ".opacity' has the wrong size"};
  return part;
}

void add_part(Sections& sections, const FieldPart& part, const std::string& name) {
  sections[name + ".params"] = to_section(part.field.parameters);
  sections[name + ".occ"] = to_section(part.occupancy.bits);
  sections[name + ".core"] = to_section(part.core.bits);
  sections[name + ".opacity"] = to_section(part.opacity);
}

TorsoModes torso_modes_from_json(const json& j) {
  TorsoModes m;
  const json& grid = j.at("torso_grid");
  m.grid.origin = {grid.at(0).get<float>(), grid.at(1).get<float>()};
  m.grid.cell = grid.at(2).get<float>();
  m.grid.columns = whole_number_in(grid.at(3)), m.grid.rows = whole_number_in(grid.at(4));
  m.mean = numbers_in(j.at("torso_mean"));
  if (!take_modes(j.at("torso_modes").get<std::vector<std::vector<float>>>(), m) || !is_consistent(m))
    throw Bad{"the torso's modes do not match their grid"};
  if (j.contains("torso_hem")) {
    const json& hem = j.at("torso_hem");
    m.hem = {float(finite(hem.at(0), "hem")), float(finite(hem.at(1), "hem")),
             float(finite(hem.at(2), "hem"))};
  }
  return m;
}

NeckZone neck_from_json(const json& j) {
  NeckZone neck;
  neck.base = float(finite(j.at(0), "neck")), neck.top = float(finite(j.at(1), "neck"));
  for (int axis = 0; axis < 3; ++axis) neck.middle[axis] = float(finite(j.at(std::size_t(2 + axis)), "neck"));
  if (neck.top > neck.base && neck.top - neck.base < 0.005f) throw Bad{"the neck is too short to bend"};
  return neck;
}

ExpressionDetail detail_from(const json& j, const Sections& sections, int expressions) {
  ExpressionDetail d;
  const auto k = std::size_t(whole(j.at("vertices"), "detail", 1, 1 << 24)),
             r = std::size_t(whole(j.at("components"), "components of the detail", 0, 256)),
             inputs = std::size_t(expressions) + 3;
  std::vector<float> numbers;
  if (!from_section(sections, "detail.vertices", k, d.vertices) ||
      !from_section(sections, "detail.numbers", k * (1 + r) + inputs * (1 + r) + 2 * r, numbers))
    throw Bad{"a section of the detail has the wrong size"};
  const float* at = numbers.data();
  const auto take = [&](std::size_t rows, std::size_t columns) {
    Eigen::MatrixXf taken = Eigen::Map<const Eigen::MatrixXf>(at, Eigen::Index(rows), Eigen::Index(columns));
    at += rows * columns;
    return taken;
  };
  d.mean = take(k, 1), d.basis = take(k, r), d.middle = take(inputs, 1), d.rows = take(r, inputs);
  d.low = take(r, 1), d.high = take(r, 1);
  if (!is_consistent(d, 1 << 24, expressions)) throw Bad{"the detail's numbers do not match each other"};
  return d;
}

void add_detail_sections(Sections& sections, const ExpressionDetail& d) {
  std::vector<float> numbers;
  const auto add = [&](const auto& m) { numbers.insert(numbers.end(), m.data(), m.data() + m.size()); };
  add(d.mean), add(d.basis), add(d.middle), add(d.rows), add(d.low), add(d.high);
  sections["detail.vertices"] = to_section(d.vertices);
  sections["detail.numbers"] = to_section(numbers);
}

json meta_of(const Sections& sections) {
  const auto meta = sections.find("meta");
  if (meta == sections.end()) throw Bad{"section 'meta' is missing"};
  const char* text = reinterpret_cast<const char*>(meta->second.data());
  return parse_json({text, meta->second.size()});
}

// Torso and room, which do not depend on the expression.
FieldPart unconditioned_from(const json& j, const Sections& sections, const char* name) {
  FieldPart part = part_from(j, sections, name);
  if (part.field.config.condition_count != 0) throw Bad{fmt::format("the {} depends on an expression", name)};
  return part;
}

Mosaic mosaic_from_json(const json& j, const Sections& sections) {
  Mosaic mosaic;
  mosaic.camera.frame = -1;
  mosaic.camera.intrinsics = intrinsics_from_json(j.at("intrinsics"));
  mosaic.camera.cam_from_world = pose_from_json(j.at("cam_from_world"), "the mosaic's camera");
  const int width = mosaic.camera.intrinsics.width, height = mosaic.camera.intrinsics.height;
  const std::size_t pixels = std::size_t(width) * std::size_t(height);
  mosaic.colour.width = width, mosaic.colour.height = height, mosaic.colour.channels = 3;
  if (!from_section(sections, "mosaic", 3 * pixels, mosaic.colour.data))
    throw Bad{"section 'mosaic' has the wrong size"};
  if (!j.at("known").get<bool>()) return mosaic;
  mosaic.known.width = width, mosaic.known.height = height, mosaic.known.channels = 1;
  if (!from_section(sections, "mosaic_known", pixels, mosaic.known.data))
    throw Bad{"section 'mosaic_known' has the wrong size"};
  return mosaic;
}

Avatar avatar_from(const Sections& sections) {
  const json j = meta_of(sections);
  Avatar a;
  a.head = part_from(j.at("head"), sections, "head");
  if (!j.at("torso").is_null()) a.torso = unconditioned_from(j.at("torso"), sections, "torso");
  if (j.contains("room")) a.room = unconditioned_from(j.at("room"), sections, "room");
  a.condition.mean = vector_from_json(j.at("condition_mean"), "condition mean");
  if (j.contains("attributes")) {
    const json& attributes = j.at("attributes");
    if (attributes.size() > std::size_t(kMaxAttributes)) throw Bad{"there are too many attributes"};
    for (std::size_t i = 0; i < attributes.size(); ++i)
      a.attributes.push_back(attribute_from(attributes.at(i), sections, i));
  }
  FieldConfig& config = a.head.field.config;
  config.local_conditions = int(a.attributes.size());
  const int k = config.condition_count - config.local_conditions;
  if (k < 0) throw Bad{"the field knows fewer conditions than there are attributes"};
  const Eigen::VectorXf rows = vector_from_json(j.at("condition_rows"), "condition rows");
  if (rows.size() != k * a.condition.mean.size()) throw Bad{"the condition map does not match the field"};
  a.condition.rows = Eigen::Map<const Eigen::Matrix<float, -1, -1, Eigen::RowMajor>>(rows.data(), k,
                                                                                     a.condition.mean.size());
  a.condition.low = vector_from_json(j.at("condition_low"), "condition range");
  a.condition.high = vector_from_json(j.at("condition_high"), "condition range");
  if (a.condition.low.size() != k || a.condition.high.size() != k)
    throw Bad{"the range of the condition does not match the field"};
  a.person.identity = vector_from_json(j.at("identity"), "identity");
  const int offsets = whole(j.at("offsets"), "personal shape", 0, 1 << 24);
  std::vector<float> flat;
  if (offsets > 0 && !from_section(sections, "offsets", 3 * std::size_t(offsets), flat))
    throw Bad{"section 'offsets' has the wrong size"};
  if (!std::ranges::all_of(flat, [](float v) { return std::isfinite(v); }))
    throw Bad{"the personal shape is not finite"};
  for (int v = 0; v < offsets; ++v)
    a.person.offsets.emplace_back(flat[3 * v], flat[3 * v + 1], flat[3 * v + 2]);
  a.head_model_name = j.at("head_model_name").get<std::string>();
  a.head_model_hash = j.at("head_model_hash").get<std::string>();
  a.head_model_file = j.at("head_model_file").get<std::string>();
  a.neutral = articulation_from_json(j.at("neutral"));
  if (j.contains("detail"))
    a.detail = detail_from(j.at("detail"), sections, int(a.neutral.expression.size()));
  a.warp_cell = float(finite(j.at("warp_cell"), "warp lattice"));
  if (a.warp_cell != 0 && !(a.warp_cell > 0.001f && a.warp_cell < 0.1f))
    throw Bad{"the warp lattice's cells are impossible"};
  if (k > 0 && a.neutral.expression.size() + 9 != a.condition.mean.size())
    throw Bad{"the neutral expression does not match the condition map"};
  for (const json& range : j.at("seen")) a.seen.push_back(range_from_json(range));
  a.world_from_head = pose_from_json(j.at("world_from_head"), "world_from_head");
  a.world_from_torso = pose_from_json(j.at("world_from_torso"), "world_from_torso");
  a.torso_modes = torso_modes_from_json(j);
  a.neck = neck_from_json(j.at("neck"));
  a.cam_from_world = pose_from_json(j.at("cam_from_world"), "cam_from_world");
  a.intrinsics = intrinsics_from_json(j.at("intrinsics"));
  a.size = whole(j.at("size"), "size", 1, 1 << 14);
  a.steps = j.at("steps").get<std::uint64_t>();
  a.seed = j.at("seed").get<std::uint64_t>();
  a.train_seconds = finite(j.at("train_seconds"), "training time");
  if (j.contains("parts"))
    for (const json& part : j.at("parts")) a.parts.push_back(avatar_part_from_json(part));
  if (j.contains("holds")) a.holds = holding_range_from_json(j.at("holds"));
  if (j.contains("background_fault")) a.background_fault = j.at("background_fault").get<std::string>();
  const int width = whole(j.at("plate_width"), "plate width", 0, 1 << 14);
  const int height = whole(j.at("plate_height"), "plate height", 0, 1 << 14);
  if (width > 0 && height > 0) {
    a.plate.width = width, a.plate.height = height, a.plate.channels = 3;
    if (!from_section(sections, "plate", std::size_t(width) * height * 3, a.plate.data))
      throw Bad{"section 'plate' has the wrong size"};
    if (width != a.intrinsics.width || height != a.intrinsics.height)
      throw Bad{"the plate is not the picture of the typical camera"};
  }
  if (j.contains("mosaic")) a.mosaic = mosaic_from_json(j.at("mosaic"), sections);
  return a;
}

}  // namespace

Result<void> write_avatar(const std::filesystem::path& path, const Avatar& avatar) {
  const Eigen::Matrix<float, -1, -1, Eigen::RowMajor> rows = avatar.condition.rows;
  json j = {{"head", part_to_json(avatar.head)},
            {"torso", avatar.torso ? part_to_json(*avatar.torso) : json()},
            {"condition_mean", vector_to_json(avatar.condition.mean)},
            {"condition_rows", vector_to_json(Eigen::Map<const Eigen::VectorXf>(rows.data(), rows.size()))},
            {"condition_low", vector_to_json(avatar.condition.low)},
            {"condition_high", vector_to_json(avatar.condition.high)},
            {"identity", vector_to_json(avatar.person.identity)},
            {"offsets", avatar.person.offsets.size()},
            {"head_model_name", avatar.head_model_name},
            {"head_model_hash", avatar.head_model_hash},
            {"head_model_file", avatar.head_model_file},
            {"neutral", to_json(avatar.neutral)},
            {"warp_cell", avatar.warp_cell},
            {"seen", json::array()},
            {"world_from_head", to_json(avatar.world_from_head)},
            {"world_from_torso", to_json(avatar.world_from_torso)},
            {"torso_grid",
             {avatar.torso_modes.grid.origin.x(), avatar.torso_modes.grid.origin.y(),
              avatar.torso_modes.grid.cell, avatar.torso_modes.grid.columns, avatar.torso_modes.grid.rows}},
            {"neck",
             {avatar.neck.base, avatar.neck.top, avatar.neck.middle.x(), avatar.neck.middle.y(),
              avatar.neck.middle.z()}},
            {"torso_mean", avatar.torso_modes.mean},
            {"torso_modes", avatar.torso_modes.modes},
            {"cam_from_world", to_json(avatar.cam_from_world)},
            {"intrinsics", to_json(avatar.intrinsics)},
            {"size", avatar.size},
            {"steps", avatar.steps},
            {"seed", avatar.seed},
            {"train_seconds", avatar.train_seconds},
            {"plate_width", avatar.plate.width},
            {"plate_height", avatar.plate.height}};
  if (avatar.room) j["room"] = part_to_json(*avatar.room);
  if (avatar.mosaic)
    j["mosaic"] = {{"intrinsics", to_json(avatar.mosaic->camera.intrinsics)},
                   {"cam_from_world", to_json(avatar.mosaic->camera.cam_from_world)},
                   {"known", !avatar.mosaic->known.empty()}};
  if (!avatar.detail.empty())
    j["detail"] = {{"vertices", avatar.detail.vertices.size()}, {"components", avatar.detail.components()}};
  for (const ActionRange& range : avatar.seen) j["seen"].push_back(to_json(range));
  for (const AttributeRegion& region : avatar.attributes) j["attributes"].push_back(to_json(region));
  if (!avatar.parts.empty()) j["parts"] = json::array();
  for (const AvatarPart& part : avatar.parts) j["parts"].push_back(to_json(part));
  if (avatar.holds) j["holds"] = to_json(*avatar.holds);
  if (const auto& hem = avatar.torso_modes.hem) j["torso_hem"] = {hem->height, hem->slope_x, hem->slope_z};
  if (!avatar.background_fault.empty()) j["background_fault"] = avatar.background_fault;
  Sections sections;
  // A non-UTF-8 file name must not make the avatar unwritable.
  const std::string text = json_text(j);
  sections["meta"] = to_section(std::span<const char>(text.data(), text.size()));
  add_part(sections, avatar.head, "head");
  if (avatar.torso) add_part(sections, *avatar.torso, "torso");
  if (avatar.room) add_part(sections, *avatar.room, "room");
  for (std::size_t i = 0; i < avatar.attributes.size(); ++i)
    sections[weights_section(i)] = to_section(avatar.attributes[i].weights);
  if (!avatar.detail.empty()) add_detail_sections(sections, avatar.detail);
  std::vector<float> offsets;
  for (const Vec3f& v : avatar.person.offsets) offsets.insert(offsets.end(), {v.x(), v.y(), v.z()});
  if (!offsets.empty()) sections["offsets"] = to_section(offsets);
  if (!avatar.plate.empty()) sections["plate"] = to_section(avatar.plate.data);
  if (avatar.mosaic) {
    sections["mosaic"] = to_section(avatar.mosaic->colour.data);
    if (!avatar.mosaic->known.empty()) sections["mosaic_known"] = to_section(avatar.mosaic->known.data);
  }
  return write_sections(path, kFormat, sections);
}

Result<void> write_room(const std::filesystem::path& path, const FieldPart& room) {
  Sections sections;
  const std::string text = json_text(part_to_json(room));
  sections["meta"] = to_section(std::span<const char>(text.data(), text.size()));
  add_part(sections, room, "room");
  return write_sections(path, kRoomFormat, sections);
}

Result<FieldPart> read_room(const std::filesystem::path& path) {
  auto sections = read_sections(path, kRoomFormat);
  if (!sections) return sections.error();
  std::string detail;
  try {
    FieldPart room = unconditioned_from(meta_of(*sections), *sections, "room");
    round_tables(room.field);
    return room;
  } catch (const Bad& bad) {
    detail = bad.detail;
  } catch (const json::exception& e) {
    detail = e.what();
  }
  return Error{ErrorCode::bad_input, fmt::format("The file of the room cannot be used: {}.", detail),
               std::string(kRoomFormat.remedy), path.string()};
}

Result<Avatar> read_avatar(const std::filesystem::path& path) {
  auto sections = read_sections(path, kFormat);
  if (!sections) return sections.error();
  std::string detail;
  try {
    Avatar avatar = avatar_from(*sections);
    round_tables(avatar.head.field);
    if (avatar.torso) round_tables(avatar.torso->field);
    if (avatar.room) round_tables(avatar.room->field);
    return avatar;
  } catch (const Bad& bad) {
    detail = bad.detail;
  } catch (const json::exception& e) {
    detail = e.what();
  }
  return Error{ErrorCode::bad_input, fmt::format("The avatar file cannot be used: {}.", detail),
               std::string(kFormat.remedy), path.string()};
}

}  // namespace likeness
