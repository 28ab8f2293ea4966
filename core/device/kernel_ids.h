// Numbers of the kernels, each with its argument struct.
#pragma once

#include <cstdint>

namespace likeness {

enum class Kernel : std::int32_t {
  encode,            // core/field/device_kernels.h: EncodeArgs
  encode_backward,   // EncodeBackwardArgs
  network_forward,   // NetworkArgs
  network_backward,  // NetworkArgs
  adam_lines,        // AdamLinesArgs
  adam_networks,     // AdamNetworksArgs
  adam_codes,        // AdamCodesArgs
  ray_loss,          // core/render/device_loss.h: RayLossArgs
  neck_cells,        // core/render/device_march.h: NeckCellsArgs
  march_strata,      // MarchStrataArgs
  march_rays,        // MarchRaysArgs
  ray_offsets,       // RayOffsetsArgs
  gather_samples,    // GatherArgs
  refine_strata,     // RefineArgs
  pick_samples,      // PickArgs
  composite_pixels,  // CompositeArgs
  choose_rays,       // core/train/device_rays.h: ChooseRaysArgs
  march_chosen,      // MarchChosenArgs
  ordered_offsets,   // OrderedOffsetsArgs
  gather_chosen,     // GatherChosenArgs
  look_up_cells,     // LookUpArgs
  decay_cells,       // DecayArgs
  set_cell_bits,     // CellBitsArgs
  mark_bricks,       // BricksArgs
  bound_layers,      // LayersArgs
  bound_necks,       // NeckBoxArgs
  fill_necks,        // FillNecksArgs
  read_write,        // core/device/device_ceilings.h: CeilingArgs
  matrix_rate,       // CeilingArgs
  count
};

}  // namespace likeness
