// Claims about exports as they are asked for: the choice is made possible before it is carried out, and what
// is written is what was asked for.
#include "ui/studio/export_order.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "core/base/files.h"
#include "core/direct/edit_keys.h"
#include "core/direct/performance.h"
#include "core/image/files.h"
#include "core/video/decode.h"
#include "tests/core/device/emulated_device.h"
#include "tests/core/export/tiny_project.h"

namespace likeness::ui {
namespace {

namespace fs = std::filesystem;

std::shared_ptr<const ProjectContents> tiny_contents(const fs::path& folder, bool walked = false) {
  Avatar avatar = likeness::test::filmed_avatar();
  if (walked) avatar.room = avatar.torso, avatar.room->cube = {Vec3f(-2, -2, -1), 4};
  avatar.size = 64;
  avatar.intrinsics = {64, 64, 120, 120, 32, 32, 0, 0, 0, 0};
  avatar.plate = Image8(64, 64, 3, 77);
  auto contents = std::make_shared<ProjectContents>();
  contents->project.folder = folder;
  contents->avatar = ProjectAvatar::make(std::move(avatar),
                                         std::make_shared<const HeadModel>(likeness::test::tiny_head()), {});
  return contents;
}

Result<std::string> write(const ExportChoice& choice, const std::shared_ptr<const ProjectContents>& contents,
                          const Performance& performance = {}) {
  fs::path out;
  for (int number = 1; out.empty() || fs::exists(out); ++number)
    out = contents->project.folder / "exports" / export_file_name(choice, number);
  const ExportOrder order{choice, contents, std::make_shared<const Performance>(performance), 0, out};
  if (const auto fine = check_order(order); !fine) return fine.error();
  const auto written = write_order(order, Progress(), {});
  return written ? Result<std::string>(out.string()) : written;
}

TEST(ExportOrder, AChoiceIsMadePossible) {
  const auto contents = tiny_contents("/nowhere");
  const Avatar& avatar = contents->avatar->avatar;
  ExportChoice choice{.kind = ExportKind::orbit, .ground = ExportGround::transparent};
  EXPECT_EQ(settled(choice, {}, avatar).form, ExportForm::pictures);
  choice.ground = ExportGround::room;
  EXPECT_EQ(settled(choice, {}, avatar).ground, ExportGround::light);
  choice.kind = ExportKind::still;
  EXPECT_EQ(settled(choice, {}, avatar).ground, ExportGround::room);
  ViewPoint turned;
  turned.yaw = 0.2;
  EXPECT_EQ(settled(choice, {turned}, avatar).ground, ExportGround::light);
  choice = {.kind = ExportKind::mesh, .mesh = MeshForm::ply, .moving = true};
  EXPECT_EQ(settled(choice, {}, avatar).mesh, MeshForm::glb);
}

TEST(ExportOrder, WhatIsMissingIsSaidBeforeAnythingIsDone) {
  const likeness::test::TinyProject project;
  const auto contents = tiny_contents(project.folder());
  for (const ExportChoice& choice :
       {ExportChoice{.kind = ExportKind::driven}, ExportChoice{.kind = ExportKind::performance},
        ExportChoice{.kind = ExportKind::mesh, .moving = true},
        ExportChoice{.kind = ExportKind::still, .ground = ExportGround::picture}}) {
    const auto written = write(choice, contents);
    ASSERT_FALSE(written.ok());
    EXPECT_FALSE(written.error().fix.empty());
  }
  EXPECT_FALSE(fs::exists(project.folder() / "exports"));
}

TEST(ExportOrder, AStillHasItsSizeAndItsTransparency) {
  const likeness::test::TinyProject project;
  const auto contents = tiny_contents(project.folder());
  const auto written =
      write({.kind = ExportKind::still, .ground = ExportGround::transparent, .times = 2}, contents);
  ASSERT_TRUE(written.ok()) << written.error().what;
  const auto still = read_image(*written);
  ASSERT_TRUE(still.ok());
  EXPECT_EQ(still->width, 128);
  EXPECT_EQ(still->channels, 4);
}

TEST(ExportOrder, ADeviceRendersItAndOneThatFailsIsSaidAndLeavesItToTheProcessor) {
  const likeness::test::TinyProject project;
  const auto contents = tiny_contents(project.folder());
  const ExportChoice choice{.kind = ExportKind::still, .ground = ExportGround::transparent};
  const auto processors = write(choice, contents);
  ASSERT_TRUE(processors.ok());
  const auto truth = read_image(*processors);
  int number = 0;
  for (const long lost_after : {-1L, 5L}) {
    const fs::path out = project.folder() / "exports" / fmt::format("device-{}.png", ++number);
    const OpenBackend open = [&]() -> Result<std::shared_ptr<Backend>> {
      return device_backend(emulated_device({.lost_after = lost_after}));
    };
    const ExportOrder order{choice, contents, std::make_shared<const Performance>(), 0, out, open};
    const auto written = write_order(order, Progress(), {});
    ASSERT_TRUE(written.ok()) << written.error().what;
    EXPECT_GT(emulated_counts().launches, 0u);
    if (lost_after < 0)
      EXPECT_EQ(*written, "written");
    else
      EXPECT_THAT(*written, testing::HasSubstr("Continuing on the processor"));
    const auto still = read_image(out);
    ASSERT_TRUE(still.ok() && truth.ok());
    ASSERT_EQ(still->data.size(), truth->data.size());
    double apart = 0;
    for (std::size_t i = 0; i < truth->data.size(); ++i)
      apart += std::abs(double(still->data[i]) - double(truth->data[i]));
    // The device has a ray for every pixel, the processor for four of a kind.
    EXPECT_LT(apart / double(truth->data.size()), lost_after < 0 ? 3 : 1e-9);
  }
}

TEST(ExportOrder, AnOrbitIsAFilmOrAFolder) {
  const likeness::test::TinyProject project;
  const auto contents = tiny_contents(project.folder());
  ExportChoice choice{.kind = ExportKind::orbit, .frames_per_second = 30, .seconds = 0.2};
  const auto film = write(choice, contents);
  ASSERT_TRUE(film.ok()) << film.error().what;
  const auto info = probe_video(*film);
  ASSERT_TRUE(info.ok());
  EXPECT_EQ(info->frame_count, 6);
  EXPECT_DOUBLE_EQ(info->frames_per_second, 30);
  choice.form = ExportForm::pictures;
  const auto folder = write(choice, contents);
  ASSERT_TRUE(folder.ok()) << folder.error().what;
  EXPECT_TRUE(fs::exists(fs::path(*folder) / "000005.png"));
}

TEST(ExportOrder, WhatWasDirectedIsFilmedAtTheRateAskedFor) {
  const likeness::test::TinyProject project;
  const auto contents = tiny_contents(project.folder());
  Performance performance;
  performance.duration_s = 0.2;
  set_key(performance, "head yaw", {0, 10});
  ExportChoice choice{.kind = ExportKind::performance, .ground = ExportGround::room, .frames_per_second = 50};
  const auto film = write(choice, contents, performance);
  ASSERT_TRUE(film.ok()) << film.error().what;
  EXPECT_EQ(probe_video(*film)->frame_count, 10);
  const auto mesh = write({.kind = ExportKind::mesh, .moving = true}, contents, performance);
  ASSERT_TRUE(mesh.ok()) << mesh.error().what;
  EXPECT_EQ(fs::path(*mesh).extension(), ".glb");
  // The room is known from one place only.
  set_key(performance, "camera yaw", {0, 20});
  EXPECT_EQ(settled(choice, directed_scene(performance, {}), contents->avatar->avatar).ground,
            ExportGround::light);
  EXPECT_TRUE(write(choice, contents, performance).ok());
  // A room that a moving camera taught is known from everywhere.
  const auto walked = tiny_contents(project.folder(), true);
  const auto in_room = write(choice, walked, performance);
  EXPECT_TRUE(in_room.ok()) << in_room.error().what;
  EXPECT_TRUE(room_possible({.kind = ExportKind::orbit}, {}, walked->avatar->avatar));
  EXPECT_FALSE(room_possible({.kind = ExportKind::orbit}, {}, contents->avatar->avatar));
  // A file of one goes before the project's own.
  choice.performance = project.root / "keys.json";
  EXPECT_FALSE(write(choice, contents, performance).ok());
  ASSERT_TRUE(write_performance(choice.performance, performance).ok());
  const fs::path out = project.folder() / "exports" / "moved.mp4";
  const auto said =
      write_order({choice, contents, std::make_shared<const Performance>(), 0, out}, Progress(), {});
  ASSERT_TRUE(said.ok()) << said.error().what;
  EXPECT_THAT(*said, testing::HasSubstr("light background")) << "what stands behind was not chosen";
  performance.channels.clear();
  set_key(performance, "head yaw", {0, 10});
  ASSERT_TRUE(write_performance(choice.performance, performance).ok());
  EXPECT_TRUE(write(choice, contents).ok());
}

// What Direct shows, Export writes: the wall, also of a view that zooms where the camera stood.
TEST(ExportOrder, TheWallIsBehindAStillUnlessItsCameraMoved) {
  const likeness::test::TinyProject project;
  auto contents = std::make_shared<ProjectContents>(*tiny_contents(project.folder()));
  Avatar avatar = contents->avatar->avatar;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) std::fill_n(avatar.plate.at(x, y), 3, std::uint8_t(x < 24 ? 0 : 255));
  contents->avatar = ProjectAvatar::make(std::move(avatar), contents->avatar->model, {});
  const auto at_20 = [&](const char* channel, float value) {
    Performance performance;
    if (*channel) set_key(performance, channel, {0, value});
    const ViewPoint view = direct_moment(contents->avatar->directed, performance, 0).view;
    const ExportChoice choice =
        settled({.kind = ExportKind::still}, directed_scene(performance, view), contents->avatar->avatar);
    const auto written = write(choice, contents, performance);
    EXPECT_TRUE(written.ok());
    const auto still = written ? read_image(*written) : Result<Image8>(written.error());
    EXPECT_TRUE(still.ok());
    const ExportOrder order{choice, contents, std::make_shared<const Performance>(performance), 0, {}};
    const auto first = first_picture(order);
    EXPECT_TRUE(first.ok() && still.ok());
    if (!first || !still) return -1;
    EXPECT_EQ(first->width, still->width);
    EXPECT_NEAR(int(first->at(20, 1)[0]), int(still->at(20, 1)[0]), 12) << channel;
    return int(still->at(20, 1)[0]);
  };
  EXPECT_LT(at_20("", 0), 40);
  EXPECT_GT(at_20("camera zoom", 2), 215) << "twice as large about the middle: column 26 of the wall";
  EXPECT_NEAR(at_20("camera yaw", 20), 0xe6, 40) << "nobody saw the wall from there";
}

TEST(ExportOrder, AnOrbitGoesAsFarAsTheAvatarHolds) {
  const auto contents = tiny_contents("/nowhere");
  EXPECT_EQ(orbit_of(*contents->avatar).high, 25) << "nothing is known of it";
  Avatar avatar = contents->avatar->avatar;
  avatar.holds = HoldingRange{.yaw_low = {-9, "torn"}, .yaw_high = {4, "torn"}};
  const auto checked = ProjectAvatar::make(std::move(avatar), contents->avatar->model, {});
  ASSERT_NE(checked, nullptr);
  EXPECT_NEAR(orbit_of(*checked).low, -9, 0.5);
  EXPECT_NEAR(orbit_of(*checked).high, 4, 0.5);
}

TEST(ExportOrder, WhatWasOnlySettledStaysAsItWasWished) {
  const Avatar avatar = likeness::test::filmed_avatar();
  const ExportChoice wished;
  ExportChoice orbit = settled(wished, {}, avatar);
  orbit.kind = ExportKind::orbit;
  const ExportChoice then = with_wishes(wished, settled(wished, {}, avatar), orbit);
  EXPECT_EQ(settled(then, {}, avatar).ground, ExportGround::light);
  ExportChoice still = settled(then, {}, avatar);
  still.kind = ExportKind::still;
  EXPECT_EQ(settled(with_wishes(then, settled(then, {}, avatar), still), {}, avatar).ground,
            ExportGround::room);
}

TEST(ExportOrder, AStoppedSequenceLeavesNoFolder) {
  const likeness::test::TinyProject project;
  const auto contents = tiny_contents(project.folder());
  const ExportChoice choice{.kind = ExportKind::orbit, .form = ExportForm::pictures};
  const fs::path out = project.folder() / "exports" / "orbit-001";
  std::stop_source stop;
  stop.request_stop();
  const auto written = write_order({choice, contents, std::make_shared<const Performance>(), 0, out},
                                   Progress(), stop.get_token());
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().code, ErrorCode::cancelled);
  EXPECT_FALSE(fs::exists(out));
}

TEST(ExportOrder, WhatWasThereIsNeitherOverwrittenNorRemoved) {
  const likeness::test::TinyProject project;
  const auto contents = tiny_contents(project.folder());
  const fs::path exports = project.folder() / "exports";
  const fs::path theirs = exports / "orbit-001" / "notes.txt";
  ASSERT_TRUE(write_text(theirs, "mine").ok());
  ASSERT_TRUE(write_text(exports / "still-001.png", "mine").ok());
  const auto order = [&](ExportChoice choice, const char* name) {
    return write_order({choice, contents, std::make_shared<const Performance>(), 0, exports / name},
                       Progress(), {});
  };
  const auto folder = order({.kind = ExportKind::orbit, .form = ExportForm::pictures}, "orbit-001");
  ASSERT_FALSE(folder.ok());
  EXPECT_FALSE(folder.error().fix.empty());
  EXPECT_EQ(*read_text(theirs), "mine");
  EXPECT_FALSE(order({.kind = ExportKind::still}, "still-001.png").ok());
  EXPECT_EQ(*read_text(exports / "still-001.png"), "mine");
}

}  // namespace
}  // namespace likeness::ui
