// Claims about checkpoints that need no training.
#include "core/train/checkpoint.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <limits>

#include "core/base/files.h"
#include "core/train/condition_map.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

TrainingState ball_state(const TrainingSet& set) {
  const HeadShape shape = shape_head(set.model, set.person);
  std::vector<Articulation> articulations;
  for (const TrainingView& view : set.views) articulations.push_back(view.pose.articulation);
  return make_training_state(set, {}, learn_condition_map(set.model, shape, articulations),
                             make_volumes(set, shape));
}

TEST(Checkpoint, RefusesCutFilesAndLeavesTheStateAlone) {
  const auto path =
      std::filesystem::temp_directory_path() / ("likeness_checkpoint_" + std::to_string(getpid()) + ".bin");
  const TrainingSet set = ball_set(5, 24);
  TrainingState state = ball_state(set);
  state.step = 77, state.seconds = 9, state.pass_seconds = 4;
  state.head.part.field.parameters[5] = 0.25f;
  ASSERT_TRUE(write_checkpoint(path, state, "print").ok());

  TrainingState read = ball_state(set);
  ASSERT_TRUE(read_checkpoint(path, "print", read).ok());
  EXPECT_EQ(read.step, 77u);
  EXPECT_EQ(read.seconds, 9);
  EXPECT_EQ(read.pass_seconds, 4);
  EXPECT_EQ(read.head.part.field.parameters, state.head.part.field.parameters);

  TrainingState other = ball_state(set);
  const auto foreign = read_checkpoint(path, "another", other);
  ASSERT_FALSE(foreign.ok());
  EXPECT_EQ(foreign.error().code, ErrorCode::bad_input);
  const auto bytes = *read_file(path);
  for (const double share : {0.0, 0.01, 0.5, 0.999}) {
    ASSERT_TRUE(write_file(path, std::span(bytes.data(), std::size_t(share * double(bytes.size())))).ok());
    EXPECT_FALSE(read_checkpoint(path, "print", other).ok());
  }
  EXPECT_EQ(other.step, 0u);
  state.head.adam.second[7] = std::numeric_limits<float>::infinity();
  ASSERT_TRUE(write_checkpoint(path, state, "print").ok());
  EXPECT_FALSE(read_checkpoint(path, "print", other).ok());
  EXPECT_EQ(other.step, 0u);
  std::filesystem::remove(path);
  EXPECT_EQ(read_checkpoint(path, "print", other).error().code, ErrorCode::not_found);
}

TEST(TrainingFingerprint, ChangesWithEveryPixelAndPose) {
  TrainingSet set = ball_set(5, 24);
  const std::string before = training_fingerprint(set, {});
  EXPECT_EQ(before, training_fingerprint(set, {}));
  TrainOptions even;
  even.rays.even_samples = 1;
  EXPECT_NE(before, training_fingerprint(set, even));
  TrainOptions landmarks;
  landmarks.losses.landmark_weight = 0.1;
  EXPECT_NE(before, training_fingerprint(set, landmarks));
  set.views[2].rgb.data[10] ^= 1;
  TrainingSet smiling = set;  // another resting face, another canonical space
  smiling.neutral.jaw.x() += 0.01f;
  EXPECT_NE(before, training_fingerprint(smiling, {}));
  const std::string pixel = training_fingerprint(set, {});
  EXPECT_NE(before, pixel);
  set.views[2].rgb.data[10] ^= 1;
  set.views[4].pose.world_from_torso.translate(Vec3d(0, 1e-9, 0));
  EXPECT_NE(before, training_fingerprint(set, {}));
}

}  // namespace
}  // namespace likeness
