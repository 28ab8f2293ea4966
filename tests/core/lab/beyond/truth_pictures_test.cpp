// Claims about pictures that the demo's film does not hold: they are as the film would have shown them.
#include "core/lab/beyond/truth_pictures.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <numbers>

#include "core/base/rigid.h"
#include "core/head/builtin_head.h"
#include "core/image/files.h"
#include "core/scene/mesh_scene.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

struct PictureFolder {
  fs::path path = fs::temp_directory_path() / ("likeness_truth_pictures_" + std::to_string(::getpid()));
  PictureFolder() { fs::remove_all(path); }
  ~PictureFolder() { fs::remove_all(path); }
};

DemoOptions small_film() {
  DemoOptions film;
  film.width = film.height = 96;
  film.frames = 40;
  film.samples_per_pixel = 1;
  film.camera = DemoCamera::resting;
  return film;
}

Capture small_capture() {
  Capture capture;
  capture.width = capture.height = 96;
  capture.crop = {8, 6, 84}, capture.size = 64;
  return capture;
}

// Of the film, as far as pictures need it.
TrackTruth truth_of(DemoStage& stage) {
  TrackTruth truth;
  truth.model = stage.model();
  truth.track.person = stage.person_shape();
  return truth;
}

// A stage that films, and a camera for what it does not.
struct Studio {
  DemoStage stage{make_builtin_head(), small_film()};
  TrackTruth truth = truth_of(stage);
  Capture capture = small_capture();
  TruthCamera camera{small_film(), truth, capture, {}};
};

Studio& studio() {
  static Studio shared;
  return shared;
}

Image8 as_imported(const Capture& capture, const Image8& whole) {
  const SquareCrop& c = capture.crop;
  return resize(crop(whole, c.x, c.y, c.side, c.side), capture.size, capture.size);
}

int pixels_in(const Image8& mask) { return int(std::ranges::count(mask.data, 255)); }

// Mean column of the mask's pixels.
double middle_column(const Image8& mask) {
  double sum = 0;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) sum += *mask.at(x, y) != 0 ? x + 0.5 : 0;
  return sum / pixels_in(mask);
}

bool within(const Image8& inner, const Image8& outer) {
  for (std::size_t i = 0; i < inner.data.size(); ++i)
    if (inner.data[i] != 0 && outer.data[i] == 0) return false;
  return true;
}

Vec2d seen_at(const TruthPicture& picture, const Capture& capture, const Vec3f& in_head) {
  const SquareCrop& c = capture.crop;
  const Intrinsics k = crop_intrinsics(picture.shot.camera.intrinsics, c.x, c.y, c.side, capture.size);
  return project<double>(
      k, Vec3d(picture.shot.camera.cam_from_world * picture.shot.world_from_head * in_head.cast<double>()));
}

TEST(TruthCamera, OfAFrameTakesItsPictureAsAProjectCropsIt) {
  Studio& s = studio();
  for (const int frame : {12, 30}) {
    const auto picture = s.camera.take("frame", s.camera.of_frame(frame), {});
    ASSERT_TRUE(picture.ok()) << picture.error().what;
    const Shot shot = s.stage.shot(frame);
    EXPECT_EQ(picture->rgb.data, as_imported(s.capture, s.stage.film(shot, {}).rgb).data);
    EXPECT_EQ(picture->room.data, as_imported(s.capture, *s.stage.film_room(shot.camera, {})).data);
  }
}

TEST(TruthCamera, RegionsLieWithinEachOtherAndTheForeheadAboveTheBrows) {
  Studio& s = studio();
  const auto picture = s.camera.take("rest", s.camera.at_rest(), {});
  ASSERT_TRUE(picture.ok()) << picture.error().what;
  EXPECT_GT(pixels_in(picture->forehead), 20);
  EXPECT_GT(pixels_in(picture->skin), 4 * pixels_in(picture->forehead));
  EXPECT_TRUE(within(picture->forehead, picture->skin));
  EXPECT_TRUE(within(picture->skin, picture->regions.person));
  EXPECT_TRUE(within(picture->skin, picture->regions.face));
  EXPECT_TRUE(within(picture->regions.face, picture->regions.head));
  EXPECT_LT(pixels_in(picture->regions.head), 0.8 * pixels_in(picture->regions.person));
  const auto landmarks = landmark_positions(s.stage.model(), s.stage.shape().vertices);
  double brows = s.capture.size;
  for (std::size_t i = 17; i <= 26; ++i)
    brows = std::min(brows, seen_at(*picture, s.capture, landmarks[i]).y());
  for (int y = int(brows) + 1; y < s.capture.size; ++y)
    for (int x = 0; x < s.capture.size; ++x) ASSERT_EQ(*picture->forehead.at(x, y), 0) << x << ' ' << y;
}

TEST(TruthCamera, SeesMoreOfTheLeftCheekFromThePersonsLeft) {
  Studio& s = studio();
  const Shot rest = s.camera.at_rest();
  const auto front = s.camera.take("front", rest, {}),
             left = s.camera.take("left", s.camera.seen_from(rest, 30, 0), {}),
             right = s.camera.take("right", s.camera.seen_from(rest, -30, 0), {});
  ASSERT_TRUE(front.ok() && left.ok() && right.ok());
  // The person looks at the camera of the film: to the right of the picture is their left.
  const double moved = 0.025 * s.capture.size;
  EXPECT_LT(middle_column(left->skin), middle_column(front->skin) - moved);
  EXPECT_GT(middle_column(right->skin), middle_column(front->skin) + moved);
  // The head itself keeps its place.
  EXPECT_NEAR(middle_column(left->regions.head), middle_column(right->regions.head), 2 * moved);
  EXPECT_NE(left->room.data, front->room.data);
}

TEST(TruthCamera, SeenFromAboveTheLensIsAboveAndAsFarAway) {
  Studio& s = studio();
  const Shot rest = s.camera.at_rest();
  const auto lens = [](const Shot& shot) {
    return Vec3d(inverse(shot.world_from_head) * inverse(shot.camera.cam_from_world).translation());
  };
  const Shot above = s.camera.seen_from(rest, 0, 25), aside = s.camera.seen_from(rest, 30, 0);
  EXPECT_GT(lens(above).y(), lens(rest).y() + 0.1);
  EXPECT_NEAR(lens(above).x(), lens(rest).x(), 1e-9);
  EXPECT_GT(lens(aside).x(), lens(rest).x() + 0.1);  // the subject's left
  EXPECT_NEAR(lens(aside).y(), lens(rest).y(), 1e-9);
  const auto angle = [&](const Shot& shot) {
    return rotation_angle(rest.camera.cam_from_world.linear().transpose() *
                          shot.camera.cam_from_world.linear()) *
           180 / std::numbers::pi;
  };
  EXPECT_NEAR(angle(above), 25, 1e-6);
  EXPECT_NEAR(angle(aside), 30, 1e-6);
}

TEST(TruthCamera, DepthIsTheDistanceToTheTrueSurface) {
  Studio& s = studio();
  const auto picture = s.camera.take("side", s.camera.seen_from(s.camera.at_rest(), 15, 0), {});
  ASSERT_TRUE(picture.ok()) << picture.error().what;
  const Camera& camera = picture->shot.camera;
  const SquareCrop& c = s.capture.crop;
  const Intrinsics k = crop_intrinsics(camera.intrinsics, c.x, c.y, c.side, s.capture.size);
  const MeshScene surface(s.stage.posed(picture->shot), s.stage.model().triangles);
  const Pose head_from_cam = inverse(camera.cam_from_world * picture->shot.world_from_head);
  int compared = 0;
  for (int y = 1; y < k.height; y += 3)
    for (int x = 1; x < k.width; x += 3) {
      const Vec3d ray = ray_direction(k, Vec2d(x + 0.5, y + 0.5)).normalized();
      const auto hit = surface.intersect(head_from_cam.translation().cast<float>(),
                                         (head_from_cam.linear() * ray).cast<float>());
      const float depth = picture->depth[std::size_t(y) * std::size_t(k.width) + std::size_t(x)];
      if (*picture->skin.at(x, y) == 0) continue;
      ASSERT_TRUE(hit) << x << ' ' << y;
      EXPECT_NEAR(depth, hit->distance, 1e-4) << x << ' ' << y;
      ++compared;
    }
  EXPECT_GT(compared, 20);
  EXPECT_EQ(picture->depth.front(), 0) << "the room's corner";
}

TEST(TruthCamera, KeptPicturesAreReadBackAndAnotherCropsAreNot) {
  const PictureFolder folder;
  Studio& s = studio();
  TruthCamera keeping(small_film(), s.truth, s.capture, folder.path / "truth");
  const Shot rest = keeping.at_rest();
  const auto taken = keeping.take("rest", rest, {});
  ASSERT_TRUE(taken.ok()) << taken.error().what;
  const auto again = keeping.take("rest", rest, {});
  ASSERT_TRUE(again.ok()) << again.error().what;
  EXPECT_EQ(again->rgb.data, taken->rgb.data);
  EXPECT_EQ(again->room.data, taken->room.data);
  EXPECT_EQ(again->depth, taken->depth);
  for (const auto region : {&Regions::person, &Regions::head, &Regions::face})
    EXPECT_EQ((again->regions.*region).data, (taken->regions.*region).data);
  EXPECT_EQ(again->skin.data, taken->skin.data);
  EXPECT_EQ(again->forehead.data, taken->forehead.data);

  // Nothing is filmed for it: what lies in the file is handed back.
  const Image8 painted(s.capture.size, s.capture.size, 3, 7);
  for (const auto& entry : fs::recursive_directory_iterator(folder.path)) {
    if (entry.path().filename() != "rest.png") continue;
    ASSERT_TRUE(write_image(entry.path(), painted).ok());
  }
  EXPECT_EQ(keeping.take("rest", rest, {})->rgb.data, painted.data);

  Capture larger = s.capture;
  larger.size = 80;
  TruthCamera other(small_film(), s.truth, larger, folder.path / "truth");
  const auto anew = other.take("rest", rest, {});
  ASSERT_TRUE(anew.ok()) << anew.error().what;
  EXPECT_EQ(anew->rgb.width, 80);
  EXPECT_EQ(anew->regions.face.width, 80);
}

TEST(TruthCamera, AStopLeavesNoPictures) {
  const PictureFolder folder;
  Studio& s = studio();
  TruthCamera keeping(small_film(), s.truth, s.capture, folder.path);
  std::stop_source source;
  source.request_stop();
  const auto stopped = keeping.take("rest", keeping.at_rest(), source.get_token());
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
  EXPECT_FALSE(fs::exists(folder.path));
}

}  // namespace
}  // namespace likeness
