// Claims about the demo capture's files.
#include "core/synth/demo_capture.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>

#include "core/camera/camera.h"
#include "core/head/builtin_head.h"
#include "core/head/pose_head.h"
#include "core/image/files.h"
#include "core/scene/track.h"
#include "core/synth/demo_stage.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

struct ScratchFolder {
  fs::path path = fs::temp_directory_path() / ("likeness_demo_test_" + std::to_string(::getpid()));
  ScratchFolder() { fs::remove_all(path); }
  ~ScratchFolder() { fs::remove_all(path); }
};

DemoOptions tiny() {
  DemoOptions options;
  options.width = options.height = 64;
  options.frames = 12;
  options.samples_per_pixel = 1;
  return options;
}

// Landmarks of the track, projected again from the two truth files alone: exact where nothing moves beyond
// the model's expressions (bridge of the nose, lids), elsewhere off by the person's own expressions beyond
// them.
void expect_truth_agrees(const fs::path& folder, const DemoOptions& options, bool is_static) {
  const auto cameras = read_cameras(folder / "cameras_truth.json");
  const auto track = read_track(folder / "track_truth.json");
  ASSERT_TRUE(cameras.ok()) << cameras.error().what;
  ASSERT_TRUE(track.ok()) << track.error().what;
  EXPECT_EQ(cameras->rests(), is_static);
  EXPECT_EQ(cameras->scale, CameraScale::metric);
  ASSERT_EQ(track->frames.size(), std::size_t(options.frames));
  const HeadModel model = make_builtin_head();
  EXPECT_EQ(track->head_model_hash, model.hash);
  const HeadShape shape = shape_head(model, track->person);
  for (const TrackedFrame& f : track->frames) {
    const Camera* camera = find_camera(*cameras, f.frame);
    ASSERT_NE(camera, nullptr);
    EXPECT_TRUE(!is_static || camera->cam_from_world.isApprox(Pose::Identity()));
    const auto points = landmark_positions(model, pose_head(model, shape, f.pose.articulation));
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3d in_cam = camera->cam_from_world * f.pose.world_from_head * points[i].cast<double>();
      ASSERT_GT(in_cam.z(), 0.3);
      const double off = (project<double>(camera->intrinsics, in_cam) - f.landmarks[i]).norm();
      const bool firm = (i >= 27 && i <= 30) || (i >= 36 && i <= 47);
      EXPECT_LT(off, firm ? 0.05 : 0.008 * camera->intrinsics.fx / in_cam.z()) << i;
    }
    char name[32];
    std::snprintf(name, sizeof name, "%06d.png", f.frame);
    EXPECT_TRUE(read_image(folder / "masks_truth" / name).ok()) << name;
  }
}

TEST(WriteDemoCapture, WritesVideoCamerasTrackAndMasksThatAgree) {
  const ScratchFolder scratch;
  double last = 0;
  const Progress progress([&](const ProgressReport& report) {
    EXPECT_GE(report.fraction, last);
    last = report.fraction;
  });
  const auto written = write_demo_capture(scratch.path, tiny(), progress, {});
  ASSERT_TRUE(written.ok()) << written.error().what;
  EXPECT_DOUBLE_EQ(last, 1);
  EXPECT_GT(fs::file_size(scratch.path / "demo.mp4"), 1000u);
  EXPECT_FALSE(fs::exists(scratch.path / ".filming"));
  expect_truth_agrees(scratch.path, tiny(), false);
}

// The file alone gives the true neutral surface.
TEST(WriteDemoCapture, TruthOfTheTrackIsTheTrueSurface) {
  const ScratchFolder scratch;
  DemoOptions options = tiny();
  options.frames = 2;
  options.person = 4;
  options.light = 2;
  ASSERT_TRUE(write_demo_capture(scratch.path, options, Progress(), {}).ok());
  const auto track = read_track(scratch.path / "track_truth.json");
  ASSERT_TRUE(track.ok()) << track.error().what;
  const DemoStage stage(make_builtin_head(), options);
  const HeadShape recovered = shape_head(stage.model(), track->person);
  for (std::size_t v = 0; v < recovered.vertices.size(); ++v)
    ASSERT_LT((recovered.vertices[v] - stage.shape().vertices[v]).norm(), 2e-6f) << v;
}

TEST(WriteDemoCapture, RestingCameraIsTheWorldFrame) {
  const ScratchFolder scratch;
  DemoOptions options = tiny();
  options.moving_share = 0;
  ASSERT_TRUE(write_demo_capture(scratch.path, options, Progress(), {}).ok());
  expect_truth_agrees(scratch.path, options, true);
}

TEST(WriteDemoCapture, StoppingMidwayLeavesNothingBehind) {
  const ScratchFolder scratch;
  std::stop_source source;
  const Progress progress([&](const ProgressReport& report) {
    if (report.fraction > 0.3) source.request_stop();
  });
  const auto written = write_demo_capture(scratch.path, tiny(), progress, source.get_token());
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().code, ErrorCode::cancelled);
  EXPECT_FALSE(fs::exists(scratch.path));
}

TEST(WriteDemoCapture, StoppingBeforehandKeepsTheFoldersContents) {
  const ScratchFolder scratch;
  fs::create_directories(scratch.path);
  std::ofstream(scratch.path / "demo.mp4") << "older";
  std::stop_source source;
  source.request_stop();
  ASSERT_FALSE(write_demo_capture(scratch.path, tiny(), Progress(), source.get_token()).ok());
  std::string kept;
  std::ifstream(scratch.path / "demo.mp4") >> kept;
  EXPECT_EQ(kept, "older");
}

TEST(WriteDemoCapture, RefusesImpossibleOptionsWithARemedy) {
  const ScratchFolder scratch;
  for (const auto spoil :
       {+[](DemoOptions& o) { o.width = 4; }, +[](DemoOptions& o) { o.frames = 0; },
        +[](DemoOptions& o) { o.frames_per_second = 0; }, +[](DemoOptions& o) { o.samples_per_pixel = 0; },
        +[](DemoOptions& o) { o.person = 6; }, +[](DemoOptions& o) { o.light = -1; },
        +[](DemoOptions& o) { o.head_within_deg = 0; }, +[](DemoOptions& o) { o.head_within_deg = -3; },
        +[](DemoOptions& o) { o.head_within_deg = std::nan(""); },
        +[](DemoOptions& o) { o.action_share = 0; }, +[](DemoOptions& o) { o.action_share = 1.01; }}) {
    DemoOptions options = tiny();
    spoil(options);
    const auto written = write_demo_capture(scratch.path, options, Progress(), {});
    ASSERT_FALSE(written.ok());
    EXPECT_EQ(written.error().code, ErrorCode::bad_input);
    EXPECT_FALSE(written.error().what.empty());
    EXPECT_FALSE(written.error().fix.empty());
    EXPECT_FALSE(fs::exists(scratch.path));
  }
}

}  // namespace
}  // namespace likeness
