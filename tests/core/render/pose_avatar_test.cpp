// Claims about the rig of an avatar from a file: what does not fit its head model is refused, and nothing is
// posed.
#include "core/render/pose_avatar.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "core/head/builtin_head.h"
#include "tests/core/render/tiny_avatar.h"

namespace likeness {
namespace {

const HeadModel& rigged_head() {
  static const HeadModel model = make_builtin_head();
  return model;
}

Avatar rigged_avatar() {
  Avatar a = tiny_avatar();
  const HeadModel& model = rigged_head();
  a.person.identity = Eigen::VectorXf::Zero(model.identity_count());
  a.person.offsets.assign(std::size_t(model.vertex_count()), Vec3f::Zero());
  a.neutral = neutral_articulation(model);
  a.condition.mean = Eigen::VectorXf::Zero(model.expression_count() + 9);
  a.condition.rows = Eigen::MatrixXf::Zero(2, model.expression_count() + 9);
  a.warp_cell = 0.02f;
  return a;
}

TEST(MakeRig, AnAvatarOfTheModelIsRigged) {
  const auto rig = make_rig(rigged_avatar(), rigged_head());
  ASSERT_TRUE(rig.ok()) << rig.error().what;
  EXPECT_FALSE(pose_avatar(*rig, {.articulation = neutral_articulation(rigged_head())}).warp.empty());
}

TEST(MakeRig, NumbersThatCannotBeTheModelsAreRefused) {
  struct Fault {
    std::string name;
    std::function<void(Avatar&)> apply;
  };
  const std::vector<Fault> faults{
      {"identity of 5,000", [](Avatar& a) { a.person.identity = Eigen::VectorXf::Zero(5000); }},
      {"identity of 300 each", [](Avatar& a) { a.person.identity.setConstant(300); }},
      {"identity of 1e6 each", [](Avatar& a) { a.person.identity.setConstant(1e6f); }},
      {"7 offsets", [](Avatar& a) { a.person.offsets.resize(7); }},
      {"a vertex at 1e6 m", [](Avatar& a) { a.person.offsets[100].x() = 1e6f; }},
      {"a vertex nowhere",
       [](Avatar& a) { a.person.offsets[9].y() = std::numeric_limits<float>::quiet_NaN(); }},
      {"5 expressions", [](Avatar& a) { a.neutral.expression = Eigen::VectorXf::Zero(5); }},
      {"552 expressions", [](Avatar& a) { a.neutral.expression = Eigen::VectorXf::Zero(552); }},
      {"a condition of others", [](Avatar& a) { a.condition.mean = Eigen::VectorXf::Zero(14); }},
      {"detail at vertex 16,000,000",
       [](Avatar& a) {
         const auto inputs = a.neutral.expression.size() + 3;
         a.detail.vertices = {16'000'000};
         a.detail.mean = Eigen::VectorXf::Zero(1), a.detail.basis = Eigen::MatrixXf::Zero(1, 1);
         a.detail.middle = Eigen::VectorXf::Zero(inputs), a.detail.rows = Eigen::MatrixXf::Zero(1, inputs);
         a.detail.low = a.detail.high = Eigen::VectorXf::Zero(1);
       }},
  };
  for (const Fault& fault : faults) {
    Avatar avatar = rigged_avatar();
    fault.apply(avatar);
    const auto fits = check_numbers_fit(avatar, rigged_head());
    ASSERT_FALSE(fits.ok()) << fault.name;
    EXPECT_EQ(fits.error().code, ErrorCode::bad_input) << fault.name;
    EXPECT_FALSE(fits.error().fix.empty()) << fault.name;
    EXPECT_FALSE(make_rig(avatar, rigged_head()).ok()) << fault.name;
  }
}

}  // namespace
}  // namespace likeness
