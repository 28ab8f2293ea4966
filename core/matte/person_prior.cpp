// Head from the posed model; neck and torso from a cone of human proportions hung below it in the picture.
#include "core/matte/person_prior.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/scene/mesh_scene.h"

namespace likeness {
namespace {

// Half-widths of a torso at heights below the neck's base, m. Anthropometry: shoulders are 0.36 to 0.5 m
// wide.
struct TorsoRow {
  double below, half_width;
};
constexpr TorsoRow kCertainTorso[] = {{0.07, 0.045}, {0.11, 0.075}, {0.6, 0.075}};
constexpr TorsoRow kLikelyTorso[] = {{-0.05, 0.06}, {0.02, 0.07}, {0.06, 0.16}, {0.12, 0.21}, {0.6, 0.23}};
constexpr TorsoRow kPossibleTorso[] = {{-0.06, 0.1}, {0.0, 0.17}, {0.05, 0.26},
                                       {0.12, 0.3},  {0.3, 0.36}, {0.6, 0.42}};
constexpr double kErosion = 0.012;        // m by which the head's outline may lie inside the model's
constexpr double kSkullErosion = 0.004;   // m, the same of a skull above the brow, most of the time
constexpr double kSkullAboveBrow = 0.03;  // m
constexpr float kSkullPlace = 1.2f;       // evidence of the place there, beyond a head's usual surroundings
constexpr double kHairThickness = 0.03;   // m of hair that most heads have
constexpr double kHairMargin = 0.08;      // m around the bare head
constexpr double kLongHair = 0.2;         // m around the bare head
constexpr double kShoulderMargin = 0.05;  // m beyond a torso of usual width
constexpr double kSideMargin = 0.008;  // m by which the bare head's outline may be off beside face and neck

cv::Point to_pixel(const Vec2d& p) { return {int(std::lround(p.x())), int(std::lround(p.y()))}; }

template <std::size_t N>
void draw_torso(cv::Mat& mask, const PersonPlace& place, const TorsoRow (&rows)[N]) {
  std::vector<cv::Point> outline;
  const double scale = place.px_per_metre;
  for (const auto& row : rows)
    outline.push_back(to_pixel(place.neck + scale * Vec2d(-row.half_width, row.below)));
  const double bottom = std::max(mask.rows + 2.0, place.neck.y() + scale * rows[N - 1].below);
  outline.push_back(to_pixel({place.neck.x() - scale * rows[N - 1].half_width, bottom}));
  outline.push_back(to_pixel({place.neck.x() + scale * rows[N - 1].half_width, bottom}));
  for (std::size_t i = N; i-- > 0;)
    outline.push_back(to_pixel(place.neck + scale * Vec2d(rows[i].half_width, rows[i].below)));
  cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{outline}, 255);
}

cv::Mat disc(double radius) {
  const int r = std::max(1, int(std::lround(radius)));
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * r + 1, 2 * r + 1});
}

Pose metric(const Pose& cam_from_world, double metres_per_unit) {
  Pose pose = cam_from_world;
  pose.translation() *= metres_per_unit;
  return pose;
}

Vec2d mean_pixel(const std::array<Vec3f, kLandmarkCount>& landmarks, std::initializer_list<int> which,
                 const Pose& cam_from_head, const Intrinsics& k) {
  Vec3d sum = Vec3d::Zero();
  for (int i : which) sum += landmarks[std::size_t(i)].cast<double>() / double(which.size());
  return project<double>(k, cam_from_head * sum);
}

}  // namespace

PersonModel make_person_model(const HeadModel& model, const Track& track) {
  PersonModel person;
  person.model = &model;
  person.shape = shape_head(model, track.person);
  const HeadRegions regions = head_regions(model);
  person.head = region_triangles(model, regions.head);
  person.face = region_triangles(model, regions.face);
  const auto posed = pose_head(model, person.shape, neutral_articulation(model));
  person.head_low = Vec3d::Constant(1e9), person.head_high = -person.head_low;
  for (const Triangle& triangle : person.head)
    for (const auto corner : triangle) {
      const Vec3d at = posed[std::size_t(corner)].cast<double>();
      person.head_low = person.head_low.cwiseMin(at), person.head_high = person.head_high.cwiseMax(at);
    }
  const auto landmarks = landmark_positions(model, posed);
  person.neck_base = Vec3d(0, landmarks[8].y(), 0.5 * (landmarks[2].z() + landmarks[14].z()));
  return person;
}

std::optional<PersonPlace> place_person(const PersonModel& person, const TrackedFrame& tracked,
                                        const Camera& camera, const Intrinsics& picture,
                                        double metres_per_unit) {
  PersonPlace place;
  const Pose cam_from_world = metric(camera.cam_from_world, metres_per_unit);
  place.cam_from_head = cam_from_world * tracked.pose.world_from_head;
  const double depth = place.cam_from_head.translation().z();
  if (!(depth > 0.05)) return std::nullopt;
  place.px_per_metre = picture.fx / depth;
  place.vertices = pose_head(*person.model, person.shape, tracked.pose.articulation);
  const auto landmarks = landmark_positions(*person.model, place.vertices);
  place.jaw_corners = mean_pixel(landmarks, {3, 4, 12, 13}, place.cam_from_head, picture);
  place.brow = mean_pixel(landmarks, {21, 22, 0, 16}, place.cam_from_head, picture);
  const Vec3d up_in_cam = place.cam_from_head.linear() * Vec3d(0, 1, 0);
  place.up = up_in_cam.head<2>().norm() > 0.2 ? Vec2d(up_in_cam.head<2>().normalized()) : Vec2d(0, -1);
  const double side = std::max(picture.width, picture.height);
  if ((place.brow - Vec2d(picture.width / 2.0, picture.height / 2.0)).norm() > 1.5 * side)
    return std::nullopt;
  // The neck's base is fixed in the torso's frame or, if that is nowhere near, in the head's.
  const Vec3d on_head = place.cam_from_head * person.neck_base;
  place.cam_from_torso = cam_from_world * tracked.pose.world_from_torso;
  const Vec3d on_torso = place.cam_from_torso * person.neck_base;
  place.torso_known = (on_torso - on_head).norm() < 0.2;
  place.neck = project<double>(picture, place.torso_known ? on_torso : on_head);
  return place;
}

cv::Mat head_silhouette(const PersonModel& person, const PersonPlace& place, const Intrinsics& picture,
                        bool face_only) {
  Image8 seen;
  if (!face_only) {
    seen = silhouette(place.vertices, person.head, picture, place.cam_from_head);
  } else {
    // Only what is not hidden behind the head: a face turned away shows its near half.
    const auto front = rasterise_triangles(place.vertices, person.face, picture, place.cam_from_head);
    seen = Image8(picture.width, picture.height, 1);
    for (std::size_t i = 0; i < front.size(); ++i) seen.data[i] = front[i] >= 0 ? 255 : 0;
  }
  return cv::Mat(picture.height, picture.width, CV_8U, seen.data.data()).clone();
}

PersonPrior person_prior(const PersonModel& person, const PersonPlace& place, const Intrinsics& picture) {
  PersonPrior prior;
  const double scale = place.px_per_metre;
  const cv::Mat head = head_silhouette(person, place, picture, false);
  cv::erode(head, prior.certain, disc(kErosion * scale));
  cv::Mat skull;
  cv::erode(head, skull, disc(kSkullErosion * scale));
  draw_torso(prior.certain, place, kCertainTorso);
  const Vec2d middle = 0.5 * (place.jaw_corners + place.neck);
  cv::line(prior.certain, to_pixel(middle), to_pixel(place.neck + Vec2d(0, 0.1 * scale)), 255,
           std::max(1, int(0.07 * scale)));

  cv::dilate(head, prior.likely, disc(0.7 * kHairThickness * scale));
  cv::Mat close;
  cv::dilate(head, close, disc(kSideMargin * scale));
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      if ((Vec2d(x + 0.5, y + 0.5) - place.brow).dot(place.up) < 0)
        prior.likely.at<unsigned char>(y, x) = close.at<unsigned char>(y, x);
  draw_torso(prior.likely, place, kLikelyTorso);
  prior.below = cv::Mat(picture.height, picture.width, CV_8U, cv::Scalar(0));
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      if ((Vec2d(x + 0.5, y + 0.5) - place.neck).dot(place.up) < -0.01 * scale &&
          !head.at<unsigned char>(y, x))
        prior.below.at<unsigned char>(y, x) = 255;
  cv::Mat from_head;
  cv::distanceTransform(255 - head, from_head, cv::DIST_L2, 3);
  prior.hair = from_head < kLongHair * scale;
  prior.possible = prior.likely.clone();
  cv::dilate(prior.possible, prior.possible, disc(0.5 * kHairMargin * scale));
  cv::dilate(head, head, disc(kHairMargin * scale));
  prior.possible |= head;
  draw_torso(prior.possible, place, kPossibleTorso);

  cv::Mat distance;
  cv::distanceTransform(255 - prior.likely, distance, cv::DIST_L2, 3);
  const float slope = float(2.2 / (kHairMargin * scale));
  prior.location = 0.8f - distance * slope;
  // Hair before a wall of its colour: what covers the skull is the person's unless the colours strongly
  // disagree. But the wall above a skull lower than the model's must not be taken.
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      if (skull.at<unsigned char>(y, x) &&
          (Vec2d(x + 0.5, y + 0.5) - place.brow).dot(place.up) > kSkullAboveBrow * scale)
        prior.location.at<float>(y, x) += kSkullPlace;
  // Shoulders vary more than heads: there the place says less, and even less far out.
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      if (prior.below.at<unsigned char>(y, x) && !prior.certain.at<unsigned char>(y, x)) {
        const float away = distance.at<float>(y, x);
        prior.location.at<float>(y, x) = 0.2f - 2 * slope * away;
        if (away > kShoulderMargin * scale) prior.possible.at<unsigned char>(y, x) = 0;
      }
  prior.location = cv::max(prior.location, -1.5f);
  return prior;
}

}  // namespace likeness
