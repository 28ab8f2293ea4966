// Renders, measures, judges: see check_holds.h.
#include "core/holds/check_holds.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>

#include "core/base/quantile.h"
#include "core/base/rigid.h"
#include "core/holds/carried_colours.h"
#include "core/holds/picture_faults.h"
#include "core/holds/skin_parts.h"
#include "core/render/camera_path.h"
#include "core/render/pose_avatar.h"
#include "core/render/ray_depth.h"

namespace likeness {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kYaws_deg[] = {7.5, 15, 30, 45}, kPitches_deg[] = {7.5, 15, 25};  // to either side
constexpr double kBeside_deg = 3;    // nearer to the typical view nothing is tried
constexpr int kDepthSide = 96;       // px
constexpr float kBehindAll = 0.5f;   // grey, where nothing is
constexpr float kUnmoved = 0.0003f;  // m
constexpr double kLevels = 255;
constexpr double kUnlikeSkin = 64 / kLevels;
constexpr double kFewPixels = 0.0005;     // of the picture: a part seen by fewer has no colour
constexpr double kSilhouetteRim = 0.012;  // of the picture's width: the fitted outline is no better
constexpr double kHullMargin = 0.02;      // of the picture's width, beyond the farthest hair
constexpr int kChinMark = 8, kJawMark = 0;

Camera small_camera(Camera camera, int side) {
  Intrinsics& k = camera.intrinsics;
  const double scale = std::min(1.0, double(side) / std::max(k.width, k.height));
  const int width = std::max(1, int(std::lround(scale * k.width))),
            height = std::max(1, int(std::lround(scale * k.height)));
  const double x = double(width) / k.width, y = double(height) / k.height;
  k.width = width, k.height = height;
  k.fx *= x, k.cx *= x, k.fy *= y, k.cy *= y;
  return camera;
}

Image smoothed(const Image& picture) {
  Image out = picture;
  const cv::Mat from(picture.height, picture.width, CV_32FC3, const_cast<float*>(picture.data.data()));
  cv::Mat to(out.height, out.width, CV_32FC3, out.data.data());
  cv::blur(from, to, {3, 3});
  return out;
}

struct Shown {
  Camera camera;
  RenderState state;
  Image rgb, smooth, alpha;
  HeadInPicture head;
  Above chin;    // what of the picture is the head's
  Image8 heads;  // the head's silhouette
};

class Looker {
 public:
  Looker(const Avatar& avatar, const HeadModel& model, AvatarRig rig, FrameRenderer& renderer, int side)
      : avatar_(avatar),
        model_(model),
        renderer_(renderer),
        rig_(std::move(rig)),
        side_(side),
        map_(make_skin_map(model, posed(avatar.neutral))) {}

  const SkinMap& map() const { return map_; }
  std::vector<Vec3f> posed(const Articulation& face) const {
    return pose_detailed_head(model_, rig_.shape, face, rig_.detail);
  }

  Result<Shown> look(const Camera& camera, const Articulation& face) const {
    Shown look;
    look.camera = small_camera(camera, side_);
    AvatarPose pose = typical_state(avatar_).pose;
    pose.articulation = face;
    look.state = pose_avatar(rig_, pose);
    auto frame = renderer_.render(look.camera, look.state, render_options(RenderQuality::final));
    if (!frame) return frame.error();
    const Image& rgba = frame->rgba;
    look.rgb = composite(rgba, {}, Vec3f::Constant(kBehindAll));
    look.smooth = smoothed(look.rgb);
    look.alpha = Image(rgba.width, rgba.height, 1);
    for (std::size_t i = 0; i < look.alpha.data.size(); ++i) look.alpha.data[i] = rgba.data[4 * i + 3];
    const Pose cam_from_head = look.camera.cam_from_world * pose.world_from_head;
    look.head = head_in_picture(model_, map_, posed(face), look.camera.intrinsics, cam_from_head);
    look.heads = seen_mask(look.head, map_.head);
    look.chin = above_chin(look.head);
    return look;
  }

 private:
  // From the chin's height in the middle of the head on: seen from above or below, chin and shoulders lie
  // elsewhere.
  Above above_chin(const HeadInPicture& head) const {
    const auto landmarks = landmark_positions(model_, posed(avatar_.neutral));
    const Vec3d at(0, landmarks[kChinMark].y(), landmarks[kJawMark].z());
    Above above;
    above.at = project<double>(head.intrinsics, Vec3d(head.cam_from_head * at));
    above.up = (project<double>(head.intrinsics, Vec3d(head.cam_from_head * (at + 0.05 * Vec3d::UnitY()))) -
                above.at)
                   .normalized();
    return above;
  }

  const Avatar& avatar_;
  const HeadModel& model_;
  FrameRenderer& renderer_;
  AvatarRig rig_;
  int side_;
  SkinMap map_;
};

// Median over the face's skin of how far, along the ray, light ends from the posed head, mm; NaN where none
// of it is seen.
double depth_off_mm(const Avatar& avatar, const HeadModel& model, const Shown& look) {
  const Camera camera = small_camera(look.camera, kDepthSide);
  const HeadInPicture head =
      head_in_picture(model, *look.head.map, look.head.posed, camera.intrinsics, look.head.cam_from_head);
  const RayDepths ends = ray_depths(avatar, camera, look.state);
  std::vector<double> off;
  for (std::size_t i = 0; i < ends.alpha.size(); ++i) {
    const int t = head.triangle(i);
    if (t < 0 || !head.map->skin[std::size_t(t)] || ends.alpha[i] < 0.5f) continue;
    const Vec2d pixel(double(i % std::size_t(head.raster.width)) + 0.5,
                      double(i / std::size_t(head.raster.width)) + 0.5);
    const double ray = ray_direction(camera.intrinsics, pixel).norm();
    off.push_back(1000 * std::abs(double(ends.metres[i]) - ray * double(head.raster.depth[i])));
  }
  return off.empty() ? std::numeric_limits<double>::quiet_NaN() : median(std::move(off));
}

// Where specks count: on plain skin, which has none of its own.
Image8 plain_skin(const Shown& look) {
  const SkinMap& map = *look.head.map;
  std::vector<std::uint8_t> plain(map.part.size(), 0);
  for (std::size_t t = 0; t < plain.size(); ++t) plain[t] = map.part[t] != SkinPart::none;
  const Image8 seen = seen_mask(look.head, plain);
  Image8 mask = seen;
  const cv::Mat from(seen.height, seen.width, CV_8U, const_cast<std::uint8_t*>(seen.data.data()));
  cv::Mat to(mask.height, mask.width, CV_8U, mask.data.data());
  cv::erode(from, to, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
  return mask;
}

// Of a picture by itself.
struct OwnFaults {
  double missing = 0, outside = 0, loose = 0, shredded = 0, specks = 0;
};
OwnFaults own_faults(const Shown& look, double hair_px) {
  return {missing_share(look.alpha, look.heads, kSilhouetteRim * look.alpha.width),
          outside_share(look.alpha, look.heads, look.chin, hair_px), loose_share(look.alpha),
          shredded_share(look.alpha), speck_share_within(look.rgb, plain_skin(look))};
}

// The avatar where it was filmed, at rest: what everything is compared with.
struct Reference {
  Shown look;
  double hair_px = 0;
  OwnFaults own;
  double depth_mm = 0;
};

HoldFigures common_figures(const Reference& reference, const Shown& look) {
  HoldFigures figures;
  const OwnFaults own = own_faults(look, reference.hair_px);
  figures[HoldFault::missing] = own.missing - reference.own.missing;
  figures[HoldFault::outside] = own.outside - reference.own.outside;
  figures[HoldFault::loose] = own.loose - reference.own.loose;
  figures[HoldFault::shredded] = own.shredded - reference.own.shredded;
  figures[HoldFault::specks] = own.specks - reference.own.specks;
  const CarriedColours carried = carry_colours(reference.look.head, reference.look.smooth, look.head);
  const ColourChange change =
      colour_change(carried, look.head, look.smooth, int(kFewPixels * double(look.alpha.data.size())));
  figures[HoldFault::drift] = kLevels * change.drift;
  figures[HoldFault::painted] = kLevels * change.mean;
  return figures;
}

// What an action leaves where it is: seen at rest and with it, and moved in neither.
Image8 unmoved_mask(const SkinMap& map, const std::vector<Triangle>& triangles, const Shown& rest,
                    const Shown& look) {
  std::vector<std::uint8_t> still(triangles.size(), 0);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    still[t] = map.head[t] && std::ranges::all_of(triangles[t], [&](int v) {
                 return (rest.head.posed[std::size_t(v)] - look.head.posed[std::size_t(v)]).norm() < kUnmoved;
               });
  Image8 mask = seen_mask(rest.head, still);
  const Image8 with = seen_mask(look.head, still);
  for (std::size_t i = 0; i < mask.data.size(); ++i) mask.data[i] &= with.data[i];
  return mask;
}

// Of the pixels where an eye was seen at rest and the posed head shows skin, the share that does not look
// like skin; nullopt where there are few.
std::optional<double> open_lids_share(const Shown& rest, const Shown& look) {
  const SkinMap& map = *look.head.map;
  const Image8 eyes = seen_mask(rest.head, map.eyes), skin = seen_mask(look.head, map.skin),
               plain = plain_skin(look);
  Vec3d usual = Vec3d::Zero();
  int plain_pixels = 0;
  for (std::size_t i = 0; i < plain.data.size(); ++i)
    if (plain.data[i] != 0)
      usual += Eigen::Map<const Vec3f>(look.rgb.data.data() + 3 * i).cast<double>(), ++plain_pixels;
  if (plain_pixels == 0) return std::nullopt;
  usual /= plain_pixels;
  int lids = 0, open = 0;
  for (std::size_t i = 0; i < eyes.data.size(); ++i) {
    if (eyes.data[i] == 0 || skin.data[i] == 0) continue;
    const Vec3d own = Eigen::Map<const Vec3f>(look.rgb.data.data() + 3 * i).cast<double>();
    ++lids;
    open += (own - usual).cwiseAbs().maxCoeff() > kUnlikeSkin;
  }
  if (double(lids) < kFewPixels * double(eyes.data.size())) return std::nullopt;
  return double(open) / lids;
}

void add_action_figures(const HeadModel& model, const SkinMap& map, const Reference& reference,
                        const AskedAction& asked, const Shown& look, HoldFigures& figures) {
  const Shown& rest = reference.look;
  const bool forehead_rests = std::ranges::none_of(map.forehead_vertices, [&](int v) {
    return (rest.head.posed[std::size_t(v)] - look.head.posed[std::size_t(v)]).norm() > kUnmoved;
  });
  std::vector<std::uint8_t> forehead(map.part.size(), 0);
  for (std::size_t t = 0; t < forehead.size(); ++t) forehead[t] = map.part[t] == SkinPart::forehead;
  if (forehead_rests)
    figures[HoldFault::forehead] =
        kLevels * change_within(rest.rgb, look.rgb, seen_mask(rest.head, forehead));
  figures[HoldFault::elsewhere] =
      kLevels * change_within(rest.rgb, look.rgb, unmoved_mask(map, model.triangles, rest, look));
  if (const auto open = open_lids_share(rest, look)) figures[HoldFault::lids] = *open;
  if (asked.name != "jawOpen") return;
  const Image8 inside = seen_mask(look.head, map.mouth), lips = seen_mask(look.head, map.lips);
  if (double(std::ranges::count(inside.data, 255)) < kFewPixels * double(inside.data.size())) return;
  const double about = brightness_within(look.rgb, lips);
  if (about > 0) figures[HoldFault::mouth] = brightness_within(look.rgb, inside) / about;
}

// The way outwards on one axis: the rungs beyond the typical view, the nearest first.
std::vector<double> rungs(std::span<const double> sizes, double typical, int side) {
  std::vector<double> out;
  for (const double size : sizes)
    for (const double at : {-size, size})
      if (side * (at - typical) > kBeside_deg) out.push_back(at);
  if (side * (0 - typical) > kBeside_deg) out.push_back(0);
  std::ranges::sort(out, [&](double a, double b) { return side * a < side * b; });
  return out;
}

// The camera as seen from the head, degrees.
std::array<double, 2> yaw_and_pitch_deg(const Pose& cam_from_head) {
  const Vec3d to_camera = inverse(cam_from_head).translation().normalized();
  return {std::atan2(to_camera.x(), to_camera.z()) / kDegree,
          std::asin(std::clamp(to_camera.y(), -1.0, 1.0)) / kDegree};
}

using Clock = std::chrono::steady_clock;

// All that the tries share.
struct Tries {
  const Avatar& avatar;
  const HeadModel& model;
  const Looker& looker;
  const Reference& reference;
  const Progress& progress;
  std::stop_token stop;
  HoldCheck& check;

  void say(const std::string& what) const {
    constexpr double kAbout = 2 * (std::size(kYaws_deg) + std::size(kPitches_deg));
    progress.report(
        double(check.views.size() + check.actions.size()) / (kAbout + double(asked_actions().size())), what);
  }
};

Result<HeldEnd> go_outwards(const Tries& tries, bool yaw, int side) {
  HoldCheck& check = tries.check;
  const double typical = yaw ? check.typical_yaw_deg : check.typical_pitch_deg;
  std::vector<HoldStep> steps;
  for (const double at : yaw ? rungs(kYaws_deg, typical, side) : rungs(kPitches_deg, typical, side)) {
    if (tries.stop.stop_requested()) return cancelled_error();
    HoldView view{yaw ? at : check.typical_yaw_deg, yaw ? check.typical_pitch_deg : at, {}};
    tries.say(fmt::format("{} {:+.1f} degrees", yaw ? "yaw" : "pitch", at));
    const double turn = (at - typical) * kDegree;
    const auto look = tries.looker.look(
        orbit_camera(tries.avatar, tries.avatar.world_from_head, yaw ? turn : 0, yaw ? 0 : turn),
        tries.avatar.neutral);
    if (!look) return look.error();
    view.figures = common_figures(tries.reference, *look);
    view.figures[HoldFault::depth] =
        depth_off_mm(tries.avatar, tries.model, *look) - tries.reference.depth_mm;
    steps.push_back({at, view.figures});
    check.views.push_back(std::move(view));
  }
  return hold_end(typical, steps);
}

Result<void> try_actions(const Tries& tries) {
  HoldCheck& check = tries.check;
  for (const AskedAction& asked : asked_actions()) {
    if (tries.stop.stop_requested()) return cancelled_error();
    if (std::ranges::any_of(asked.actions,
                            [&](const std::string& name) { return sides_of(tries.model, name).empty(); }))
      continue;
    tries.say(fmt::format("{} {:.1f}", asked.name, asked.amount));
    Articulation face = tries.avatar.neutral;
    perform_asked(tries.model, asked, face);
    const auto look = tries.looker.look(typical_camera(tries.avatar), face);
    if (!look) return look.error();
    TriedAction& tried = check.actions.emplace_back(TriedAction{asked, {}});
    tried.figures = common_figures(tries.reference, *look);
    add_action_figures(tries.model, tries.looker.map(), tries.reference, asked, *look, tried.figures);
  }
  for (std::size_t first = 0, end = 0; first < check.actions.size(); first = end) {
    std::vector<HoldStep> steps;
    const std::string& name = check.actions[first].asked.name;
    for (end = first; end < check.actions.size() && check.actions[end].asked.name == name; ++end)
      steps.push_back({check.actions[end].asked.amount, check.actions[end].figures});
    const HeldEnd most = hold_end(0, steps);
    check.range.actions.push_back({name, float(most.deg), most.fault});
  }
  return {};
}

}  // namespace

Result<HoldCheck> check_holds(const Avatar& avatar, const HeadModel& model, const RenderPlace& place,
                              const HoldOptions& options, const Progress& progress, std::stop_token stop) {
  const Clock::time_point began = Clock::now();
  if (stop.stop_requested()) return cancelled_error();
  const auto renderer = make_renderer(place, avatar);
  if (!renderer) return renderer.error();
  auto rig = make_rig(avatar, model);
  if (!rig) return rig.error();
  const Looker looker(avatar, model, std::move(*rig), **renderer, options.side_px);
  HoldCheck check;
  const auto [yaw, pitch] = yaw_and_pitch_deg(avatar.cam_from_world * avatar.world_from_head);
  check.typical_yaw_deg = yaw, check.typical_pitch_deg = pitch;
  Reference reference;
  progress.report(0, "as it was filmed");
  auto front = looker.look(typical_camera(avatar), avatar.neutral);
  if (!front) return front.error();
  reference.look = std::move(*front);
  reference.hair_px = reach_px(reference.look.alpha, reference.look.heads, reference.look.chin) +
                      kHullMargin * reference.look.alpha.width;
  reference.own = own_faults(reference.look, reference.hair_px);
  reference.depth_mm = depth_off_mm(avatar, model, reference.look);
  const Tries tries{avatar, model, looker, reference, progress, stop, check};
  const std::array<HeldEnd*, 4> ends{&check.range.yaw_low, &check.range.yaw_high, &check.range.pitch_low,
                                     &check.range.pitch_high};
  for (std::size_t i = 0; i < ends.size(); ++i) {
    auto end = go_outwards(tries, i < 2, i % 2 == 0 ? -1 : 1);
    if (!end) return end.error();
    *ends[i] = std::move(*end);
  }
  if (const auto tried = try_actions(tries); !tried) return tried.error();
  check.seconds = std::chrono::duration<double>(Clock::now() - began).count();
  progress.report(1);
  return check;
}

}  // namespace likeness
