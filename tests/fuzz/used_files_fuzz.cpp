// Damaged files that are read and then used, as the program goes on to use them: an avatar is posed and
// rendered twice, a performance directs one, a checkpoint is trained a step further.
#include <gtest/gtest.h>

#include <algorithm>
#include <span>

#include "core/direct/direct_avatar.h"
#include "core/direct/performance.h"
#include "core/project/project_views.h"
#include "core/render/pose_avatar.h"
#include "core/render/render.h"
#include "core/train/checkpoint.h"
#include "core/train/train.h"
#include "tests/core/export/tiny_project.h"
#include "tests/core/train/ball_scene.h"
#include "tests/fuzz/fuzz.h"

namespace likeness {
namespace {

// A camera of few pixels that sees what the avatar's own sees, wherever a file puts that.
Camera small_camera(const Avatar& avatar) {
  Camera camera = typical_camera(avatar);
  camera.intrinsics = {24, 16, 30, 30, 12, 8, 0, 0, 0, 0};
  return camera;
}

TEST(FuzzUsedFiles, AvatarIsRendered) {
  const ScratchFolder scratch;
  Avatar avatar = test::filmed_avatar();
  FieldConfig config = avatar.head.field.config;
  ++config.condition_count, config.local_conditions = 1;
  avatar.head.field = make_field(config, 5);
  avatar.attributes.resize(1);
  avatar.attributes[0].name = "cheek puff", avatar.attributes[0].cell = 0.01f;
  avatar.attributes[0].count = {2, 3, 4}, avatar.attributes[0].weights.assign(24, 9);
  avatar.warp_cell = 0.02f;
  FuzzTarget target;
  target.name = "avatar rendered";
  for (const bool room : {false, true}) {
    if (room) avatar.room = *avatar.torso, avatar.warp_cell = 0;
    ASSERT_TRUE(write_avatar(scratch.path() / "avatar.bin", avatar).ok());
    target.seeds.push_back(scratch.get("avatar.bin"));
  }
  target.repair = repair_checksum;
  target.memory_floor = std::size_t(1) << 30;  // a head a metre wide has a large lattice
  target.max_cpu_s = 20;
  target.inputs = 200;
  target.max_kept = std::size_t(1) << 20;
  target.read = [&](std::span<const std::byte> bytes) {
    const auto read = read_avatar(scratch.put("avatar.bin", bytes));
    if (!read || !check_avatar_fits(*read, test::tiny_head(), "fuzz")) return false;
    const auto rig = make_rig(*read, test::tiny_head());
    if (!rig) return false;
    const DirectedAvatar directed = direct_avatar(*read, test::tiny_head());
    Performance performance;
    performance.channels["action jawOpen"] = {{0, 0}, {1, 1}};
    performance.channels["camera yaw"] = {{0, 0}, {1, 30}};
    for (const double time_s : {0.0, 1.0}) {
      const DirectedMoment moment = direct_moment(directed, performance, time_s);
      const RenderedFrame frame = render_frame(*read, small_camera(*read), pose_avatar(*rig, moment.pose),
                                               render_options(RenderQuality::preview));
      EXPECT_EQ(frame.rgba.pixels(), 24u * 16u);
    }
    return true;
  };
  fuzz(target);
}

TEST(FuzzUsedFiles, PerformanceDirects) {
  const ScratchFolder scratch;
  const Avatar avatar = test::filmed_avatar();
  const DirectedAvatar directed = direct_avatar(avatar, test::tiny_head());
  Performance performance;
  performance.channels["head yaw"] = {{0, 5, Easing::hold}, {0.5, -5, Easing::linear}, {1.25, 0.1f}};
  performance.channels["action jawOpen"] = {{0.7, 0.3f, Easing::ease_in}};
  performance.channels["camera distance"] = {{0.7, 2, Easing::linear}};
  performance.channels["gaze yaw"] = {{0.1, 20, Easing::linear}};
  FuzzTarget target;
  target.name = "performance directs";
  ASSERT_TRUE(write_performance(scratch.path() / "performance.json", performance).ok());
  target.seeds = {scratch.get("performance.json")};
  target.read = [&](std::span<const std::byte> bytes) {
    const auto read = read_performance(scratch.put("performance.json", bytes));
    if (!read || !check_performance(*read, test::tiny_head())) return false;
    for (const double share : {0.0, 0.37, 1.0}) {
      const DirectedMoment moment = direct_moment(directed, *read, share * read->duration_s);
      EXPECT_TRUE(moment.camera.cam_from_world.matrix().allFinite());
      EXPECT_TRUE(moment.pose.world_from_head.matrix().allFinite());
      EXPECT_TRUE(moment.pose.articulation.expression.allFinite());
    }
    return true;
  };
  fuzz(target);
}

TEST(FuzzUsedFiles, CheckpointIsTrained) {
  const ScratchFolder scratch;
  const TrainingSet set = ball_set(5, 24);
  TrainOptions options;
  options.schedule.steps = 1, options.rays.per_step = 64;
  options.fields.sizes = {10, 24, 10, 24, 2};
  const auto train = [&] {
    return train_avatar(set, options, scratch.path() / "checkpoint.bin", Progress(), {}, {});
  };
  const auto begun = train();
  ASSERT_TRUE(begun.ok()) << begun.error().what << begun.error().fix;
  FuzzTarget target;
  target.name = "checkpoint trained";
  target.seeds = {scratch.get("checkpoint.bin")};
  target.repair = repair_checksum;
  target.memory_floor = std::size_t(256) << 20;
  target.max_cpu_s = 20;
  target.inputs = 50;
  target.max_kept = std::size_t(1) << 20;
  options.schedule.steps = 2;
  target.read = [&](std::span<const std::byte> bytes) {
    scratch.put("checkpoint.bin", bytes);
    const auto avatar = train();  // goes on, or says that it begins anew
    EXPECT_TRUE(avatar.ok());
    return avatar.ok() && avatar->steps == 2;
  };
  fuzz(target);
}

}  // namespace
}  // namespace likeness
