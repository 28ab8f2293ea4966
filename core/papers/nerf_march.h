// Rays through the baselines' fields in two passes (Mildenhall et al. 2020, section 5.2): a coarse field's
// samples spread evenly over the stretch where head and torso may be, then a fine field's where the light was
// lost in the coarse one. Stretches, order and compositing are those of core/render.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/papers/nerf_field.h"
#include "core/render/avatar.h"
#include "core/render/composite.h"
#include "core/render/pose_avatar.h"

namespace likeness {

// A coarse and a fine field of one rigid frame.
using NerfPair = std::array<NerfField<float>, 2>;

// The result of training. `scene` holds all that a likeness::Avatar does except the fields, which are empty.
struct NerfAvatar {
  Avatar scene;
  NerfPair head;
  std::optional<NerfPair> torso;
};
std::size_t parameter_count(const NerfAvatar& avatar);

struct NerfMarchOptions {
  int coarse = 32, fine = 32;  // samples a ray, head and torso together
  float min_step = 0.0005f;    // m between samples, at least
  std::uint64_t seed = 0;      // for the samples' places in their stretches; 0: in the middle
};

// Samples of one pass and the fields' values at them.
struct NerfPass {
  SampleBatch batch;
  std::array<std::vector<float>, 2> sigma, colour;    // by field: (N), (N, 3)
  std::array<std::vector<NerfTape<float>>, 2> tapes;  // one for each kNerfChunk samples, if kept
  std::vector<Composited<float>> rays;                // (R)
};
inline constexpr std::size_t kNerfChunk = 1024;

// What rays are cast into. Refers to its members' owners.
struct NerfScene {
  const NerfPair* head = nullptr;
  const NerfPair* torso = nullptr;  // or none
  MarchVolumes volumes;
  const float* conditions = nullptr;               // (views, K)
  std::function<void(SampleBatch&)> to_canonical;  // moves samples to canonical space
  const NerfField<float>& field(int part, int pass) const {
    return (part == 0 ? *head : *torso)[std::size_t(pass)];
  }
};

// Both passes over all rays; parallel, independent of the threads. keep_tapes: for training; otherwise only
// the coarse field's densities are computed and its colours are black.
void march_nerf(const NerfScene& scene, std::span<const RayRequest> rays, const NerfMarchOptions& options,
                bool keep_tapes, std::array<NerfPass, 2>& passes);

// The share of a ray's light that each of its samples [begin, end) takes.
void ray_weights(const NerfPass& pass, std::size_t ray, std::vector<float>& weights);

// A picture: premultiplied, (h, w, 4).
Image render_nerf(const NerfAvatar& avatar, const Camera& camera, const RenderState& state,
                  const NerfMarchOptions& options = {});

}  // namespace likeness
