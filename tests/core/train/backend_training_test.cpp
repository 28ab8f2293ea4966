// Claims about training on a device (core/train/train.h): it continues where the processor stopped and vice
// versa, reports errors, and falls back on request. On the emulated device.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <set>

#include "core/render/backend.h"
#include "core/train/train.h"
#include "tests/core/device/emulated_device.h"
#include "tests/core/render/two_fields.h"
#include "tests/core/train/ball_scene.h"

namespace likeness {
namespace {

using testing::HasSubstr;

class BackendTraining : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("likeness_backend_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Result<Avatar> train(std::uint64_t steps, std::shared_ptr<Backend> backend, bool fall_back = false,
                       const std::string& checkpoint = "", std::uint64_t stop_at = 0) {
    TrainOptions options;
    options.schedule.steps = steps, options.rays.per_step = 48, options.seed = 3;
    options.schedule.checkpoint_every_s = 0;
    options.place.backend = std::move(backend), options.place.fall_back = fall_back;
    options.place.precision = precision_;
    said_.clear();
    const Progress progress([this](const ProgressReport& report) { said_ += report.text + "\n"; });
    std::stop_source source;
    const AvatarTap tap{[] { return true; },
                        [&](const Avatar& avatar) {
                          if (stop_at > 0 && avatar.steps == stop_at) source.request_stop();
                        }};
    return train_avatar(set_, options, checkpoint.empty() ? std::filesystem::path{} : folder_ / checkpoint,
                        progress, {}, source.get_token(), tap);
  }
  TrainingSet set_ = ball_set(8, 24);
  std::filesystem::path folder_;
  std::string said_;
  FieldPrecision precision_ = FieldPrecision::exact;  // of the processor
};

// The processor, in whose moments a NaN turns up after some steps, which the loss does not show.
class SpoiltBackend : public Backend {
 public:
  explicit SpoiltBackend(std::set<int> after) : after_(std::move(after)) {}
  std::string name() const override { return "cpu"; }
  Result<std::unique_ptr<FieldLearner>> make_learner(const LearntParts& parts,
                                                     const LearnerShape& shape) override {
    auto learner = sound_->make_learner(parts, shape);
    if (!learner) return learner.error();
    return std::unique_ptr<FieldLearner>(new Learner(std::move(*learner), parts, *this));
  }
  Result<std::unique_ptr<FrameRenderer>> make_renderer(const Avatar& avatar) override {
    return sound_->make_renderer(avatar);
  }

 private:
  class Learner : public FieldLearner {
   public:
    Learner(std::unique_ptr<FieldLearner> sound, const LearntParts& parts, SpoiltBackend& owner)
        : sound_(std::move(sound)), parts_(parts), owner_(owner) {}
    Result<LearningResult> step(const LearningStep& step) override {
      auto result = sound_->step(step);
      if (owner_.after_.contains(++owner_.steps_))
        parts_.fields[0].adam->second.back() = std::numeric_limits<float>::quiet_NaN();
      return result;
    }
    Result<void> densities(int field, const FieldInputs& inputs, std::vector<float>& sigma) override {
      return sound_->densities(field, inputs, sigma);
    }
    Result<void> fetch() override { return sound_->fetch(); }
    Result<void> place() override { return sound_->place(); }

   private:
    std::unique_ptr<FieldLearner> sound_;
    LearntParts parts_;
    SpoiltBackend& owner_;
  };
  std::shared_ptr<Backend> sound_ = cpu_backend(FieldPrecision::exact);
  std::set<int> after_;
  int steps_ = 0;
};

double apart(const Avatar& a, const Avatar& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.head.field.parameters.size(); ++i)
    worst = std::max(worst, double(std::abs(a.head.field.parameters[i] - b.head.field.parameters[i])));
  return worst;
}

TEST_F(BackendTraining, ACheckpointOfOneContinuesOnTheOther) {
  const auto uncut = train(4, nullptr);
  ASSERT_TRUE(uncut.ok());
  for (const bool device_first : {true, false}) {
    const auto device = device_backend(emulated_device(), false);
    const std::string name = device_first ? "device.bin" : "cpu.bin";
    const auto cut = train(4, device_first ? device : nullptr, false, name, 2);
    ASSERT_FALSE(cut.ok());
    ASSERT_EQ(cut.error().code, ErrorCode::cancelled);
    const auto resumed = train(4, device_first ? nullptr : device, false, name);
    ASSERT_TRUE(resumed.ok()) << resumed.error().what;
    EXPECT_THAT(said_, HasSubstr("continuing at step 2"));
    EXPECT_EQ(resumed->steps, 4u);
    // Adam turns a gradient's chance sign into a whole step, 0.01 at most each, warm-up included.
    EXPECT_LT(apart(*resumed, *uncut), 0.03);
  }
}

TEST_F(BackendTraining, ACheckpointContinuesInAnotherPrecision) {
  const auto uncut = train(4, nullptr);
  ASSERT_TRUE(uncut.ok());
  for (const FieldPrecision first : {FieldPrecision::exact, FieldPrecision::bf16}) {
    const std::string name = first == FieldPrecision::exact ? "exact.bin" : "bf16.bin";
    precision_ = first;
    ASSERT_FALSE(train(4, nullptr, false, name, 2).ok());
    precision_ = first == FieldPrecision::exact ? FieldPrecision::bf16 : FieldPrecision::exact;
    const auto resumed = train(4, nullptr, false, name);
    ASSERT_TRUE(resumed.ok()) << resumed.error().what;
    EXPECT_THAT(said_, HasSubstr("continuing at step 2"));
    EXPECT_EQ(resumed->steps, 4u);
    EXPECT_LT(apart(*resumed, *uncut), 0.06);  // a whole step either way for a gradient's chance sign
  }
}

TEST(DeviceSteps, AreOneReplayAndOneWaitEach) {
  TwoFields fields(1);
  const auto device = emulated_device();
  const auto learner = device_backend(device)->make_learner(fields.parts(), fields.shape());
  ASSERT_TRUE(learner.ok());
  const RayProblem problem(fields, 7);
  const EmulatedCounts before = emulated_counts();
  for (int k = 0; k < 3; ++k) ASSERT_TRUE((*learner)->step(problem.step()).ok());
  const EmulatedCounts after = emulated_counts();
  EXPECT_EQ(after.replays - before.replays, 3u);
  EXPECT_EQ(after.waits - before.waits, 3u);
  EXPECT_EQ(after.waits_while_recording, 0u);
}

TEST_F(BackendTraining, RefusesTheLandmarkLossRatherThanIgnoringIt) {
  TwoFields fields(1);
  LearnerShape shape = TwoFields::shape();
  shape.patches = true;
  const auto learner = device_backend(emulated_device())->make_learner(fields.parts(), shape);
  ASSERT_FALSE(learner.ok());
  EXPECT_THAT(learner.error().what, HasSubstr("landmark loss"));
  EXPECT_THAT(learner.error().fix, HasSubstr("--backend cpu"));
  // With --backend auto the processor takes it over, and says so.
  EXPECT_TRUE(failed_on_device(learner.error()));
  EXPECT_EQ(continuing_on_processor(learner.error()),
            "The landmark loss is computed only on the processor. Continuing on the processor.");
}

TEST_F(BackendTraining, ReportsTooLittleMemoryBeforeTraining) {
  const auto avatar = train(2, device_backend(emulated_device({.memory_bytes = 1 << 20})));
  ASSERT_FALSE(avatar.ok());
  EXPECT_THAT(avatar.error().what, HasSubstr("GiB"));
  EXPECT_THAT(avatar.error().fix, HasSubstr("--backend cpu"));
}

TEST_F(BackendTraining, ReportsALostDeviceAndKeepsTheCheckpoint) {
  const auto avatar = train(6, device_backend(emulated_device({.lost_after = 40})), false, "lost.bin");
  ASSERT_FALSE(avatar.ok());
  EXPECT_THAT(avatar.error().what, HasSubstr("stopped responding"));
  EXPECT_THAT(avatar.error().fix, HasSubstr("continues from the last checkpoint"));
  const auto resumed = train(6, nullptr, false, "lost.bin");
  ASSERT_TRUE(resumed.ok());
  EXPECT_THAT(said_, HasSubstr("continuing at step"));
  EXPECT_EQ(resumed->steps, 6u);
}

TEST_F(BackendTraining, ContinuesOnTheProcessorOnRequest) {
  const auto alone = train(5, nullptr);
  const auto fallen = train(5, device_backend(emulated_device({.lost_after = 40})), true);
  ASSERT_TRUE(fallen.ok()) << fallen.error().what;
  EXPECT_THAT(said_, HasSubstr("Continuing on the processor"));
  EXPECT_EQ(fallen->steps, 5u);
  const auto never = train(5, device_backend(emulated_device({.memory_bytes = 1 << 20})), true);
  ASSERT_TRUE(alone.ok() && never.ok());
  EXPECT_EQ(never->head.field.parameters, alone->head.field.parameters);  // no step was the device's
}

TEST_F(BackendTraining, NonFiniteStepsAreDroppedAndTrainingRecovers) {
  const auto recovered = train(4, std::make_shared<SpoiltBackend>(std::set{3}), false, "spoilt.bin");
  ASSERT_TRUE(recovered.ok()) << recovered.error().what;
  EXPECT_EQ(recovered->steps, 4u);
  for (const float p : recovered->head.field.parameters) ASSERT_TRUE(std::isfinite(p));
  // The last step is looked at, too, and there is an end to starting over.
  ASSERT_TRUE(train(4, std::make_shared<SpoiltBackend>(std::set{4})).ok());
  const auto never =
      train(4, std::make_shared<SpoiltBackend>(std::set{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}), false,
            "never.bin");
  ASSERT_FALSE(never.ok());
  EXPECT_THAT(never.error().what, HasSubstr("diverged"));
}

TEST_F(BackendTraining, StoppingIsNotABackendFailure) {
  const auto stopped = train(5, device_backend(emulated_device()), true, "", 2);
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace likeness
