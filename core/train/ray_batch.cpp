// Choosing rays.
#include "core/train/ray_batch.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/camera/mosaic.h"
#include "core/train/random_stream.h"
#include "core/train/ray_choice.h"
#include "core/train/sides_seen.h"

namespace likeness {
namespace {

constexpr double kPatchShare = 0.25;
constexpr std::uint64_t kPatchStream = 0x9a7c4ull;
// Beyond every unit cube.
const FieldRay kNowhere{Vec3f::Constant(3), Vec3f::UnitX()};

// The rays through a pixel.
void aim(const RaySource& source, const MarchVolumes& volumes, std::size_t v, PixelPlace pixel,
         RayRequest& request) {
  const TrainingView& view = picture_at(*source.set, v);
  const Vec3f direction =
      ray_direction(view.camera.intrinsics, Vec2d(pixel.x + 0.5, pixel.y + 0.5)).normalized().cast<float>();
  for (int f = 0; f < 2; ++f)
    if (volumes.fields[f].occupancy) request.fields[f] = field_ray(source.views[v].maps[f], direction);
  const LearntPart part = learnt_part(view);
  if (part == LearntPart::torso) request.fields[0] = kNowhere;
  if (part == LearntPart::head) request.fields[1] = kNowhere;
  request.nothing_before = {};
}

Vec3f colour_at(const Image8& image, int x, int y) {
  const std::uint8_t* p = image.at(x, y);
  return Vec3f(float(p[0]), float(p[1]), float(p[2])) / 255.f;
}

// Of a mosaic, as mosaic_colour fetches them.
auto packed_pixels(const Image8& rgb, const Image8& known) {
  return [&rgb, &known](int x, int y) {
    const std::uint8_t* p = rgb.at(x, y);
    const std::uint32_t seen = known.empty() ? 255u : known.at(x, y)[0];
    return p[0] | std::uint32_t(p[1]) << 8 | std::uint32_t(p[2]) << 16 | seen << 24;
  };
}

struct ColourSum {
  Vec3f sum = Vec3f::Zero();
  float count = 0;
  Vec3f mean() const { return sum / std::max(1.f, count); }
};

// Sums the person's colours in the face's box, every few pixels.
ColourSum face_colour(const TrainingView& view, const RaySource::View& box) {
  constexpr int kStep = 3;
  ColourSum colour;
  for (int y = box.face_y0; y < box.face_y1; y += kStep)
    for (int x = box.face_x0; x < box.face_x1; x += kStep)
      if (view.alpha.empty() || view.alpha.at(x, y) == 255)
        colour.sum += colour_at(view.rgb, x, y), ++colour.count;
  return colour;
}

// Exposure and white balance of the further clips, brought to the first one's.
void match_faces(const TrainingSet& set, std::vector<RaySource::View>& views) {
  std::map<int, ColourSum> clips;  // 0: the first
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    const ColourSum face = face_colour(set.views[v], views[v]);
    ColourSum& clip = clips[set.views[v].further_clip];
    clip.sum += face.sum, clip.count += face.count;
  }
  constexpr float kDarkest = 0.02f, kMost = 4;
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    const int clip = set.views[v].further_clip;
    if (clip == 0 || clips[0].count == 0 || clips[clip].count == 0) continue;
    const Vec3f gain = (clips[0].mean().array() + kDarkest) / (clips[clip].mean().array() + kDarkest);
    views[v].gain = gain.cwiseMin(kMost).cwiseMax(1 / kMost);
  }
}

// As ray_choice.h requires them.
struct HostViews {
  const RaySource& source;
  const MarchVolumes& volumes;
  RayRequest& request;  // is aimed

  const TrainingView& view(std::size_t v) const { return picture_at(*source.set, v); }
  int width(std::size_t v) const { return view(v).rgb.width; }
  int height(std::size_t v) const { return view(v).rgb.height; }
  PixelBox face(std::size_t v) const {
    const RaySource::View& own = source.views[v];
    return {own.face_x0, own.face_y0, own.face_x1, own.face_y1};
  }
  bool has_alpha(std::size_t v) const { return !view(v).alpha.empty(); }
  std::uint8_t alpha(std::size_t v, int x, int y) const { return view(v).alpha.at(x, y); }
  bool masked(std::size_t v) const { return !view(v).teaches.empty(); }
  bool teaches(std::size_t v, int x, int y) const { return !masked(v) || view(v).teaches.at(x, y) > 0; }
  bool further(std::size_t v) const { return view(v).further_clip != 0; }
  void in_avatars_light(const Image8& picture, std::size_t v, int x, int y, float (&out)[3]) const {
    Eigen::Map<Vec3f>{out} = colour_at(picture, x, y).cwiseProduct(source.views[v].gain).cwiseMin(1.f);
  }
  void colour(std::size_t v, int x, int y, float (&out)[3]) const {
    in_avatars_light(view(v).rgb, v, x, y, out);
  }
  bool plate(std::size_t v, int x, int y, float (&out)[3]) const {
    const auto [behind, known, camera] = plate_of(*source.set, view(v));
    if (behind->empty()) return false;
    // A guessed plate is not used as background: there the matte separates the person, as without a plate.
    if (camera != nullptr) {
      bool seen = false;
      mosaic_colour(source.views[v].mosaic, x, y, packed_pixels(*behind, *known), out, seen);
      Eigen::Map<Vec3f> colour{out};
      colour = colour.cwiseProduct(source.views[v].gain).cwiseMin(1.f);
      return seen || !has_alpha(v);
    }
    if (!known->empty() && has_alpha(v) && known->at(x, y)[0] != 255) return false;
    in_avatars_light(*behind, v, x, y, out);
    return true;
  }
  bool meets(std::size_t v, int x, int y) {
    request.view = std::int32_t(v);
    aim(source, volumes, v, {x, y}, request);
    return meets_volume(request, volumes);
  }
};

// The first rays of a batch: the views that have patches in turn, any of their landmarks. Returns their
// number.
std::size_t choose_patches(const RaySource& source, const MarchVolumes& volumes, bool drop_codes,
                           std::uint64_t seed, std::uint64_t step, RayBatch& batch) {
  batch.patches.clear();
  if (source.patches == nullptr) return 0;
  const LandmarkPatches& from = *source.patches;
  const std::size_t rays = batch.requests.size();
  batch.patches.resize(std::max<std::size_t>(rays >= kPatchRays ? 1 : 0,
                                             std::size_t(kPatchShare * double(rays)) / kPatchRays));
  parallel_for(batch.patches.size(), [&](std::size_t p) {
    RandomStream random(seed ^ kPatchStream, step, p);
    const double turn = (double(p) + random.uniform()) / double(batch.patches.size());
    const std::size_t v =
        from.views[std::min(from.views.size() - 1, std::size_t(turn * double(from.views.size())))];
    const std::vector<PatchPlace>& places = from.places[v];
    const PatchPlace& place = places[random.below(std::uint32_t(places.size()))];
    const LandmarkMap& map = from.maps[std::size_t(place.landmark)];
    const bool drop = drop_codes && random.uniform() < 0.5f;
    float other[3];
    for (int c = 2; c >= 0; --c) other[c] = random.uniform();
    RayPatch& patch = batch.patches[p];
    patch = {p * kPatchRays, kPatchRays, place.landmark, map.weight * place.visibility, map.map};
    for (int i = 0; i < kPatchRays; ++i) {
      const std::size_t r = patch.first + std::size_t(i);
      const auto [x, y] = patch_pixel(place, from.stride, i);
      RayRequest& request = batch.requests[r];
      aim(source, volumes, v, {x, y}, request);
      request.view = std::int32_t(drop ? v + source.views.size() : v);
      request.jitter = random.bits() | 1;
      float target[3], background[3];
      paint(HostViews{source, volumes, request}, v, {x, y}, other, false, target, background);
      batch.target[r] = Eigen::Map<Vec3f>(target), batch.background[r] = Eigen::Map<Vec3f>(background);
    }
  });
  return batch.patches.size() * kPatchRays;
}

}  // namespace

MosaicPlace mosaic_place(const TrainingSet& set, const TrainingView& view) {
  const PlateOfView plate = plate_of(set, view);
  MosaicPlace place{};
  if (plate.rgb->empty() || plate.camera == nullptr) return place;
  const Mat3d map = pixels_between(view.camera, *plate.camera);
  for (int i = 0; i < 9; ++i) place.from_pixel[i] = float(map(i / 3, i % 3));
  place.width = plate.rgb->width, place.height = plate.rgb->height;
  return place;
}

RaySource make_ray_source(const TrainingSet& set, std::span<const AvatarPose> poses, const HeadShape& shape,
                          const FieldCube& head, const FieldCube* torso, const WarpFrame* warp,
                          const NeckZone& neck) {
  RaySource source;
  source.set = &set;
  const std::size_t count = poses.size();
  source.views.resize(count);
  if (warp && !warp->vertices.empty()) source.warps.resize(count);
  if (torso && !set.torso_modes.empty()) source.torsos.resize(count);
  if (!neck.empty()) source.necks.resize(count);
  parallel_for(count, [&](std::size_t v) {
    const TrainingView& view = picture_at(set, v);
    RaySource::View& out = source.views[v];
    const AvatarPose& pose = poses[v];
    out.maps[0] = unit_from_camera(head, view.camera.cam_from_world, pose.world_from_head);
    if (torso) out.maps[1] = unit_from_camera(*torso, view.camera.cam_from_world, pose.world_from_torso);
    if (!source.necks.empty())
      source.necks[v] =
          make_neck_bend(neck, inverse(pose.world_from_head) * pose.world_from_torso, head.origin, head.side);
    out.mosaic = mosaic_place(set, view);
    // -- Box of the landmarks, a sixth larger on each side; empty where no face is learnt.
    const std::vector<Vec3f> posed = pose_head(set.model, shape, pose.articulation);
    if (!source.torsos.empty()) source.torsos[v] = torso_field(set.torso_modes, pose.torso_shape);
    if (!source.warps.empty()) {
      std::vector<Vec3f> detailed = posed;
      if (!set.detail.empty())
        add_detail(set.model, set.detail,
                   pose.detail.size() > 0 ? pose.detail : detail_scores(set.detail, pose.articulation),
                   detailed);
      source.warps[v] = make_warp_lattice(*warp, detailed);
    }
    if (learnt_part(view) == LearntPart::torso) return;
    const auto landmarks = landmark_positions(set.model, posed);
    const Pose cam_from_head = view.camera.cam_from_world * pose.world_from_head;
    Vec2d low = Vec2d::Constant(1e9), high = -low;
    for (const Vec3f& landmark : landmarks) {
      const Vec3d p = cam_from_head * landmark.cast<double>();
      if (p.z() < 1e-3) return;
      const Vec2d pixel = project(view.camera.intrinsics, p);
      low = low.cwiseMin(pixel), high = high.cwiseMax(pixel);
    }
    const Vec2d margin = (high - low) / 6;
    const int width = view.rgb.width, height = view.rgb.height;
    out.face_x0 = int(std::clamp(low.x() - margin.x(), 0.0, double(width)));
    out.face_y0 = int(std::clamp(low.y() - margin.y(), 0.0, double(height)));
    out.face_x1 = int(std::clamp(high.x() + margin.x(), 0.0, double(width)));
    out.face_y1 = int(std::clamp(high.y() + margin.y(), 0.0, double(height)));
  });
  if (own_views(set).size() == set.views.size()) return source;
  match_faces(set, source.views);
  source.sides = sides_seen(set, shape, head);
  return source;
}

void choose_rays(const RaySource& source, const MarchVolumes& volumes, bool drop_codes, std::uint64_t seed,
                 std::uint64_t step, int count, RayBatch& batch) {
  const std::size_t views = source.views.size(), own = own_views(*source.set).size(),
                    drawn = std::min({source.drawn, views, source.set->views.size()});
  batch.requests.resize(std::size_t(count));
  batch.target.resize(std::size_t(count)), batch.background.resize(std::size_t(count));
  const std::size_t first = choose_patches(source, volumes, drop_codes, seed, step, batch),
                    single = std::size_t(count) - first;
  const ChoiceNumbers numbers{seed,
                              step,
                              std::uint32_t(views),
                              std::uint32_t(own),
                              std::uint32_t(drawn),
                              std::uint32_t(first),
                              std::uint32_t(single),
                              drop_codes,
                              std::uint32_t(views - std::min(views, source.set->views.size())),
                              source.proxies_until};
  parallel_ranges(single, 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const std::size_t i = first + n;
      RayRequest& request = batch.requests[i];
      HostViews from{source, volumes, request};
      const ChosenRay ray = choose_ray(from, numbers, n);
      request.view = ray.view, request.jitter = ray.jitter;
      if (ray.nowhere) request.fields = {kNowhere, kNowhere}, request.nothing_before = {};
      batch.target[i] = Eigen::Map<const Vec3f>(ray.target);
      batch.background[i] = Eigen::Map<const Vec3f>(ray.background);
    }
  });
}

}  // namespace likeness
