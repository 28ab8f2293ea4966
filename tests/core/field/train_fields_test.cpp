// Claims about core/field/train_fields.h: the division of samples among blocks and threads changes only
// rounding, and a loss sees what it needs. Parity with the reference: evaluate_test.cpp.
#include "core/field/train_fields.h"

#include <atomic>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "core/field/evaluate.h"
#include "tests/core/field/random_field.h"
#include "tests/core/field/relative_l2.h"

namespace likeness {
namespace {

FieldConfig head_like() {
  FieldConfig config;
  config.condition_count = 3, config.latent_count = 2;
  config.position = {3, 4, 4, 10, 4, 32};
  config.ambient_grid = {2, 3, 2, 8, 4, 12};
  return config;
}
FieldConfig torso_like() {
  FieldConfig config;
  config.position = {3, 3, 2, 9, 4, 24};
  config.view_direction = false;
  return config;
}

struct Learner {
  Field field;
  Batch batch;
  std::shared_ptr<FieldTape> tape = make_tape();
  FieldOutputs out;
  FieldGradients gradients;
  FieldPrecision precision;

  Learner(const FieldConfig& config, std::size_t count, std::uint32_t seed,
          FieldPrecision given = FieldPrecision::exact)
      : field(trained_like_field(config, seed)),
        batch(random_batch(config, count, 5, seed + 1)),
        gradients(make_gradients(field, batch.views)),
        precision(given) {
    gradients.want_conditions = gradients.want_positions = true;
  }
  FieldStep step(std::span<const std::size_t> ends) {
    return {field, batch.inputs(), ends, out, batch.output_gradients(), *tape, gradients, precision};
  }
};

// `count` samples in blocks of sizes that no tile divides, some empty.
std::vector<std::size_t> uneven(std::size_t count, std::size_t blocks) {
  std::vector<std::size_t> ends;
  for (std::size_t b = 1; b < blocks; ++b) ends.push_back(count * (b - b % 3) / blocks);
  ends.push_back(count);
  return ends;
}

class TrainFields : public testing::TestWithParam<FieldPrecision> {};
INSTANTIATE_TEST_SUITE_P(Precisions, TrainFields,
                         testing::Values(FieldPrecision::exact, FieldPrecision::bf16), [](const auto& info) {
                           return info.param == FieldPrecision::exact ? "Exact" : "Bf16";
                         });

TEST_P(TrainFields, BlocksOfAnySizeGiveTheGradientsOfOneBatch) {
  constexpr std::size_t kCount = 3001;
  Learner whole(head_like(), kCount, 3, GetParam());
  train_field(whole.field, whole.batch.inputs(), whole.out, whole.batch.output_gradients(), *whole.tape,
              whole.gradients, GetParam());
  for (const std::size_t blocks : {1, 7, 50, 400}) {
    Learner some(head_like(), kCount, 3, GetParam());
    const std::vector<std::size_t> ends = uneven(kCount, blocks);
    const FieldStep step = some.step(ends);
    train_fields({&step, 1}, nullptr);
    EXPECT_EQ(some.out.sigma, whole.out.sigma);
    EXPECT_EQ(some.out.blue, whole.out.blue);
    EXPECT_LE(relative_l2(some.gradients.parameters, whole.gradients.parameters), 1e-5);
    EXPECT_LE(relative_l2(some.gradients.latents, whole.gradients.latents), 1e-5);
    EXPECT_LE(relative_l2(some.gradients.conditions, whole.gradients.conditions), 1e-5);
    EXPECT_EQ(some.gradients.touched, whole.gradients.touched);
    EXPECT_EQ(some.gradients.x, whole.gradients.x);
  }
}

TEST_P(TrainFields, LossSeesItsBlocksOutputsInEveryFieldAndItsGradientsAreUsed) {
  constexpr std::size_t kBlocks = 61, kHead = 2500, kTorso = 1111;
  const std::vector<std::size_t> head_ends = uneven(kHead, kBlocks), torso_ends = uneven(kTorso, kBlocks);
  const auto two = [&](bool by_loss) {
    auto head = std::make_unique<Learner>(head_like(), kHead, 5, GetParam());
    auto torso = std::make_unique<Learner>(torso_like(), kTorso, 6, GetParam());
    const std::vector<float> wanted = head->batch.sigma;
    if (by_loss) head->batch.sigma.assign(kHead, 1e9f);  // wrong until the loss says otherwise
    FieldOutputs truth_head, truth_torso;
    evaluate_field(head->field, head->batch.inputs(), truth_head, GetParam());
    evaluate_field(torso->field, torso->batch.inputs(), truth_torso, GetParam());
    std::vector<std::atomic<int>> calls(kBlocks);
    const auto loss = [&](std::size_t block) {
      ++calls[block];
      const auto begin = [&](const std::vector<std::size_t>& ends) {
        return block == 0 ? 0 : ends[block - 1];
      };
      for (std::size_t n = begin(head_ends); n < head_ends[block]; ++n) {
        EXPECT_EQ(head->out.sigma[n], truth_head.sigma[n]);
        head->batch.sigma[n] = wanted[n];
      }
      for (std::size_t n = begin(torso_ends); n < torso_ends[block]; ++n)
        EXPECT_EQ(torso->out.green[n], truth_torso.green[n]);
    };
    const FieldStep steps[2] = {head->step(head_ends), torso->step(torso_ends)};
    train_fields(steps, by_loss ? BlockLoss(loss) : nullptr);
    for (const std::atomic<int>& count : calls) EXPECT_EQ(count, by_loss ? 1 : 0);
    return std::pair{head->gradients.parameters, torso->gradients.parameters};
  };
  const auto known = two(false), learnt = two(true);
  EXPECT_EQ(known.first, learnt.first);
  EXPECT_EQ(known.second, learnt.second);
  const ThreadLimit one(1);
  const auto alone = two(true);
  EXPECT_EQ(learnt.first, alone.first);
  EXPECT_EQ(learnt.second, alone.second);
}

TEST(TrainFieldsDeathTest, BlocksThatLeaveSamplesOutAreReported) {
  Learner learner(torso_like(), 100, 7);
  const std::vector<std::size_t> ends{40, 90};
  const FieldStep step = learner.step(ends);
  EXPECT_DEATH(train_fields({&step, 1}, nullptr), "blocks of 90 samples, but 100");
}

}  // namespace
}  // namespace likeness
