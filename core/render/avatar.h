// The avatar: everything needed to render a person, and nothing else. Stored in avatar.bin.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/linalg.h"
#include "core/base/result.h"
#include "core/camera/camera.h"
#include "core/camera/mosaic.h"
#include "core/field/field.h"
#include "core/head/expression_detail.h"
#include "core/head/head_model.h"
#include "core/image/image.h"
#include "core/render/attribute.h"
#include "core/render/holding_range.h"
#include "core/scene/neck_bend.h"
#include "core/scene/torso_warp.h"

namespace likeness {

// psi = clamp(rows * ([expression (E), jaw (3), left eye (3), right eye (3)] - mean), low, high): the
// low-dimensional condition of the ambient slice, learnt from the training track (principal components
// weighted by the vertex motion they cause). The bounds are those of the training: beyond them the field has
// learnt nothing.
struct ConditionMap {
  Eigen::VectorXf mean;       // (E + 9)
  Eigen::MatrixXf rows;       // (K, E + 9)
  Eigen::VectorXf low, high;  // (K)
};
Eigen::VectorXf articulation_vector(const Articulation& articulation);  // (E + 9), in the order above
Eigen::VectorXf condition(const ConditionMap& map, const Articulation& articulation);
// The inputs that condition the head's field: psi, then the attributes' amounts, each limited to its seen
// range. amounts: one per attribute, or empty, which is all at rest.
Eigen::VectorXf condition(const ConditionMap& map, const Articulation& articulation,
                          std::span<const AttributeRegion> attributes, std::span<const float> amounts);

// Axis-aligned cube of a field in its own frame, m.
struct FieldCube {
  Vec3f origin = Vec3f::Zero();
  float side = 1;
};

// Which cells of a field's cube may hold density. One bit per cell, (z, y, x).
struct OccupancyGrid {
  int resolution = 0;              // cells along an axis
  std::vector<std::uint8_t> bits;  // (resolution^3 / 8)

  bool occupied(int x, int y, int z) const {  // indices in [0, resolution)
    const std::size_t i = (std::size_t(z) * resolution + y) * resolution + x;
    return bits[i >> 3] >> (i & 7) & 1;
  }
};

OccupancyGrid make_occupancy(int resolution, bool filled);
void set_occupied(OccupancyGrid& grid, int x, int y, int z, bool occupied);

struct FieldPart {
  Field field;
  FieldCube cube;
  OccupancyGrid occupancy;
  OccupancyGrid core;  // cells deep inside the head, which end every ray that meets them; empty = none
  // Light lost along a cell's width, 0..255, for the cells of `occupancy`: tells where a ray's samples are
  // best placed.
  std::vector<std::uint8_t> opacity;  // (resolution^3), (z, y, x); empty = not known
};

// The range of an action in the capture's training frames, 1 = full.
struct ActionRange {
  std::string name;
  float low = 0, high = 0;           // 2nd and 98th percentile
  float coverage = 0;                // share of the frames that show more than a fifth of it
  std::array<float, 8> histogram{};  // shares of the frames by eighths of 0..1, the outermost open-ended
};

// A part of the method as this avatar was made, and why (core/train/choose_parts.h).
struct AvatarPart {
  std::string name;    // "torso", "code", ...; part_title() says it in words
  bool on = true;      // the avatar has it
  bool asked = false;  // the user's choice; otherwise the capture's measurements decided
  std::string value;   // what it is, in words: "a field of its own"
  std::string reason;  // in words, with the figure it is based on
};

struct Avatar {
  FieldPart head;
  std::optional<FieldPart> torso;
  ConditionMap condition;
  PersonShape person;
  ExpressionDetail detail;  // of the surface that the deformation follows; empty: the model's own
  std::string head_model_name, head_model_hash, head_model_file;
  Articulation neutral;                     // the person's calibrated neutral; the canonical face
  float warp_cell = 0;                      // m between nodes of the warp lattice; 0: the field is not warped
  std::vector<ActionRange> seen;            // per named action
  std::vector<AttributeRegion> attributes;  // painted by the user; each has an entry in the field's psi
  Pose world_from_head = Pose::Identity();  // typical, for orbit and sliders
  Pose world_from_torso = Pose::Identity();
  TorsoModes torso_modes;  // empty: a rigid torso
  NeckZone neck;           // empty: the head's field is rigid down to its end
  Intrinsics
      intrinsics;  // of the part that was filmed of the training pictures (crop, size x size): mostly all
  Pose cam_from_world = Pose::Identity();  // typical
  Image8 plate;                            // the background that the typical camera sees; empty: not known
  std::optional<Mosaic> mosaic;            // of which the plate is a part, behind a hand-held camera
  std::optional<FieldPart> room;           // in the world's frame: behind a person filmed by a walking camera
  // Why what stands behind the person is not the background that was filmed (core/matte/matte_report.h), in a
  // sentence; empty: it is, as far as it was seen. Where it is not, figures of full frames say nothing about
  // the person.
  std::string background_fault;
  int size = 256;
  std::uint64_t steps = 0, seed = 0;
  double train_seconds = 0;
  std::vector<AvatarPart> parts;  // what was chosen for its capture; empty: made before this was stored
  // Beyond what was filmed; nullopt: made before this was looked for, or the looking was stopped.
  std::optional<HoldingRange> holds;
};

// avatar.bin: versioned, checksummed, whole or not at all.
Result<void> write_avatar(const std::filesystem::path& path, const Avatar& avatar);
Result<Avatar> read_avatar(const std::filesystem::path& path);

}  // namespace likeness
