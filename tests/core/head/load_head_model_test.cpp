// Claims about reading head models: nothing is lost, and every fault is named with its key and both sizes.
#include "core/head/load_head_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <random>

#include "tests/core/head/ict_head.h"
#include "tests/core/head/synthetic_head.h"

namespace likeness {
namespace {

using ::testing::HasSubstr;

class LoadHeadModel : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("likeness_load_head_" + std::to_string(std::random_device{}()) +
               std::to_string(std::random_device{}()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Result<HeadModel> load(const NpzArchive& archive) {
    const std::filesystem::path path = folder_ / "head.npz";
    const Result<void> written = write_npz(path, archive);
    EXPECT_TRUE(written.ok());
    return load_head_model(path);
  }
  // The complaint about the synthetic model after `change`.
  template <class Change>
  std::string fault(Change change) {
    NpzArchive archive = archive_of(synthetic_head());
    change(archive);
    const Result<HeadModel> model = load(archive);
    if (model.ok()) return "no fault found";
    EXPECT_EQ(model.error().code, ErrorCode::bad_input);
    EXPECT_FALSE(model.error().fix.empty());
    EXPECT_THAT(model.error().where, HasSubstr("head.npz"));
    return model.error().what;
  }

  std::filesystem::path folder_;
};

TEST_F(LoadHeadModel, RoundTripKeepsEverything) {
  const HeadModel model = synthetic_head();
  const Result<HeadModel> read = load(archive_of(model));
  ASSERT_TRUE(read.ok()) << read.error().what;
  EXPECT_EQ(read->hash, content_hash(model));
  EXPECT_EQ(read->vertices, model.vertices);
  EXPECT_EQ(read->identity_basis, model.identity_basis);
  EXPECT_EQ(read->expression_basis, model.expression_basis);
  EXPECT_EQ(read->pose_basis, model.pose_basis);
  EXPECT_EQ(read->triangles, model.triangles);
  EXPECT_EQ(read->parts, model.parts);
  EXPECT_EQ(read->expression_names, model.expression_names);
  EXPECT_EQ(read->expression_min, Eigen::VectorXf::Zero(4));
  EXPECT_EQ(read->expression_max, Eigen::VectorXf::Ones(4));
  EXPECT_EQ(read->actions.size(), 4u);
  EXPECT_EQ(read->name, "head");
}

TEST_F(LoadHeadModel, ReadsHalfPrecisionBases) {
  const HeadModel model = synthetic_head();
  NpzArchive archive = archive_of(model);
  NpyArray& shapes = archive["shapedirs"];
  const std::vector<float> values = shapes.as_float();
  shapes.item_bytes = 2;
  shapes.data.resize(2 * values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Eigen::half half(values[i]);
    std::memcpy(shapes.data.data() + 2 * i, &half, 2);
  }
  const Result<HeadModel> read = load(archive);
  ASSERT_TRUE(read.ok()) << read.error().what;
  EXPECT_LT((read->identity_basis - model.identity_basis).cwiseAbs().maxCoeff(), 1e-5f);
  EXPECT_GT((read->identity_basis - model.identity_basis).cwiseAbs().maxCoeff(), 0);
}

TEST_F(LoadHeadModel, TakesNamesFromATextFileOfTheSameCount) {
  HeadModel model = synthetic_head();
  model.expression_names.clear();
  std::ofstream(folder_ / "a_expression_names.txt") << "one\ntwo\nthree\n";
  Result<HeadModel> read = load(archive_of(model));
  ASSERT_TRUE(read.ok()) << read.error().what;
  EXPECT_TRUE(read->expression_names.empty());  // three names for four expressions are not theirs
  EXPECT_TRUE(read->actions.empty());
  EXPECT_EQ(read->expression_min, Eigen::VectorXf::Constant(4, -3));
  EXPECT_EQ(read->expression_max, Eigen::VectorXf::Constant(4, 3));
  std::ofstream(folder_ / "b_expression_names.txt") << "one\ntwo\nthree\nfour\n";
  read = load(archive_of(model));
  ASSERT_TRUE(read.ok()) << read.error().what;
  EXPECT_EQ(read->expression_names, (std::vector<std::string>{"one", "two", "three", "four"}));
  EXPECT_EQ(read->expression_max, Eigen::VectorXf::Ones(4));
}

TEST_F(LoadHeadModel, PartsAndPoseCorrectivesMayBeAbsent) {
  NpzArchive archive = archive_of(synthetic_head());
  archive.erase("part_id");
  archive.erase("posedirs");
  archive.erase("n_expr");
  const Result<HeadModel> read = load(archive);
  ASSERT_TRUE(read.ok()) << read.error().what;
  EXPECT_EQ(read->pose_basis.cols(), 0);
  EXPECT_EQ(read->expression_count(), 4);
  for (const HeadPart part : read->parts) EXPECT_EQ(part, HeadPart::unknown);
}

TEST_F(LoadHeadModel, DividesUnlabelledBasesAsFlameDoes) {
  const HeadModel base = synthetic_head();
  for (const auto& [total, identity] : {std::pair{400, 300}, std::pair{150, 100}}) {
    HeadModel model = base;
    model.expression_names.clear();
    model.identity_basis = Eigen::MatrixXf::Constant(3 * base.vertex_count(), identity, 1e-3f);
    model.expression_basis = Eigen::MatrixXf::Constant(3 * base.vertex_count(), total - identity, 2e-3f);
    NpzArchive archive = archive_of(model);
    archive.erase("n_shape");
    archive.erase("n_expr");
    const Result<HeadModel> read = load(archive);
    ASSERT_TRUE(read.ok()) << read.error().what;
    EXPECT_EQ(read->identity_count(), identity);
    EXPECT_EQ(read->expression_basis, model.expression_basis);
  }
  EXPECT_THAT(fault([](NpzArchive& a) { a.erase("n_shape"), a.erase("n_expr"); }),
              HasSubstr("10 directions"));
}

TEST_F(LoadHeadModel, NamesTheMissingKey) {
  for (const char* key : {"v_template", "shapedirs", "J_regressor", "weights", "kintree_table", "f",
                          "lmk_faces_idx", "lmk_bary_coords"})
    EXPECT_EQ(fault([&](NpzArchive& a) { a.erase(key); }), std::string(key) + " is missing.");
}

TEST_F(LoadHeadModel, NamesTheWrongShapeAndTheRightOne) {
  const auto floats = [](std::vector<std::size_t> shape) {
    std::size_t count = 1;
    for (const std::size_t n : shape) count *= n;
    return npy_from_floats(shape, std::vector<float>(count, 0.1f));
  };
  const auto replaced = [&](const char* key, std::vector<std::size_t> shape) {
    return fault([&](NpzArchive& a) { a[key] = floats(shape); });
  };
  EXPECT_THAT(replaced("v_template", {120, 2}), HasSubstr("v_template has shape (120, 2) where (V, 3)"));
  EXPECT_THAT(replaced("shapedirs", {119, 3, 10}),
              HasSubstr("shapedirs has shape (119, 3, 10) where (120, 3, n)"));
  EXPECT_THAT(replaced("posedirs", {120, 3, 35}),
              HasSubstr("posedirs has shape (120, 3, 35) where (120, 3, 36)"));
  EXPECT_THAT(replaced("J_regressor", {4, 120}), HasSubstr("J_regressor has shape (4, 120) where (5, 120)"));
  EXPECT_THAT(replaced("weights", {120, 4}), HasSubstr("weights has shape (120, 4) where (120, 5)"));
  EXPECT_THAT(replaced("lmk_bary_coords", {51, 3}),
              HasSubstr("lmk_bary_coords has shape (51, 3) where (68, 3)"));
  EXPECT_THAT(replaced("f", {12}), HasSubstr("f has shape (12)"));
}

TEST_F(LoadHeadModel, RefusesIndicesThatPointNowhere) {
  const auto set_int = [](NpyArray& array, std::size_t index, std::int32_t value) {
    std::memcpy(array.data.data() + 4 * index, &value, 4);
  };
  EXPECT_THAT(fault([&](NpzArchive& a) { set_int(a["f"], 7, 120); }),
              HasSubstr("vertex 120 at flat index 7"));
  EXPECT_THAT(fault([&](NpzArchive& a) { set_int(a["f"], 0, -1); }), HasSubstr("vertex -1"));
  EXPECT_THAT(fault([&](NpzArchive& a) { set_int(a["lmk_faces_idx"], 3, 216); }),
              HasSubstr("lmk_faces_idx refers to triangle 216"));
  EXPECT_THAT(fault([&](NpzArchive& a) { set_int(a["part_id"], 3, 11); }),
              HasSubstr("part_id refers to part 11"));
  EXPECT_THAT(fault([&](NpzArchive& a) { set_int(a["kintree_table"], 1, 3); }),
              HasSubstr("joint 1 the parent 3"));
  EXPECT_THAT(fault([&](NpzArchive& a) { set_int(a["n_shape"], 0, 7); }),
              HasSubstr("n_shape 7 and n_expr 4"));
}

TEST_F(LoadHeadModel, RefusesValuesThatCannotBeAHead) {
  const auto set_float = [](NpyArray& array, std::size_t index, float value) {
    std::memcpy(array.data.data() + 4 * index, &value, 4);
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const char* key : {"v_template", "shapedirs", "posedirs", "J_regressor", "weights", "lmk_bary_coords"})
    EXPECT_THAT(fault([&](NpzArchive& a) { set_float(a[key], 9, nan); }),
                HasSubstr(std::string(key) + " holds a value that is not finite, at flat index 9"));
  EXPECT_THAT(fault([&](NpzArchive& a) { set_float(a["weights"], 10, 2.0f); }),
              HasSubstr("Row 2 of weights sums to"));
  EXPECT_THAT(fault([&](NpzArchive& a) { set_float(a["J_regressor"], 10, 2.0f); }), HasSubstr("J_regressor"));
  EXPECT_THAT(fault([&](NpzArchive& a) {
                HeadModel model = synthetic_head();
                for (Vec3f& vertex : model.vertices) vertex *= 100;  // centimetres
                a = archive_of(model);
              }),
              HasSubstr("metres"));
  EXPECT_THAT(fault([&](NpzArchive& a) { a["f"] = text_array({"a", "b"}); }), HasSubstr("f holds text"));
  EXPECT_THAT(fault([&](NpzArchive& a) {
                a["expression_names"] = text_array({"a", "b"});
              }),
              HasSubstr("2 names for 4 expressions"));
}

TEST_F(LoadHeadModel, AnAbsentFileIsAnErrorNotACrash) {
  const Result<HeadModel> model = load_head_model(folder_ / "nothing.npz");
  ASSERT_FALSE(model.ok());
  EXPECT_FALSE(model.error().fix.empty());
}

TEST(IctHead, LoadsWithNamesPartsAndActions) {
  LIKENESS_NEED_ICT_HEAD(model);
  EXPECT_EQ(model.name, "ICT-FaceKit");
  EXPECT_EQ(model.vertex_count(), 8880);
  EXPECT_EQ(model.identity_count(), 100);
  EXPECT_EQ(model.expression_count(), 53);
  EXPECT_EQ(model.actions.size(), 53u);
  EXPECT_EQ(std::count(model.parts.begin(), model.parts.end(), HeadPart::teeth), 1150);
  EXPECT_EQ(model.hash.size(), 32u);
}

}  // namespace
}  // namespace likeness
