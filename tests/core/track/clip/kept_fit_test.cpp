// Claims about a fit's state that is kept between its parts.
#include "core/track/clip/kept_fit.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <random>

#include "core/head/builtin_head.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

const HeadModel& fitted_model() {
  static const HeadModel model = make_builtin_head();
  return model;
}

CameraSet one_camera() {
  CameraSet cameras;
  cameras.kind = CameraKind::resting;
  cameras.cameras.push_back({-1, {64, 64, 80, 80, 32, 32}, Pose::Identity()});
  return cameras;
}

// Of three frames, the last without a face; every number drawn.
ClipWork drawn_work(const CameraSet& cameras, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  ClipWork work;
  work.clip.region = {0, 0, 64, 64};
  for (int i = 0; i < 3; ++i) {
    ClipFrame& frame = work.clip.frames.emplace_back();
    frame.frame = 2 * i;
    frame.grey = Image8(64, 64, 1);
    if (i == 2) continue;
    frame.box = {1, 2, 30, 30, normal(engine)};
    Landmarks& found = frame.landmarks.emplace();
    for (Vec2d& p : found.points) p = Vec2d(32 + normal(engine), 32 + normal(engine));
    for (double& s : found.spread) s = normal(engine);
  }
  prepare(cameras, fitted_model(), work);
  for (FaceFrame& face : work.faces) {
    face.state.cam_from_head.translate(Vec3d(normal(engine), normal(engine), 1));
    for (double& e : face.state.expression) e = normal(engine);
    face.state.jaw = normal(engine);
  }
  work.dense[1].solved = true, work.dense[1].median_px = normal(engine);
  work.gaze[0] = Gaze{normal(engine), normal(engine), 0, {}};
  work.optical.assign(3, {4, normal(engine), true});
  work.lids.resize(3);
  work.lids[1][0] = {true, normal(engine), 1, 0};
  work.rest = {{0, 2}, true, 0.5, "why", "warning"};
  for (double& i : work.identity) i = normal(engine);
  HeadPoint& point = work.points.emplace_back();
  point.track.point = Vec3d(normal(engine), 0, 0);
  point.track.seen = {{0, Vec2d(normal(engine), 0)}, {1, Vec2d(0, 1)}};
  return work;
}

TEST(KeptFit, AStateComesBackToTheBit) {
  const CameraSet cameras = one_camera();
  const ClipWork work = drawn_work(cameras, 1);
  const std::string bytes = bytes_of_work(work);
  ClipWork other = drawn_work(cameras, 2);
  ASSERT_NE(bytes_of_work(other), bytes);
  ASSERT_TRUE(take_work(bytes, fitted_model(), false, other));
  EXPECT_EQ(bytes_of_work(other), bytes);
  EXPECT_EQ(other.rest.why, "why");
  EXPECT_EQ(other.faces[1].frame, 2);
  EXPECT_FALSE(other.clip.frames[2].landmarks.has_value());
}

TEST(KeptFit, WhatIsNotOfThisClipIsRefusedAndChangesNothing) {
  const CameraSet cameras = one_camera();
  ClipWork work = drawn_work(cameras, 1);
  const std::string bytes = bytes_of_work(work);
  const auto refused = [&](const std::string& other) {
    return !take_work(other, fitted_model(), false, work);
  };
  for (std::size_t size = 0; size < bytes.size(); size += 101)
    EXPECT_TRUE(refused(bytes.substr(0, size))) << size;
  EXPECT_TRUE(refused(bytes + "x"));
  ClipWork wrong = drawn_work(cameras, 3);
  wrong.faces[0].state.expression.resize(2);
  EXPECT_TRUE(refused(bytes_of_work(wrong)));
  wrong = drawn_work(cameras, 3);
  wrong.points[0].track.seen[0].frame = 1'000'000;
  EXPECT_TRUE(refused(bytes_of_work(wrong)));
  wrong = drawn_work(cameras, 3);
  wrong.faces[2].seen = true;  // without landmarks
  EXPECT_TRUE(refused(bytes_of_work(wrong)));
  wrong = drawn_work(cameras, 3);
  wrong.clip.frames.pop_back(), wrong.faces.pop_back(), wrong.dense.pop_back(), wrong.gaze.pop_back();
  EXPECT_TRUE(refused(bytes_of_work(wrong)));
  EXPECT_EQ(bytes_of_work(work), bytes);
}

TEST(KeptFit, AKilledFitGoesOnAfterItsLastWholePart) {
  const CameraSet cameras = one_camera();
  const fs::path file =
      fs::temp_directory_path() / ("likeness_fit_" + std::to_string(::getpid())) / "fit.kept";
  std::vector<std::string> ran;
  // Each part adds to the identity; `fails` stops before it.
  const auto fit = [&](const std::string& fails) {
    ClipWork work = drawn_work(cameras, 4);
    KeptFit kept(std::make_shared<KeptWork>(file, "inputs"), fitted_model(), false, work);
    kept.go_on({"a", "b", "c"});
    for (const char* name : {"a", "b", "c"}) {
      const auto done = kept.part(name, [&]() -> Result<void> {
        if (name == fails) return cancelled_error();
        ran.emplace_back(name);
        work.identity.array() *= 1.1;
        return {};
      });
      if (!done) break;
    }
    return bytes_of_work(work);
  };
  const std::string whole = fit("");
  EXPECT_EQ(ran, (std::vector<std::string>{"a", "b", "c"}));
  fs::remove(file);
  ran.clear();
  fit("c");
  EXPECT_EQ(ran, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(fit(""), whole);
  EXPECT_EQ(ran, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(fit(""), whole);
  EXPECT_EQ(ran.size(), 3u);
  fs::remove_all(file.parent_path());
}

}  // namespace
}  // namespace likeness
