// Claims about directing from the command line: performances to films and meshes, a driven clip to keys.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/camera/camera.h"
#include "core/capture/capture.h"
#include "core/direct/edit_keys.h"
#include "core/image/files.h"
#include "core/scene/track.h"
#include "core/video/decode.h"
#include "core/video/encode.h"
#include "tests/core/export/tiny_project.h"
#include "tests/core/lab/truth/acted_track.h"
#include "tests/support/run_program.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

class DirectCommand : public testing::Test {
 protected:
  fs::path save(const Performance& performance) {
    const fs::path path = project_.root / "performance.json";
    EXPECT_TRUE(write_performance(path, performance).ok());
    return path;
  }
  ProgramResult render(std::vector<std::string> arguments, const char* out) {
    arguments.insert(arguments.begin(), {"render", project_.folder().string()});
    arguments.insert(arguments.end(), {"--json", "--out", (project_.root / out).string()});
    return likeness(arguments);
  }
  bool there(const char* name) const { return fs::exists(project_.root / name); }

  TinyProject project_;
};

Performance turning() {
  Performance performance;
  performance.duration_s = 0.4, performance.frames_per_second = 20;
  set_key(performance, "head yaw", {0, -20});
  set_key(performance, "head yaw", {0.35, 20});
  set_key(performance, "action jawOpen", {0, 0.4f});
  return performance;
}

// The project's avatar, as if its training had found this of it.
void hold_within(const TinyProject& project, double yaw_deg, float jaw) {
  Avatar avatar = filmed_avatar();
  HoldingRange& range = avatar.holds.emplace();
  range.yaw_low = {-yaw_deg, "drift"}, range.yaw_high = {yaw_deg, "loose"};
  range.pitch_low = {-25, ""}, range.pitch_high = {25, ""};
  range.actions = {{"jawOpen", jaw, "mouth"}};
  ASSERT_TRUE(write_avatar(project.folder() / "avatar.bin", avatar).ok());
}

TEST_F(DirectCommand, AStudyTellsHowFarAnyAvatarHolds) {
  const ProgramResult result = likeness(
      {"study", "beyond", project_.folder().string(), "--out", (project_.root / "study").string(), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json study = json::parse(result.out);
  EXPECT_TRUE(study.at("inside").at("psnr_head_db").is_null()) << "without a truth";
  ASSERT_GE(study.at("views").size(), 10u);
  for (const json& view : study.at("views")) {
    EXPECT_TRUE(view.at("psnr_head_db").is_null());
    EXPECT_TRUE(view.at("yaw").is_number() && view.at("pitch").is_number() && view.contains("drift"));
  }
  EXPECT_EQ(study.at("actions").at(0).at("name"), "jawOpen");
  EXPECT_LE(study.at("holds").at("yaw").at(0).get<double>(), study.at("holds").at("yaw").at(1).get<double>());
  EXPECT_TRUE(study.at("holds").at("actions").contains("jawOpen"));
  EXPECT_TRUE(there("study/check.csv"));
}

TEST_F(DirectCommand, WhatGoesBeyondWhatHoldsIsSaid) {
  const std::string keys = save(turning()).string();
  const ProgramResult unknown = render({"--performance", keys}, "unknown");
  ASSERT_EQ(unknown.exit_code, 0) << unknown.err;
  EXPECT_TRUE(json::parse(unknown.out).at("beyond_holds").is_null());
  hold_within(project_, 30, 0.6f);
  const json within = json::parse(render({"--performance", keys}, "within").out).at("beyond_holds");
  EXPECT_EQ(within.at("frames"), 0);
  EXPECT_TRUE(within.at("sides").empty());
  EXPECT_TRUE(within.at("actions").empty());
  hold_within(project_, 10, 0.2f);
  const json beyond = json::parse(render({"--performance", keys}, "beyond").out).at("beyond_holds");
  EXPECT_EQ(beyond.at("frames"), 8) << "the jaw, in all of them";
  EXPECT_NEAR(beyond.at("view_deg").get<double>(), 10, 2);
  EXPECT_EQ(beyond.at("sides").size(), 2u);
  EXPECT_NEAR(beyond.at("actions").at("jawOpen").get<double>(), 0.4, 0.03);
  EXPECT_EQ(beyond.at("film_again").size(), 3u);
  const ProgramResult told = likeness({"render", project_.folder().string(), "--expression", "jawOpen=1",
                                       "--out", (project_.root / "open.png").string()});
  EXPECT_EQ(told.exit_code, 0);
  EXPECT_THAT(told.err, HasSubstr("Open the mouth wide, slowly, twice."));
}

TEST_F(DirectCommand, APerformanceBecomesAFilmOfItsLength) {
  const ProgramResult result = render({"--performance", save(turning()).string()}, "film.mp4");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(json::parse(result.out).at("frames"), 8);
  const auto info = probe_video(project_.root / "film.mp4");
  ASSERT_TRUE(info.ok());
  EXPECT_DOUBLE_EQ(info->frames_per_second, 20);
  ASSERT_EQ(render({"--performance", save(turning()).string()}, "frames").exit_code, 0);
  const auto first = read_image(project_.root / "frames" / "000000.png");
  const auto last = read_image(project_.root / "frames" / "000007.png");
  ASSERT_TRUE(first.ok() && last.ok());
  EXPECT_NE(first->data, last->data);
}

TEST_F(DirectCommand, APerformanceBecomesAMovingMeshAndAPoseAStillOne) {
  const ProgramResult moving = render({"--performance", save(turning()).string()}, "head.glb");
  ASSERT_EQ(moving.exit_code, 0) << moving.err;
  EXPECT_EQ(json::parse(moving.out).at("frames"), 8);
  EXPECT_TRUE(read_text(project_.root / "head.glb")->starts_with("glTF"));
  const ProgramResult still = render({"--expression", "jawOpen=0.5", "--pose=20,0,0"}, "head.ply");
  ASSERT_EQ(still.exit_code, 0) << still.err;
  EXPECT_TRUE(read_text(project_.root / "head.ply")->starts_with("ply\n"));
}

TEST_F(DirectCommand, WhatContradictsItselfIsRefusedAndNothingIsWritten) {
  const std::string performance = save(turning()).string();
  for (const auto& [arguments, out, word] :
       std::vector<std::tuple<std::vector<std::string>, const char*, const char*>>{
           {{"--performance", performance, "--pose=5,0,0"}, "a.mp4", "--pose"},
           {{"--performance", performance}, "a.ply", ".glb"},
           {{"--performance", performance}, "a.png", ".mp4"},
           {{"--camera", "orbit"}, "a.glb", "--camera"},
           {{"--mark"}, "a.ply", "--mark"},
           {{"--performance", (project_.root / "absent.json").string()}, "a.mp4", "absent.json"}}) {
    const ProgramResult result = render(arguments, out);
    EXPECT_EQ(result.exit_code, 1) << out;
    EXPECT_THAT(result.err, HasSubstr(word));
    EXPECT_FALSE(there(out)) << out;
  }
  Performance unknown = turning();
  set_key(unknown, "action grin", {0, 1});
  const ProgramResult result = render({"--performance", save(unknown).string()}, "a.mp4");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("jawOpen"));
}

TEST_F(DirectCommand, TheMarkIsOptional) {
  ASSERT_EQ(render({}, "plain.png").exit_code, 0);
  ASSERT_EQ(render({"--mark"}, "marked.png").exit_code, 0);
  EXPECT_NE(read_image(project_.root / "plain.png")->data, read_image(project_.root / "marked.png")->data);
}

TrackTruth acted_truth_on_disk(int frames) {
  TrackTruth truth = acted_truth(frames);
  truth.track.neutral = neutral_articulation(acting_head());
  for (TrackedFrame& frame : truth.track.frames) frame.landmarks.fill(Vec2d::Zero());
  return truth;
}

class DrivenCommand : public DirectCommand {
 protected:
  void SetUp() override {
    clip_ = project_.root / "clip.mp4", track_ = project_.root / "track.json";
    ASSERT_TRUE(write_track(track_, acted_truth_on_disk(20).track).ok());
    auto writer = VideoWriter::create(clip_, 64, 48);
    for (int i = 0; i < 20; ++i) ASSERT_TRUE(writer->add(Image8(64, 48, 3, 128)).ok());
    ASSERT_TRUE(writer->finish().ok());
  }
  ProgramResult drive(std::vector<std::string> arguments, const char* out) {
    arguments.insert(arguments.begin(), {"drive", project_.folder().string(), clip_.string(), "--track",
                                         track_.string(), "--json", "--out", (project_.root / out).string()});
    return likeness(arguments);
  }

  fs::path clip_, track_;
};

TEST_F(DrivenCommand, AClipBecomesKeysThatRenderTakes) {
  const fs::path keys = project_.root / "keys.json";
  const ProgramResult driven = drive({}, "keys.json");
  ASSERT_EQ(driven.exit_code, 0) << driven.err;
  const auto performance = read_performance(keys);
  ASSERT_TRUE(performance.ok()) << performance.error().what;
  EXPECT_EQ(frame_count(*performance), 20);
  EXPECT_EQ(performance->channels.at("head yaw").size(), 20u);
  const ProgramResult rendered = render({"--performance", keys.string()}, "again.mp4");
  EXPECT_EQ(rendered.exit_code, 0) << rendered.err;
}

TEST_F(DrivenCommand, AHeadThatIsHeldTurnsAsAskedWhileTheFaceMoves) {
  const ProgramResult driven = drive({"--pose=20,0,0"}, "held.json");
  ASSERT_EQ(driven.exit_code, 0) << driven.err;
  const auto performance = read_performance(project_.root / "held.json");
  ASSERT_TRUE(performance.ok()) << performance.error().what;
  for (const auto& key : performance->channels.at("head yaw")) EXPECT_NEAR(key.value, 20, 1e-3);
  const auto& jaw = performance->channels.at("action jawOpen");
  const auto [least, most] = std::ranges::minmax(jaw, {}, [](const auto& key) { return key.value; });
  EXPECT_GT(most.value, least.value + 0.05f);
  EXPECT_EQ(drive({"--pose=20,0,0", "--keep-head"}, "x.json").exit_code, 2) << "either of them";
}

TEST_F(DrivenCommand, ACameraGoesRoundOrIsFollowed) {
  const std::vector<std::string> still{"--keep-head", "--background", "#808080"};
  ASSERT_EQ(drive(still, "still").exit_code, 0);
  std::vector<std::string> around = still;
  around.insert(around.end(), {"--camera", "orbit", "--orbit", "60"});
  const ProgramResult orbit = drive(around, "orbit");
  ASSERT_EQ(orbit.exit_code, 0) << orbit.err;
  EXPECT_TRUE(json::parse(orbit.out).at("beyond_holds").is_null());
  EXPECT_EQ(json::parse(orbit.out).at("frames"), 20);
  const auto seen = [&](const char* folder, const char* frame) {
    const auto picture = read_image(project_.root / folder / frame);
    EXPECT_TRUE(picture.ok()) << folder;
    return picture ? picture->data : std::vector<std::uint8_t>();
  };
  EXPECT_NE(seen("orbit", "000005.png"), seen("still", "000005.png"));  // a quarter of the way: 60 degrees
  hold_within(project_, 30, 1);
  const ProgramResult told = drive(around, "orbit again");
  ASSERT_EQ(told.exit_code, 0) << told.err;
  const json beyond = json::parse(told.out).at("beyond_holds");
  EXPECT_GT(beyond.at("frames").get<int>(), 5);
  EXPECT_EQ(beyond.at("sides").size(), 2u);
  CameraSet path{.kind = CameraKind::walking};
  Camera camera = typical_camera(filmed_avatar());
  for (camera.frame = 0; camera.frame < 7; ++camera.frame) path.cameras.push_back(camera);
  ASSERT_TRUE(write_cameras(project_.root / "path.json", path).ok());
  const ProgramResult followed = drive({"--camera", (project_.root / "path.json").string()}, "path.mp4");
  ASSERT_EQ(followed.exit_code, 0) << followed.err;
  EXPECT_EQ(json::parse(followed.out).at("frames"), 7) << "as long as the shorter of the two";
  for (const char* out : {"a.glb", "a.json"}) {
    const ProgramResult refused = drive({"--camera", "orbit"}, out);
    EXPECT_EQ(refused.exit_code, 1) << out;
    EXPECT_THAT(refused.err, HasSubstr("Leave out --camera"));
    EXPECT_FALSE(there(out));
  }
}

TEST_F(DrivenCommand, ATrackThatIsThereIsJudgedByMarks) {
  std::ofstream(project_.root / "marks.json")
      << R"({"version": 1, "frames": [0, 4, 8, 12], "mouth": "oo?c", "eyes": "oooo", "placed": "rrwr"})";
  const ProgramResult result = likeness(
      {"study", "track", track_.string(), "--marks", (project_.root / "marks.json").string(), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_EQ(report.at("frames").at(0).at("good"), 20);
  const json& marks = report.at("marks").at(0);
  EXPECT_EQ(marks.at("marked_mouths"), 3);
  EXPECT_EQ(marks.at("marked_eyes"), 4);
  EXPECT_EQ(marks.at("marked_good"), 4);
  EXPECT_EQ(marks.at("misplaced"), (std::vector<int>{8}));
}

TEST_F(DirectCommand, TheCardSaysTheSameInWordsAndInJson) {
  TrackTruth truth = acted_truth_on_disk(120);
  Capture capture;
  capture.width = capture.height = 512, capture.crop = {0, 0, 512};
  for (TrackedFrame& frame : truth.track.frames) {
    const bool spoilt = frame.frame >= 50 && frame.frame < 75;
    frame.inner_error_px = 1;
    if (spoilt) frame.status = FrameStatus::lost, frame.reason = "no face";
    capture.frames.push_back({frame.frame, frame.time_s, 100, false, true, ""});
  }
  ASSERT_TRUE(write_capture(project_.folder() / "capture.json", capture).ok());
  ASSERT_TRUE(write_cameras(project_.folder() / "cameras.json", truth.cameras).ok());
  ASSERT_TRUE(write_track(project_.folder() / "track.json", truth.track).ok());
  const ProgramResult found_now = likeness({"card", project_.folder().string(), "--json"});
  ASSERT_EQ(found_now.exit_code, 0) << found_now.err;
  EXPECT_EQ(json::parse(found_now.out).at("holds").at("yaw").size(), 2u) << "it is looked for on demand";
  hold_within(project_, 17, 0.6f);
  const ProgramResult told = likeness({"card", project_.folder().string(), "--json"});
  ASSERT_EQ(told.exit_code, 0) << told.err;
  const json card = json::parse(told.out);
  EXPECT_EQ(card.at("holds").at("yaw"), json({-17, 17}));
  EXPECT_NEAR(card.at("holds").at("actions").at("jawOpen").get<double>(), 0.6, 1e-6);
  EXPECT_EQ(card.at("holds_gaps").size(), 3u);
  EXPECT_EQ(card.at("consent"), "not_asked");
  EXPECT_EQ(card.at("frames").at("lost"), 25);
  EXPECT_EQ(card.at("frames").at("trained"), 95);
  EXPECT_GT(card.at("seen_from_deg").at("yaw").at(1).get<double>(), 20);
  ASSERT_EQ(card.at("worst").size(), 1u);
  EXPECT_NEAR(card.at("worst").at(0).at("from_s").get<double>(), 2, 0.2);
  const ProgramResult printed = likeness({"card", project_.folder().string()});
  EXPECT_THAT(printed.out, HasSubstr(card.at("worst").at(0).at("film_again").get<std::string>()));
  EXPECT_THAT(printed.out, HasSubstr("It holds from 17 degrees on the person's right to 17 on the left"));
  EXPECT_THAT(printed.out, HasSubstr("Never seen: "));
  EXPECT_THAT(printed.out, HasSubstr("25 lost"));
  EXPECT_THAT(printed.out, HasSubstr("Whether the filmed person agreed was never answered"));
}

TEST_F(DirectCommand, TheCardOfAnUntrainedFolderSaysWhatIsMissing) {
  const ProgramResult result = likeness({"card", project_.folder().string()});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("capture.json"));
}

}  // namespace
}  // namespace likeness::test
