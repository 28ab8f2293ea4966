// Claims about the whole matte stage on a small made scene: a textured wall and a person whose outline is
// known.
#include "core/matte/matte.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <mutex>
#include <set>

#include "core/base/files.h"
#include "core/head/builtin_head.h"
#include "core/head/pose_head.h"
#include "core/image/files.h"
#include "core/matte/person_prior.h"
#include "tests/core/camera/textured_room.h"
#include "tests/core/matte/tiny_network.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kSize = 128, kFrames = 36, kHeldFrom = 30;

const HeadModel& head_model() {
  static const HeadModel model = make_builtin_head();
  return model;
}

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

enum class Moves { never, always, at_first };

// The project folder of a made clip, with the truth kept beside it.
struct Scene {
  fs::path folder;
  Capture capture;
  CameraSet cameras;
  Track track;
  std::vector<Image8> alpha;  // one channel
  std::vector<Image8> wall;   // of every frame

  explicit Scene(const std::string& name, Moves moves = Moves::never) {
    folder = fs::temp_directory_path() / ("likeness_matte_" + name + std::to_string(::getpid()));
    fs::create_directories(folder / "frames");
    capture.width = capture.height = kSize;
    capture.crop = {0, 0, kSize};
    capture.size = kSize;
    capture.frames_per_second = 10;
    track.person.identity = Eigen::VectorXf::Zero(head_model().identity_count());
    cameras.is_static = moves == Moves::never;
    Intrinsics k;
    k.width = k.height = kSize;
    k.fx = k.fy = 2.0 * kSize, k.cx = k.cy = kSize / 2.0;
    if (cameras.is_static) cameras.cameras.push_back({-1, k, Pose::Identity()});
    for (int frame = 0; frame < kFrames; ++frame) {
      CaptureFrame entry;
      entry.frame = frame, entry.time_s = frame / 10.0;
      entry.held_out = frame >= kHeldFrom, entry.used = !entry.held_out;
      capture.frames.push_back(entry);
      const int steps = moves == Moves::always ? frame : moves == Moves::at_first ? std::min(frame, 14) : 0;
      Camera camera{frame, k, Pose::Identity()};
      camera.cam_from_world.translation().x() = -0.01 * steps;
      if (!cameras.is_static) cameras.cameras.push_back(camera);
      add_frame(frame, camera, 3.0 * steps);
    }
  }
  ~Scene() { fs::remove_all(folder); }

  // The head sways; what is drawn is larger than the bare model, as a head with hair is.
  void add_frame(int frame, const Camera& camera, double wall_shift) {
    TrackedFrame tracked;
    tracked.frame = frame;
    tracked.articulation = neutral_articulation(head_model());
    const double sway = 0.045 * std::sin(frame * 0.55), yaw = 0.3 * std::sin(frame * 0.4);
    Pose cam_from_head = Pose::Identity();  // the head looks back at the camera: x and z turned about
    cam_from_head.linear() =
        (Eigen::AngleAxisd(M_PI, Vec3d::UnitX()) * Eigen::AngleAxisd(yaw, Vec3d::UnitY())).toRotationMatrix();
    cam_from_head.translation() = Vec3d(sway, -0.05, 0.95);
    tracked.world_from_head = camera.cam_from_world.inverse() * cam_from_head;
    Pose rest = cam_from_head;
    rest.linear() = Eigen::AngleAxisd(M_PI, Vec3d::UnitX()).toRotationMatrix();
    rest.translation().x() = 0.3 * sway;
    tracked.world_from_torso = camera.cam_from_world.inverse() * rest;
    track.frames.push_back(tracked);

    const PersonModel person = make_person_model(head_model(), track);
    const auto place = place_person(person, tracked, camera, camera.intrinsics, 1);
    const auto posed = landmark_positions(head_model(), place->vertices);
    const Vec3d centre_in_head = (0.5 * (posed[0] + posed[16]) + Vec3f(0, 0.02f, 0.02f)).cast<double>();
    const Vec2d head = project<double>(camera.intrinsics, cam_from_head * centre_in_head);
    draw(head, place->neck, place->px_per_metre, wall_shift);
    ASSERT_TRUE(write_image(folder / frame_name(frame), picture_).ok());
  }

  void draw(const Vec2d& head, const Vec2d& neck, double scale, double wall_shift) {
    Image8 alpha_now(kSize, kSize, 1), wall_now(kSize, kSize, 3);
    picture_ = Image8(kSize, kSize, 3);
    const auto inside = [&](double x, double y) {
      const double hx = (x - head.x()) / (0.105 * scale), hy = (y - head.y()) / (0.145 * scale);
      const double sx = (x - neck.x()) / (0.2 * scale), sy = (y - neck.y() - 0.2 * scale) / (0.15 * scale);
      const bool column =
          std::abs(x - neck.x()) < 0.055 * scale && y > head.y() && y < neck.y() + 0.15 * scale;
      return hx * hx + hy * hy < 1 || column || (sx * sx + sy * sy < 1) || (std::abs(sx) < 1 && sy > 0);
    };
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        int count = 0;
        for (int s = 0; s < 16; ++s) count += inside(x + (s % 4 + 0.5) / 4, y + (s / 4 + 0.5) / 4);
        *alpha_now.at(x, y) = std::uint8_t(count * 255 / 16);
        const bool shirt = y > neck.y() + 0.04 * scale;
        for (int c = 0; c < 3; ++c) {
          const double back =
              60 + 150 * wall_texture(x + wall_shift, y, c == 2 ? 3 : 4) * (c == 0 ? 0.6 : 1.0);
          const double skin[] = {225, 170, 140}, cloth[] = {150, 30, 40};
          const double front =
              (shirt ? cloth[c] : skin[c]) + 12 * wall_texture(x - head.x(), y - head.y(), 8);
          wall_now.at(x, y)[c] = std::uint8_t(back);
          picture_.at(x, y)[c] = std::uint8_t(front * count / 16 + back * (16 - count) / 16);
        }
      }
    alpha.push_back(alpha_now);
    wall.push_back(wall_now);
  }

  Result<MatteResult> matte(const Progress& progress = {}, std::stop_token stop = {},
                            const fs::path& network = {}, const LearnRoom& learn_room = {}) const {
    MatteOptions options;
    options.size = kSize;
    options.network = network;
    options.learn_room = learn_room;
    return matte_clip(folder, capture, cameras, track, head_model(), options, progress, stop);
  }
  double overlap(int frame) const {
    const auto mask = read_image(folder / "masks" / frame_name(frame).filename());
    if (!mask || mask->data.size() != alpha[std::size_t(frame)].data.size()) return 0;
    int both = 0, either = 0;
    for (std::size_t i = 0; i < mask->data.size(); ++i) {
      const bool a = mask->data[i] > 127, b = alpha[std::size_t(frame)].data[i] > 127;
      both += a && b;
      either += a || b;
    }
    return double(both) / either;
  }

 private:
  Image8 picture_;
};

TEST(MatteClip, StaticCameraGivesAlphaAndPlateCloseToTheTruth) {
  const Scene scene("static");
  std::mutex mutex;
  double fraction = 0;
  bool rising = true;
  const auto result = scene.matte(Progress([&](const ProgressReport& report) {
    const std::lock_guard lock(mutex);
    rising = rising && report.fraction >= fraction;
    fraction = report.fraction;
  }));
  ASSERT_TRUE(result.ok()) << result.error().what;
  EXPECT_TRUE(rising);
  EXPECT_DOUBLE_EQ(fraction, 1);
  EXPECT_TRUE(result->has_plate);
  EXPECT_EQ(int(result->plate_frames.size()), kFrames);
  for (int frame = 0; frame < kFrames; ++frame) EXPECT_GT(scene.overlap(frame), 0.95) << frame;

  const auto plate = read_image(scene.folder / "plate.png");
  ASSERT_TRUE(plate.ok());
  const auto known = read_image(scene.folder / "plate_known.png");
  ASSERT_TRUE(known.ok());
  EXPECT_EQ(known->channels, 1);
  // Where the person never leaves is flagged, and the rest adds up to the coverage.
  EXPECT_EQ(*known->at(kSize / 2, kSize - 6), 0);
  EXPECT_NEAR(double(std::count(known->data.begin(), known->data.end(), 255)) / (kSize * kSize),
              result->plate_coverage, 1e-9);
  double sum = 0;
  int seen = 0, free_pixels = 0;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      int free_frames = 0;
      for (int frame = 0; frame < kHeldFrom; ++frame)
        free_frames += *scene.alpha[std::size_t(frame)].at(x, y) == 0;
      free_pixels += free_frames > 2;
      if (free_frames < 10) continue;
      for (int c = 0; c < 3; ++c) sum += std::abs(double(plate->at(x, y)[c]) - scene.wall[0].at(x, y)[c]) / 3;
      ++seen;
    }
  EXPECT_LT(sum / seen, 1.5);
  EXPECT_NEAR(result->plate_coverage, double(free_pixels) / (kSize * kSize), 0.08);
}

TEST(MatteClip, WhatThePersonAlwaysCoversIsSolid) {
  const Scene scene("solid");
  ASSERT_TRUE(scene.matte().ok());
  for (int frame = 0; frame < kFrames; ++frame) {
    const auto mask = read_image(scene.folder / "masks" / frame_name(frame).filename());
    ASSERT_TRUE(mask.ok());
    for (int y = kSize - 12; y < kSize; ++y)
      for (int x = kSize / 2 - 14; x < kSize / 2 + 14; ++x) EXPECT_EQ(*mask->at(x, y), 255) << frame;
  }
}

TEST(MatteClip, HeldOutPicturesChangeNeitherPlateNorTrainingMasks) {
  Scene scene("leak");
  ASSERT_TRUE(scene.matte().ok());
  const std::string plate = bytes_of(scene.folder / "plate.png"),
                    info = bytes_of(scene.folder / "plate.json");
  std::vector<std::string> masks;
  for (int frame = 0; frame < kHeldFrom; ++frame)
    masks.push_back(bytes_of(scene.folder / "masks" / frame_name(frame).filename()));
  for (int frame = kHeldFrom; frame < kFrames; ++frame) {
    Image8 noise(kSize, kSize, 3);
    for (std::size_t i = 0; i < noise.data.size(); ++i)
      noise.data[i] = std::uint8_t(i * 7919 + std::size_t(frame));
    ASSERT_TRUE(write_image(scene.folder / frame_name(frame), noise).ok());
  }
  ASSERT_TRUE(scene.matte().ok());
  EXPECT_EQ(bytes_of(scene.folder / "plate.png"), plate);
  EXPECT_EQ(bytes_of(scene.folder / "plate.json"), info);
  for (int frame = 0; frame < kHeldFrom; ++frame)
    EXPECT_EQ(bytes_of(scene.folder / "masks" / frame_name(frame).filename()), masks[std::size_t(frame)])
        << frame;
}

// What the room is learnt from is part of it: a learner whose room is the mean of its training pictures'
// colours.
TEST(MatteClip, HeldOutPicturesChangeNothingOfARoomOrThePlateThatItCompletes) {
  const Scene scene("leak_room", Moves::at_first);
  std::vector<double> learnt;
  const LearnRoom learn = [&](const std::vector<RoughMatte>& mattes, RoomPass, const Progress&,
                              std::stop_token) -> Result<RoomBehind> {
    double sum = 0, count = 0;
    for (const RoughMatte& matte : mattes) {
      const auto picture = read_image(scene.folder / frame_name(matte.frame));
      if (!picture) return picture.error();
      for (std::size_t i = 0; i < matte.alpha.data.size(); ++i)
        if (matte.alpha.data[i] == 0) sum += picture->data[3 * i], ++count;
    }
    learnt.push_back(sum / count);
    return RoomBehind([&, colour = std::uint8_t(sum / count)](int frame) {
      Image8 room = scene.wall[std::size_t(std::min(frame, kHeldFrom - 1))];
      for (std::uint8_t& value : room.data) value = std::uint8_t((3 * value + colour) / 4);
      return room;
    });
  };
  ASSERT_TRUE(scene.matte({}, {}, {}, learn).ok());
  const auto shared = [&] {
    std::string bytes = bytes_of(scene.folder / "plate.png") + bytes_of(scene.folder / "plate_known.png");
    for (int frame = 0; frame < kHeldFrom; ++frame)
      bytes += bytes_of(scene.folder / "masks" / frame_name(frame).filename());
    return bytes;
  };
  const std::string before = shared();
  for (int frame = kHeldFrom; frame < kFrames; ++frame)
    ASSERT_TRUE(write_image(scene.folder / frame_name(frame), Image8(kSize, kSize, 3, 200)).ok());
  ASSERT_TRUE(scene.matte({}, {}, {}, learn).ok());
  EXPECT_TRUE(shared() == before);
  ASSERT_EQ(learnt.size(), 4u);
  EXPECT_EQ(learnt[0], learnt[2]);
  EXPECT_EQ(learnt[1], learnt[3]);
}

TEST(MatteClip, AMovingCameraGetsMattesButNoPlate) {
  const Scene scene("moving", Moves::always);
  const auto result = scene.matte();
  ASSERT_TRUE(result.ok()) << result.error().what;
  EXPECT_FALSE(result->has_plate);
  EXPECT_TRUE(result->plate_frames.empty());
  EXPECT_FALSE(fs::exists(scene.folder / "plate.png"));
  double sum = 0;
  for (int frame = 0; frame < kFrames; ++frame) sum += scene.overlap(frame) / kFrames;
  EXPECT_GT(sum, 0.9);
}

TEST(MatteClip, TheRoomBehindAMovingCameraSharpensItsMattes) {
  const Scene scene("room", Moves::always);
  const auto error = [&] {
    double sum = 0;
    for (int frame = 0; frame < kFrames; ++frame) sum += (1 - scene.overlap(frame)) / kFrames;
    return sum;
  };
  ASSERT_TRUE(scene.matte().ok());
  const double without = error();
  // A model of the room that is right but for a constant error.
  std::set<int> learnt_from;
  std::map<RoomPass, double> person;  // share of the pictures that is left out
  const LearnRoom learn = [&](const std::vector<RoughMatte>& mattes, RoomPass pass, const Progress&,
                              std::stop_token) -> Result<RoomBehind> {
    for (const RoughMatte& matte : mattes) {
      learnt_from.insert(matte.frame);
      const auto out = std::ranges::count_if(matte.alpha.data, [](auto a) { return a > 0; });
      person[pass] += double(out) / double(matte.alpha.data.size() * mattes.size());
    }
    return RoomBehind([&](int frame) {
      Image8 room = scene.wall[std::size_t(frame)];
      for (std::uint8_t& value : room.data) value = std::uint8_t(std::min(255, value + 8));
      return room;
    });
  };
  const auto result = scene.matte({}, {}, {}, learn);
  ASSERT_TRUE(result.ok()) << result.error().what;
  EXPECT_FALSE(result->has_plate);
  EXPECT_LT(error(), 0.7 * without);
  EXPECT_EQ(learnt_from.size(), std::size_t(kHeldFrom));  // every training frame, no held-out one
  EXPECT_LT(*learnt_from.rbegin(), kHeldFrom);
  ASSERT_EQ(person.size(), 2u);  // generously, then from the cuts
  EXPECT_LT(person[RoomPass::last], 0.9 * person[RoomPass::first]);

  const Scene resting("room_resting");
  learnt_from.clear();
  ASSERT_TRUE(resting.matte({}, {}, {}, learn).ok());
  EXPECT_TRUE(learnt_from.empty());
}

TEST(MatteClip, ARoomThatCannotBeLearntEndsTheStage) {
  const Scene scene("no_room", Moves::always);
  const auto result =
      scene.matte({}, {}, {}, [](const auto&, RoomPass, const auto&, auto) -> Result<RoomBehind> {
        return Error{ErrorCode::no_space, "The disk is full.", "Free some space.", ""};
      });
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::no_space);
  EXPECT_FALSE(fs::exists(scene.folder / "masks"));
}

TEST(MatteClip, ANetworkIsFollowedWhereItIsSure) {
  const Scene scene("network", Moves::always);
  const fs::path network = scene.folder / "net.onnx";
  const std::string format = R"({"size_px": 128, "mean": [0, 0, 0], "scale": 1, "activation": "sigmoid"})";
  ASSERT_TRUE(write_text(scene.folder / "net.json", format));
  const auto matted_by = [&](const std::vector<float>& weights, float bias) {
    EXPECT_TRUE(write_text(network, tiny_network(kSize, weights, {bias})));
    const auto result = scene.matte({}, {}, network);
    EXPECT_TRUE(result.ok()) << (result ? "" : result.error().what);
    std::size_t person = 0;
    for (int frame = 0; frame < kFrames; ++frame) {
      const auto mask = read_image(scene.folder / "masks" / frame_name(frame).filename());
      EXPECT_TRUE(mask.ok());
      if (mask) person += std::size_t(std::ranges::count_if(mask->data, [](auto a) { return a > 127; }));
    }
    return person;
  };
  // Skin and cloth are redder than green, the wall never is.
  const std::size_t whole = matted_by({0.1f, -0.1f, 0}, -2.5f);
  double overlap = 0;
  for (int frame = 0; frame < kFrames; ++frame) overlap += scene.overlap(frame) / kFrames;
  EXPECT_GT(overlap, 0.97);
  // Only skin is bright red: by this network the cloth is no part of the person.
  EXPECT_LT(matted_by({0.1f, 0, 0}, -19), whole * 95 / 100);

  const auto absent = scene.matte({}, {}, scene.folder / "none.onnx");
  ASSERT_FALSE(absent.ok());
  EXPECT_EQ(absent.error().code, ErrorCode::not_found);
}

TEST(MatteClip, AMixedClipGetsThePlateOfItsRest) {
  const Scene scene("mixed", Moves::at_first);
  const auto result = scene.matte();
  ASSERT_TRUE(result.ok()) << result.error().what;
  EXPECT_TRUE(result->has_plate);
  ASSERT_FALSE(result->plate_frames.empty());
  EXPECT_EQ(result->plate_frames.front(), 14);
  EXPECT_EQ(result->plate_frames.back(), kFrames - 1);
  const auto info = read_plate_info(scene.folder / "plate.json");
  ASSERT_TRUE(info.ok());
  EXPECT_EQ(info->frames, result->plate_frames);
  for (int frame : result->plate_frames) EXPECT_GT(scene.overlap(frame), 0.93) << frame;
}

TEST(MatteClip, TheRoomCompletesThePlateOfARest) {
  const Scene scene("completed", Moves::at_first);
  const Image8& wall = scene.wall.back();
  const auto error_of_plate = [&](bool seen) {
    const auto plate = read_image(scene.folder / "plate.png"),
               known = read_image(scene.folder / "plate_known.png");
    EXPECT_TRUE(plate.ok() && known.ok());
    double sum = 0, count = 0;
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x)
        for (int c = 0; c < 3 && (*known->at(x, y) == 255) == seen; ++c, ++count)
          sum += std::abs(int(plate->at(x, y)[c]) - int(wall.at(x, y)[c]));
    return sum / count;
  };
  ASSERT_TRUE(scene.matte().ok());
  const double guessed = error_of_plate(false);
  const LearnRoom learn = [&](const auto&, RoomPass, const Progress&, std::stop_token) -> Result<RoomBehind> {
    return RoomBehind([&](int frame) { return scene.wall[std::size_t(frame)]; });
  };
  const auto result = scene.matte({}, {}, {}, learn);
  ASSERT_TRUE(result.ok()) << result.error().what;
  EXPECT_LT(error_of_plate(false), 0.2 * guessed);
  EXPECT_LT(error_of_plate(true), 3);
  for (int frame : result->plate_frames) EXPECT_GT(scene.overlap(frame), 0.93) << frame;
}

TEST(MatteClip, RegionsAreOfHeldOutFramesNestAndStayFrozen) {
  const Scene scene("regions");
  ASSERT_TRUE(scene.matte().ok());
  for (int frame = 0; frame < kFrames; ++frame)
    EXPECT_EQ(fs::exists(scene.folder / "regions" / frame_name(frame).filename()), frame >= kHeldFrom);
  const auto regions = read_image(scene.folder / "regions" / frame_name(kHeldFrom).filename());
  ASSERT_TRUE(regions.ok());
  EXPECT_EQ(regions->width, kSize);
  int person = 0, head = 0, face = 0, face_in_head = 0;
  for (int i = 0; i < kSize * kSize; ++i) {
    const std::uint8_t* pixel = regions->data.data() + 3 * i;
    person += pixel[0] == 255, head += pixel[1] == 255, face += pixel[2] == 255;
    face_in_head += pixel[1] == 255 && pixel[2] == 255;
  }
  EXPECT_GT(person, head / 2);
  EXPECT_GT(face, 200);
  EXPECT_GT(head, face);
  EXPECT_EQ(face_in_head, face);
  const auto before = bytes_of(scene.folder / "regions" / frame_name(kHeldFrom).filename());
  const auto marker = scene.folder / "regions" / frame_name(kHeldFrom + 1).filename();
  ASSERT_TRUE(write_image(marker, Image8(kSize, kSize, 3, 1)).ok());
  const auto altered = bytes_of(marker);
  // One frame without regions must not make the others be drawn anew.
  fs::remove(scene.folder / "regions" / frame_name(kHeldFrom + 2).filename());
  ASSERT_TRUE(scene.matte().ok());
  EXPECT_TRUE(fs::exists(scene.folder / "regions" / frame_name(kHeldFrom + 2).filename()));
  EXPECT_EQ(bytes_of(scene.folder / "regions" / frame_name(kHeldFrom).filename()), before);
  EXPECT_EQ(bytes_of(marker), altered);
}

TEST(MatteClip, StoppedMidwayLeavesTheOldMasksAsTheyWere) {
  const Scene scene("stopped");
  fs::create_directories(scene.folder / "masks");
  std::ofstream(scene.folder / "masks" / "000000.png") << "old";
  std::stop_source stop;
  const Progress progress([&](const ProgressReport& report) {
    if (report.fraction > 0.4) stop.request_stop();
  });
  const auto result = scene.matte(progress, stop.get_token());
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::cancelled);
  EXPECT_EQ(bytes_of(scene.folder / "masks" / "000000.png"), "old");
  EXPECT_FALSE(fs::exists(scene.folder / "plate.png"));
  EXPECT_FALSE(fs::exists(scene.folder / "masks.part"));
}

TEST(MatteClip, AMissingFrameIsAnErrorThatNamesTheFile) {
  const Scene scene("missing");
  fs::remove(scene.folder / frame_name(3));
  const auto result = scene.matte();
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.error().where.find("000003"), std::string::npos);
}

}  // namespace
}  // namespace likeness
