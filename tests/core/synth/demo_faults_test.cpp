// Claims about the pictures of films with a phone's faults, and that their truth agrees with them.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "core/base/rigid.h"
#include "core/head/builtin_head.h"
#include "core/image/files.h"
#include "core/scene/mesh_scene.h"
#include "core/synth/demo_camera.h"
#include "core/synth/demo_capture.h"
#include "core/synth/demo_stage.h"
#include "core/synth/demo_truth.h"
#include "core/synth/drift.h"
#include "core/synth/garment.h"
#include "core/synth/hair.h"
#include "core/video/decode.h"
#include "core/video/lens_tag.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

const HeadModel& demo_head() {
  static const HeadModel model = make_builtin_head();
  return model;
}

DemoOptions small_film(int size, int frames = 60) {
  DemoOptions options;
  options.width = options.height = size;
  options.frames = frames;
  options.samples_per_pixel = 1;
  options.camera = DemoCamera::resting;
  return options;
}

double grey_at(const Image8& picture, double x, double y) {
  const int i = std::clamp(int(x - 0.5), 0, picture.width - 2),
            j = std::clamp(int(y - 0.5), 0, picture.height - 2);
  const double a = std::clamp(x - 0.5 - i, 0.0, 1.0), b = std::clamp(y - 0.5 - j, 0.0, 1.0);
  const auto grey = [&](int u, int v) {
    const std::uint8_t* p = picture.at(u, v);
    return (p[0] + 2.0 * p[1] + p[2]) / 4;
  };
  return (grey(i, j) * (1 - a) + grey(i + 1, j) * a) * (1 - b) +
         (grey(i, j + 1) * (1 - a) + grey(i + 1, j + 1) * a) * b;
}

// Mean difference of grey values between two rooms, when the second is looked up where `to` has what `from`
// shows far away, or at the same pixel.
struct Agreement {
  double by_truth = 0, in_place = 0;
};
Agreement room_agrees(const Image8& a, const Camera& from, const Image8& b, const Camera& to) {
  Agreement sum;
  int count = 0;
  for (int y = 2; y < a.height - 2; ++y)
    for (int x = 2; x < a.width - 2; ++x) {
      const Vec2d pixel(x + 0.5, y + 0.5);
      const Vec3d direction = to.cam_from_world.linear() * from.cam_from_world.linear().transpose() *
                              ray_direction(from.intrinsics, pixel);
      const Vec2d at = project<double>(to.intrinsics, direction);
      if (at.x() < 2 || at.y() < 2 || at.x() > b.width - 2 || at.y() > b.height - 2) continue;
      sum.by_truth += std::abs(grey_at(a, pixel.x(), pixel.y()) - grey_at(b, at.x(), at.y()));
      sum.in_place += std::abs(grey_at(a, pixel.x(), pixel.y()) - grey_at(b, pixel.x(), pixel.y()));
      ++count;
    }
  sum.by_truth /= count, sum.in_place /= count;
  return sum;
}

TEST(DemoFaults, TheTrueCamerasMapOneRoomOntoTheOther) {
  for (const DemoCamera kind : {DemoCamera::handheld, DemoCamera::zoom, DemoCamera::slide}) {
    DemoOptions options = small_film(160);
    options.camera = kind;
    options.hand_shift_m = 0;
    options.hand_turn_deg = 6;
    DemoStage stage(demo_head(), options);
    const auto a = stage.film_room(12, {}), b = stage.film_room(40, {});
    ASSERT_TRUE(a && b);
    const Agreement agreement = room_agrees(*a, stage.shot(12).camera, *b, stage.shot(40).camera);
    EXPECT_LT(agreement.by_truth, 0.45 * agreement.in_place) << demo_camera_names()[std::size_t(kind)];
  }
}

// The filmed picture is the room wherever the mask says that nobody is.
TEST(DemoFaults, TheRoomsTruthIsThePictureBesideThePerson) {
  DemoOptions options = small_film(128);
  options.samples_per_pixel = 8;
  options.camera = DemoCamera::handheld;
  options.drift = true;
  DemoStage stage(demo_head(), options);
  const DemoFrame picture = stage.film(30, {});
  const auto room = stage.film_room(30, {});
  ASSERT_TRUE(room.has_value());
  double sum = 0, behind = 0;
  int count = 0, hidden = 0;
  for (std::size_t i = 0; i < picture.mask.pixels(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const double difference = std::abs(int(picture.rgb.data[3 * i + c]) - int(room->data[3 * i + c]));
      if (picture.mask.data[i] == 0) sum += difference, ++count;
      if (picture.mask.data[i] == 255) behind += difference, ++hidden;
    }
  EXPECT_LT(sum / count, 3);
  EXPECT_GT(behind / hidden, 20);
}

// Width of the person in the picture, m, at the height of the mouth; widest over some rows.
double width_at_mouth(const DemoStage& stage, const DemoFrame& picture, const Shot& shot) {
  const auto l = landmark_positions(stage.model(), stage.posed(shot));
  const Vec3d mouth = shot.camera.cam_from_world * shot.world_from_head * l[66].cast<double>();
  const int y = int(project<double>(shot.camera.intrinsics, mouth).y());
  int covered = 0;
  for (int x = 0; x < picture.mask.width; ++x) covered += *picture.mask.at(x, y) > 127;
  return covered * mouth.z() / shot.camera.intrinsics.fx;
}

TEST(DemoFaults, LooseHairIsWiderThanTheHeadByEightCentimetresAndInTheMask) {
  for (const int person : {0, 3}) {
    DemoOptions options = small_film(160);
    options.person = person;
    DemoStage own(demo_head(), options);
    options.hair = DemoHair::loose;
    DemoStage loose(demo_head(), options);
    const DemoFrame a = own.film(1, {}), b = loose.film(1, {});
    const auto l = landmark_positions(own.model(), own.posed(own.shot(1)));
    const double head = double(l[16].x() - l[0].x());
    EXPECT_GT(width_at_mouth(loose, b, loose.shot(1)), head + 0.08) << person;
    EXPECT_GT(width_at_mouth(loose, b, loose.shot(1)), width_at_mouth(own, a, own.shot(1)) + 0.04) << person;
    // On the chest, where own hair ends, the cloth of the one is covered by hair of the other.
    int covered = 0;
    for (std::size_t i = 0; i < a.mask.pixels(); ++i) {
      const double difference = std::abs(int(a.rgb.data[3 * i + 1]) - int(b.rgb.data[3 * i + 1]));
      const bool chest = i / 160 > 128;
      covered += chest && a.mask.data[i] == 255 && difference > 25;
    }
    EXPECT_GT(covered, 150) << person;
  }
}

// What loose hair is made of, without a picture: roots with the head, ends with the torso, nothing in the
// cloth.
TEST(DemoFaults, LooseHairFollowsTheHeadAboveAndLiesOnTheTorsoBelow) {
  const HeadModel& model = demo_head();
  const HeadShape shape = shape_head(model, Eigen::VectorXf::Zero(model.identity_count()));
  std::vector<Triangle> skull;
  std::vector<Vec3f> skin;
  for (const Triangle& t : model.triangles) {
    const HeadPart part = model.parts[std::size_t(t[0])];
    if (part == HeadPart::face || part == HeadPart::scalp_neck || part == HeadPart::unknown)
      skull.push_back(t);
  }
  for (int v = 0; v < model.vertex_count(); ++v)
    if (model.parts[std::size_t(v)] == HeadPart::face || model.parts[std::size_t(v)] == HeadPart::scalp_neck)
      skin.push_back(shape.vertices[std::size_t(v)]);
  const auto landmarks = landmark_positions(model, shape.vertices);
  const Garment garment = make_garment(skin, landmarks);
  HairOptions options;
  options.look.cut = HairCut::loose;
  options.locks = 300, options.strands_per_lock = 4;
  const HairMesh hair =
      grow_hair({shape.vertices, skull, landmarks}, {garment.vertices, garment.triangles}, options);
  ASSERT_EQ(hair.follow.size(), hair.vertices.size());
  const MeshScene cloth(garment.vertices, garment.triangles);
  const float chin = landmarks[8].y();
  std::size_t lying = 0, below = 0, inside = 0, before = 0, behind = 0;
  float lowest = 0;
  for (std::size_t v = 0; v < hair.vertices.size(); ++v) {
    const Vec3f& p = hair.vertices[v];
    lowest = std::min(lowest, p.y());
    ASSERT_TRUE(hair.follow[v] >= 0 && hair.follow[v] <= 1);
    if (p.y() > chin + 0.13f) {
      EXPECT_GT(hair.follow[v], 0.85f) << p.transpose();
    }
    below += p.y() < chin - 0.05f;
    const auto near = cloth.closest(p, 0.03f);
    if (hair.follow[v] > 0) continue;
    ++lying;
    (p.z() > -0.01f ? before : behind) += 1;
    if (!near) continue;
    const Triangle& t = garment.triangles[std::size_t(near->triangle)];
    const Vec3f& a = garment.vertices[std::size_t(t[0])];
    const Vec3f n = (garment.vertices[std::size_t(t[1])] - a).cross(garment.vertices[std::size_t(t[2])] - a);
    inside += (p - near->position).dot(n.normalized()) < -0.002f;
  }
  EXPECT_LT(lowest, chin - 0.12f);
  EXPECT_GT(below, hair.vertices.size() / 20);
  EXPECT_GT(lying, hair.vertices.size() / 20);
  EXPECT_GT(before, lying / 8);
  EXPECT_GT(behind, lying / 8);
  EXPECT_LT(inside, lying / 20);
}

TEST(DemoFaults, AStillTorsoKeepsItsPixels) {
  DemoOptions options = small_film(128);
  options.still_torso = true;
  DemoStage stage(demo_head(), options);
  DemoOptions moving = options;
  moving.still_torso = false;
  DemoStage other(demo_head(), moving);
  const auto difference = [](const Image8& a, const Image8& b) {
    double sum = 0;
    for (int y = 112; y < 128; ++y)
      for (int x = 30; x < 98; ++x)
        for (int c = 0; c < 3; ++c) sum += std::abs(a.at(x, y)[c] - b.at(x, y)[c]);
    return sum / (16 * 68 * 3);
  };
  // The head's shadow moves; nothing else does.
  EXPECT_LT(difference(stage.film(15, {}).rgb, stage.film(40, {}).rgb), 1.0);
  EXPECT_GT(difference(other.film(15, {}).rgb, other.film(40, {}).rgb), 4);
}

TEST(DemoFaults, APlainWallHasNoTextureAndAPlasteredOneHas) {
  const auto roughest = [](DemoWall wall) {
    DemoOptions options = small_film(128);
    options.wall = wall;
    options.camera = DemoCamera::walking;
    DemoStage stage(demo_head(), options);
    double most = 0, low = 255, high = 0;
    for (const int frame : {0, 30}) {
      const auto room = stage.film_room(frame, {});
      for (int y = 0; y < 128; ++y)
        for (int x = 1; x < 128; ++x) {
          const double g = grey_at(*room, x + 0.5, y + 0.5);
          most = std::max(most, std::abs(g - grey_at(*room, x - 0.5, y + 0.5)));
          low = std::min(low, g), high = std::max(high, g);
        }
    }
    return std::pair(most, high - low);
  };
  const auto [plain, shading] = roughest(DemoWall::plain);
  EXPECT_LE(plain, 2.5);
  EXPECT_GT(shading, 5);
  EXPECT_GT(roughest(DemoWall::textured).first, 12);
}

double mean_grey(const Image8& picture) {
  double sum = 0;
  for (const std::uint8_t value : picture.data) sum += value;
  return sum / double(picture.data.size());
}

double sharpness(const Image8& picture) {
  double sum = 0;
  for (int y = 1; y < picture.height; ++y)
    for (int x = 1; x < picture.width; ++x)
      sum += std::pow(grey_at(picture, x + 0.5, y + 0.5) - grey_at(picture, x - 0.5, y + 0.5), 2);
  return sum;
}

TEST(DemoFaults, DriftWandersWithinItsBoundsAndIsInThePicture) {
  DemoOptions options = small_film(96, 200);
  options.drift = true;
  float low = 2, high = 0, red = 0, face = 0, room = 0;
  int darkest = 0, brightest = 0, sharp = 0, soft = 0;
  for (int frame = 0; frame < options.frames; ++frame) {
    const Drift drift = drift_of(options, frame);
    const float exposure = 0.5f * (drift.gain.x() + drift.gain.z());
    if (exposure < low) low = exposure, darkest = frame;
    if (exposure > high) high = exposure, brightest = frame;
    red = std::max(red, std::abs(drift.gain.x() / exposure - 1));
    if (drift.room_blur_px > room) room = drift.room_blur_px, soft = frame;
    if (drift.room_blur_px < drift_of(options, sharp).room_blur_px) sharp = frame;
    face = std::max(face, drift.face_blur_px);
  }
  EXPECT_GT(low, 0.79f);
  EXPECT_LT(low, 0.90f);
  EXPECT_LT(high, 1.21f);
  EXPECT_GT(high, 1.10f);
  EXPECT_GT(red, 0.03f);
  EXPECT_LT(red, 0.061f);
  EXPECT_GT(face, 0.7f);
  EXPECT_GT(room, 0.7f);
  EXPECT_LE(std::max(face, room), kFocusDrift_px);
  DemoStage stage(demo_head(), options);
  EXPECT_GT(mean_grey(*stage.film_room(brightest, {})), 1.05 * mean_grey(*stage.film_room(darkest, {})));
  EXPECT_GT(sharpness(*stage.film_room(sharp, {})), 1.3 * sharpness(*stage.film_room(soft, {})));
  EXPECT_TRUE(drift_of(small_film(96), 7).gain == Vec3f::Ones());
}

TEST(DemoFaults, QuickMotionIsBlurredAndRestIsNot) {
  DemoOptions options = small_film(128, 48);
  options.frames_per_second = 4;  // an eighth of a second of exposure
  DemoStage sharp(demo_head(), options);
  options.motion_blur = true;
  DemoStage blurred(demo_head(), options);
  int soft = 0, before = 0;
  const int quick = 12;  // the head passes the middle
  const DemoFrame a = sharp.film(quick, {}), b = blurred.film(quick, {});
  for (std::size_t i = 0; i < a.mask.pixels(); ++i) {
    before += a.mask.data[i] > 0 && a.mask.data[i] < 255;
    soft += b.mask.data[i] > 0 && b.mask.data[i] < 255;
  }
  EXPECT_EQ(before, 0);
  EXPECT_GT(soft, 60);
  EXPECT_TRUE(blurred.shot(quick).world_from_head.isApprox(sharp.shot(quick).world_from_head, 1e-12));
}

// -- Files

struct FilmFolder {
  fs::path path;
  explicit FilmFolder(const char* name)
      : path(fs::temp_directory_path() /
             ("likeness_faults_" + std::string(name) + std::to_string(::getpid()))) {
    fs::remove_all(path);
  }
  ~FilmFolder() { fs::remove_all(path); }
};

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

DemoOptions everything() {
  DemoOptions options;
  options.width = 72, options.height = 128;
  options.frames = 24;
  options.samples_per_pixel = 1;
  options.camera = DemoCamera::handheld;
  options.cuts = 3;
  options.hair = DemoHair::loose;
  options.wall = DemoWall::textured;
  options.still_torso = options.drift = options.motion_blur = options.lens_tag = true;
  return options;
}

TEST(DemoFaults, FilesSayWhatWasFilmedAndTheSameSeedWritesTheSameBytes) {
  const FilmFolder first("a"), second("b");
  const DemoOptions options = everything();
  ASSERT_TRUE(write_demo_capture(first.path, options, Progress(), {}).ok());
  ASSERT_TRUE(write_demo_capture(second.path, options, Progress(), {}).ok());
  for (const char* name : {"demo.mp4", "cameras_truth.json", "track_truth.json", "drift_truth.json",
                           "wall_truth/000010.png", "masks_truth/000013.png"}) {
    const std::string bytes = bytes_of(first.path / name);
    EXPECT_GT(bytes.size(), 50u) << name;
    EXPECT_TRUE(bytes == bytes_of(second.path / name)) << name;
  }
  const auto cameras = read_cameras(first.path / "cameras_truth.json");
  ASSERT_TRUE(cameras.ok()) << cameras.error().what;
  EXPECT_FALSE(cameras->rests());
  ASSERT_EQ(cameras->cameras.size(), 24u);
  EXPECT_NE(cameras->cameras[0].intrinsics.fx, cameras->cameras[20].intrinsics.fx);
  const auto truth = read_demo_truth(first.path / "cameras_truth.json");
  ASSERT_TRUE(truth.ok()) << truth.error().what;
  EXPECT_EQ(truth->camera, DemoCamera::handheld);
  const auto shots = demo_shots(options);
  ASSERT_EQ(truth->shots.size(), shots.size());
  for (std::size_t i = 0; i < shots.size(); ++i) {
    EXPECT_EQ(truth->shots[i].first, shots[i].first);
    EXPECT_EQ(truth->shots[i].last, shots[i].last);
    EXPECT_EQ(truth->shots[i].place, shots[i].place);
    EXPECT_EQ(truth->shots[i].cut, cut_name(shots[i].kind));
    char name[32];
    std::snprintf(name, sizeof name, "%06d.png", shots[i].first);
    EXPECT_TRUE(fs::exists(first.path / "wall_truth" / name)) << name;
  }
  EXPECT_DOUBLE_EQ(read_focal_35mm(first.path / "demo.mp4"), focal_35mm(options));
  const auto info = probe_video(first.path / "demo.mp4");
  ASSERT_TRUE(info.ok());
  EXPECT_DOUBLE_EQ(info->focal_35mm, 27);
}

TEST(DemoFaults, AGuidedFilmHasNoneOfTheirFilesAndARestingOneOneCamera) {
  const FilmFolder folder("c");
  ASSERT_TRUE(write_demo_capture(folder.path, everything(), Progress(), {}).ok());
  DemoOptions options = small_film(64, 12);
  options.camera = DemoCamera::guided;
  ASSERT_TRUE(write_demo_capture(folder.path, options, Progress(), {}).ok());  // over the other one
  EXPECT_FALSE(fs::exists(folder.path / "wall_truth"));
  EXPECT_FALSE(fs::exists(folder.path / "drift_truth.json"));
  EXPECT_EQ(bytes_of(folder.path / "cameras_truth.json").find("\"demo_camera\""), std::string::npos);
  EXPECT_EQ(read_focal_35mm(folder.path / "demo.mp4"), 0);
  EXPECT_EQ(read_demo_truth(folder.path / "cameras_truth.json")->camera, DemoCamera::guided);
  options.camera = DemoCamera::resting;
  ASSERT_TRUE(write_demo_capture(folder.path, options, Progress(), {}).ok());
  EXPECT_TRUE(read_cameras(folder.path / "cameras_truth.json")->rests());
  EXPECT_EQ(read_demo_truth(folder.path / "cameras_truth.json")->camera, DemoCamera::resting);
}

// A camera at rest that is cut closer zooms, one that is cut to another place is found nowhere at rest.
TEST(DemoFaults, TheTruthOfACutFilmSaysWhatAPerfectSolveWouldShow) {
  const FilmFolder folder("f");
  const std::pair<int, CameraKind> films[] = {
      {0, CameraKind::resting}, {1, CameraKind::handheld}, {2, CameraKind::walking}};
  for (const auto& [seed, kind] : films) {  // a jump, a closer crop, another angle
    DemoOptions options = small_film(64, 12);
    options.cuts = 1;
    options.seed = seed;
    ASSERT_TRUE(write_demo_capture(folder.path, options, Progress(), {}).ok());
    const auto cameras = read_cameras(folder.path / "cameras_truth.json");
    ASSERT_TRUE(cameras.ok()) << cameras.error().what;
    EXPECT_EQ(cameras->kind, kind) << seed;
  }
}

// The decoded film changes at its cuts, and more than anywhere else.
TEST(DemoFaults, ThePictureChangesAtTheCuts) {
  const FilmFolder folder("d");
  DemoOptions options = small_film(96, 60);
  options.cuts = 2;
  options.seed = 1;  // a punch-in and another angle
  ASSERT_TRUE(write_demo_capture(folder.path, options, Progress(), {}).ok());
  auto film = VideoReader::open(folder.path / "demo.mp4");
  ASSERT_TRUE(film.ok()) << film.error().what;
  const auto shots = demo_shots(options);
  Image8 last;
  double least_cut = 255, most_step = 0;
  int frame = 0;
  for (; true; ++frame) {
    auto next = film->next();
    ASSERT_TRUE(next.ok());
    if (!*next) break;
    if (frame > 0) {
      double step = 0;
      for (std::size_t i = 0; i < last.data.size(); ++i)
        step += std::abs(int(last.data[i]) - int((*next)->rgb.data[i])) / double(last.data.size());
      const bool cut = shot_of(shots, frame).first == frame;
      (cut ? least_cut : most_step) = cut ? std::min(least_cut, step) : std::max(most_step, step);
    }
    last = (*next)->rgb;
  }
  EXPECT_EQ(frame, 60);
  EXPECT_GT(least_cut, 2 * most_step);
}

TEST(DemoFaults, RefusesHandsAndCutsThatCannotBe) {
  const FilmFolder folder("e");
  for (const auto spoil :
       {+[](DemoOptions& o) { o.cuts = o.frames; }, +[](DemoOptions& o) { o.cuts = -1; },
        +[](DemoOptions& o) { o.hand_turn_deg = 50; }, +[](DemoOptions& o) { o.hand_shift_m = -0.1; }}) {
    DemoOptions options = small_film(64, 12);
    spoil(options);
    const auto written = write_demo_capture(folder.path, options, Progress(), {});
    ASSERT_FALSE(written.ok());
    EXPECT_EQ(written.error().code, ErrorCode::bad_input);
    EXPECT_FALSE(written.error().fix.empty());
  }
}

}  // namespace
}  // namespace likeness
