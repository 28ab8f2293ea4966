// Claims about the reader of colmap's binary models, on files made here byte by byte.
#include "core/camera/colmap_model.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <fstream>

namespace likeness {
namespace {

namespace fs = std::filesystem;

struct Bytes {
  std::string data;
  template <class T>
  Bytes& put(T value) {
    data.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Bytes& name(const std::string& text) {
    data += text;
    data += '\0';
    return *this;
  }
};

struct ModelFolder {
  fs::path path = fs::temp_directory_path() / ("likeness_model_" + std::to_string(::getpid()));
  Bytes cameras, images, points;

  ModelFolder() {
    fs::create_directories(path);
    cameras.put<std::uint64_t>(1).put<std::int32_t>(1).put<std::int32_t>(4).put<std::uint64_t>(540);
    cameras.put<std::uint64_t>(960);
    for (double p : {700.0, 701.0, 270.0, 480.0, 0.05, -0.01, 0.001, -0.002}) cameras.put(p);
    images.put<std::uint64_t>(2);
    // The first stored is the second by name; its quaternion is a quarter turn about y.
    picture(7, {std::sqrt(0.5), 0, std::sqrt(0.5), 0}, {1, 2, 3}, "000009.png", 2);
    picture(3, {1, 0, 0, 0}, {0, 0, 0}, "000001.png", 1);
    points.put<std::uint64_t>(1).put<std::uint64_t>(42).put(0.1).put(0.2).put(2.0);
    for (int c = 0; c < 3; ++c) points.put<std::uint8_t>(9);
    points.put(0.4).put<std::uint64_t>(2);
    for (std::uint32_t v : {7u, 0u, 3u, 0u}) points.put(v);
  }
  ~ModelFolder() { fs::remove_all(path); }

  void picture(std::uint32_t id, std::array<double, 4> q, std::array<double, 3> t, const char* name,
               int features) {
    images.put(id);
    for (double v : q) images.put(v);
    for (double v : t) images.put(v);
    images.put<std::uint32_t>(1).name(name).put<std::uint64_t>(std::uint64_t(features));
    for (int i = 0; i < features; ++i) images.put(10.5 + i).put(20.5).put<std::int64_t>(i == 0 ? 42 : -1);
  }
  void write(std::size_t camera_bytes, std::size_t image_bytes, std::size_t point_bytes) const {
    std::ofstream(path / "cameras.bin", std::ios::binary) << cameras.data.substr(0, camera_bytes);
    std::ofstream(path / "images.bin", std::ios::binary) << images.data.substr(0, image_bytes);
    std::ofstream(path / "points3D.bin", std::ios::binary) << points.data.substr(0, point_bytes);
  }
  void write_whole() const { write(cameras.data.size(), images.data.size(), points.data.size()); }
};

TEST(ColmapModel, ReadsCamerasPosesFeaturesAndPoints) {
  ModelFolder folder;
  folder.write_whole();
  const auto model = read_colmap_model(folder.path);
  ASSERT_TRUE(model.ok()) << model.error().what;
  ASSERT_EQ(model->cameras.size(), 1u);
  const Intrinsics& k = model->cameras.at(1);
  EXPECT_EQ(k.width, 540);
  EXPECT_EQ(k.fy, 701);
  EXPECT_EQ(k.p2, -0.002);
  ASSERT_EQ(model->images.size(), 2u);
  EXPECT_EQ(model->images[0].name, "000001.png");  // by name, not as stored
  const auto& turned = model->images[1];
  EXPECT_LT((turned.cam_from_world * Vec3d(0, 0, 1) - Vec3d(2, 2, 3)).norm(), 1e-12);
  ASSERT_EQ(turned.observations.size(), 2u);
  EXPECT_EQ(turned.observations[0].point, 42);
  EXPECT_EQ(turned.observations[1].point, -1);
  EXPECT_EQ(turned.observations[1].pixel, Vec2d(11.5, 20.5));
  EXPECT_EQ(model->points.at(42).views, 2);
  EXPECT_EQ(model->points.at(42).position, Vec3d(0.1, 0.2, 2.0));
}

TEST(ColmapModel, EveryTruncationIsAnErrorNotACrash) {
  ModelFolder folder;
  const std::size_t c = folder.cameras.data.size(), i = folder.images.data.size(),
                    p = folder.points.data.size();
  for (std::size_t cut = 0; cut < c; ++cut) {
    folder.write(cut, i, p);
    EXPECT_FALSE(read_colmap_model(folder.path).ok()) << "cameras.bin cut at " << cut;
  }
  for (std::size_t cut = 0; cut < i; ++cut) {
    folder.write(c, cut, p);
    EXPECT_FALSE(read_colmap_model(folder.path).ok()) << "images.bin cut at " << cut;
  }
  for (std::size_t cut = 0; cut < p; ++cut) {
    folder.write(c, i, cut);
    EXPECT_FALSE(read_colmap_model(folder.path).ok()) << "points3D.bin cut at " << cut;
  }
}

TEST(ColmapModel, AbsurdCountsTakeNoMemory) {
  ModelFolder folder;
  const std::uint64_t absurd = 1ull << 60;
  std::memcpy(folder.images.data.data(), &absurd, sizeof absurd);
  folder.write_whole();
  const auto model = read_colmap_model(folder.path);
  ASSERT_FALSE(model.ok());
  EXPECT_FALSE(model.error().fix.empty());
}

TEST(ColmapModel, CamerasCanBeReplacedByOnesWithEveryNumber) {
  ModelFolder folder;
  folder.write_whole();
  auto cameras = read_colmap_model(folder.path)->cameras;
  ASSERT_EQ(cameras.size(), 1u);
  Intrinsics& k = cameras.begin()->second;
  k.fy = 640.5, k.p2 = 0.25;
  ASSERT_TRUE(write_colmap_cameras(folder.path, cameras));
  const auto read = read_colmap_model(folder.path);
  ASSERT_TRUE(read.ok()) << read.error().what;
  EXPECT_EQ(read->images.size(), 2u);
  EXPECT_EQ(read->cameras.begin()->first, cameras.begin()->first);
  const Intrinsics& again = read->cameras.begin()->second;
  EXPECT_EQ(again.width, k.width);
  EXPECT_EQ(again.height, k.height);
  EXPECT_EQ(again.fx, k.fx);
  EXPECT_EQ(again.fy, 640.5);
  EXPECT_EQ(again.cx, k.cx);
  EXPECT_EQ(again.cy, k.cy);
  EXPECT_EQ(again.k1, k.k1);
  EXPECT_EQ(again.k2, k.k2);
  EXPECT_EQ(again.p1, k.p1);
  EXPECT_EQ(again.p2, 0.25);
}

TEST(ColmapModel, ReprojectionIsTheMeanDistanceOfObservations) {
  ColmapModel model;
  Intrinsics k;
  k.width = k.height = 100, k.fx = k.fy = 100, k.cx = k.cy = 50;
  model.cameras[1] = k;
  model.points[5] = {Vec3d(0, 0, 2), 0, 2};
  ColmapImage image;
  image.camera = 1;
  image.observations = {{{53, 54}, 5}, {{50, 50}, 5}, {{0, 0}, -1}};
  model.images.push_back(image);
  EXPECT_NEAR(mean_reprojection_px(model), 2.5, 1e-12);
}

}  // namespace
}  // namespace likeness
