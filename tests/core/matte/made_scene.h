// A small made clip for the matte stage: a textured wall and a person whose outline is known.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/rigid.h"
#include "core/head/builtin_head.h"
#include "core/head/pose_head.h"
#include "core/image/files.h"
#include "core/matte/matte.h"
#include "core/matte/person_network.h"
#include "core/matte/person_prior.h"
#include "tests/core/camera/textured_room.h"

namespace likeness::test {

namespace fs = std::filesystem;

inline constexpr int kSize = 128, kFrames = 36, kHeldFrom = 30;

inline const HeadModel& head_model() {
  static const HeadModel model = make_builtin_head();
  return model;
}

inline std::string bytes_of(const fs::path& path) {
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
    cameras.kind = moves == Moves::never ? CameraKind::resting : CameraKind::walking;
    Intrinsics k;
    k.width = k.height = kSize;
    k.fx = k.fy = 2.0 * kSize, k.cx = k.cy = kSize / 2.0;
    if (cameras.rests()) cameras.cameras.push_back({-1, k, Pose::Identity()});
    for (int frame = 0; frame < kFrames; ++frame) {
      CaptureFrame entry;
      entry.frame = frame, entry.time_s = frame / 10.0;
      entry.held_out = frame >= kHeldFrom, entry.used = !entry.held_out;
      capture.frames.push_back(entry);
      const int steps = moves == Moves::always ? frame : moves == Moves::at_first ? std::min(frame, 14) : 0;
      Camera camera{frame, k, Pose::Identity()};
      camera.cam_from_world.translation().x() = -0.01 * steps;
      if (!cameras.rests()) cameras.cameras.push_back(camera);
      add_frame(frame, camera, 3.0 * steps);
    }
  }
  ~Scene() { fs::remove_all(folder); }

  // The head sways; what is drawn is larger than the bare model, as a head with hair is.
  void add_frame(int frame, const Camera& camera, double wall_shift) {
    TrackedFrame tracked;
    tracked.frame = frame;
    tracked.pose.articulation = neutral_articulation(head_model());
    const double sway = 0.045 * std::sin(frame * 0.55), yaw = 0.3 * std::sin(frame * 0.4);
    Pose cam_from_head = Pose::Identity();  // the head looks back at the camera: x and z turned about
    cam_from_head.linear() =
        (Eigen::AngleAxisd(M_PI, Vec3d::UnitX()) * Eigen::AngleAxisd(yaw, Vec3d::UnitY())).toRotationMatrix();
    cam_from_head.translation() = Vec3d(sway, -0.05, 0.95);
    tracked.pose.world_from_head = inverse(camera.cam_from_world) * cam_from_head;
    Pose rest = cam_from_head;
    rest.linear() = rotation_about(Vec3d::UnitX(), M_PI);
    rest.translation().x() = 0.3 * sway;
    tracked.pose.world_from_torso = inverse(camera.cam_from_world) * rest;
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
                            const fs::path& network = {}, const LearnRoom& learn_room = {},
                            const FrameStrokes& strokes = {},
                            std::shared_ptr<const PersonNetwork> person_network = {}) const {
    MatteOptions options;
    options.person_network = std::move(person_network);
    options.size = kSize;
    options.network = network;
    options.learn_room = learn_room;
    options.strokes = strokes;
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

}  // namespace likeness::test
