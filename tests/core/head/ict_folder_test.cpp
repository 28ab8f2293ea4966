// Claims about ICT-FaceKit's folder, on meshes made here in its order of vertices: every shape is the
// difference of two files in metres, the jaw's turn is the jawOpen shape, and a bad file is named with its
// line.
#include "core/head/ict_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>

#include "core/head/load_head_model.h"
#include "core/head/pose_head.h"
#include "tests/core/head/bytes_of.h"
#include "tests/core/head/ict_head.h"

namespace likeness {
namespace {

using ::testing::HasSubstr;

constexpr int kAll = 26719;

// Points in ICT's order: skin on an ellipsoid that reaches down to the neck, eyeballs on spheres, the rest
// inside.
std::vector<Vec3f> made_up_mesh_cm() {
  std::vector<Vec3f> points;
  std::mt19937 random(2);
  std::uniform_real_distribution<float> unit(-1, 1);
  for (int v = 0; v < kAll; ++v) {
    const bool left = v >= 21451 && v < 23021, right = v >= 23021 && v < 24591;
    Vec3f direction(unit(random), unit(random), unit(random));
    direction.normalize();
    if (left || right)
      points.push_back(Vec3f(left ? 3.1f : -3.1f, 3.6f, 7.9f) + 1.3f * direction);
    else if (v < 11248)
      points.push_back({8 * direction.x(), -2.5f + 16 * direction.y(), 9 * direction.z()});
    else
      points.push_back({3 * direction.x(), -3 + 2 * direction.y(), 6 + 3 * direction.z()});
  }
  return points;
}

// jawOpen: what lies in front, below the joint, turns by 25.33 degrees about it, fading out upwards.
std::vector<Vec3f> jaw_open_cm(const std::vector<Vec3f>& neutral) {
  const Vec3f joint(0, -0.54732505f, 1.8191051f);
  const Eigen::AngleAxisf turn(25.33f * std::numbers::pi_v<float> / 180, Vec3f::UnitX());
  std::vector<Vec3f> moved = neutral;
  for (std::size_t v = 0; v < 21451; ++v) {
    const float share =
        std::clamp((-2 - neutral[v].y()) / 4, 0.0f, 1.0f) * std::clamp((neutral[v].z() - 2) / 3, 0.0f, 1.0f);
    moved[v] = (1 - share) * neutral[v] + share * (turn * (neutral[v] - joint) + joint);
  }
  return moved;
}

void write_obj(const std::filesystem::path& path, const std::vector<Vec3f>& points) {
  std::string text = "# made up\n";
  char line[96];
  for (const Vec3f& p : points) {
    std::snprintf(line, sizeof line, "v %.6f %.6f %.6f\n", double(p.x()), double(p.y()), double(p.z()));
    text += line;
  }
  for (int v = 1; v + 3 <= kAll; v += 2) {  // quads and triangles through every vertex
    std::snprintf(line, sizeof line, v % 4 == 1 ? "f %d/1/1 %d/2/2 %d/3/3 %d/4/4\n" : "f %d %d %d\n", v,
                  v + 1, v + 2, std::min(v + 3, kAll));
    text += line;
  }
  std::ofstream(path, std::ios::binary) << text;
}

class IctFolder : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::filesystem::temp_directory_path() /
              std::string("likeness_ict_").append(std::to_string(std::random_device{}()));
    std::filesystem::create_directories(folder_ / "FaceXModel");
    neutral_ = made_up_mesh_cm();
    std::vector<Vec3f> wide = neutral_, smile = neutral_;
    for (Vec3f& p : wide) p.x() *= 1.1f;
    for (std::size_t v = 0; v < 500; ++v) smile[v] += Vec3f(0.3f, 0.2f, -0.1f);
    write_obj(mesh("generic_neutral_mesh"), neutral_);
    write_obj(mesh("identity000"), wide);
    write_obj(mesh("mouthSmile_L"), smile);
    write_obj(mesh("jawOpen"), jaw_open_cm(neutral_));
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(folder_); }
  static std::filesystem::path mesh(const std::string& name) {
    return folder_ / "FaceXModel" / std::string(name).append(".obj");
  }
  static inline std::filesystem::path folder_;
  static inline std::vector<Vec3f> neutral_;
};

TEST_F(IctFolder, LoadsItsMeshesInMetresWithNamesPartsAndLandmarks) {
  const auto model = load_head_model(folder_);
  ASSERT_TRUE(model.ok()) << model.error().what;
  EXPECT_EQ(model->name, "ICT-FaceKit");
  EXPECT_EQ(model->vertex_count(), 24591);
  EXPECT_EQ(model->identity_count(), 1);
  EXPECT_EQ(model->expression_names, (std::vector<std::string>{"jawOpen", "mouthSmile_L"}));
  EXPECT_LT((model->vertices[4000] - 0.01f * neutral_[4000]).norm(), 1e-7f);
  EXPECT_NEAR(model->identity_basis(3 * 4000, 0), 0.001f * neutral_[4000].x(), 2e-6f);
  EXPECT_NEAR(model->expression_basis(3 * 100 + 1, 1), 0.002f, 1e-6f);
  EXPECT_EQ(model->parts[9408], HeadPart::face);
  EXPECT_EQ(model->parts[9409], HeadPart::scalp_neck);
  EXPECT_EQ(model->parts[17039], HeadPart::teeth);
  EXPECT_EQ(model->parts[24590], HeadPart::right_eyeball);
  const auto landmarks = landmark_positions(*model, model->vertices);
  EXPECT_EQ(landmarks[0], model->vertices[1225]);
  EXPECT_EQ(landmarks[32],
            model->vertices[2075]);  // of those that the predictor draws where the list has them
  const float eyes = (landmarks[36] - landmarks[45]).norm();
  EXPECT_LT((landmarks[66] - model->vertices[5517]).norm(), 0.03f * eyes);
  const HeadShape shape = shape_head(*model, PersonShape{});
  EXPECT_LT((shape.joints[kLeftEye] - Vec3f(0.031f, 0.036f, 0.079f)).norm(), 2e-4f);
  EXPECT_LT((shape.joints[kJaw] - Vec3f(0, -0.0054732505f, 0.018191051f)).norm(), 1e-4f);
  for (int v = 0; v < model->vertex_count(); ++v) ASSERT_NEAR(model->skinning_weights.row(v).sum(), 1, 1e-5f);
}

TEST_F(IctFolder, TheJawsTurnIsTheJawOpenShape) {
  const auto model = load_ict_folder(folder_);
  ASSERT_TRUE(model.ok()) << model.error().what;
  const NamedAction* open = find_action(*model, "jawOpen");
  ASSERT_NE(open, nullptr);
  EXPECT_NEAR(open->jaw.x(), 25.33f * std::numbers::pi_v<float> / 180,
              0.01f);  // so the joint stands for the shape
  Articulation articulation = neutral_articulation(*model);
  articulation.jaw.x() = 25.33f * std::numbers::pi_v<float> / 180;
  const auto posed = pose_head(*model, shape_head(*model, PersonShape{}), articulation);
  float worst = 0;
  for (std::size_t v = 0; v < posed.size(); ++v)
    worst = std::max(worst, (posed[v] - model->vertices[v] -
                             model->expression_basis.col(0).segment<3>(3 * Eigen::Index(v)))
                                .norm());
  EXPECT_LT(worst, 1e-4f);
}

TEST_F(IctFolder, NamesTheFileThatIsMissingOrDisagrees) {
  const auto other = folder_ / "other";
  std::filesystem::create_directories(other);
  EXPECT_THAT(load_ict_folder(other).error().what, HasSubstr("has no generic_neutral_mesh.obj"));
  std::filesystem::copy_file(mesh("generic_neutral_mesh"), other / "generic_neutral_mesh.obj");
  EXPECT_THAT(load_ict_folder(other).error().what, HasSubstr("has no jawOpen.obj"));
  std::ofstream(other / "jawOpen.obj") << "v 0 0 0\n";
  EXPECT_THAT(load_ict_folder(other).error().what,
              HasSubstr("has 1 vertices where the neutral mesh has 26719"));
  EXPECT_EQ(ict_folder_files(other).size(), 2u);
  EXPECT_EQ(ict_folder_files(folder_).size(), 4u);
}

TEST(ParseObj, CutsPolygonsAndReadsAllFormsOfCorners) {
  const std::string text =
      "o x\nv 0 0 0\r\nv 1 0 0 0.5 0.5 0.5\nv\t1 1 0\nv 0 1e0 -0\nvt 0 0\nf 1/1 2/1 3/1 4/1\nf -4 -3 -2\nf "
      "1//1 2//1 4//1\n";
  const auto mesh = parse_obj(bytes_of(text), "x.obj");
  ASSERT_TRUE(mesh.ok()) << mesh.error().what;
  EXPECT_EQ(mesh->vertices.size(), 4u);
  const std::vector<Triangle> want{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {0, 1, 3}};
  EXPECT_EQ(mesh->triangles, want);
}

TEST(ParseObj, FaultsNameTheLine) {
  const auto fault = [](const std::string& text) {
    const auto mesh = parse_obj(bytes_of(text), "x.obj");
    return mesh ? "no fault found" : mesh.error().what;
  };
  EXPECT_THAT(fault("v 0 0 0\nv 1 2\n"), HasSubstr("Line 2 of x.obj does not hold three coordinates"));
  EXPECT_THAT(fault("v 0 0 nan\n"), HasSubstr("Line 1"));
  EXPECT_THAT(fault("v 0 0 1e300\n"), HasSubstr("Line 1"));
  EXPECT_THAT(fault("v 0 0 1e400\n"), HasSubstr("Line 1")) << "no double holds it";
  EXPECT_THAT(fault("v 0 0 0\nf 1 1 4294967297\n"), HasSubstr("Line 2"));
  EXPECT_EQ(fault("v 0 0 1e-400\n"), "no fault found");
  EXPECT_THAT(fault("v 0 0 0\n\nf 1 2 3\n"), HasSubstr("Line 3 of x.obj refers to vertex 3 of 1"));
  EXPECT_THAT(fault("v 0 0 0\nf 1 1 -2\n"), HasSubstr("Line 2 of x.obj refers to an impossible vertex"));
  EXPECT_THAT(fault("v 0 0 0\nf 1 1 99999999999999999999\n"), HasSubstr("Line 2"));
  EXPECT_THAT(fault("v 0 0 0\nf 1 1\n"), HasSubstr("fewer than three corners"));
  EXPECT_THAT(fault("f 1 x 2\n"), HasSubstr("not a number"));
}

}  // namespace
}  // namespace likeness
