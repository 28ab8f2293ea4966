// On nodes of the torso frame's plane through the neck's axis: which are body, how far it is to the outline,
// how thick the body is there.
#include "core/train/proxy_bust.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/scene/head_regions.h"
#include "core/train/fill_mesh.h"
#include "core/train/head_marks.h"

namespace likeness {
namespace {

constexpr int kOutlineViews = 24, kBustColourViews = 24, kBustRounds = 800;
constexpr float kNode = 0.005f;                    // m between nodes
constexpr float kHalfWidth = 0.5f, kDeep = 0.45f;  // m beside the axis, below the neck's base
constexpr float kNeckBand = 0.025f;                // m above it, up to about the chin
constexpr float kBesideChin = 0.03f;               // m above it: as high as shoulders rise
constexpr float kAboveNeckBase = 0.02f;            // m: from there on it is the head's neck
constexpr float kNeckRadius = 0.065f,
                kChestRadius = 0.105f;  // m: half of the thickness, far from the outline
constexpr float kToChest = 0.08f;       // m below the upper end from which it is a chest
constexpr float kFewestNodes = 400;     // a hundred square centimetres
constexpr double kSameSide = 20;        // degrees, between views whose outlines are one
constexpr double kBlur = 2;             // nodes
constexpr float kCertain = 0.3f;        // ViewColours::weight

enum class Node : std::uint8_t { outside, body, hidden, unknown };  // hidden: body behind the head and neck

struct Plane {
  int columns = 0, rows = 0;  // rows upwards
  Vec3f origin = Vec3f::Zero();
  std::vector<Node> nodes;
  std::vector<float> half;  // m

  std::size_t index(int x, int y) const { return std::size_t(y) * std::size_t(columns) + std::size_t(x); }
  Vec3f place(int x, int y) const { return origin + kNode * Vec3f(float(x), float(y), 0); }
  bool is(Node node, int x, int y) const {
    return x >= 0 && y >= 0 && x < columns && y < rows && nodes[index(x, y)] == node;
  }
  bool body(int x, int y) const { return is(Node::body, x, y) || is(Node::hidden, x, y); }
};

Vec3d posed_place(const TrainingSet& set, const std::vector<float>& displacement, const Vec3f& p) {
  Vec3d posed = p.cast<double>();
  if (displacement.empty()) return posed;
  const GridPlace at = place_in(set.torso_modes.grid, p.x(), p.y());
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t c = 0; c < 2; ++c)
      posed[Eigen::Index(c)] += double(at.weight[k] * displacement[2 * std::size_t(at.node[k]) + c]);
  return posed;
}

std::vector<float> displacement_of(const TrainingSet& set, const TrainingView& view) {
  return set.torso_modes.empty() ? std::vector<float>()
                                 : posed_displacement(set.torso_modes, view.pose.torso_shape);
}

// Own views, evenly, that see the torso from about where most do: an outline belongs to one side.
std::vector<const TrainingView*> outline_views(const TrainingSet& set, const Vec3d& middle) {
  const std::span<const TrainingView> own = own_views(set);
  std::vector<Vec3d> directions;
  Vec3d usual = Vec3d::Zero();
  for (const TrainingView& view : own) {
    const Pose torso_from_cam = inverse(view.camera.cam_from_world * view.pose.world_from_torso);
    directions.push_back((torso_from_cam.translation() - middle).normalized());
    usual += directions.back();
  }
  usual.normalize();
  std::vector<const TrainingView*> views;
  for (std::size_t i = 0; i < own.size(); ++i)
    if (directions[i].dot(usual) > std::cos(kSameSide * std::numbers::pi / 180)) views.push_back(&own[i]);
  std::vector<const TrainingView*> chosen;
  for (const std::size_t i : evenly(views.size(), kOutlineViews)) chosen.push_back(views[i]);
  return chosen;
}

// By the mattes: a node is body where more than half of the views that see it say so.
Plane outline(const TrainingSet& set, const ProxyPart& head, float axis_z, float base, float top) {
  Plane plane;
  plane.columns = int(2 * kHalfWidth / kNode) + 1;
  plane.rows = int((top - base + kDeep) / kNode) + 1;
  plane.origin = {-kHalfWidth, base - kDeep, axis_z};
  std::vector<int> seen(std::size_t(plane.columns) * std::size_t(plane.rows), 0), person = seen;
  for (const TrainingView* view : outline_views(set, {0, base - 0.1, axis_z})) {
    const std::vector<float> moved = displacement_of(set, *view);
    const Pose cam_from_torso = view->camera.cam_from_world * view->pose.world_from_torso;
    const Raster hides = see_proxy(head, *view);
    parallel_for(std::size_t(plane.rows), [&](std::size_t y) {
      for (int x = 0; x < plane.columns; ++x) {
        const Vec3d in_cam = cam_from_torso * posed_place(set, moved, plane.place(x, int(y)));
        if (!(in_cam.z() > 0)) continue;
        const Vec2d pixel = project<double>(view->camera.intrinsics, in_cam);
        if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < hides.width && pixel.y() < hides.height))
          continue;
        const int u = int(pixel.x()), v = int(pixel.y());
        if (!view->inside.empty() && !view->inside.contains(u, v)) continue;
        if (hides.triangle[std::size_t(v) * std::size_t(hides.width) + std::size_t(u)] >= 0) continue;
        const std::size_t i = plane.index(x, int(y));
        ++seen[i], person[i] += view->alpha.at(u, v) >= 128;
      }
    });
  }
  plane.nodes.resize(seen.size());
  for (std::size_t i = 0; i < seen.size(); ++i)
    plane.nodes[i] = seen[i] == 0 ? Node::unknown : 2 * person[i] > seen[i] ? Node::body : Node::outside;
  return plane;
}

// What chin and neck always hide lies between what they do not; then the largest piece alone.
void close_outline(Plane& plane) {
  for (int y = 0; y < plane.rows; ++y) {
    int first = plane.columns, last = -1;
    for (int x = 0; x < plane.columns; ++x)
      if (plane.body(x, y)) first = std::min(first, x), last = x;
    for (int x = first; x <= last; ++x)
      if (Node& node = plane.nodes[plane.index(x, y)]; node == Node::unknown) node = Node::hidden;
  }
  cv::Mat body(plane.rows, plane.columns, CV_8U), pieces, facts, centres;
  for (int y = 0; y < plane.rows; ++y)
    for (int x = 0; x < plane.columns; ++x) body.at<unsigned char>(y, x) = plane.body(x, y) ? 255 : 0;
  const int count = cv::connectedComponentsWithStats(body, pieces, facts, centres, 4, CV_32S);
  int largest = 0, nodes = 0;
  for (int piece = 1; piece < count; ++piece)
    if (facts.at<int>(piece, cv::CC_STAT_AREA) > nodes)
      largest = piece, nodes = facts.at<int>(piece, cv::CC_STAT_AREA);
  for (int y = 0; y < plane.rows; ++y)
    for (int x = 0; x < plane.columns; ++x)
      if (plane.body(x, y) && pieces.at<int>(y, x) != largest) plane.nodes[plane.index(x, y)] = Node::outside;
}

// A circle's section at the outline, flat where that is far. What was not filmed is no outline.
void blow_up(Plane& plane, float neck_from) {
  cv::Mat within(plane.rows, plane.columns, CV_8U), distance;
  for (int y = 0; y < plane.rows; ++y)
    for (int x = 0; x < plane.columns; ++x)
      within.at<unsigned char>(y, x) = plane.nodes[plane.index(x, y)] == Node::outside ? 0 : 255;
  cv::distanceTransform(within, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::Mat half(plane.rows, plane.columns, CV_32F), weight(plane.rows, plane.columns, CV_32F);
  for (int y = 0; y < plane.rows; ++y) {
    const float drop = std::clamp((neck_from - plane.place(0, y).y()) / kToChest, 0.f, 1.f);
    const float radius = kNeckRadius + drop * (kChestRadius - kNeckRadius);
    for (int x = 0; x < plane.columns; ++x) {
      const float inwards = std::clamp(kNode * (distance.at<float>(y, x) - 0.5f), 0.f, radius);
      half.at<float>(y, x) = std::sqrt(inwards * (2 * radius - inwards));
      weight.at<float>(y, x) = plane.body(x, y) ? 1.f : 0.f;
      half.at<float>(y, x) *= weight.at<float>(y, x);
    }
  }
  cv::GaussianBlur(half, half, {}, kBlur), cv::GaussianBlur(weight, weight, {}, kBlur);
  plane.half.resize(plane.nodes.size());
  for (int y = 0; y < plane.rows; ++y)
    for (int x = 0; x < plane.columns; ++x)
      plane.half[plane.index(x, y)] = half.at<float>(y, x) / std::max(1e-6f, weight.at<float>(y, x));
}

// Front, back, and between them a wall wherever the body ends. says: 0 on walls above and below, and on
// what is hidden.
std::vector<Vec3f> surface_of(const Plane& plane, std::vector<Triangle>& triangles,
                              std::vector<std::uint8_t>& says) {
  std::vector<Vec3f> vertices;
  std::vector<int> front(plane.nodes.size(), -1);
  for (int y = 0; y < plane.rows; ++y)
    for (int x = 0; x < plane.columns; ++x) {
      if (!plane.body(x, y)) continue;
      const std::size_t i = plane.index(x, y);
      front[i] = int(vertices.size());
      vertices.push_back(plane.place(x, y) + Vec3f(0, 0, plane.half[i]));
      vertices.push_back(plane.place(x, y) - Vec3f(0, 0, plane.half[i]));
    }
  const auto quad = [&](int a, int b, int c, int d, bool told) {  // counter-clockwise from outside
    triangles.push_back({a, b, c}), triangles.push_back({a, c, d});
    says.insert(says.end(), 2, std::uint8_t(told));
  };
  const auto whole = [&](int x, int y) {
    return plane.body(x, y) && plane.body(x + 1, y) && plane.body(x, y + 1) && plane.body(x + 1, y + 1);
  };
  const auto at = [&](int x, int y) { return front[plane.index(x, y)]; };
  for (int y = 0; y + 1 < plane.rows; ++y)
    for (int x = 0; x + 1 < plane.columns; ++x) {
      if (!whole(x, y)) continue;
      const int a = at(x, y), b = at(x + 1, y), c = at(x + 1, y + 1), d = at(x, y + 1);
      const bool told = !plane.is(Node::hidden, x, y) && !plane.is(Node::hidden, x + 1, y) &&
                        !plane.is(Node::hidden, x, y + 1) && !plane.is(Node::hidden, x + 1, y + 1);
      quad(a, b, c, d, told);
      quad(b + 1, a + 1, d + 1, c + 1, told);
      if (!whole(x - 1, y)) quad(a + 1, a, d, d + 1, told);
      if (!whole(x + 1, y)) quad(b, b + 1, c + 1, c, told);
      if (!whole(x, y - 1)) quad(a + 1, b + 1, b, a, false);
      // At the shoulders it is the outline, at the upper end where the neck goes on.
      if (!whole(x, y + 1)) quad(d, c, c + 1, d + 1, told && y + 2 < plane.rows);
    }
  return vertices;
}

}  // namespace

std::optional<ProxyBust> make_proxy_bust(const TrainingSet& set, const HeadShape& shape,
                                         const ProxyPart& head) {
  if (!set.has_torso) return std::nullopt;
  ProxyBust bust;
  const HeadMarks marks = head_marks(set.model, shape);
  const float neck_from = marks.base + kAboveNeckBase;
  bust.axis_z = neck_axis(set.model, shape), bust.top = marks.chin + kBesideChin;
  Plane plane = outline(set, head, bust.axis_z, marks.base, bust.top);
  close_outline(plane);
  if (float(std::ranges::count(plane.nodes, Node::body)) < kFewestNodes) return std::nullopt;
  blow_up(plane, neck_from);
  const auto vertices =
      std::make_shared<const std::vector<Vec3f>>(surface_of(plane, bust.part.triangles, bust.says));
  bust.part.pose = [&set, vertices](const TrainingView& view) {
    const std::vector<float> moved = displacement_of(set, view);
    PosedSurface posed{*vertices, view.pose.world_from_torso};
    for (Vec3f& p : posed.vertices) p = posed_place(set, moved, p).cast<float>();
    return posed;
  };
  const auto before = [&](const TrainingView& view) { return see_proxy(head, view); };
  ViewColours seen = gather_colours(set, bust.part.triangles, bust.part.pose, kBustColourViews, before);
  std::vector<float> known(seen.weight.size());
  for (std::size_t v = 0; v < known.size(); ++v) known[v] = std::min(1.f, seen.weight[v] / kCertain);
  const std::vector<std::uint8_t> all(known.size(), 1);
  bust.part.colours = std::move(seen.colour);
  fill_mesh(vertex_neighbours(int(known.size()), bust.part.triangles), known, all, kBustRounds,
            bust.part.colours);
  const std::array<const ProxyPart*, 2> parts{&bust.part, &head};
  const auto above = [&](const TrainingView& view, double height) {
    return above_place(view, view.pose.world_from_torso, {0, height, bust.axis_z});
  };
  bust.unexplained = unexplained(
      set, parts, [&](const TrainingView& view) { return std::vector{other_half(above(view, bust.top))}; });
  bust.neck_unexplained = unexplained(set, std::span(parts).last(1), [&](const TrainingView& view) {
    return std::vector{above(view, neck_from), other_half(above(view, neck_from + kNeckBand))};
  });
  return bust;
}

}  // namespace likeness
