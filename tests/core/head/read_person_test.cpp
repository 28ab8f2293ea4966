// Claims about a given person's shape: coefficients and meshes round-trip, and errors say what was found and
// what is needed.
#include "core/head/read_person.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <limits>
#include <random>

#include "core/base/files.h"
#include "core/base/npz.h"
#include "core/head/pose_head.h"
#include "tests/core/head/builtin.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class ReadPerson : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              fmt::format("likeness_person_{}_{}", getpid(),
                          testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  static Eigen::VectorXf someone(float scale = 1) {
    std::mt19937 engine(3);
    std::normal_distribution<float> normal;
    Eigen::VectorXf identity(builtin().identity_count());
    for (float& value : identity) value = scale * normal(engine);
    return identity;
  }
  static std::vector<float> flat(const std::vector<Vec3f>& vertices) {
    std::vector<float> values;
    for (const Vec3f& v : vertices) values.insert(values.end(), {v.x(), v.y(), v.z()});
    return values;
  }
  static std::vector<Vec3f> mesh_of(const Eigen::VectorXf& identity) {
    return shape_head(builtin(), identity).vertices;
  }
  // Each key's array.
  fs::path npz(const std::string& name, const std::map<std::string, NpyArray>& arrays) const {
    EXPECT_TRUE(write_npz(folder_ / name, arrays).ok());
    return folder_ / name;
  }
  // NumPy's own format, version 1.0.
  fs::path npy(const std::string& name, const std::vector<std::size_t>& shape,
               const std::vector<float>& values) const {
    std::string tuple;
    for (const std::size_t n : shape) tuple += fmt::format("{}, ", n);
    std::string header = fmt::format("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}), }}", tuple);
    while ((header.size() + 11) % 64 != 0) header += ' ';
    header += '\n';
    std::string bytes("\x93NUMPY\x01\x00", 8);
    bytes += char(header.size() & 255), bytes += char(header.size() >> 8);
    bytes += header;
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
    EXPECT_TRUE(write_text(folder_ / name, bytes).ok());
    return folder_ / name;
  }
  fs::path obj(const std::string& name, const std::vector<Vec3f>& vertices,
               const std::vector<Triangle>& triangles) const {
    std::string text = "# a head\n";
    for (const Vec3f& v : vertices) text += fmt::format("v {:.9g} {:.9g} {:.9g}\n", v.x(), v.y(), v.z());
    for (const Triangle& t : triangles) text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    EXPECT_TRUE(write_text(folder_ / name, text).ok());
    return folder_ / name;
  }
  // The whole error message.
  static std::string refusal(const fs::path& path) {
    const auto person = read_person(path, builtin());
    EXPECT_FALSE(person.ok()) << path;
    if (person) return "";
    EXPECT_EQ(person.error().where, path.string());
    EXPECT_FALSE(person.error().fix.empty());
    return person.error().what + " " + person.error().fix;
  }
  static void expect_refused(const fs::path& path, const std::vector<std::string>& words) {
    const std::string message = refusal(path);
    for (const std::string& word : words)
      EXPECT_NE(message.find(word), std::string::npos) << word << ": " << message;
  }

  fs::path folder_;
};

TEST_F(ReadPerson, CoefficientsRoundTripBitForBit) {
  const Eigen::VectorXf identity = someone();
  const std::vector<float> values(identity.begin(), identity.end());
  const std::size_t n = values.size();
  const std::vector<fs::path> files{
      npy("a.npy", {n}, values), npy("b.npy", {1, n}, values),
      npz("c.npz", {{"shape", npy_from_floats({1, n}, values)},
                    {"expression", npy_from_floats({2}, std::vector<float>{1, 2})}}),
      npz("d.npz", {{"identity", npy_from_floats({n}, values)}}),
      npz("e.npz", {{"betas", npy_from_floats({n}, values)}})};
  for (const fs::path& file : files) {
    const auto person = read_person(file, builtin());
    ASSERT_TRUE(person.ok()) << file << ": " << person.error().what;
    EXPECT_EQ(person->identity, identity) << file;
    EXPECT_TRUE(person->offsets.empty());
  }
}

TEST_F(ReadPerson, AMeshIsExplainedByTheIdentityItWasMadeOf) {
  const Eigen::VectorXf identity = someone();
  const std::vector<Vec3f> mesh = mesh_of(identity);
  for (const fs::path& file :
       {npy("m.npy", {mesh.size(), 3}, flat(mesh)), npy("one.npy", {1, mesh.size(), 3}, flat(mesh)),
        npz("m.npz", {{"vertices", npy_from_floats({mesh.size(), 3}, flat(mesh))}}), obj("m.obj", mesh, {}),
        obj("faces.obj", mesh, builtin().triangles)}) {
    const auto person = read_person(file, builtin());
    ASSERT_TRUE(person.ok()) << file << ": " << person.error().what;
    const std::vector<Vec3f> again = shape_head(builtin(), *person).vertices;
    for (std::size_t v = 0; v < mesh.size(); ++v) ASSERT_LT((again[v] - mesh[v]).norm(), 2e-5f) << file;
  }
}

TEST_F(ReadPerson, OffsetsHoldWhatNoIdentityExplains) {
  std::vector<Vec3f> mesh = mesh_of(someone(0.5f));
  for (std::size_t v = 0; v < mesh.size(); v += 7) mesh[v] += Vec3f(0.001f, 0, 0.003f);  // a rash
  const auto person = read_person(npy("m.npy", {mesh.size(), 3}, flat(mesh)), builtin());
  ASSERT_TRUE(person.ok()) << person.error().what;
  ASSERT_EQ(person->offsets.size(), mesh.size());
  const std::vector<Vec3f> again = shape_head(builtin(), *person).vertices;
  for (std::size_t v = 0; v < mesh.size(); ++v) ASSERT_LT((again[v] - mesh[v]).norm(), 2e-5f);
}

TEST_F(ReadPerson, WrongSizeErrorsNameBothSizes) {
  const std::string own = std::to_string(builtin().identity_count()),
                    vertices = std::to_string(builtin().vertex_count());
  expect_refused(npy("mica.npy", {1, 300}, std::vector<float>(300, 0.1f)),
                 {"mica.npy holds 300", own, "MICA"});
  expect_refused(npy("few.npy", {17, 3}, std::vector<float>(51, 0.1f)),
                 {"17 vertices", vertices, "topology"});
  expect_refused(npy("odd.npy", {4, 5}, std::vector<float>(20, 0.1f)), {"(4, 5)", own, vertices});
  expect_refused(npz("other.npz", {{"pose", npy_from_floats({1}, std::vector<float>{0})},
                                   {"cam", npy_from_floats({1}, std::vector<float>{0})}}),
                 {"cam, pose", "identity, shape nor vertices"});
}

TEST_F(ReadPerson, RefusesValuesThatAreNotFinite) {
  std::vector<float> values(std::size_t(builtin().identity_count()), 0.f);
  values[5] = std::numeric_limits<float>::quiet_NaN();
  expect_refused(npy("nan.npy", {values.size()}, values), {"not finite, at 5"});
  values[5] = 37;
  expect_refused(npy("wild.npy", {values.size()}, values), {"Coefficient 5", "37"});
  std::vector<Vec3f> mesh = mesh_of(someone());
  mesh[9].y() = std::numeric_limits<float>::infinity();
  expect_refused(npy("mesh.npy", {mesh.size(), 3}, flat(mesh)), {"not finite, at 28"});
}

TEST_F(ReadPerson, RefusesUnitsOtherThanMetres) {
  const std::vector<Vec3f> mesh = mesh_of(someone());
  const auto scaled = [&](float by) {
    std::vector<Vec3f> other = mesh;
    for (Vec3f& v : other) v *= by;
    return other;
  };
  expect_refused(npy("mm.npy", {mesh.size(), 3}, flat(scaled(1000))), {"units tall", "millimetres", "1000"});
  expect_refused(npy("cm.npy", {mesh.size(), 3}, flat(scaled(100))), {"units tall", "centimetres"});
  expect_refused(obj("what.obj", scaled(18), {}), {"units tall", "metres"});
  expect_refused(npy("dot.npy", {mesh.size(), 3}, std::vector<float>(3 * mesh.size(), 0.f)),
                 {"0 units tall"});
}

TEST_F(ReadPerson, RefusesAnotherFrameOrTopology) {
  std::vector<Vec3f> mesh = mesh_of(someone());
  std::vector<Vec3f> moved = mesh;
  for (Vec3f& v : moved) v += Vec3f(0, 0.3f, 0.3f);
  expect_refused(npy("moved.npy", {mesh.size(), 3}, flat(moved)), {"0.42 m", "own frame"});
  std::vector<Vec3f> shuffled = mesh;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(1));
  expect_refused(npy("shuffled.npy", {mesh.size(), 3}, flat(shuffled)), {"another order"});
  std::vector<Triangle> faces = builtin().triangles;
  for (Triangle& t : faces) std::swap(t[0], t[1]), t[2] = (t[2] + 11) % builtin().vertex_count();
  expect_refused(obj("faces.obj", mesh, faces), {"another topology"});
}

TEST_F(ReadPerson, RefusesFilesThatHoldNoPerson) {
  expect_refused(folder_ / "mesh.ply", {"neither .npy, .npz nor .obj"});
  EXPECT_FALSE(read_person(folder_ / "absent.npy", builtin()).ok());
  ASSERT_TRUE(write_text(folder_ / "bad.npy", "no array").ok());
  EXPECT_FALSE(read_person(folder_ / "bad.npy", builtin()).ok());
  ASSERT_TRUE(write_text(folder_ / "bad.obj", "v 1 2\n").ok());
  EXPECT_FALSE(read_person(folder_ / "bad.obj", builtin()).ok());
}

}  // namespace
}  // namespace likeness
