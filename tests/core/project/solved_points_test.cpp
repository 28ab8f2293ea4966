// Claims about the points of a solved room: in metres, without those that are hardly known.
#include "core/project/solved_points.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <fstream>

namespace likeness {
namespace {

namespace fs = std::filesystem;

template <class T>
void put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// A model of no pictures, one camera and some points, as colmap writes it.
void write_model(const fs::path& folder,
                 const std::vector<std::pair<double, std::uint64_t>>& error_and_views) {
  fs::create_directories(folder);
  std::string cameras, images, points;
  put<std::uint64_t>(cameras, 1);
  put<std::int32_t>(cameras, 1);
  put<std::int32_t>(cameras, 4);
  put<std::uint64_t>(cameras, 540);
  put<std::uint64_t>(cameras, 960);
  for (const double p : {700.0, 700.0, 270.0, 480.0, 0.0, 0.0, 0.0, 0.0}) put(cameras, p);
  put<std::uint64_t>(images, 0);
  put<std::uint64_t>(points, error_and_views.size());
  for (std::size_t i = 0; i < error_and_views.size(); ++i) {
    put<std::uint64_t>(points, i + 1);
    for (const double v : {1.0 * double(i), 2.0, 3.0}) put(points, v);
    for (int c = 0; c < 3; ++c) put<std::uint8_t>(points, 9);
    put(points, error_and_views[i].first);
    put<std::uint64_t>(points, error_and_views[i].second);
    for (std::uint64_t v = 0; v < 2 * error_and_views[i].second; ++v) put<std::uint32_t>(points, 0);
  }
  std::ofstream(folder / "cameras.bin", std::ios::binary) << cameras;
  std::ofstream(folder / "images.bin", std::ios::binary) << images;
  std::ofstream(folder / "points3D.bin", std::ios::binary) << points;
}

TEST(SolvedPoints, AreInMetresAndWellKnown) {
  std::string name = (fs::temp_directory_path() / "likeness_points_XXXXXX").string();
  ASSERT_NE(::mkdtemp(name.data()), nullptr);
  Project project;
  project.folder = name;
  Track track;
  track.metres_per_unit = 0.5;
  const auto none = solved_points(project, track);
  ASSERT_TRUE(none.ok());
  EXPECT_TRUE(none->empty());
  write_model(fs::path(name) / "colmap" / "model", {{0.4, 5}, {0.4, 2}, {3.5, 9}, {1.0, 3}});
  const auto points = solved_points(project, track);
  ASSERT_TRUE(points.ok()) << points.error().what;
  ASSERT_EQ(points->size(), 2u);
  EXPECT_NEAR((points->front() - Vec3f(0, 1, 1.5f)).norm(), 0, 1e-6);
  EXPECT_NEAR((points->back() - Vec3f(1.5f, 1, 1.5f)).norm(), 0, 1e-6);
  write_model(fs::path(name) / "colmap" / "model",
              std::vector<std::pair<double, std::uint64_t>>(kMostSolvedPoints + 500, {0.4, 3}));
  const auto all = solved_points(project, track);
  ASSERT_TRUE(all.ok());
  EXPECT_EQ(all->size(), kMostSolvedPoints);
  fs::remove_all(name);
}

}  // namespace
}  // namespace likeness
