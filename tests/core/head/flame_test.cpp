// Claims about FLAME's own files: a pickle of its structure and size loads to the model it was made from, its
// landmarks come from the files beside it, and its relatives are refused by name.
#include "core/head/flame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numbers>

#include "core/base/files.h"
#include "core/head/flame_landmarks.h"
#include "core/head/load_head_model.h"
#include "tests/core/head/bytes_of.h"
#include "tests/core/head/pickle_writer.h"

namespace likeness {
namespace {

using namespace std::string_literals;
using ::testing::HasSubstr;

class FlameFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              std::string("likeness_flame_").append(std::to_string(std::random_device{}())) / "FLAME2020";
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_.parent_path()); }
  std::filesystem::path put(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  std::filesystem::path folder_;
};

const HeadModel& flame_sized() {
  static const HeadModel model = flame_sized_head();
  return model;
}

// Row r of the table, landmark i: a triangle that tells both. Degrees 0..limit, then -1..-limit.
std::int32_t contour_triangle(std::size_t row, std::size_t landmark) {
  return std::int32_t(100 * row + landmark);
}

void put_points(PickleWriter& w, const char* index_key, const char* weight_key,
                std::vector<std::size_t> shape, const std::vector<std::int32_t>& indices) {
  w.text(index_key).array(npy_from_ints(shape, indices));
  std::vector<float> weights;
  for (std::size_t i = 0; i < indices.size(); ++i) weights.insert(weights.end(), {0.5f, 0.25f, 0.25f});
  shape.push_back(3);
  w.text(weight_key).array(npy_from_doubles(shape, weights));
}

std::vector<std::int32_t> fixed_triangles(std::size_t count) {
  std::vector<std::int32_t> list;
  for (std::size_t i = 0; i < count; ++i) list.push_back(std::int32_t(7000 + i));
  return list;
}

std::vector<std::int32_t> table_triangles(std::size_t rows) {
  std::vector<std::int32_t> list;
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t i = 0; i < 17; ++i) list.push_back(contour_triangle(r, i));
  return list;
}

std::string as_npy(PickleWriter& w) {
  std::string header = "{'descr': '|O', 'fortran_order': False, 'shape': (), }";
  header.append(63 - (10 + header.size()) % 64, ' ');
  header += '\n';
  return "\x93NUMPY\x01\x00"s + char(header.size()) + '\0' + header + w.finish();
}

std::string landmark_embedding() {
  PickleWriter w;
  w.object_array([&] {
    w.raw("}(");
    put_points(w, "static_lmk_faces_idx", "static_lmk_bary_coords", {51}, fixed_triangles(51));
    put_points(w, "dynamic_lmk_faces_idx", "dynamic_lmk_bary_coords", {79, 17}, table_triangles(79));
    put_points(w, "full_lmk_faces_idx", "full_lmk_bary_coords", {1, 68}, fixed_triangles(68));
    w.raw("u");
  });
  return as_npy(w);
}

TEST_F(FlameFolder, RoundTripsAModelOfFlamesSize) {
  const HeadModel& model = flame_sized();
  const auto path = put("generic_model.pkl", flame_pickle(model));
  put("landmark_embedding.npy", landmark_embedding());
  const auto read = load_head_model(path);
  ASSERT_TRUE(read.ok()) << read.error().what << " " << read.error().fix;
  EXPECT_EQ(read->name, "FLAME 2020");
  EXPECT_EQ(read->vertex_count(), 5023);
  EXPECT_EQ(read->identity_count(), 300);
  EXPECT_EQ(read->expression_count(), 100);
  EXPECT_EQ(read->vertices, model.vertices);
  EXPECT_EQ(read->identity_basis, model.identity_basis);
  EXPECT_EQ(read->expression_basis, model.expression_basis);
  EXPECT_EQ(read->pose_basis, model.pose_basis);
  EXPECT_LT((read->joint_regressor - model.joint_regressor).cwiseAbs().maxCoeff(), 1e-7f);
  EXPECT_EQ(read->skinning_weights, model.skinning_weights);
  EXPECT_EQ(read->parents, model.parents);
  EXPECT_EQ(read->triangles, model.triangles);
  EXPECT_TRUE(read->expression_names.empty());
  // Eyeballs are known by their joints, nothing else by anything.
  for (int v = 0; v < 5023; ++v)
    ASSERT_EQ(read->parts[std::size_t(v)], v % 7 == 0 ? HeadPart::left_eyeball : HeadPart::unknown);
  // -- Landmarks: the frontal row of the table, then the 51 fixed ones
  EXPECT_EQ(read->landmark_triangle[0], contour_triangle(0, 0));
  EXPECT_EQ(read->landmark_triangle[16], contour_triangle(0, 16));
  EXPECT_EQ(read->landmark_triangle[17], 7000);
  EXPECT_EQ(read->landmark_triangle[67], 7050);
  EXPECT_EQ(read->landmark_barycentric[30], Vec3f(0.5f, 0.25f, 0.25f));
  ASSERT_TRUE(read->dynamic_contour.has_value());
  EXPECT_EQ(read->dynamic_contour->rows.size(), 79u);
}

TEST_F(FlameFolder, TheContourFollowsTheYawToBothSides) {
  HeadModel model = flame_sized();
  const auto path = folder_ / "generic_model.pkl";
  put("landmark_embedding.npy", landmark_embedding());
  const auto landmarks = read_flame_landmarks(path);
  ASSERT_TRUE(landmarks.ok()) << landmarks.error().what;
  const auto first_of = [](const DynamicContour& contour, double degrees) {
    return contour_at(contour, degrees * std::numbers::pi / 180)[0].triangle;
  };
  const DynamicContour& contour = *landmarks->contour;
  EXPECT_EQ(contour.limit_deg(), 39);
  EXPECT_EQ(first_of(contour, 0.4), 0);
  EXPECT_EQ(first_of(contour, 12), 1200);
  EXPECT_EQ(first_of(contour, 80), 3900);
  EXPECT_EQ(first_of(contour, -1), 4000);   // row 40
  EXPECT_EQ(first_of(contour, -39), 7800);  // row 78
  EXPECT_EQ(first_of(contour, -90), 7800);
  // Whatever the file's sense of direction: on the side that turns away the contour lies further in front.
  ASSERT_TRUE(attach_landmarks(*landmarks, "x", model).ok());
  const auto forward = [&](double degrees) {
    double left = 0, right = 0;
    const ContourRow& row = contour_at(*model.dynamic_contour, degrees * std::numbers::pi / 180);
    for (std::size_t i = 1; i <= 7; ++i)
      for (int k = 0; k < 3; ++k) {
        left += double(model.vertices[std::size_t(model.triangles[std::size_t(row[8 + i].triangle)][k])].z());
        right +=
            double(model.vertices[std::size_t(model.triangles[std::size_t(row[8 - i].triangle)][k])].z());
      }
    return left - right;
  };
  double sense = 0;
  for (int degree = 1; degree <= 39; ++degree) sense += degree * (forward(degree) - forward(-degree));
  EXPECT_GT(sense, 0);
}

TEST_F(FlameFolder, ReadsTheTwoOlderFilesToo) {
  const auto path = folder_ / "flame2023.pkl";
  PickleWriter fixed, table;
  fixed.raw("}(");
  put_points(fixed, "lmk_face_idx", "lmk_b_coords", {51}, fixed_triangles(51));
  fixed.raw("u");
  table.object_array([&] {
    table.raw("}(");
    put_points(table, "lmk_face_idx", "lmk_b_coords", {79, 17}, table_triangles(79));
    table.raw("u");
  });
  put("flame_static_embedding.pkl", fixed.finish());
  auto landmarks = read_flame_landmarks(path);
  ASSERT_FALSE(landmarks.ok());
  EXPECT_THAT(landmarks.error().what, HasSubstr("flame_dynamic_embedding.npy is not beside it"));
  put("flame_dynamic_embedding.npy", as_npy(table));
  landmarks = read_flame_landmarks(path);
  ASSERT_TRUE(landmarks.ok()) << landmarks.error().what;
  EXPECT_EQ(landmarks->points[20].triangle, 7003);
  EXPECT_EQ(landmarks->points[16].triangle, 16);
  EXPECT_EQ(landmark_files_beside(path).size(), 2u);
}

TEST_F(FlameFolder, WithoutAnEmbeddingTheErrorSaysWhichFileGoesWhere) {
  const auto path = put("generic_model.pkl", flame_pickle(flame_sized()));
  const auto read = load_head_model(path);
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().code, ErrorCode::not_found);
  EXPECT_THAT(read.error().what, HasSubstr("landmark_embedding.npy is not beside it"));
  EXPECT_THAT(read.error().fix, HasSubstr(folder_.string()));
}

TEST_F(FlameFolder, RefusesAnEmbeddingForAnotherMesh) {
  HeadModel model = flame_sized();
  model.triangles.resize(5000);
  put("landmark_embedding.npy", landmark_embedding());
  const auto landmarks = read_flame_landmarks(folder_ / "x.pkl");
  ASSERT_TRUE(landmarks.ok());
  const auto attached = attach_landmarks(*landmarks, "x", model);
  ASSERT_FALSE(attached.ok());
  EXPECT_THAT(attached.error().what, HasSubstr("beyond the model's 5000"));
}

TEST_F(FlameFolder, FilesHashCoversTheModelAndItsEmbedding) {
  const auto path = put("generic_model.pkl", "model");
  const auto alone = head_model_files_hash(path);
  put("landmark_embedding.npy", "embedding");
  const auto both = head_model_files_hash(path);
  put("landmark_embedding.npy", "another");
  const auto other = head_model_files_hash(path);
  ASSERT_TRUE(alone.ok() && both.ok() && other.ok());
  EXPECT_NE(*alone, *both);
  EXPECT_NE(*both, *other);
}

TEST_F(FlameFolder, FilesHashCoversTheNamesBesideAnNpz) {
  const auto path = put("head.npz", "model");
  const auto alone = head_model_files_hash(path);
  put("any_expression_names.txt", "jawOpen");
  const auto named = head_model_files_hash(path);
  ASSERT_TRUE(alone.ok() && named.ok());
  EXPECT_NE(*alone, *named);
}

TEST(Flame, RefusesRelatedModelsByName) {
  const auto refusal = [](std::size_t vertices, std::size_t joints) {
    PickleWriter w;
    w.raw("}(").text("v_template").array(npy_from_doubles({vertices, 3}, std::vector<float>(3 * vertices)));
    w.text("weights")
        .array(npy_from_doubles({vertices, joints}, std::vector<float>(joints * vertices)))
        .raw("u");
    const std::string pickle = w.finish();
    const auto archive = read_flame_pickle(bytes_of(pickle), "x.pkl");
    return archive ? "accepted" : archive.error().what;
  };
  EXPECT_THAT(refusal(6890, 24), HasSubstr("SMPL, a body model"));
  EXPECT_THAT(refusal(6890, 52), HasSubstr("SMPL-H"));
  EXPECT_THAT(refusal(10475, 55), HasSubstr("SMPL-X"));
  EXPECT_THAT(refusal(778, 16), HasSubstr("MANO"));
  EXPECT_EQ(refusal(5023, 5), "accepted");
}

TEST(Flame, TakesItsNameFromItsFiles) {
  EXPECT_EQ(flame_name("a/FLAME2020/female_model.pkl"), "FLAME 2020 (female)");
  EXPECT_EQ(flame_name("a/male_model.pkl"), "FLAME (male)");
  EXPECT_EQ(flame_name("a/flame2023_no_jaw.pkl"), "FLAME 2023 (expressions without jaw)");
  EXPECT_EQ(flame_name("generic_model.pkl"), "FLAME");
}

// DECA's embedding keeps its table as torch tensors: torch._utils._rebuild_tensor_v2 over a storage of bytes.
TEST(Flame, ReadsTorchTensorsInTheEmbedding) {
  const auto tensor = [](PickleWriter& w, const char* storage, const std::string& data, std::size_t count,
                         const std::vector<std::size_t>& shape, const std::vector<std::size_t>& stride) {
    PickleWriter magic, version, system, identity, keys;
    std::string saved = magic.integer(1).finish() + version.integer(1001).finish() + system.raw("}").finish();
    identity.raw("(")
        .text("storage")
        .global("torch", storage)
        .text("0")
        .text("cpu")
        .integer(std::int64_t(count));
    saved += identity.raw("NtQ").finish() + keys.raw("](").text("0").raw("e").finish();
    saved += std::string(8, '\0') + data;
    w.global("torch._utils", "_rebuild_tensor_v2")
        .raw("(")
        .global("torch.storage", "_load_from_bytes")
        .text(saved);
    w.raw("\x85R").integer(0).tuple(shape).tuple(stride).raw("\x89").raw("}tR");
  };
  const std::vector<std::int32_t> table = table_triangles(3);
  std::string indices, weights;
  for (const std::int32_t value : table) {
    const std::int64_t wide = value;
    indices.append(reinterpret_cast<const char*>(&wide), 8);
    for (const float weight : {0.2f, 0.3f, 0.5f}) weights.append(reinterpret_cast<const char*>(&weight), 4);
  }
  PickleWriter w;
  w.raw("}(").text("dynamic_lmk_faces_idx");
  tensor(w, "LongStorage", indices, 51, {3, 17}, {17, 1});
  w.text("dynamic_lmk_bary_coords");
  tensor(w, "FloatStorage", weights, 153, {3, 17, 3}, {51, 3, 1});
  w.raw("u");
  const std::string pickle = w.finish();
  const auto embedding = parse_landmark_embedding(bytes_of(pickle), "x");
  ASSERT_TRUE(embedding.ok()) << embedding.error().what;
  ASSERT_EQ(embedding->rows.size(), 3u);
  EXPECT_EQ(embedding->rows[2][5].triangle, contour_triangle(2, 5));
  EXPECT_NEAR(embedding->rows[2][5].barycentric[2], 0.5f, 1e-6f);
}

}  // namespace
}  // namespace likeness
