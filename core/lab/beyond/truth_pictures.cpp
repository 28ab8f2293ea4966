// Filmed at the film's own size, so that hair and pores are as fine as in it, then cropped as a project does.
#include "core/lab/beyond/truth_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <opencv2/core.hpp>

#include "core/base/files.h"
#include "core/base/rigid.h"
#include "core/image/files.h"
#include "core/matte/person_prior.h"
#include "core/matte/regions.h"
#include "core/project/project_views.h"
#include "core/scene/mesh_scene.h"
#include "core/synth/body_pose.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr double kRadians = std::numbers::pi / 180;
constexpr float kAboveBrows = 0.008f;  // m that the forehead begins above the brows

cv::Mat as_matrix(Image8& mask) { return {mask.height, mask.width, CV_8U, mask.data.data()}; }

Image8 as_mask(const cv::Mat& from) {
  Image8 mask(from.cols, from.rows, 1);
  for (int y = 0; y < from.rows; ++y)
    for (int x = 0; x < from.cols; ++x) *mask.at(x, y) = from.at<unsigned char>(y, x) > 127 ? 255 : 0;
  return mask;
}

// Where pictures of this crop and size are kept: of another one they would be other pictures.
fs::path folder_of_crop(const fs::path& folder, const Capture& capture) {
  const SquareCrop& c = capture.crop;
  return folder.empty() ? folder : folder / fmt::format("{}_{}_{}_{}px", c.x, c.y, c.side, capture.size);
}

Image8 as_pictures_are(const Capture& capture, const Image8& whole) {
  const SquareCrop& c = capture.crop;
  return resize(crop(whole, c.x, c.y, c.side, c.side), capture.size, capture.size);
}

}  // namespace

TruthCamera::TruthCamera(const DemoOptions& film, const TrackTruth& truth, const Capture& capture,
                         const fs::path& folder)
    : stage_(truth.model, film),
      capture_(capture),
      person_(std::make_unique<PersonModel>(make_person_model(stage_.model(), truth.track))),
      folder_(folder_of_crop(folder, capture)) {
  const HeadRegions regions = head_regions(stage_.model());
  face_skin_.resize(regions.face.size());
  for (std::size_t f = 0; f < face_skin_.size(); ++f)
    face_skin_[f] = regions.face[f] && regions.skin[f] && !regions.eyes[f] && !regions.mouth_interior[f];
  const auto landmarks = landmark_positions(stage_.model(), stage_.shape().vertices);
  for (int i = 17; i <= 26; ++i) brow_line_ = std::max(brow_line_, landmarks[std::size_t(i)].y());
  brow_line_ += kAboveBrows;
}

TruthCamera::~TruthCamera() = default;

Shot TruthCamera::at_rest() const {
  Shot shot = stage_.shot(0);
  Articulation rest = neutral_articulation(stage_.model());
  rest.left_eye = shot.articulation.left_eye, rest.right_eye = shot.articulation.right_eye;
  shot.articulation = rest;
  return shot;
}

Shot TruthCamera::seen_from(Shot shot, double yaw_deg, double pitch_deg) const {
  const Vec3d centre = shot.world_from_head * (0.5 * (person_->head_low + person_->head_high));
  Pose turn = Pose::Identity();
  turn.linear() = shot.world_from_head.linear() * head_turn(yaw_deg * kRadians, -pitch_deg * kRadians, 0) *
                  shot.world_from_head.linear().transpose();
  turn.translation() = centre - turn.linear() * centre;
  shot.camera.cam_from_world = shot.camera.cam_from_world * inverse(turn);
  return shot;
}

Result<Image8> TruthCamera::kept(const std::string& name, int channels) const {
  if (folder_.empty() || !path_exists(folder_ / name))
    return Error{ErrorCode::not_found, "Not kept.", "", ""};
  return read_own_picture(folder_, name, capture_.size, channels);
}

Result<TruthPicture> TruthCamera::take(const std::string& name, const Shot& shot, std::stop_token stop) {
  auto rgb = kept(name + ".png", 3), mask = kept(name + ".mask.png", 1), room = kept(name + ".room.png", 3);
  if (!rgb || !mask || !room) {
    const DemoFrame taken = stage_.film(shot, stop);
    const auto behind = stage_.film_room(shot.camera, stop);
    if (!taken.complete || !behind) return cancelled_error();
    rgb = as_pictures_are(capture_, taken.rgb), mask = as_pictures_are(capture_, taken.mask);
    room = as_pictures_are(capture_, *behind);
    if (!folder_.empty())
      for (const auto& [end, picture] :
           {std::pair(".png", &*rgb), std::pair(".mask.png", &*mask), std::pair(".room.png", &*room)})
        if (const auto written = write_image(folder_ / (name + end), *picture); !written)
          return written.error();
  }
  TruthPicture picture{shot, std::move(*rgb), std::move(*room), {}, {}, {}, {}};
  const Intrinsics k = crop_intrinsics(shot.camera.intrinsics, capture_.crop.x, capture_.crop.y,
                                       capture_.crop.side, capture_.size);
  const Pose cam_from_head = shot.camera.cam_from_world * shot.world_from_head;

  // -- The head's surface in the picture
  const auto& triangles = stage_.model().triangles;
  const std::vector<Vec3f> posed = stage_.posed(shot);
  const std::vector<Vec3f>& resting = stage_.shape().vertices;
  const Raster raster = rasterise(posed, triangles, k, cam_from_head);
  picture.skin = Image8(k.width, k.height, 1), picture.forehead = picture.skin;
  picture.depth.assign(raster.triangle.size(), 0.f);
  for (std::size_t i = 0; i < raster.triangle.size(); ++i) {
    if (raster.triangle[i] < 0) continue;
    const Vec2d pixel(double(i % std::size_t(k.width)) + 0.5, double(i / std::size_t(k.width)) + 0.5);
    picture.depth[i] = raster.depth[i] * float(ray_direction(k, pixel).norm());
    const auto t = std::size_t(raster.triangle[i]);
    if (!face_skin_[t] || mask->data[i] < 128) continue;
    picture.skin.data[i] = 255;
    float height = 0;
    for (int c = 0; c < 3; ++c)
      height += raster.barycentric[i][c] * resting[std::size_t(triangles[t][c])].y();
    if (height > brow_line_) picture.forehead.data[i] = 255;
  }

  // -- Person, head and face, as a project's regions are drawn, the head without their margin
  TrackedFrame tracked;
  tracked.pose.world_from_head = shot.world_from_head, tracked.pose.world_from_torso = shot.world_from_torso;
  tracked.pose.articulation = shot.articulation;
  const auto place = place_person(*person_, tracked, shot.camera, k, 1);
  if (!place)
    return Error{ErrorCode::failed, "The head is not in the picture that was to be taken of it.", "", name};
  picture.regions.person = as_mask(as_matrix(*mask));
  picture.regions.head = as_mask(head_with_hair(as_matrix(picture.regions.person), *person_, *place, k));
  picture.regions.face = as_mask(head_silhouette(*person_, *place, k, true));
  return picture;
}

}  // namespace likeness
