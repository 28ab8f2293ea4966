// See network_landmarks.h.
#include "core/face/network_landmarks.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/head/drawn_landmarks.h"

namespace likeness {
namespace {

// A landmark between up to three points of the network.
struct MeshMix {
  std::array<short, 3> point;
  std::array<float, 3> weight;  // sum 1
};

// The medians of eleven people's frontal faces, both halves alike, of where dlib's predictor draws a landmark
// among the network's points; lids and lips between two points of their own edge. From one person to the next
// the two differ by 0.01 of the distance between the outer corners of the eyes, along the jaw by 0.03. On the
// demo's people, who had no part in it, the result is closer to the true landmarks than dlib's is.
constexpr std::array<MeshMix, kLandmarkCount> kMixes{{
    // jaw line
    {{127, 0, 0}, {1, 0, 0}},
    {{234, 93, 0}, {0.78f, 0.22f, 0}},
    {{93, 132, 0}, {0.57f, 0.43f, 0}},
    {{132, 58, 0}, {0.45f, 0.55f, 0}},
    {{58, 172, 0}, {0.3f, 0.7f, 0}},
    {{136, 150, 0}, {0.91f, 0.09f, 0}},
    {{150, 149, 0}, {0.29f, 0.71f, 0}},
    {{176, 148, 0}, {0.48f, 0.52f, 0}},
    {{152, 0, 0}, {1, 0, 0}},
    {{400, 377, 0}, {0.48f, 0.52f, 0}},
    {{379, 378, 0}, {0.29f, 0.71f, 0}},
    {{365, 379, 0}, {0.91f, 0.09f, 0}},
    {{288, 397, 0}, {0.3f, 0.7f, 0}},
    {{361, 288, 0}, {0.45f, 0.55f, 0}},
    {{323, 361, 0}, {0.57f, 0.43f, 0}},
    {{454, 323, 0}, {0.78f, 0.22f, 0}},
    {{356, 0, 0}, {1, 0, 0}},
    // brows
    {{70, 66, 46}, {0.43f, -0.11f, 0.68f}},
    {{70, 105, 55}, {0.44f, 0.58f, -0.02f}},
    {{70, 105, 107}, {0.06f, 0.73f, 0.21f}},
    {{70, 107, 55}, {0.2f, 0.96f, -0.16f}},
    {{107, 52, 55}, {0.5f, -0.08f, 0.58f}},
    {{336, 282, 285}, {0.5f, -0.08f, 0.58f}},
    {{300, 336, 285}, {0.2f, 0.96f, -0.16f}},
    {{300, 334, 336}, {0.06f, 0.73f, 0.21f}},
    {{300, 334, 285}, {0.44f, 0.58f, -0.02f}},
    {{300, 296, 276}, {0.43f, -0.11f, 0.68f}},
    // nose
    {{168, 6, 0}, {0.62f, 0.38f, 0}},
    {{197, 0, 0}, {1, 0, 0}},
    {{195, 5, 0}, {0.3f, 0.7f, 0}},
    {{4, 1, 0}, {0.8f, 0.2f, 0}},
    {{240, 98, 99}, {0.21f, 0.51f, 0.28f}},
    {{97, 167, 141}, {0.94f, 0.04f, 0.02f}},
    {{2, 0, 0}, {1, 0, 0}},
    {{326, 393, 370}, {0.94f, 0.04f, 0.02f}},
    {{460, 327, 328}, {0.21f, 0.51f, 0.28f}},
    // eyes
    {{33, 133, 0}, {0.92f, 0.08f, 0}},
    {{160, 159, 0}, {0.49f, 0.51f, 0}},
    {{158, 157, 0}, {0.69f, 0.31f, 0}},
    {{133, 33, 0}, {0.97f, 0.03f, 0}},
    {{145, 153, 0}, {0.09f, 0.91f, 0}},
    {{144, 145, 0}, {0.81f, 0.19f, 0}},
    {{362, 263, 0}, {0.97f, 0.03f, 0}},
    {{385, 384, 0}, {0.69f, 0.31f, 0}},
    {{387, 386, 0}, {0.49f, 0.51f, 0}},
    {{263, 362, 0}, {0.92f, 0.08f, 0}},
    {{373, 374, 0}, {0.81f, 0.19f, 0}},
    {{374, 380, 0}, {0.09f, 0.91f, 0}},
    // lips
    {{61, 0, 0}, {1, 0, 0}},
    {{40, 39, 0}, {0.39f, 0.61f, 0}},
    {{37, 0, 0}, {0.91f, 0.09f, 0}},
    {{0, 0, 0}, {1, 0, 0}},
    {{267, 0, 0}, {0.91f, 0.09f, 0}},
    {{270, 269, 0}, {0.39f, 0.61f, 0}},
    {{291, 0, 0}, {1, 0, 0}},
    {{321, 405, 0}, {0.4f, 0.6f, 0}},
    {{314, 17, 0}, {0.96f, 0.04f, 0}},
    {{17, 0, 0}, {1, 0, 0}},
    {{84, 17, 0}, {0.96f, 0.04f, 0}},
    {{91, 181, 0}, {0.4f, 0.6f, 0}},
    {{78, 0, 0}, {1, 0, 0}},
    {{81, 82, 0}, {0.2f, 0.8f, 0}},
    {{13, 0, 0}, {1, 0, 0}},
    {{311, 312, 0}, {0.2f, 0.8f, 0}},
    {{308, 0, 0}, {1, 0, 0}},
    {{402, 317, 0}, {0.15f, 0.85f, 0}},
    {{14, 0, 0}, {1, 0, 0}},
    {{178, 87, 0}, {0.15f, 0.85f, 0}},
}};

// The lids' landmarks between two points of their margins, measured in the same way.
struct LidMix {
  int right, left;  // landmarks
  int from, to;     // points of the margins
  double share;     // of `to`
};
constexpr LidMix kLidMixes[] = {
    {37, 44, 13, 12, 0.22}, {38, 43, 11, 10, 0.05}, {40, 47, 2, 1, 0.12}, {41, 46, 5, 4, 0.85}};

constexpr int kJawLine = 17, kLips = 48;  // landmarks before the one, from the other on
// Usual errors, in distances between the outer corners of the eyes. The network draws the edge of the face
// where it is on the head, dlib where it is seen. It trembles by less than these: they are what it is off by
// all through a clip, which the pictures' own points have to be able to overrule. How far lips are apart it
// knows better than where they are.
constexpr double kInnerError = 0.02, kLipError = 0.006, kLidError = 0.01, kJawError = 0.03;
constexpr double kShutGap = 0.03;  // the same unit
constexpr double kAgree = 0.03;    // the same unit: looks nearer to their mean than this agree
constexpr double kRegionSide = 1.52, kRegionRaise = 0.02;  // in sides of the face's box
constexpr int kRunsPerLook = 8, kMostLooks = 4;

using Points = std::array<Vec2d, kLandmarkCount>;

Image8 mirrored(const Image8& picture) {
  Image8 result(picture.width, picture.height, picture.channels);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      std::copy_n(picture.at(x, y), picture.channels, result.at(picture.width - 1 - x, y));
  return result;
}

// The part of a picture that looks near a region need, so that no whole picture is mirrored.
struct Cut {
  Image8 picture;
  Vec2d corner = Vec2d::Zero();  // px of the whole picture
};
Cut cut_round(const Image8& picture, const MeshRegion& region) {
  const double reach = 0.85 * region.side;
  const int x0 = std::clamp(int(region.centre.x() - reach), 0, picture.width - 1),
            y0 = std::clamp(int(region.centre.y() - reach), 0, picture.height - 1),
            x1 = std::clamp(int(region.centre.x() + reach), x0 + 1, picture.width),
            y1 = std::clamp(int(region.centre.y() + reach), y0 + 1, picture.height);
  return {crop(picture, x0, y0, x1 - x0, y1 - y0), Vec2d(x0, y0)};
}

// The region a little larger and smaller, moved to and fro: what differs between looks is the network's
// noise.
MeshRegion shaken(MeshRegion region, int look) {
  constexpr double kScale[kMostLooks] = {1, 1, 1.05, 0.95}, kShift[kMostLooks] = {0, 0, 0.015, -0.015};
  region.side *= kScale[look];
  region.centre += Vec2d::Constant(kShift[look] * region.side);
  return region;
}

// A further look: at the mirrored picture, every second time.
std::optional<Points> further_look(const FaceNetwork& network, const Image8& part, const Image8& mirror,
                                   MeshRegion region, int look) {
  region = shaken(region, look);
  if (look % 2 == 0) {
    const auto mesh = network.look(part, region);
    return mesh ? std::optional(ibug_points(mesh->points)) : std::nullopt;
  }
  region.centre.x() = mirror.width - region.centre.x();
  region.roll = -region.roll;
  const auto mesh = network.look(mirror, region);
  if (!mesh) return std::nullopt;
  const Points seen = ibug_points(mesh->points);
  Points points;
  for (int k = 0; k < kLandmarkCount; ++k) {
    points[k] = seen[mirrored_landmark(k)];
    points[k].x() = mirror.width - points[k].x();
  }
  return points;
}

double inner_distance(const Points& a, const Points& b) {
  double sum = 0;
  for (int k = kJawLine; k < kLandmarkCount; ++k) sum += (a[k] - b[k]).norm();
  return sum / (kLandmarkCount - kJawLine);
}

Landmarks mean_of(const std::vector<Points>& looks, double presence) {
  Landmarks found;
  found.runs = int(looks.size());
  for (int k = 0; k < kLandmarkCount; ++k) {
    found.points[k] = Vec2d::Zero();
    for (const Points& look : looks) found.points[k] += look[k] / double(looks.size());
  }
  const Points drawn = found.points;
  close_shut_lips(found.points);
  const double eyes = (drawn[45] - drawn[36]).norm();
  for (int k = 0; k < kLandmarkCount; ++k) {
    double apart = 0;
    for (const Points& look : looks) apart += (look[k] - drawn[k]).squaredNorm() / double(looks.size());
    const double usual = k < kJawLine ? kJawError : k < kLips ? kInnerError : kLipError;
    found.spread[k] = std::hypot(usual * eyes, std::sqrt(apart));
  }
  const auto agree = std::ranges::count_if(
      looks, [&](const Points& look) { return inner_distance(look, drawn) < kAgree * eyes; });
  found.cluster_share = presence * double(agree) / double(looks.size());
  return found;
}

void take_lids(const LidMargins& margins, Landmarks& found) {
  const double eyes = (found.points[45] - found.points[36]).norm();
  for (const LidMix& mix : kLidMixes)
    for (const int side : {0, 1}) {
      const auto& margin = margins[side];
      const int landmark = side == 0 ? mix.right : mix.left;
      found.points[landmark] = (1 - mix.share) * margin[mix.from] + mix.share * margin[mix.to];
      found.spread[landmark] = kLidError * eyes;
    }
}

}  // namespace

std::array<Vec2d, kLandmarkCount> ibug_points(const std::array<Vec2d, kMeshCount>& mesh) {
  Points points;
  for (int k = 0; k < kLandmarkCount; ++k) {
    points[k] = Vec2d::Zero();
    for (int j = 0; j < 3; ++j) points[k] += double(kMixes[k].weight[j]) * mesh[kMixes[k].point[j]];
  }
  return points;
}

void close_shut_lips(std::array<Vec2d, kLandmarkCount>& points) {
  const double eyes = (points[45] - points[36]).norm();
  for (const auto& [upper, lower] : {std::array{61, 67}, std::array{62, 66}, std::array{63, 65}}) {
    const Vec2d apart = points[lower] - points[upper];
    const double gap = apart.norm() / std::max(1e-9, kShutGap * eyes);
    const Vec2d taken = 0.5 * std::exp(-gap * gap) * apart;  // grows less than the gap: what opens, opens
    points[upper] += taken, points[lower] -= taken;
  }
}

FaceBox box_round(const std::array<Vec2d, kLandmarkCount>& points) {
  Vec2d low = Vec2d::Constant(1e9), high = Vec2d::Constant(-1e9);
  for (int k = kJawLine; k < kLandmarkCount; ++k)
    low = low.cwiseMin(points[k]), high = high.cwiseMax(points[k]);
  // dlib's boxes reach from above the brows to the chin, about 1.5 times as wide as brows and mouth.
  const double side = 1.45 * std::max(high.x() - low.x(), 0.95 * (high.y() - low.y()));
  const Vec2d centre = 0.5 * (low + high) + Vec2d(0, 0.02 * side);
  return {centre.x() - 0.5 * side, centre.y() - 0.5 * side, side, side, 0};
}

MeshRegion region_of(const FaceBox& box, double roll) {
  const double side = std::max(box.width, box.height);
  const Vec2d up(std::sin(roll), -std::cos(roll));
  return {Vec2d(box.x + 0.5 * box.width, box.y + 0.5 * box.height) + kRegionRaise * side * up,
          kRegionSide * side, roll};
}

std::vector<FaceBox> network_faces(const FaceNetwork& network, const Image8& picture, const FaceBox* before) {
  std::vector<FaceMesh> faces;
  if (before)
    if (auto mesh = network.settle(picture, region_of(*before))) {
      const FaceBox box = box_round(ibug_points(mesh->points));
      if (overlap(box, *before) > 0) faces.push_back(std::move(*mesh));
    }
  if (faces.empty()) faces = network.find(picture);
  std::vector<FaceBox> boxes;
  for (const FaceMesh& mesh : faces) {
    boxes.push_back(box_round(ibug_points(mesh.points)));
    boxes.back().score = 2 * mesh.presence - 1;
  }
  return boxes;
}

Landmarks network_landmarks(const FaceNetwork& network, const Image8& picture, const FaceBox& box,
                            const LandmarkHint* hint, const LandmarkEffort& effort) {
  double roll = 0;
  if (hint) {
    const Vec2d eyes = hint->points[45] - hint->points[36];
    roll = std::atan2(eyes.y(), eyes.x());
  }
  const MeshRegion start = region_of(hint ? box_round(hint->points) : box, roll);
  auto first = network.settle(picture, start);
  if (!first)
    first = network.look(picture, start);  // what it draws where it sees no face: nobody agrees with it
  if (!first) {                            // beside the picture
    Landmarks nothing;
    nothing.points.fill(start.centre);
    nothing.spread.fill(start.side);
    return nothing;
  }
  std::vector<Points> looks{ibug_points(first->points)};
  const int wanted = std::clamp(effort.most / kRunsPerLook, 1, kMostLooks);
  if (wanted > 1) {
    const MeshRegion region = region_round(first->points);
    const Cut part = cut_round(picture, region);
    const Image8 mirror = mirrored(part.picture);
    MeshRegion in_part = region;
    in_part.centre -= part.corner;
    for (int look = 1; look < wanted; ++look)
      if (auto points = further_look(network, part.picture, mirror, in_part, look)) {
        for (Vec2d& p : *points) p += part.corner;
        looks.push_back(*points);
      }
  }
  Landmarks found = mean_of(looks, first->presence);
  if (const auto margins = network.lids(picture, first->points)) take_lids(*margins, found);
  return found;
}

}  // namespace likeness
