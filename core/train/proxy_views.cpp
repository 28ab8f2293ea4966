// Each is a moment's head drawn from another camera; the moment's own picture gives the colours.
#include "core/train/proxy_views.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/scene/mesh_scene.h"
#include "core/train/head_marks.h"
#include "core/train/proxy_head.h"
#include "core/train/random_stream.h"

namespace likeness {
namespace {

constexpr double kRadian = std::numbers::pi / 180;
constexpr std::uint64_t kProxyStream = 0x9c0ffeeull;
constexpr std::uint64_t kTriesEach = 40;  // drawn places until one lies beside the filmed views
constexpr std::size_t kFewestViews = 10;  // of a clip that a proxy is made for
constexpr double kExplained = 0.04,
                 kRoughly = 0.08;              // of mattes, up to which an outline is believed: crown, all
constexpr float kNeckKept = 0.02f;             // m above the neck's base: below, clothes may hide it
constexpr double kHiddenBy = 0.005;            // m
constexpr double kSlant = 0.2, kSquare = 0.5;  // cosines between which the moment's own pixel takes over
constexpr double kOutline = 0.01;              // of the picture's width, beside the outline
constexpr int kOwnMatte = 250;
constexpr float kForeign = 0.4f;  // from the usual colour, encoded: farther than lips, teeth and glints reach

// A view's camera as seen from the middle of the head, unit.
Vec3d direction_of(const TrainingView& view, const Vec3d& centre) {
  const Pose head_from_cam = inverse(view.camera.cam_from_world * view.pose.world_from_head);
  return (head_from_cam.translation() - centre).normalized();
}

// In the head frame: of a camera in a direction, up or down first, then round the head.
Mat3d orbit(const Vec3d& direction, double yaw, double pitch) {
  const Vec3d side = Vec3d::UnitY().cross(direction).normalized();
  return (Eigen::AngleAxisd(yaw, Vec3d::UnitY()) * Eigen::AngleAxisd(-pitch, side)).toRotationMatrix();
}

struct ProxyPlace {
  std::size_t moment = 0;          // of own views
  Mat3d turn = Mat3d::Identity();  // of its camera about the head's middle, head frame
};

std::vector<ProxyPlace> draw_places(const TrainingSet& set, const Vec3d& centre,
                                    const ProxyViewOptions& options) {
  const std::span<const TrainingView> own = own_views(set);
  std::vector<Vec3d> filmed;  // further clips', too
  for (const TrainingView& view : set.views) filmed.push_back(direction_of(view, centre));
  const double nearest = std::cos(kRadian * options.beside_deg);
  const std::uint64_t wanted = most_proxies(own.size(), options);
  std::vector<ProxyPlace> places;
  for (std::uint64_t i = 0; places.size() < wanted && i < kTriesEach * wanted; ++i) {
    RandomStream random(kProxyStream, 0, i);
    ProxyPlace place;
    place.moment = random.below(std::uint32_t(own.size()));
    const double yaw = kRadian * options.yaw_deg * (2 * double(random.uniform()) - 1),
                 pitch = kRadian * options.pitch_deg * (2 * double(random.uniform()) - 1);
    place.turn = orbit(filmed[place.moment], yaw, pitch);
    const Vec3d from = place.turn * filmed[place.moment];
    if (std::ranges::none_of(filmed, [&](const Vec3d& f) { return f.dot(from) > nearest; }))
      places.push_back(place);
  }
  return places;
}

Vec3f colour_between(const Image8& picture, const Vec2d& pixel) {
  const double x = pixel.x() - 0.5, y = pixel.y() - 0.5;
  const int ix = std::clamp(int(std::floor(x)), 0, picture.width - 2),
            iy = std::clamp(int(std::floor(y)), 0, picture.height - 2);
  const float fx = std::clamp(float(x - ix), 0.f, 1.f), fy = std::clamp(float(y - iy), 0.f, 1.f);
  Vec3f colour;
  for (int c = 0; c < 3; ++c) {
    const float upper = (1 - fx) * float(picture.at(ix, iy)[c]) + fx * float(picture.at(ix + 1, iy)[c]),
                lower =
                    (1 - fx) * float(picture.at(ix, iy + 1)[c]) + fx * float(picture.at(ix + 1, iy + 1)[c]);
    colour[c] = ((1 - fy) * upper + fy * lower) / 255.f;
  }
  return colour;
}

// A moment's head, and its own picture laid on it.
class Moment {
 public:
  Moment(const TrainingSet& set, const ProxyHead& proxy, const TrainingView& view)
      : view_(view),
        posed_(pose_proxy(set.model, proxy, view.pose.articulation)),
        normals_(vertex_normals(posed_, set.model.triangles)),
        cam_from_head_(view.camera.cam_from_world * view.pose.world_from_head),
        eye_(inverse(cam_from_head_).translation()),
        seen_(rasterise(posed_, proxy.triangles, view.camera.intrinsics, cam_from_head_)) {}

  const std::vector<Vec3f>& posed() const { return posed_; }

  // Of a place on a triangle; `usual`: the proxy's colour there.
  Vec3f colour(const Triangle& triangle, const Vec3f& weights, const Vec3f& usual) const {
    Vec3f place = Vec3f::Zero(), normal = place;
    for (int c = 0; c < 3; ++c)
      place += weights[c] * posed_[std::size_t(triangle[c])],
          normal += weights[c] * normals_[std::size_t(triangle[c])];
    const Vec3d p = place.cast<double>(), in_cam = cam_from_head_ * p;
    const double facing = normal.cast<double>().normalized().dot((eye_ - p).normalized());
    if (!(facing > kSlant) || !(in_cam.z() > 0)) return usual;
    const Vec2d pixel = project<double>(view_.camera.intrinsics, in_cam);
    if (!(pixel.x() >= 1 && pixel.y() >= 1 && pixel.x() < seen_.width - 1 && pixel.y() < seen_.height - 1))
      return usual;
    const int x = int(pixel.x()), y = int(pixel.y());
    const float depth = seen_.depth[std::size_t(y) * std::size_t(seen_.width) + std::size_t(x)];
    if (depth == 0 || in_cam.z() > depth + kHiddenBy) return usual;
    if (view_.alpha.at(x, y) < kOwnMatte || (!view_.teaches.empty() && view_.teaches.at(x, y) == 0))
      return usual;
    const float own = float(std::clamp((facing - kSlant) / (kSquare - kSlant), 0.0, 1.0));
    const Vec3f here = colour_between(view_.rgb, pixel);
    if ((here - usual).norm() > kForeign) return usual;  // a hand, a cup
    return own * here + (1 - own) * usual;
  }

 private:
  const TrainingView& view_;
  std::vector<Vec3f> posed_, normals_;
  Pose cam_from_head_;
  Vec3d eye_;
  Raster seen_;
};

bool faces_away(const std::vector<Vec3f>& posed, const Triangle& triangle, const Vec3f& eye) {
  const Vec3f &a = posed[std::size_t(triangle[0])], &b = posed[std::size_t(triangle[1])],
              &c = posed[std::size_t(triangle[2])];
  return (b - a).cross(c - a).dot(eye - a) < 0;
}

// Where the outline is believed: above a place in the picture; nowhere if `up` is zero.
struct Believed {
  Vec2d above = Vec2d::Zero(), up = Vec2d::Zero();
  bool at(int x, int y) const { return (Vec2d(x + 0.5, y + 0.5) - above).dot(up) > 0; }
};

// Leaves out the outline itself, and says that nothing lies beside it where it is believed.
void trim(const Image8& alpha, const Believed& believed, Image8& teaches) {
  const cv::Mat head(alpha.height, alpha.width, CV_8U, const_cast<std::uint8_t*>(alpha.data.data()));
  const int edge = std::max(1, int(std::lround(kOutline * alpha.width)));
  cv::Mat within, around;
  cv::erode(head, within, cv::getStructuringElement(cv::MORPH_ELLIPSE, {3, 3}));
  cv::dilate(head, around, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * edge + 1, 2 * edge + 1}));
  for (int y = 0; y < alpha.height; ++y)
    for (int x = 0; x < alpha.width; ++x) {
      if (*alpha.at(x, y) != 0) {
        if (within.at<unsigned char>(y, x) == 0) *teaches.at(x, y) = 0;
        continue;
      }
      if (believed.at(x, y) && around.at<unsigned char>(y, x) == 0) *teaches.at(x, y) = 255;
    }
}

TrainingView picture_from(const TrainingSet& set, const ProxyHead& proxy, const TrainingView& filmed,
                          const Vec3d& centre, const std::vector<float>& heights, const ProxyPlace& place) {
  TrainingView view;
  view.pose = filmed.pose, view.camera = filmed.camera, view.has_plate = false;
  const Mat3d head = filmed.pose.world_from_head.linear();
  Pose turn = Pose::Identity();
  turn.linear() = head * place.turn * head.transpose();
  turn.translation() =
      filmed.pose.world_from_head * centre - turn.linear() * (filmed.pose.world_from_head * centre);
  view.camera.cam_from_world = filmed.camera.cam_from_world * inverse(turn);
  const Pose cam_from_head = view.camera.cam_from_world * view.pose.world_from_head;
  const Intrinsics& k = view.camera.intrinsics;

  const Moment moment(set, proxy, filmed);
  const Vec3f eye = inverse(cam_from_head).translation().cast<float>();
  const Raster raster = rasterise(moment.posed(), proxy.triangles, k, cam_from_head);
  Image8 rgb(k.width, k.height, 3), alpha(k.width, k.height, 1), teaches(k.width, k.height, 1);
  for (std::size_t i = 0; i < raster.triangle.size(); ++i) {
    if (raster.triangle[i] < 0) continue;
    const Triangle& triangle = proxy.triangles[std::size_t(raster.triangle[i])];
    const Vec3f& weights = raster.barycentric[i];
    Vec3f usual = Vec3f::Zero();
    float height = 0;
    for (int c = 0; c < 3; ++c) {
      usual += weights[c] * proxy.colours[std::size_t(triangle[c])];
      height += weights[c] * heights[std::size_t(triangle[c])];
    }
    const Vec3f colour = moment.colour(triangle, weights, usual);
    for (int c = 0; c < 3; ++c)
      rgb.data[3 * i + std::size_t(c)] = std::uint8_t(std::lround(255 * std::clamp(colour[c], 0.f, 1.f)));
    alpha.data[i] = 255;
    const bool inner = faces_away(moment.posed(), triangle, eye);  // of the open neck
    teaches.data[i] = height > proxy.base + kNeckKept && !inner ? 255 : 0;
  }
  // Down to the chin or, where hair hangs, to the brows; in the middle of the head, as from above and below
  // chin and brows lie elsewhere.
  const auto landmarks = landmark_positions(set.model, moment.posed());
  constexpr int kChinMark = 8, kJawMark = 0;
  Believed believed;
  if (proxy.crown_unexplained < kExplained) {
    const float height = proxy.unexplained < kRoughly ? landmarks[kChinMark].y() : proxy.brow;
    believed.above = project<double>(k, Vec3d(cam_from_head * Vec3d(0, height, landmarks[kJawMark].z())));
    believed.up = (cam_from_head.linear() * Vec3d::UnitY()).head<2>();
  }
  trim(alpha, believed, teaches);
  view.rgb = std::move(rgb), view.alpha = TiledMask(alpha), view.teaches = TiledMask(teaches);
  return view;
}

}  // namespace

std::size_t most_proxies(std::size_t own_views, const ProxyViewOptions& options) {
  if (own_views < kFewestViews) return 0;
  return std::size_t(std::max(double(options.least), options.share * double(own_views)));
}

std::vector<TrainingView> make_proxy_views(const TrainingSet& set, const ProxyViewOptions& options) {
  const std::span<const TrainingView> own = own_views(set);
  const bool matted = std::ranges::all_of(own, [](const TrainingView& v) { return !v.alpha.empty(); });
  if (own.size() < kFewestViews || !matted) return {};
  const HeadShape shape = shape_head(set.model, set.person);
  const std::vector<Vec3f> rest = pose_head(set.model, shape, neutral_articulation(set.model));
  const Vec3d centre = head_middle(set.model, rest).cast<double>();
  const std::vector<ProxyPlace> places = draw_places(set, centre, options);
  if (places.empty()) return {};
  const ProxyHead proxy = make_proxy_head(set, shape);
  std::vector<float> heights;
  for (const Vec3f& p : rest) heights.push_back(p.y());
  std::vector<TrainingView> views(places.size());
  parallel_for(places.size(), [&](std::size_t i) {
    views[i] = picture_from(set, proxy, own[places[i].moment], centre, heights, places[i]);
  });
  return views;
}

}  // namespace likeness
