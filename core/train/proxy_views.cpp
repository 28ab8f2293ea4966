// Each is a moment's head drawn from another camera; the moment's own picture gives the colours.
#include "core/train/proxy_views.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/train/head_marks.h"
#include "core/train/proxy_bust.h"
#include "core/train/proxy_head.h"
#include "core/train/random_stream.h"
#include "core/train/unseen_expressions.h"

namespace likeness {
namespace {

constexpr double kRadian = std::numbers::pi / 180;
constexpr std::uint64_t kProxyStream = 0x9c0ffeeull, kBustStream = 0xb057ull, kFaceStream = 0xfaceull;
constexpr std::uint64_t kTriesEach = 40;  // drawn places until one lies beside the filmed views
constexpr std::size_t kFewestViews = 10;  // of a clip that a proxy is made for
constexpr double kExplained = 0.04,
                 kRoughly = 0.08;  // of mattes, up to which an outline is believed: crown, all
constexpr double kBustExplained = 0.08, kAboveNeck = 0.1;  // the second in m: beyond all of a torso
constexpr float kNeckKept = 0.02f;  // m above the neck's base: below, clothes may hide it
constexpr double kOutline = 0.01;   // of the picture's width, beside the outline

// A view's camera as seen from a point of a part, unit.
Vec3d direction_of(const TrainingView& view, const Pose& world_from_part, const Vec3d& centre) {
  const Pose part_from_cam = inverse(view.camera.cam_from_world * world_from_part);
  return (part_from_cam.translation() - centre).normalized();
}

// In the head frame: of a camera in a direction, up or down first, then round the head.
Mat3d orbit(const Vec3d& direction, double yaw, double pitch) {
  const Vec3d side = Vec3d::UnitY().cross(direction).normalized();
  return (Eigen::AngleAxisd(yaw, Vec3d::UnitY()) * Eigen::AngleAxisd(-pitch, side)).toRotationMatrix();
}

struct ProxyPlace {
  std::size_t moment = 0;              // of own views
  Mat3d turn = Mat3d::Identity();      // of its camera about the head's middle, in the part's frame
  std::optional<Articulation> face{};  // unless it is the moment's own
};

// filmed: directions of all views, own ones first.
std::vector<ProxyPlace> draw_places(const std::vector<Vec3d>& filmed, std::size_t own, std::uint64_t wanted,
                                    double beside_deg, const ProxyViewOptions& options,
                                    std::uint64_t stream) {
  const double nearest = std::cos(kRadian * beside_deg);
  std::vector<ProxyPlace> places;
  for (std::uint64_t i = 0; places.size() < wanted && i < kTriesEach * wanted; ++i) {
    RandomStream random(stream, 0, i);
    ProxyPlace place;
    place.moment = random.below(std::uint32_t(own));
    const double yaw = kRadian * options.yaw_deg * (2 * double(random.uniform()) - 1),
                 pitch = kRadian * options.pitch_deg * (2 * double(random.uniform()) - 1);
    place.turn = orbit(filmed[place.moment], yaw, pitch);
    const Vec3d from = place.turn * filmed[place.moment];
    if (std::ranges::none_of(filmed, [&](const Vec3d& f) { return f.dot(from) > nearest; }))
      places.push_back(place);
  }
  return places;
}

// Faces that the clip never shows, from near its own sides.
std::vector<ProxyPlace> draw_faces(const UnseenExpressions& unseen, const std::vector<Vec3d>& filmed,
                                   std::span<const TrainingView> own, std::uint64_t wanted,
                                   const ProxyViewOptions& options) {
  std::vector<ProxyPlace> places;
  if (unseen.actions.empty()) return places;
  for (std::uint64_t i = 0; i < wanted; ++i) {
    RandomStream random(kFaceStream, 0, i);
    ProxyPlace place;
    place.moment = random.below(std::uint32_t(own.size()));
    const double yaw = kRadian * options.face_yaw_deg * (2 * double(random.uniform()) - 1),
                 pitch = kRadian * options.face_pitch_deg * (2 * double(random.uniform()) - 1);
    place.turn = orbit(filmed[place.moment], yaw, pitch);
    place.face = draw_unseen(unseen, own[place.moment].pose.articulation, random);
    places.push_back(std::move(place));
  }
  return places;
}

// Of the part that a pose places in the world: a camera moved round a point of it. Its view, before any
// picture.
TrainingView moved_camera(const TrainingView& filmed, const Pose& world_from_part, const Vec3d& centre,
                          const ProxyPlace& place) {
  TrainingView view;
  view.pose = filmed.pose, view.camera = filmed.camera, view.has_plate = false;
  const Mat3d part = world_from_part.linear();
  Pose turn = Pose::Identity();
  turn.linear() = part * place.turn * part.transpose();
  turn.translation() = world_from_part * centre - turn.linear() * (world_from_part * centre);
  view.camera.cam_from_world = filmed.camera.cam_from_world * inverse(turn);
  return view;
}

// Leaves out the outline itself, and says that nothing lies beside it on the sides where it is
// believed. shown: 255 where anything is seen that is known.
void trim(const Image8& alpha, const Image8& shown, const std::optional<HalfPicture>& believed,
          Image8& teaches) {
  const auto mat = [](const Image8& mask) {
    return cv::Mat(mask.height, mask.width, CV_8U, const_cast<std::uint8_t*>(mask.data.data()));
  };
  const int edge = std::max(1, int(std::lround(kOutline * alpha.width)));
  cv::Mat within, around;
  cv::erode(mat(alpha), within, cv::getStructuringElement(cv::MORPH_ELLIPSE, {3, 3}));
  cv::dilate(mat(shown), around, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * edge + 1, 2 * edge + 1}));
  for (int y = 0; y < alpha.height; ++y)
    for (int x = 0; x < alpha.width; ++x) {
      if (*alpha.at(x, y) != 0) {
        if (within.at<unsigned char>(y, x) == 0) *teaches.at(x, y) = 0;
        continue;
      }
      if (believed && believed->at(x, y) && around.at<unsigned char>(y, x) == 0) *teaches.at(x, y) = 255;
    }
}

TrainingView head_from(const TrainingSet& set, const ProxyHead& proxy, const ProxyPart& part,
                       const std::vector<float>& heights, const Vec3d& centre, const TrainingView& filmed,
                       const ProxyPlace& place, bool bare_neck) {
  TrainingView view = moved_camera(filmed, filmed.pose.world_from_head, centre, place);
  view.part = LearntPart::head;
  if (place.face) view.pose.articulation = *place.face;
  const Intrinsics& k = view.camera.intrinsics;
  ProxyPicture picture = draw_proxy(part, nullptr, filmed, view);
  Image8 teaches(k.width, k.height, 1);
  for (std::size_t i = 0; i < picture.raster.triangle.size(); ++i) {
    if (picture.alpha.data[i] == 0) continue;
    const Triangle& triangle = part.triangles[std::size_t(picture.raster.triangle[i])];
    float height = 0;
    for (int c = 0; c < 3; ++c)
      height += picture.raster.barycentric[i][c] * heights[std::size_t(triangle[c])];
    teaches.data[i] = height > proxy.base + kNeckKept && picture.inner[i] == 0 ? 255 : 0;
  }
  // Down to the neck's base, to the chin or, where hair hangs, to the brows; in the middle of the head, as
  // from above and below chin and brows lie elsewhere.
  const auto landmarks = landmark_positions(set.model, part.pose(view).vertices);
  constexpr int kChinMark = 8, kJawMark = 0;
  std::optional<HalfPicture> believed;
  if (bare_neck) {
    believed = above_place(view, view.pose.world_from_head, {0, proxy.base + kNeckKept, proxy.axis_z});
  } else if (proxy.crown_unexplained < kExplained) {
    const float height = proxy.unexplained < kRoughly ? landmarks[kChinMark].y() : proxy.brow;
    believed = above_place(view, view.pose.world_from_head, {0, height, landmarks[kJawMark].z()});
  }
  trim(picture.alpha, picture.alpha, believed, teaches);
  view.rgb = std::move(picture.rgb), view.alpha = TiledMask(picture.alpha), view.teaches = TiledMask(teaches);
  return view;
}

TrainingView bust_from(const ProxyBust& bust, const ProxyPart& head, const Vec3d& centre,
                       const TrainingView& filmed, const ProxyPlace& place, bool bare_neck) {
  TrainingView view = moved_camera(filmed, filmed.pose.world_from_torso, centre, place);
  view.part = LearntPart::torso;
  const Intrinsics& k = view.camera.intrinsics;
  ProxyPicture picture = draw_proxy(bust.part, &head, filmed, view);
  Image8 teaches(k.width, k.height, 1), shown(k.width, k.height, 1);
  for (std::size_t i = 0; i < picture.raster.triangle.size(); ++i) {
    const int triangle = picture.raster.triangle[i];
    shown.data[i] = triangle >= 0 || picture.other[i] != 0 ? 255 : 0;
    if (picture.alpha.data[i] != 0) teaches.data[i] = bust.says[std::size_t(triangle)] != 0 ? 255 : 0;
  }
  std::optional<HalfPicture> believed;
  if (bust.unexplained < kBustExplained) {
    const double height = bust.top + (bare_neck ? kAboveNeck : 0);
    believed = other_half(above_place(view, view.pose.world_from_torso, {0, height, bust.axis_z}));
  }
  trim(picture.alpha, shown, believed, teaches);
  view.rgb = std::move(picture.rgb), view.alpha = TiledMask(picture.alpha), view.teaches = TiledMask(teaches);
  return view;
}

std::size_t share_of(double share, std::size_t own_views, int least) {
  if (own_views < kFewestViews) return 0;
  return std::size_t(std::max(double(least), share * double(own_views)));
}

}  // namespace

std::size_t most_proxies(std::size_t own_views, const ProxyViewOptions& options) {
  return share_of(options.share, own_views, options.least) +
         share_of(options.face_share, own_views, options.face_least) +
         share_of(options.torso_share, own_views, options.torso_least);
}

std::vector<TrainingView> make_proxy_views(const TrainingSet& set, const ProxyViewOptions& options) {
  const std::span<const TrainingView> own = own_views(set);
  const bool matted = std::ranges::all_of(own, [](const TrainingView& v) { return !v.alpha.empty(); });
  if (own.size() < kFewestViews || !matted) return {};
  const HeadShape shape = shape_head(set.model, set.person);
  const std::vector<Vec3f> rest = pose_head(set.model, shape, neutral_articulation(set.model));
  const Vec3d centre = head_middle(set.model, rest).cast<double>();
  std::vector<Vec3d> of_head, of_torso;  // of further clips the head alone
  for (const TrainingView& view : set.views)
    of_head.push_back(direction_of(view, view.pose.world_from_head, centre));
  for (const TrainingView& view : own)
    of_torso.push_back(direction_of(view, view.pose.world_from_torso, centre));
  const std::size_t count = own.size();
  std::vector<ProxyPlace> heads = draw_places(of_head, count, share_of(options.share, count, options.least),
                                              options.beside_deg, options, kProxyStream);
  const std::vector<ProxyPlace> faces =
      draw_faces(unseen_expressions(set), of_head, own,
                 share_of(options.face_share, count, options.face_least), options);
  heads.insert(heads.end(), faces.begin(), faces.end());
  const std::size_t wanted = set.has_torso ? share_of(options.torso_share, count, options.torso_least) : 0;
  const std::vector<ProxyPlace> busts =
      draw_places(of_torso, count, wanted, options.torso_beside_deg, options, kBustStream);
  if (heads.empty() && busts.empty()) return {};
  const ProxyHead proxy = make_proxy_head(set, shape);
  const ProxyPart head = head_part(set.model, proxy);
  std::vector<float> heights;
  for (const Vec3f& p : rest) heights.push_back(p.y());
  std::optional<ProxyBust> bust;
  if (!busts.empty()) bust = make_proxy_bust(set, shape, head);
  const bool bare_neck = bust && bust->neck_unexplained < kExplained && proxy.unexplained < kExplained;
  std::vector<TrainingView> views(heads.size() + (bust ? busts.size() : 0));
  parallel_for(views.size(), [&](std::size_t i) {
    if (i < heads.size()) {
      views[i] = head_from(set, proxy, head, heights, centre, own[heads[i].moment], heads[i], bare_neck);
    } else {
      const ProxyPlace& place = busts[i - heads.size()];
      views[i] = bust_from(*bust, head, centre, own[place.moment], place, bare_neck);
    }
  });
  return views;
}

}  // namespace likeness
