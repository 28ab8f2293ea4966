// Tables for a device: see device_frame.h.
#include "core/render/device_frame.h"

#include <algorithm>
#include <cstring>

#include "core/base/rigid.h"
#include "core/render/pixel_bands.h"

namespace likeness {
namespace {

static_assert(kBendSteps == kNeckSteps && kGapColumns == kLipColumns);
static_assert(sizeof(LatticeColumn) == sizeof(WarpLattice::Column));
static_assert(sizeof(Vec3f) == 3 * sizeof(float));

void set(float (&to)[3], const Vec3f& from) { std::copy_n(from.data(), 3, to); }
void set(float (&to)[9], const Eigen::Matrix3f& from) {
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) to[3 * r + c] = from(r, c);
}
template <std::size_t N>
void set(float (&to)[N], const std::array<float, N>& from) {
  std::copy(from.begin(), from.end(), to);
}

MouthTable mouth_table(const MouthGap& gap) {
  MouthTable table{};
  table.open = gap.open;
  set(table.low, gap.low), set(table.high, gap.high);
  table.right = gap.edges.right, table.left = gap.edges.left;
  set(table.upper_y, gap.edges.upper_y), set(table.upper_z, gap.edges.upper_z);
  set(table.lower_y, gap.edges.lower_y), set(table.lower_z, gap.edges.lower_z);
  set(table.margin, gap.margin);
  set(table.jaw, gap.jaw);
  set(table.upper_normal, gap.upper_normal), set(table.lower_normal, gap.lower_normal);
  table.upper_height = gap.upper_height, table.lower_height = gap.lower_height;
  set(table.turn, gap.turn), set(table.shift, gap.shift), set(table.pocket, gap.pocket);
  return table;
}

NeckTable neck_table(const NeckBend& bend) {
  NeckTable table{};
  table.bends = !bend.straight, table.base = bend.base, table.top = bend.top;
  if (bend.straight) return table;
  for (std::size_t k = 0; k <= kNeckSteps; ++k)
    set(table.turn[k], bend.turn[k]), set(table.shift[k], bend.shift[k]);
  for (std::size_t a = 0; a < 4; ++a) set(table.height[a], bend.height[a]);
  return table;
}

void set_neck_box(const NeckBend& bend, const MarchVolume& head, FrameNumbers& frame) {
  if (bend.straight) return;
  MarchNeck neck = march_neck(bend, head);
  bound_neck(head, neck);
  set(frame.neck_low, neck.box.min()), set(frame.neck_high, neck.box.max());
  std::copy(neck.first.begin(), neck.first.end(), frame.neck_first);
  std::copy(neck.count.begin(), neck.count.end(), frame.neck_count);
}

// Appends an array; returns where it begins.
template <class T>
std::uint32_t append(std::vector<unsigned char>& out, const std::vector<T>& array) {
  const std::size_t at = (out.size() + 15) / 16 * 16;
  out.resize(at + array.size() * sizeof(T));
  if (!array.empty()) std::memcpy(out.data() + at, array.data(), array.size() * sizeof(T));
  return std::uint32_t(at);
}

}  // namespace

std::size_t tile_count(const Intrinsics& k) {
  const auto along = [](int pixels) { return std::size_t((pixels + kTileSide - 1) / kTileSide); };
  return along(k.width) * along(k.height);
}

PictureTiles picture_tiles(const Intrinsics& k, int block, std::size_t tiles_per_band) {
  PictureTiles out;
  std::size_t tiles = 0;
  for (int top = 0; top < k.height; top += kTileSide)
    for (int left = 0; left < k.width; left += kTileSide, ++tiles) {
      const Band tile = tile_band(k, left, top, block);
      if (tiles % tiles_per_band == 0) out.bands.push_back({out.place.size(), 0, out.block_place.size(), 0});
      PictureBand& band = out.bands.back();
      const auto first = std::uint32_t(band.blocks);
      const int rows = int(tile.blocks.size()) / tile.block_columns;
      for (std::size_t i = 0; i < tile.place.size(); ++i) {
        out.place.push_back(tile.place[i]);
        out.block.push_back(first + tile.block_of[i]);
        out.directions.insert(out.directions.end(), tile.directions[i].data(), tile.directions[i].data() + 3);
      }
      for (const Vec3f& direction : tile.blocks) {
        out.block_directions.insert(out.block_directions.end(), direction.data(), direction.data() + 3);
        out.block_place.push_back({first, tile.block_columns, rows});
      }
      band.pixels += tile.place.size(), band.blocks += tile.blocks.size();
    }
  return out;
}

bool same_picture(const Intrinsics& a, const Intrinsics& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx &&
         a.cy == b.cy && a.k1 == b.k1 && a.k2 == b.k2 && a.p1 == b.p1 && a.p2 == b.p2;
}

bool same_options(const RenderOptions& a, const RenderOptions& b) {
  return a.max_samples == b.max_samples && a.strata == b.strata && a.block == b.block &&
         a.stop_transmittance == b.stop_transmittance && a.min_step == b.min_step &&
         a.shade_weight == b.shade_weight && a.precision == b.precision;
}

void pack_frame(const FrameParts& parts, const MarchVolume* head, std::vector<unsigned char>& out) {
  FrameNumbers frame{};
  for (std::size_t f = 0; f < 2; ++f)
    if (parts.maps[f])
      set(frame.linear[f], parts.maps[f]->linear), set(frame.offset[f], parts.maps[f]->offset);
  if (parts.neck) frame.neck = neck_table(*parts.neck);
  if (parts.neck && head) set_neck_box(*parts.neck, *head, frame);
  out.resize(sizeof(frame));
  if (parts.warp && !parts.warp->empty()) {
    const WarpLattice& warp = *parts.warp;
    LatticeTable& table = frame.lattice;
    std::copy(warp.nodes.begin(), warp.nodes.end(), table.nodes);
    set(table.origin, warp.origin);
    table.cell = warp.cell, table.unit = warp.unit, table.mouth = mouth_table(warp.mouth);
    frame.columns_at = append(out, warp.columns), frame.rows_at = append(out, warp.displacement);
  }
  if (parts.torso && !parts.torso->empty()) {
    const TorsoGrid& grid = parts.torso->grid;
    const TorsoHem hem = parts.torso->hem.value_or(TorsoHem{});
    frame.torso = {grid.columns,
                   grid.rows,
                   {grid.origin.x(), grid.origin.y()},
                   grid.cell,
                   parts.torso->hem ? 1 : 0,
                   hem.height,
                   hem.slope_x,
                   hem.slope_z};
    frame.displacement_at = append(out, parts.torso->displacement);
  }
  std::memcpy(out.data(), &frame, sizeof(frame));
}

void pack_frame(const Avatar& avatar, const Camera& camera, const RenderState& state, const MarchVolume& head,
                std::vector<unsigned char>& out) {
  FrameParts parts;
  const UnitFromCamera head_map =
      unit_from_camera(avatar.head.cube, camera.cam_from_world, state.pose.world_from_head);
  parts.maps[0] = &head_map;
  UnitFromCamera torso_map;
  if (avatar.torso) {
    torso_map = unit_from_camera(avatar.torso->cube, camera.cam_from_world, state.pose.world_from_torso);
    parts.maps[1] = &torso_map;
  }
  NeckBend neck;
  if (!avatar.neck.empty()) {
    neck = make_neck_bend(avatar.neck, inverse(state.pose.world_from_head) * state.pose.world_from_torso,
                          avatar.head.cube.origin, avatar.head.cube.side);
    parts.neck = &neck;
  }
  parts.warp = &state.warp, parts.torso = &state.torso;
  pack_frame(parts, &head, out);
}

}  // namespace likeness
