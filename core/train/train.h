// Training an avatar's fields on a tracked capture. Deterministic for one seed and thread count.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/base/work_clock.h"
#include "core/camera/camera.h"
#include "core/field/precision.h"
#include "core/head/head_model.h"
#include "core/image/image.h"
#include "core/image/tiled_mask.h"
#include "core/render/avatar.h"
#include "core/render/strata.h"
#include "core/scene/avatar_pose.h"
#include "core/train/mode.h"

namespace likeness {

class Backend;  // core/render/backend.h

// What of the avatar a picture is learnt by.
enum class LearntPart { person, head, torso };

// One training picture.
struct TrainingView {
  Camera camera;    // crop intrinsics at `size`; translation in metres
  AvatarPose pose;  // attributes: one for each of the set's
  Image8 rgb;       // (size, size, 3)
  TiledMask alpha;  // (size, size) person's matte; empty = unknown
  bool has_plate =
      true;  // the background of this view is its clip's plate; otherwise the matte separates the person
  // Number of a further clip of the person, 0: the avatar's own. Another place, another light, other clothes:
  // only its head is learnt from, before its own plate, and with the view's own code wherever the first clip
  // shows that side, so that the light stays in the code; its torso is placed where the neck is straight and
  // is met by no ray.
  int further_clip = 0;
  TiledMask teaches;  // (size, size) 0: nothing is learnt from this pixel; empty: from all
  // What was filmed of the picture; empty: all of it. Nothing is known of the rest, which `teaches` leaves
  // out.
  PixelRect inside{};
  LearntPart part = LearntPart::person;  // see learnt_part
};

// By what a ray through the view is met: of further clips the head alone, otherwise what the view says.
inline LearntPart learnt_part(const TrainingView& view) {
  return view.further_clip != 0 ? LearntPart::head : view.part;
}

// The background of a further clip: as plate, plate_known and plate_camera below.
struct FurtherPlate {
  Image8 rgb, known;
  std::optional<Camera> camera{};
};

struct TrainingSet {
  int size = 256;
  std::vector<TrainingView> views;  // training frames only; those of further clips last
  Image8 plate;                     // what views with has_plate have behind them; empty: not known
  Image8 plate_known;  // (h, w, 1) 255 = the plate was seen there; less = a guess; empty = everywhere
  // Of a mosaic (core/camera/mosaic.h): the camera that would take the plate. nullopt: a resting camera's,
  // which is what every view sees.
  std::optional<Camera> plate_camera{};
  std::map<int, FurtherPlate> further_plates;  // by the clip's number; none of a walking camera
  HeadModel model;
  PersonShape person;
  ExpressionDetail detail{};  // of the surface, on top of model and person; empty: none
  TorsoModes torso_modes;     // empty: a rigid torso
  Articulation neutral;       // the person's resting face; an empty expression = not known
  bool has_torso = true;
  std::vector<AttributeRegion> attributes;  // whose amounts the views have
  // Pictures that nobody filmed, of sides that the views do not show (core/train/proxy_views.h): learnt
  // from without a code, and less from half of the steps on. Whatever is read off the clip is read off the
  // views alone.
  std::vector<TrainingView> proxies{};
};
// Views and, behind them, proxies: what rays are cast for.
inline std::size_t pictured(const TrainingSet& set) { return set.views.size() + set.proxies.size(); }
inline const TrainingView& picture_at(const TrainingSet& set, std::size_t v) {
  return v < set.views.size() ? set.views[v] : set.proxies[v - set.views.size()];
}

// The views of the clip that defines the avatar's surroundings, light and torso.
std::span<const TrainingView> own_views(const TrainingSet& set);

// The plate of a view's clip and where it was seen; empty if it has none, or the view is elsewhere.
struct PlateOfView {
  const Image8 *rgb = nullptr, *known = nullptr;
  const Camera* camera = nullptr;  // of a mosaic; null: the plate is what the view sees
};
PlateOfView plate_of(const TrainingSet& set, const TrainingView& view);
// The same as a picture of the view's size: what of its plate, or its mosaic, it sees; empty where there is
// none.
struct PlatePicture {
  Image8 rgb, known;
};
PlatePicture plate_picture(const TrainingSet& set, const TrainingView& view);

// Capacity of the fields.
struct FieldSizes {
  int head_log2_entries = 16, head_finest = 512;  // of the head's grid: entries a level, cells along an axis
  int torso_log2_entries = 15, torso_finest = 384;  // the same of the torso's
  int code_length = 4;                              // numbers of each frame's own code

  bool operator==(const FieldSizes&) const = default;
};

// How long, how fast, and when what is learnt is kept.
struct TrainSchedule {
  double budget_s = 300;    // of this stage, by `clock`; ignored when steps > 0
  std::uint64_t steps = 0;  // exact number of steps (replay)
  double rate = 1;          // factor on the learning rates
  double checkpoint_every_s = 30;
  WorkClock clock = WorkClock::wall;  // by which all seconds of training are measured
};

// Which rays a step casts, and where their samples lie.
struct TrainRays {
  // 4096 give a better picture within the first minute; from two minutes on they overfit, with visible
  // specks.
  int per_step = 8192;
  float even_samples = kEvenShare;  // share of them spread evenly along a ray (place_samples)
  bool use_occupancy = true;        // ablation switch
  // The head's empty cells are kept in the canonical face and looked up through the head model's deformation
  // (canonical_cells.h) instead of in the posed face. For studies: the resulting avatar has the usual grid.
  // The processor casts the rays.
  bool canonical_occupancy = false;
};

// What the fields are, and what they depend on.
struct TrainFields {
  FieldMode mode = kDefaultMode;
  FieldSizes sizes;
  bool use_latent = true;      // ablation switch
  bool use_gaze = true;        // the field is conditioned on the gaze
  bool use_expression = true;  // and on the expression; otherwise only on painted attributes
  bool use_still =
      true;  // where no expression moves anything, the field does not depend on it (still_cells.h)
};

// Terms beside the squared error of single rays.
struct TrainLosses {
  // lambda of the landmark loss (landmark_patches.h), which takes a quarter of the rays; 0: without. K: 0.1.
  double landmark_weight = 0;
};

// Where it computes, which changes nothing of what is learnt.
struct TrainingPlace {
  std::shared_ptr<Backend> backend;  // null: the processor
  // A failing backend is replaced by the processor, which continues from the last snapshot.
  bool fall_back = false;
  // Of the processor's products; a given backend has its own.
  FieldPrecision precision = FieldPrecision::bf16;
};

struct TrainOptions {
  std::uint64_t seed = 0;
  TrainSchedule schedule{};
  TrainRays rays{};
  TrainFields fields{};
  TrainLosses losses{};
  bool refine_track = false;  // correct the training frames' tracks through the field (refine_track.h)
  TrainingPlace place{};
};

struct TrainStatus {
  std::uint64_t step = 0;
  double seconds = 0;  // counted against the budget; passes that correct tracks are extra
  double loss = 0, train_psnr_db = 0, rays_per_s = 0;
  double samples_per_ray = 0;  // recently
};

// A look at the avatar while it is being trained. Does not change a bit of what is learnt.
struct AvatarTap {
  std::function<bool()> wanted;             // asked after every step: keep it cheap
  std::function<void(const Avatar&)> take;  // the current avatar, on the training thread
};

// Continues from `checkpoint` if it exists and matches this set and these options; writes it at intervals and
// when stopped. checkpoint.bin holds parameters, optimiser moments, occupancy, random state, schedule and
// seconds spent.
Result<Avatar> train_avatar(const TrainingSet& set, const TrainOptions& options,
                            const std::filesystem::path& checkpoint, const Progress& progress,
                            const std::function<void(const TrainStatus&)>& observe, std::stop_token stop,
                            const AvatarTap& tap = {});

}  // namespace likeness
