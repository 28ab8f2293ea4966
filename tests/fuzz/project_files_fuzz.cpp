// Damaged files of a project: track.json, cameras.json (camera paths are the same format), capture.json,
// project.json, plate.json, the strokes on masks, painted attributes and their values, avatar.bin, room.bin,
// checkpoint.bin, COLMAP's binary models and its database, performance.json, training_curve.json,
// refits.json; and beside it the studio's settings and the description of a matting network. Not the network
// itself: OpenCV divides by zero on damaged ones.
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstring>

#include "core/base/files.h"
#include "core/camera/camera.h"
#include "core/camera/colmap.h"
#include "core/camera/colmap_model.h"
#include "core/capture/capture.h"
#include "core/direct/performance.h"
#include "core/matte/attributes.h"
#include "core/matte/matte_report.h"
#include "core/matte/matting_network.h"
#include "core/matte/plate_file.h"
#include "core/project/project.h"
#include "core/project/project_attributes.h"
#include "core/project/refits.h"
#include "core/project/training_curve.h"
#include "core/render/avatar.h"
#include "core/render/room_picture.h"
#include "core/scene/track.h"
#include "core/train/checkpoint.h"
#include "tests/core/render/tiny_avatar.h"
#include "tests/fuzz/fuzz.h"
#include "tests/support/onnx_bytes.h"
#include "ui/platform/settings.h"

namespace likeness {
namespace {

// A target that reads one file by path; the seed is what `write` wrote to it.
template <class Write, class Read>
void fuzz_file(const std::string& name, const std::string& file, Write write, Read read,
               std::function<void(std::string&)> repair = {}) {
  const ScratchFolder scratch;
  ASSERT_TRUE(write(scratch.path() / file));
  FuzzTarget target;
  target.name = name;
  target.seeds = {scratch.get(file)};
  target.repair = std::move(repair);
  target.read = [&](std::span<const std::byte> bytes) { return bool(read(scratch.put(file, bytes))); };
  fuzz(target);
}

Camera some_camera(int frame) {
  Camera camera;
  camera.frame = frame;
  camera.intrinsics = {640, 480, 600, 601, 320, 240, 0.01, 0.02, 0.001, 0.002};
  camera.cam_from_world.translate(Vec3d(0.1, 0.2, 0.3 + frame));
  return camera;
}

TEST(FuzzProjectFiles, Performance) {
  Performance performance;
  performance.channels["head yaw"] = {{0, 5, Easing::hold}, {0.5, -5, Easing::linear}, {1.25, 0.1f}};
  performance.channels["action jawOpen"] = {{0.7, 0.3f, Easing::ease_in}};
  fuzz_file(
      "performance", "performance.json",
      [&](const auto& path) { return bool(write_performance(path, performance)); },
      [](const auto& path) { return read_performance(path); });
}

TEST(FuzzProjectFiles, TrainingCurve) {
  TrainingCurve curve;
  for (std::uint64_t step : {1u, 5u, 9u}) add_point(curve, {step, 0.5 * double(step), 0.01, 21.5, 45000});
  add_score(curve, {2.5, 24.25});
  fuzz_file(
      "training_curve", "training_curve.json",
      [&](const auto& path) { return write_training_curve(path, curve).ok(); },
      [](const auto& path) { return read_training_curve(path).ok(); });
}

TEST(FuzzProjectFiles, Refits) {
  const Refits refits{"0123", {{{3, 5}, 3, 2, 1, 0}, {{9, 9}, 1, 1, 1, 0}}};
  fuzz_file(
      "refits", "refits.json",
      [&](const auto& path) { return write_refits({.folder = path.parent_path()}, refits).ok(); },
      [](const auto& path) { return read_refits({.folder = path.parent_path()}).ok(); });
}

TEST(FuzzProjectFiles, Track) {
  Track track;
  track.head_model_name = std::string("a"), track.head_model_hash = std::string("b");
  track.person.identity = Eigen::VectorXf::LinSpaced(3, -1, 1);
  track.person.offsets = {{0.001f, 0, 0}};
  track.neutral.expression = Eigen::VectorXf::Zero(2);
  for (int i = 0; i < 2; ++i) {
    TrackedFrame frame;
    frame.frame = i;
    frame.pose.articulation.expression = Eigen::VectorXf::Constant(2, 0.5f);
    for (Vec2d& p : frame.landmarks) p = {1.5, 2.5};
    track.frames.push_back(frame);
  }
  fuzz_file(
      "track.json", "track.json", [&](const auto& path) { return write_track(path, track).ok(); },
      [](const auto& path) { return read_track(path).ok(); });
}

TEST(FuzzProjectFiles, Cameras) {
  CameraSet set;
  set.kind = CameraKind::walking;
  set.scale = CameraScale::arbitrary;
  for (int i = 0; i < 3; ++i) set.cameras.push_back(some_camera(i));
  fuzz_file(
      "cameras.json", "cameras.json", [&](const auto& path) { return write_cameras(path, set).ok(); },
      [](const auto& path) { return read_cameras(path).ok(); });
}

TEST(FuzzProjectFiles, Capture) {
  Capture capture;
  capture.video = "clip.mp4", capture.video_hash = "0123";
  capture.width = 640, capture.height = 480, capture.frames_per_second = 30;
  capture.crop = {10, 20, 400};
  capture.warnings = {"dark"};
  for (int i = 0; i < 4; ++i)
    capture.frames.push_back({i, i / 30.0, 100, i == 3, i < 2, i == 2 ? "blurred" : ""});
  fuzz_file(
      "capture.json", "capture.json", [&](const auto& path) { return write_capture(path, capture).ok(); },
      [](const auto& path) { return read_capture(path).ok(); });
}

TEST(FuzzProjectFiles, Project) {
  Project project;
  project.options.shared.video = "/clip.mp4";
  project.record(Stage::fit).warnings = {"one"};
  fuzz_file(
      "project.json", "project.json",
      [&](const auto& path) {
        project.folder = path.parent_path();
        return save_project(project).ok();
      },
      [](const auto& path) { return open_project(path.parent_path()).ok(); });
}

TEST(FuzzProjectFiles, Plate) {
  PlateInfo info;
  info.coverage = 0.5, info.frames = {1, 2, 30};
  fuzz_file(
      "plate.json", "plate.json", [&](const auto& path) { return write_plate_info(path, info).ok(); },
      [](const auto& path) { return read_plate_info(path).ok(); });
}

TEST(FuzzProjectFiles, MatteReport) {
  MatteReport report;
  report.prior = MaskPrior::person_network, report.frames = 40, report.prior_frames = 38;
  report.plate_look_back = {40, 0.1};
  report.plate = BackgroundFit{4, true, 31, 14}, report.room = BackgroundFit{4, false, 11, 14};
  fuzz_file(
      "matte_report.json", "matte_report.json",
      [&](const auto& path) { return write_matte_report(path, report).ok(); },
      [](const auto& path) {
        const auto read = read_matte_report(path);
        return read && *read;
      });
}

// Read and painted: what a file says must also end in a picture.
TEST(FuzzProjectFiles, Strokes) {
  const Strokes strokes{{StrokeMark::person, 12.5, {{10, 20}, {300.25, 40}}},
                        {StrokeMark::background, 3, {{1, 2}}},
                        {StrokeMark::erase, 40, {{100, 200}, {10, 20}, {3, 4}}}};
  fuzz_file(
      "strokes", "000012.json", [&](const auto& path) { return write_strokes(path, strokes).ok(); },
      [](const auto& path) {
        const auto read = read_strokes(path);
        if (read) static_cast<void>(cover_strokes(*read, {0, 0, 400}, 32));
        return read.ok();
      });
}

TEST(FuzzProjectFiles, Attributes) {
  PaintedAttributes attributes;
  annotate(attributes, "cheek puff", {12, 1, {{StrokeMark::person, 12.5, {{10, 20}, {300.25, 40}}}}});
  annotate(attributes, "cheek puff", {30, 0, {}});
  fuzz_file(
      "attributes", "attributes.json",
      [&](const auto& path) { return write_attributes(path, attributes).ok(); },
      [](const auto& path) { return read_attributes(path).ok(); });
  const AttributeCourse course{"cheek puff", {3, 8, 9}, {0, 0.5f, -1}, {0, 0.3f, 1}, {1, 0, 0}, 1, 2,
                               0.25,         1};
  fuzz_file(
      "attribute values", "attribute_values.json",
      [&](const auto& path) {
        return write_attribute_values(path, {&course, 1}).ok();
      },
      [](const auto& path) { return read_attribute_values(path).ok(); });
}

TEST(FuzzProjectFiles, Avatar) {
  Avatar avatar = tiny_avatar();
  avatar.room = *avatar.torso;
  FieldConfig config = avatar.head.field.config;
  ++config.condition_count, config.local_conditions = 1;
  avatar.head.field = make_field(config, 5);
  avatar.attributes.resize(1);
  avatar.attributes[0].name = "cheek puff", avatar.attributes[0].cell = 0.01f;
  avatar.attributes[0].count = {2, 3, 4}, avatar.attributes[0].weights.assign(24, 9);
  fuzz_file(
      "avatar.bin", "avatar.bin", [&](const auto& path) { return write_avatar(path, avatar).ok(); },
      [](const auto& path) { return read_avatar(path).ok(); }, repair_checksum);
}

TEST(FuzzProjectFiles, Room) {
  fuzz_file(
      "room.bin", "room.bin", [](const auto& path) { return write_room(path, *tiny_avatar().torso).ok(); },
      [](const auto& path) { return read_room(path).ok(); }, repair_checksum);
}

TEST(FuzzProjectFiles, Checkpoint) {
  const Avatar avatar = tiny_avatar();
  TrainingState state;
  const auto fill = [](TrainedField& field, const FieldPart& part) {
    field.part = part;
    field.adam = make_adam_state(part.field);
    field.learnt.density.assign(64, 0.5f);
  };
  fill(state.head, avatar.head);
  fill(state.torso.emplace(), *avatar.torso);
  state.codes.assign(8, 0.1f);
  state.codes_adam.first.assign(4, 0.1f), state.codes_adam.second.assign(4, 0.1f);
  fuzz_file(
      "checkpoint.bin", "checkpoint.bin",
      [&](const auto& path) { return write_checkpoint(path, state, "print").ok(); },
      [&](const auto& path) {
        TrainingState copy = state;
        return read_checkpoint(path, "print", copy).ok();
      },
      repair_checksum);
}

// The three files of a COLMAP model, joined by a line that no file holds; each input damages any of them.
TEST(FuzzProjectFiles, ColmapModel) {
  const auto put = [](std::string& text, auto value) {
    text.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  std::string cameras, images, points;
  put(cameras, std::uint64_t(1)), put(cameras, std::int32_t(1)), put(cameras, std::int32_t(4));
  put(cameras, std::uint64_t(540)), put(cameras, std::uint64_t(960));
  for (const double p : {700.0, 701.0, 270.0, 480.0, 0.05, -0.01, 0.001, -0.002}) put(cameras, p);
  put(images, std::uint64_t(1)), put(images, std::uint32_t(7));
  for (const double p : {1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0}) put(images, p);
  put(images, std::uint32_t(1));
  images.append("000001.png", 11);
  put(images, std::uint64_t(2));
  for (int i = 0; i < 2; ++i)
    put(images, 10.5 + i), put(images, 20.5), put(images, std::int64_t(i == 0 ? 42 : -1));
  put(points, std::uint64_t(1)), put(points, std::uint64_t(42));
  for (const double p : {0.1, 0.2, 2.0}) put(points, p);
  points.append(3, '\t');
  put(points, 0.4), put(points, std::uint64_t(2));
  for (const std::uint32_t v : {7u, 0u, 3u, 0u}) put(points, v);
  const std::string seam = "\n<seam>\n";
  const ScratchFolder scratch;
  FuzzTarget target;
  target.name = "COLMAP model";
  target.seeds = {cameras + seam + images + seam + points};
  target.read = [&](std::span<const std::byte> bytes) {
    const std::string text = text_of(bytes);
    const std::size_t first = std::min(text.find(seam), text.size());
    const std::size_t second =
        first < text.size() ? std::min(text.find(seam, first + 1), text.size()) : text.size();
    const auto part = [&](std::size_t begin, std::size_t end) {
      begin = std::min(begin, end);
      return bytes.subspan(begin, end - begin);
    };
    scratch.put("cameras.bin", part(0, first));
    scratch.put("images.bin", part(std::min(first + seam.size(), second), second));
    scratch.put("points3D.bin", part(std::min(second + seam.size(), text.size()), text.size()));
    const auto model = read_colmap_model(scratch.path());
    if (model) static_cast<void>(mean_reprojection_px(*model));
    return model.ok();
  };
  fuzz(target);
}

TEST(FuzzProjectFiles, ColmapDatabase) {
  fuzz_file(
      "COLMAP database", "database.db",
      [](const auto& path) {
        sqlite3* database = nullptr;
        const bool made =
            sqlite3_open(path.c_str(), &database) == SQLITE_OK &&
            sqlite3_exec(database,
                         "PRAGMA page_size = 512; CREATE TABLE images (image_id INTEGER PRIMARY KEY);"
                         "CREATE TABLE keypoints (image_id INTEGER, rows INTEGER);"
                         "CREATE TABLE two_view_geometries (pair_id INTEGER, rows INTEGER);"
                         "INSERT INTO images VALUES (1), (2); INSERT INTO keypoints VALUES (1, 60), (2, 40);"
                         "INSERT INTO two_view_geometries VALUES (7, 20);",
                         nullptr, nullptr, nullptr) == SQLITE_OK;
        sqlite3_close(database);
        return made;
      },
      [](const auto& path) { return count_database(path).ok(); });
}

TEST(FuzzProjectFiles, StudioSettings) {
  ui::Settings settings;
  settings.recent = {"/home/a.likeness", "/home/b.likeness"};
  fuzz_file(
      "studio.json", "studio.json", [&](const auto& path) { return ui::write_settings(path, settings).ok(); },
      [](const auto& path) {
        const ui::Settings read = ui::read_settings(path);  // defaults where the file is damaged
        return read.width >= 960 && read.height >= 600 && read.scale_percent >= ui::kLeastScale;
      });
}

TEST(FuzzProjectFiles, MattingNetworkFormat) {
  const ScratchFolder scratch;
  const std::string network = tiny_network(16, {0.5f, 0.2f, 0.1f, -0.5f, -0.2f, -0.1f}, {0, 0});
  scratch.put("net.onnx", std::as_bytes(std::span(network)));
  FuzzTarget target;
  target.name = "matting network's json";
  target.seeds = {R"({"size_px": 16, "mean": [127.5, 127, 128], "scale": 0.0078, "activation": "softmax",)"
                  R"( "output": "map", "person_channels": [1]})"};
  target.memory_floor = std::size_t(256) << 20;  // pictures of up to 2048 px are tried
  target.read = [&](std::span<const std::byte> bytes) {
    scratch.put("net.json", bytes);
    return MattingNetwork::load(scratch.path() / "net.onnx").ok();
  };
  fuzz(target);
}

}  // namespace
}  // namespace likeness
