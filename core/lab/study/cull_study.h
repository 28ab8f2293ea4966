// Which samples a look-up of empty cells culls and what is lost with them, for a trained head: the same rays,
// sampled evenly through all cells that the mattes leave, asked of
//
//   none       no look-up: every cell that mattes and mesh leave
//   trained    the avatar's own grid: cells of the posed head, the union over the training's poses
//   posed      the same learnt from the looks of the next two
//   canonical  cells of the canonical face, learnt over the training's expressions and looked up through the
//              head model's deformation alone
//   resting    the same learnt from the resting face: Li 2022's hypothesis as it stands, that what the field
//   adds
//              to that deformation does not move density across cells
//
// The slice of this field has no residual deformation; it may put density anywhere by the expression, and
// what it puts where the look-up expects none is what the last two lose.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/project/project.h"
#include "core/render/rays.h"
#include "core/scene/warp_lattice.h"
#include "core/train/volumes.h"

namespace likeness {

// Density at samples that lie in the canonical face, per cube side; their view is a row of conditions.
using CanonicalDensity = std::function<void(const FieldSamples& canonical, std::vector<float>& sigma)>;

// Views 0 .. lattices.size() - 1 are the training's, the next one is the face at rest.
struct CullScene {
  const Volume& head;
  std::span<const WarpLattice> lattices;
  std::span<const NeckBend> necks;  // one a view, or none
  CanonicalDensity density;
};

struct LearntCells {
  OccupancyGrid posed, canonical, resting;  // of one resolution
};

// looks: into each allowed cell, at a random place under a random view; the largest density found counts.
LearntCells learn_cells(const CullScene& scene, int looks, std::uint64_t seed);

// A head as rays see it: bound by `head.allowed`, moved by one lattice and bend.
struct CullView {
  std::vector<FieldRay> rays;  // unit cube
  const WarpLattice* lattice = nullptr;
  const NeckBend* neck = nullptr;  // or null
  std::int32_t row = 0;            // of conditions
};

struct CullSums {
  double rays = 0, samples = 0, kept = 0;  // samples before and after the look-up
  double dense = 0, dense_lost = 0;        // samples over the threshold, and those of them culled
  double density = 0, density_lost = 0;    // summed over them
  double light = 0, light_lost = 0;        // that the head's samples take, and the culled ones of it

  double kept_per_ray() const { return rays > 0 ? kept / rays : 0; }
  double share_dense_lost() const { return dense > 0 ? dense_lost / dense : 0; }
  double share_density_lost() const { return density > 0 ? density_lost / density : 0; }
  double share_light_lost() const { return light > 0 ? light_lost / light : 0; }
};

inline constexpr std::array kCullLookups{"none", "trained", "posed", "canonical", "resting"};
using CullTable = std::array<CullSums, kCullLookups.size()>;

// Adds a view's rays to the sums of every look-up. trained: the avatar's grid. spacing: m between samples.
// Rays that meet no allowed cell do not count.
void add_culled(const CullScene& scene, const OccupancyGrid& trained, const LearntCells& cells,
                const CullView& view, float spacing, CullTable& table);

struct CullStudy {
  int frames = 0, actions = 0;
  float spacing = 0;    // m
  float threshold = 0;  // density per cube side above which a sample counts as dense
  CullTable held_out;   // over the held-out frames' rays
  CullTable acted;      // over the rays of the typical view, each action the head model knows at full, alone
};

// frames: of the held-out ones, evenly chosen; 0: all.
Result<CullStudy> study_culling(const Project& project, int frames, const Progress& progress,
                                std::stop_token stop);

}  // namespace likeness
