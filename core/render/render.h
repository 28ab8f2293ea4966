// Pictures of an avatar by ray marching through its occupied cells, with a few field samples a ray.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/camera/camera.h"
#include "core/field/precision.h"
#include "core/image/image.h"
#include "core/render/avatar.h"
#include "core/scene/avatar_pose.h"
#include "core/scene/warp_lattice.h"

namespace likeness {

struct RenderState {
  AvatarPose pose;
  // The avatar's rig in one pose (core/render/pose_avatar.h).
  WarpLattice warp;  // of an avatar that warps; otherwise empty
  TorsoField torso;  // empty: a rigid torso
};

// Pixels of a picture of usual size, to which RenderOptions::edge_contrast and max_rays refer.
inline constexpr int kUsualPixels = 512 * 512;

struct RenderOptions {
  // Per ray, head and torso together. Too few leave specks where a ray grazes lips or nostrils: thin skin is
  // then represented by a sample beside it.
  int max_samples = 32;
  // Stretches of a ray, or of the ray in the middle of a block of pixels, whose densities decide where its
  // samples go (refine_strata). 0: the grid's opacities decide.
  int strata = 16;
  int block = 1;  // pixels a side
  float stop_transmittance = 1e-4f;
  float min_step = 0.0015f;     // m between the strata's samples, or those of a ray without strata, at least
  float shade_weight = 0.001f;  // share of the light a sample must take for its colour to be looked up
  // Deferred shading: the colour network's inputs from a field's samples are averaged along the ray by their
  // light, and it is evaluated once (the idea of SNeRG, Hedman et al. 2021, with the field's own network).
  bool deferred = false;
  // One ray for reduce x reduce pixels, the picture enlarged from that, but a ray for each pixel between such
  // rays that differ by more than edge_contrast; in pictures of fewer than kUsualPixels, whose pixels hold
  // more of a face, by less, in proportion to their pixels.
  int reduce = 1;
  float edge_contrast = 0.2f;
  // Rays that a picture of up to kUsualPixels may take, larger ones in proportion to their pixels: instead of
  // by `reduce`, the picture is reduced until a quarter of them or more is left for the pixels that differ
  // the most, and not at all if each pixel can have one. 0: by `reduce`, and as many as differ.
  int max_rays = 0;
  FieldPrecision precision = FieldPrecision::exact;  // of the fields
};

// The quality ladder, both in bf16 if the processor has it. The default options are the reference for both: a
// ray a pixel, each with its own strata, in single precision. `likeness bench PROJECT --tables settings`
// reports their speed and accuracy.
enum class RenderQuality {
  final,   // a ray for 2 x 2 pixels where they hardly differ, else a ray a pixel; 20 samples
  preview  // 39200 rays for 512 x 512 pixels, those left over go where pixels differ; 14 samples
};
inline constexpr const char* kRenderQualities[] = {"final", "preview"};
RenderOptions render_options(RenderQuality quality);

class StandInFields;  // core/render/stand_in.h

struct RenderedFrame {
  Image rgba;                  // (h, w, 4) sRGB-encoded, premultiplied alpha
  double samples_per_ray = 0;  // evaluated, mean over rays that met an occupied cell
};

RenderedFrame render_frame(const Avatar& avatar, const Camera& camera, const RenderState& state,
                           const RenderOptions& options = {});
// The same with a stand-in for the avatar's fields, which are not read; options.deferred and precision are
// the fields' own.
RenderedFrame render_frame(const Avatar& avatar, const StandInFields& fields, const Camera& camera,
                           const RenderState& state, const RenderOptions& options = {});

// Only some pixels: premultiplied colour and alpha, (N, 4). pixels: row-major indices.
std::vector<float> render_pixels(const Avatar& avatar, const Camera& camera, const RenderState& state,
                                 std::span<const std::uint32_t> pixels, const RenderOptions& options = {});

// The avatar's typical camera and state: the pose of its capture, neutral face.
Camera typical_camera(const Avatar& avatar);
RenderState typical_state(const Avatar& avatar);

// Over a plate of the same size, or over one colour when the plate is empty.
Image composite(const Image& rgba, const Image8& plate, const Vec3f& colour = Vec3f::Constant(1));

}  // namespace likeness
