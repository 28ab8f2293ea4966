// Claims about exported heads, checked by readers that know the formats and are independent of the writer.
#include "core/export/head_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <numbers>

#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/head/pose_head.h"
#include "core/render/camera_path.h"
#include "tests/core/export/tiny_project.h"
#include "tests/support/run_program.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

template <class T>
T at(std::span<const std::byte> bytes, std::size_t offset) {
  T value{};
  if (offset + sizeof(T) > bytes.size()) throw std::runtime_error("read beyond the end");
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

void demand(bool holds, const std::string& what) {
  if (!holds) throw std::runtime_error(what);
}

// A strict reader of glTF 2.0's .glb with one buffer. Throws at the first violation.
struct Glb {
  json document;
  std::vector<std::byte> file;
  std::span<const std::byte> bin;

  explicit Glb(const fs::path& path) : file(*read_file(path)) {
    demand(at<std::uint32_t>(file, 0) == 0x46546C67 && at<std::uint32_t>(file, 4) == 2, "header");
    demand(at<std::uint32_t>(file, 8) == file.size(), "length of the file");
    std::size_t offset = 12;
    const auto chunk = [&](std::uint32_t type) {
      const auto length = at<std::uint32_t>(file, offset);
      demand(length % 4 == 0 && at<std::uint32_t>(file, offset + 4) == type, "chunk");
      const auto body = std::span(file).subspan(offset + 8, length);
      offset += 8 + length;
      return body;
    };
    const auto text = chunk(0x4E4F534A);
    document = json::parse(reinterpret_cast<const char*>(text.data()),
                           reinterpret_cast<const char*>(text.data() + text.size()));
    bin = chunk(0x004E4942);
    demand(offset == file.size(), "something after the last chunk");
    demand(document.at("asset").at("version") == "2.0", "version");
    const std::size_t length = document.at("buffers").at(0).at("byteLength");
    demand(document.at("buffers").size() == 1 && length <= bin.size() && bin.size() < length + 4, "buffer");
    for (const json& view : document.at("bufferViews")) {
      demand(view.at("byteOffset").get<std::size_t>() + view.at("byteLength").get<std::size_t>() <= length,
             "view beyond the buffer");
      demand(view.at("byteLength").get<std::size_t>() > 0, "empty view");
    }
  }

  int columns(const json& accessor) const {
    const std::string type = accessor.at("type");
    return type == "SCALAR" ? 1 : type == "VEC2" ? 2 : type == "VEC3" ? 3 : throw std::runtime_error(type);
  }
  // Values of an accessor, after its place, alignment and bounds were checked.
  template <class T>
  std::vector<T> values(int index, int component, int wanted_columns) const {
    const json& accessor = document.at("accessors").at(std::size_t(index));
    const json& view = document.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
    const std::size_t offset = view.at("byteOffset").get<std::size_t>() + accessor.value("byteOffset", 0u);
    const std::size_t count = accessor.at("count");
    demand(accessor.at("componentType") == component && columns(accessor) == wanted_columns,
           "kind of accessor");
    demand(offset % sizeof(T) == 0, "alignment");
    demand(count > 0 &&
               count * std::size_t(wanted_columns) * sizeof(T) <= view.at("byteLength").get<std::size_t>(),
           "accessor beyond its view");
    std::vector<T> out;
    for (std::size_t i = 0; i < count * std::size_t(wanted_columns); ++i)
      out.push_back(at<T>(bin, offset + i * sizeof(T)));
    if (accessor.contains("min")) {
      for (std::size_t c = 0; c < std::size_t(wanted_columns); ++c) {
        T low = out[c], high = out[c];
        for (std::size_t i = c; i < out.size(); i += std::size_t(wanted_columns))
          low = std::min(low, out[i]), high = std::max(high, out[i]);
        demand(accessor.at("min").at(c).get<T>() == low && accessor.at("max").at(c).get<T>() == high,
               "bounds");
      }
    }
    return out;
  }
  std::vector<float> floats(const json& index, int wanted_columns) const {
    return values<float>(index.get<int>(), 5126, wanted_columns);
  }
  bool has_bounds(const json& index) const {
    return document.at("accessors").at(index.get<std::size_t>()).contains("min");
  }
};

AvatarPose posed(double yaw, float jaw) {
  const Avatar avatar = filmed_avatar();
  const Vec3d neck = shape_head(tiny_head(), avatar.person).joints[kNeck].cast<double>();
  return {.world_from_head = turned_head(avatar.world_from_head, neck, yaw, 0, 0),
          .world_from_torso = avatar.world_from_torso,
          .articulation = *articulate(tiny_head(), avatar.neutral, {{"jawOpen", jaw}})};
}

const Provenance kMade = provenance("someone", "0123abcd", {});

TEST(HeadMesh, IsThePosedHeadInTheTypicalHeadsAxes) {
  const Avatar avatar = filmed_avatar();
  const HeadMesh rest = head_mesh(avatar, tiny_head(), posed(0, 0));
  const auto expected = pose_head(tiny_head(), shape_head(tiny_head(), avatar.person), avatar.neutral);
  for (std::size_t v = 0; v < expected.size(); v += 97)
    EXPECT_LT((rest.positions[v] - expected[v]).norm(), 1e-5f);
  // Turned by a quarter to its left, the face looks along +x.
  const HeadMesh turned = head_mesh(avatar, tiny_head(), posed(std::numbers::pi / 2, 0));
  const auto marks = landmark_positions(tiny_head(), turned.positions);
  EXPECT_GT(marks[30].x(), marks[27].x() + 0.005f);  // the nose's tip before its root
  // The shoulders stay, and the face moves as one piece.
  int resting = 0;
  for (std::size_t v = 0; v < expected.size(); ++v) {
    if (tiny_head().skinning_weights(Eigen::Index(v), kRoot) < 1) continue;
    EXPECT_LT((turned.positions[v] - rest.positions[v]).norm(), 1e-6f);
    ++resting;
  }
  EXPECT_GT(resting, 100);
  const auto marks_at_rest = landmark_positions(tiny_head(), rest.positions);
  EXPECT_NEAR((marks[36] - marks[45]).norm(), (marks_at_rest[36] - marks_at_rest[45]).norm(), 1e-5f);
  AvatarPose moved = posed(0, 0);
  moved.world_from_torso.pretranslate(Vec3d(0.1, 0, 0));
  const HeadMesh body = head_mesh(avatar, tiny_head(), moved);
  const auto most =
      std::ranges::max_element(body.positions, {}, [](const Vec3f& p) { return p.squaredNorm(); }) -
      body.positions.begin();
  EXPECT_NEAR((body.positions[std::size_t(most)] - rest.positions[std::size_t(most)]).norm(), 0.1f, 1e-5f);
  for (const Vec3f& normal : turned.normals) EXPECT_NEAR(normal.norm(), 1, 1e-4f);
}

TEST(Glb, AStillHeadReadsBackExactly) {
  const TinyProject project;
  const fs::path path = project.root / "head.glb";
  const HeadMesh mesh = head_mesh(filmed_avatar(), tiny_head(), posed(0.3, 0.5f));
  ASSERT_TRUE(write_glb(path, {&mesh, 1}, std::vector<double>{0}, kMade).ok());
  const Glb glb(path);
  const json& primitive = glb.document.at("meshes").at(0).at("primitives").at(0);
  const json& attributes = primitive.at("attributes");
  ASSERT_TRUE(glb.has_bounds(attributes.at("POSITION")));
  const auto positions = glb.floats(attributes.at("POSITION"), 3),
             normals = glb.floats(attributes.at("NORMAL"), 3);
  const auto uvs = glb.floats(attributes.at("TEXCOORD_0"), 2);
  const auto corners = glb.values<std::uint32_t>(primitive.at("indices").get<int>(), 5125, 1);
  ASSERT_EQ(positions.size(), 3 * mesh.positions.size());
  ASSERT_EQ(normals.size(), positions.size());
  ASSERT_EQ(uvs.size(), 2 * mesh.positions.size());
  ASSERT_EQ(corners.size(), 3 * mesh.triangles.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    ASSERT_EQ(positions[i], mesh.positions[i / 3][Eigen::Index(i % 3)]);
    ASSERT_EQ(normals[i], mesh.normals[i / 3][Eigen::Index(i % 3)]);
  }
  for (std::size_t v = 0; v < mesh.uvs.size(); ++v) {
    ASSERT_EQ(uvs[2 * v], mesh.uvs[v].x());
    ASSERT_EQ(uvs[2 * v + 1], 1 - mesh.uvs[v].y());  // glTF's origin is at the top
  }
  for (const std::uint32_t corner : corners) ASSERT_LT(corner, mesh.positions.size());
  EXPECT_FALSE(glb.document.contains("animations"));
  EXPECT_EQ(glb.document.at("scenes").at(glb.document.at("scene").get<std::size_t>()).at("nodes"),
            json::array({0}));
  EXPECT_EQ(glb.document.at("nodes").at(0).at("mesh"), 0);
  const json& extras = glb.document.at("asset").at("extras");
  EXPECT_EQ(extras.at("synthetic"), true);
  EXPECT_EQ(extras.at("digital_source_type"), kDigitalSourceType);
  EXPECT_EQ(extras.at("avatar_hash"), "0123abcd");
}

TEST(Glb, AMovingHeadShowsEveryFrameAtItsTime) {
  const TinyProject project;
  const fs::path path = project.root / "head.glb";
  std::vector<HeadMesh> frames;
  for (int i = 0; i < 4; ++i)
    frames.push_back(head_mesh(filmed_avatar(), tiny_head(), posed(0.1 * i, 0.2f * float(i))));
  const std::vector<double> times_s{0, 0.05, 0.1, 2.5};  // a clip may pause
  ASSERT_TRUE(write_glb(path, frames, times_s, kMade).ok());
  const Glb glb(path);
  const json& mesh = glb.document.at("meshes").at(0);
  const json &primitive = mesh.at("primitives").at(0), &animation = glb.document.at("animations").at(0);
  const json& sampler = animation.at("samplers").at(0);
  const std::size_t targets = primitive.at("targets").size();
  ASSERT_EQ(targets, 3u);
  EXPECT_EQ(mesh.at("weights").size(), targets);
  EXPECT_EQ(animation.at("channels").at(0).at("target").at("path"), "weights");
  ASSERT_TRUE(glb.has_bounds(sampler.at("input")));
  const auto times = glb.floats(sampler.at("input"), 1), weights = glb.floats(sampler.at("output"), 1);
  ASSERT_EQ(times.size(), 4u);
  ASSERT_EQ(weights.size(), times.size() * targets);
  const auto base = glb.floats(primitive.at("attributes").at("POSITION"), 3);
  for (std::size_t f = 0; f < 4; ++f) {
    EXPECT_FLOAT_EQ(times[f], float(times_s[f]));
    std::vector<float> shown = base;  // as a viewer computes it
    for (std::size_t t = 0; t < targets; ++t) {
      ASSERT_TRUE(glb.has_bounds(primitive.at("targets").at(t).at("POSITION")));
      const auto offset = glb.floats(primitive.at("targets").at(t).at("POSITION"), 3);
      ASSERT_EQ(offset.size(), base.size());
      for (std::size_t i = 0; i < shown.size(); ++i) shown[i] += weights[f * targets + t] * offset[i];
    }
    for (std::size_t i = 0; i < shown.size(); ++i)
      ASSERT_NEAR(shown[i], frames[f].positions[i / 3][Eigen::Index(i % 3)], 1e-6f) << "frame " << f;
  }
}

// VTK's own reader, through Python: number of points, of cells, bounds, and whether there are normals.
TEST(Ply, VtkReadsIt) {
  const TinyProject project;
  const fs::path path = project.root / "head.ply";
  const HeadMesh mesh = head_mesh(filmed_avatar(), tiny_head(), posed(0.3, 0.5f));
  ASSERT_TRUE(write_ply(path, mesh, kMade).ok());
  const ProgramResult read =
      run_program({"/usr/bin/python3", "-c",
                   "import sys\n"
                   "try:\n"
                   "  from vtkmodules.vtkIOPLY import vtkPLYReader\n"
                   "except ImportError:\n"
                   "  sys.exit(77)\n"
                   "r = vtkPLYReader(); r.SetFileName(sys.argv[1]); r.Update(); p = r.GetOutput()\n"
                   "print(p.GetNumberOfPoints(), p.GetNumberOfPolys(), p.GetPointData().GetNormals() is not "
                   "None, *p.GetBounds())",
                   path.string()});
  if (read.exit_code == 77 || read.exit_code == 127) GTEST_SKIP() << "VTK's Python modules are not installed";
  ASSERT_EQ(read.exit_code, 0) << read.err;
  std::istringstream words(read.out);
  std::size_t points = 0, cells = 0;
  std::string normals;
  std::array<float, 6> bounds{};
  words >> points >> cells >> normals;
  for (float& bound : bounds) words >> bound;
  EXPECT_EQ(points, mesh.positions.size());
  EXPECT_EQ(cells, mesh.triangles.size());
  EXPECT_EQ(normals, "True");
  Vec3f low = mesh.positions[0], high = low;
  for (const Vec3f& p : mesh.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(bounds[std::size_t(2 * axis)], low[axis], 1e-5f);
    EXPECT_NEAR(bounds[std::size_t(2 * axis + 1)], high[axis], 1e-5f);
  }
}

TEST(Ply, HoldsWhatItsHeaderSays) {
  const TinyProject project;
  const fs::path path = project.root / "head.ply";
  const HeadMesh mesh = head_mesh(filmed_avatar(), tiny_head(), posed(0, 0));
  ASSERT_TRUE(write_ply(path, mesh, provenance("two\nlines", "0123abcd", {})).ok());
  const std::string file = *read_text(path);
  const std::size_t end = file.find("end_header\n") + 11;
  std::istringstream header(file.substr(0, end));
  std::size_t row = 0, vertices = 0, faces = 0;
  json facts;
  bool in_vertices = false;
  for (std::string line; std::getline(header, line);) {
    std::istringstream words(line);
    std::string word, second;
    words >> word >> second;
    if (word == "comment" && second == "provenance") facts = json::parse(line.substr(19));
    if (word == "element") {
      in_vertices = second == "vertex";
      words >> (in_vertices ? vertices : faces);
    }
    if (word == "property" && in_vertices) row += 4;
    EXPECT_THAT(word, testing::AnyOf("ply", "format", "comment", "element", "property", "end_header"));
  }
  EXPECT_EQ(vertices, mesh.positions.size());
  EXPECT_EQ(faces, mesh.triangles.size());
  EXPECT_EQ(file.size(), end + vertices * row + faces * 13);
  EXPECT_EQ(facts.at("digital_source_type"), kDigitalSourceType);
  EXPECT_EQ(facts.at("avatar_hash"), "0123abcd");
}

TEST(WriteHead, RefusesMoreFramesThanTheFormatHolds) {
  const TinyProject project;
  const OpenedAvatar opened = tiny_opened();
  const std::vector<AvatarPose> many(kMaxMeshFrames + 1, posed(0, 0));
  const auto write = [&](const char* name, std::size_t frames, std::stop_token stop) {
    const Film film{frames, [&](std::size_t i) { return FilmFrame{{}, many[i]}; }};
    return write_head(opened, film, steady_times(int(frames), 25), project.root / name, kMade, Progress(),
                      stop);
  };
  EXPECT_FALSE(write("a.ply", 2, {}).ok());
  EXPECT_FALSE(write("a.glb", many.size(), {}).ok());
  std::stop_source stop;
  stop.request_stop();
  const auto stopped = write("a.glb", 2, stop.get_token());
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
  EXPECT_FALSE(fs::exists(project.root / "a.glb"));
  const auto written = write("a.glb", 2, {});
  ASSERT_TRUE(written.ok());
  EXPECT_EQ(*written, 2);
}

}  // namespace
}  // namespace likeness::test
