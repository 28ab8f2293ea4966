// Checks of a training set.
#include "core/train/check_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace likeness {
namespace {

bool all_finite(std::span<const float> values) {
  return std::ranges::all_of(values, [](float v) { return std::isfinite(v); });
}

bool is_finite(const Camera& camera) {
  const Intrinsics& k = camera.intrinsics;
  return camera.cam_from_world.matrix().allFinite() &&
         std::ranges::all_of(std::array{k.fx, k.fy, k.cx, k.cy, k.k1, k.k2, k.p1, k.p2},
                             [](double v) { return std::isfinite(v); });
}

}  // namespace

Result<void> check_training_set(const TrainingSet& set) {
  const auto bad = [](std::string what, std::string fix) {
    return Error{ErrorCode::bad_input, std::move(what), std::move(fix), "training"};
  };
  if (own_views(set).empty())
    return bad("There is no training picture.",
               "Check the capture: at least one frame must be usable and tracked.");
  if (!set.person.identity.allFinite() ||
      !std::ranges::all_of(set.person.offsets, [](const Vec3f& v) { return v.allFinite(); }))
    return bad("The shape of the person is not finite.", "Fit the head again.");
  if (set.neutral.expression.size() > 0 && !articulation_vector(set.neutral).allFinite())
    return bad("The neutral face is not finite.", "Fit the head again.");
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    const TrainingView& view = set.views[v];
    if (view.rgb.channels != 3 || view.rgb.empty() || view.rgb.width != view.camera.intrinsics.width ||
        view.rgb.height != view.camera.intrinsics.height)
      return bad(fmt::format("Picture {} is {}x{} with {} channels, its camera {}x{}.", v, view.rgb.width,
                             view.rgb.height, view.rgb.channels, view.camera.intrinsics.width,
                             view.camera.intrinsics.height),
                 "Run the import again.");
    const PlateOfView own_plate = plate_of(set, view);
    const Image8 &behind = *own_plate.rgb, &known = *own_plate.known;
    const bool plate = !behind.empty();
    if (!view.alpha.empty() && (view.alpha.width != view.rgb.width || view.alpha.height != view.rgb.height))
      return bad(fmt::format("The matte of picture {} is {}x{}, the picture {}x{}.", v, view.alpha.width,
                             view.alpha.height, view.rgb.width, view.rgb.height),
                 "Run the matting again.");
    if (!view.teaches.empty() &&
        (view.teaches.width != view.rgb.width || view.teaches.height != view.rgb.height))
      return bad(fmt::format("The training mask of picture {} is {}x{}, the picture {}x{}.", v,
                             view.teaches.width, view.teaches.height, view.rgb.width, view.rgb.height),
                 "Run the matting again.");
    if (const PixelRect whole{0, 0, view.rgb.width, view.rgb.height};
        !view.inside.empty() && (common_part(view.inside, whole) != view.inside || view.teaches.empty()))
      return bad(fmt::format("The filmed part of picture {} does not lie in it, or what lies beyond is not "
                             "left out.",
                             v),
                 "Run the import again.");
    if (view.further_clip != 0 && v < own_views(set).size())
      return bad(fmt::format("Picture {} of a further clip comes before the first clip's.", v),
                 "Run the matting again.");
    if (!plate && view.alpha.empty())
      return bad(fmt::format("Picture {} has neither a background plate nor a matte.", v),
                 "Run the matting again.");
    const bool whole = own_plate.camera == nullptr;  // as the view sees it; otherwise it sees a part
    const int width = whole ? view.rgb.width : own_plate.camera->intrinsics.width,
              height = whole ? view.rgb.height : own_plate.camera->intrinsics.height;
    if (plate && (behind.width != width || behind.height != height || behind.channels != 3))
      return bad(fmt::format("The plate of picture {} is {}x{}, its camera {}x{}.", v, behind.width,
                             behind.height, width, height),
                 "Run the matting again.");
    if (plate && !known.empty() &&
        (known.width != behind.width || known.height != behind.height || known.channels != 1))
      return bad("The mask of the plate's seen pixels does not have the plate's size.",
                 "Run the matting again.");
    if (view.pose.articulation.expression.size() != set.model.expression_count())
      return bad(fmt::format("Picture {} has {} expression numbers, the head model {}.", v,
                             view.pose.articulation.expression.size(), set.model.expression_count()),
                 "Fit the head again with this head model.");
    if (!is_finite(view.camera))
      return bad(fmt::format("The camera of picture {} is not finite.", v), "Solve the cameras again.");
    if (!view.pose.world_from_head.matrix().allFinite() || !view.pose.world_from_torso.matrix().allFinite() ||
        !articulation_vector(view.pose.articulation).allFinite() || !all_finite(view.pose.torso_shape))
      return bad(fmt::format("The track of picture {} is not finite.", v), "Fit the head again.");
  }
  return {};
}

}  // namespace likeness
