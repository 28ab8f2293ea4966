// An avatar's fields stored: density, diffuse colour and a 4-D feature at the nodes of sparse voxels in the
// canonical face, and one small network per ray for what depends on view and expression. After SNeRG (Hedman
// et al. 2021) as adopted by Li 2022.
//
//   C = sum_i w_i diffuse_i + A R(F / A, D / A, d, psi)     over the head's samples, A = sum_i w_i
//   D = sum_i w_i diffuse_i,  F = sum_i w_i feature_i        R: 2 layers of 16
//
// Samples are mapped to canonical space by the head model's deformation, as usual. The density is that of one
// expression, the mean of the training frames: the field's slices for other expressions are lost, and only R,
// after the compositing, is conditioned on the expression. A torso's field depends on neither view nor
// expression: its density and colour are stored, and no network follows.
//
// The field's own colour network takes 15 numbers per sample. The feature is a linear map of these, learnt
// with R from the training pictures: along a ray the map of the mean is the mean of the maps, so that rays
// are composited once, with all 15, and the map is stored afterwards.
#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/papers/dense_network.h"
#include "core/papers/sparse_voxels.h"
#include "core/render/pose_avatar.h"
#include "core/render/render.h"
#include "core/render/stand_in.h"
#include "core/train/train.h"

namespace likeness {

inline constexpr int kBakedFeatures = 4, kRayNetworkWidth = 16, kRayNetworkLayers = 2;

struct BakedAvatar {
  Avatar scene;                       // all of the avatar except its fields' parameters
  SparseVoxels head;                  // density, diffuse (3), feature (4)
  std::optional<SparseVoxels> torso;  // density, colour (3)
  // R: inputs feature, diffuse, view (kViewTerms), psi; parameters as in dense_network.h.
  DenseNetworkSpec network;
  std::vector<float> parameters;
};
std::size_t stored_bytes(const BakedAvatar& avatar);  // voxels and network, in single precision

struct BakeOptions {
  int head_resolution = 256, torso_resolution = 192;  // cells along an axis
  int views = 8;       // directions, of the training views, that a diffuse colour is the mean over
  int rays = 262'144;  // of the training pictures, on which the network is trained
  int samples = 32;    // of each
  int rays_per_step = 4096;
  std::uint64_t steps = 3000;
  float rate = 3e-3f;  // of Adam, falling to a tenth
  std::uint64_t seed = 0;
};

// The network's inputs for a direction in the head's frame: spherical harmonics of the first and second
// order, without their factors.
inline constexpr int kViewTerms = 8;
void view_terms(float x, float y, float z, float* out);

// Composited training rays. From the head's samples only, except `rest`.
struct BakedRays {
  int features = 0;                     // that the field's colour network takes
  std::vector<float> given;             // (R, features) means by the light each sample takes
  std::vector<float> diffuse, view;     // (R, 3) mean; (R, kViewTerms)
  std::vector<float> light;             // (R) A, that the head's samples take
  std::vector<std::int32_t> condition;  // (R) row of the conditions
  std::vector<float> rest, target;      // (R, 3) torso and what lies behind; the picture
  std::size_t count() const { return light.size(); }
};

// One ray's samples, head (0) and torso (1) in depth order. values: of each sample diffuse (3) and, of the
// head's, the given features. Appends to `rays` where the head takes more than a thousandth of the light.
struct BakedSample {
  int part = 0;
  float depth = 0;  // optical
  const float* values = nullptr;
};
void add_ray(std::span<const BakedSample> samples, const Vec3f& direction, std::int32_t condition,
             const Vec3f& background, const Vec3f& target, BakedRays& rays);

// R with the map to features before it: inputs given, diffuse, view, psi.
DenseNetworkSpec ray_network(int given, int conditions);

// Mean squared error over the chosen rays and, if requested, its gradient (added). In float, or in double for
// finite differences. conditions: (rows, K).
template <class Real>
Real ray_loss(const DenseNetworkSpec& network, const Real* parameters, const BakedRays& rays,
              std::span<const std::uint32_t> chosen, const std::vector<float>& conditions, Real* gradients);

struct BakeReport {
  double loss_before = 0, loss_after = 0;  // mean squared error of the rays, without R and with it
  std::size_t rays = 0;
  double seconds = 0;  // processor
};

// avatar: without painted attributes; set: the pictures that it was trained on. Deterministic for one seed.
Result<BakedAvatar> bake_avatar(const Avatar& avatar, const TrainingSet& set, const BakeOptions& options,
                                const Progress& progress, std::stop_token stop, BakeReport* report = nullptr);

// The stand-in for the fields in one expression.
class BakedFields final : public StandInFields {
 public:
  BakedFields(const BakedAvatar& avatar, const Articulation& articulation);  // refers to the avatar
  void densities(int part, const FieldSamples& samples, std::vector<float>& sigma) const override;
  void colours(const std::array<WeightedSamples, 2>& parts, std::span<Vec3f> rays) const override;

 private:
  const BakedAvatar& avatar_;
  Eigen::VectorXf condition_;
};

RenderedFrame render_baked(const BakedAvatar& avatar, const Camera& camera, const RenderState& state,
                           const RenderOptions& options = {});

}  // namespace likeness
