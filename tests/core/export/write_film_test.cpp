// Claims about films: what is refused before long work, what is written where, and that transparency is
// correct.
#include "core/export/write_film.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "core/base/files.h"
#include "core/base/rigid.h"
#include "core/image/files.h"
#include "core/render/camera_path.h"
#include "core/render/room_picture.h"
#include "core/video/decode.h"
#include "tests/core/export/tiny_project.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST(Film, AProjectWithoutAnAvatarSaysHowToGetOne) {
  const TinyProject project;
  ASSERT_TRUE(open_avatar(project.folder()).ok());
  fs::remove(project.folder() / "avatar.bin");
  const auto opened = open_avatar(project.folder());
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, ErrorCode::not_found);
  EXPECT_NE(opened.error().fix.find("likeness build"), std::string::npos);
}

TEST(Film, AnAvatarOfAnotherHeadModelIsRefused) {
  const TinyProject project;
  Avatar other = filmed_avatar();
  other.head_model_hash = "0123";
  ASSERT_TRUE(write_avatar(project.folder() / "avatar.bin", other).ok());
  const auto opened = open_avatar(project.folder());
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, ErrorCode::bad_input);
}

TEST(Film, RefusesIncompatibleOptionsBeforeLongWork) {
  const Avatar avatar = filmed_avatar();
  const auto wrong = [&](std::size_t frames, const FilmOptions& options) {
    return !check_film(avatar, avatar.intrinsics, frames, options).ok();
  };
  EXPECT_FALSE(wrong(1, {.out = "a.png"}));
  EXPECT_TRUE(wrong(2, {.out = "a.png"}));
  EXPECT_TRUE(wrong(2, {.out = "a.mp4", .alpha = true}));
  EXPECT_TRUE(wrong(2, {.out = "a.mov"}));
  EXPECT_TRUE(wrong(2, {.out = "a.mp4", .beside_width = 20000}));
  EXPECT_FALSE(wrong(2, {.out = "folder", .alpha = true}));
  EXPECT_TRUE(wrong(2, {.out = "folder", .alpha = true, .beside_width = 8}));
  EXPECT_TRUE(wrong(1, {.out = "a.png", .background = "blue"}));
  EXPECT_FALSE(wrong(1, {.out = "a.png", .background = "#0000ff"}));
  FilmOptions plate{.out = "a.png", .background = "plate"};
  EXPECT_FALSE(wrong(1, plate));
  Intrinsics larger = avatar.intrinsics;
  larger.width *= 2;
  EXPECT_FALSE(check_film(avatar, larger, 1, plate).ok());
  plate.width = 192;  // of the plate's shape: it is enlarged with the pictures
  EXPECT_FALSE(wrong(1, plate));
  EXPECT_TRUE(wrong(1, {.out = "a.png", .background = "absent.png"}));
  EXPECT_TRUE(wrong(1, {.out = "a.png", .width = 20000}));
}

TEST(Film, AnotherSizeScalesPictureAndPlateAlike) {
  const TinyProject project;
  const OpenedAvatar opened = tiny_opened();
  const Film film = resting_film(opened.avatar, 1);
  const fs::path as_made = project.root / "as_made.png", large = project.root / "large.png";
  ASSERT_TRUE(write_film(opened, film, {.out = as_made}, Progress(), {}).ok());
  ASSERT_TRUE(write_film(opened, film, {.out = large, .width = 192}, Progress(), {}).ok());
  const auto small = read_image(as_made), twice = read_image(large);
  ASSERT_TRUE(small.ok() && twice.ok());
  ASSERT_EQ(twice->width, 192);
  ASSERT_EQ(twice->height, 128);
  EXPECT_EQ(*twice->at(2, 2), 77);  // the plate's
  const Image8 shrunk = resize(*twice, 96, 64);
  double difference = 0;
  for (std::size_t i = 0; i < shrunk.data.size(); ++i)
    difference += std::abs(int(shrunk.data[i]) - int(small->data[i]));
  EXPECT_LT(difference / double(shrunk.data.size()), 6);
}

TEST(Film, PictureBehindTheAvatarIsCroppedToShape) {
  const TinyProject project;
  const OpenedAvatar opened = tiny_opened();
  Image8 wall(40, 80, 3, 10);  // upright: its middle 40 x 27 px are shown
  for (int y = 30; y < 50; ++y)
    for (int x = 0; x < 40; ++x) *wall.at(x, y) = 250;
  const fs::path picture = project.root / "wall.png", out = project.root / "out.png";
  ASSERT_TRUE(write_image(picture, wall).ok());
  FilmOptions options{.out = out, .background = picture.string()};
  ASSERT_TRUE(write_film(opened, resting_film(opened.avatar, 1), options, Progress(), {}).ok());
  const auto shown = read_image(out);
  ASSERT_TRUE(shown.ok());
  EXPECT_EQ(*shown->at(1, 32), 250);
  EXPECT_EQ(*shown->at(1, 1), 10);
  EXPECT_EQ(shown->at(1, 32)[1], 10);
}

// Random colours all round the camera.
FieldPart random_room() {
  FieldPart room = *filmed_avatar().torso;
  room.cube = {Vec3f(-2, -2, -1), 4};
  return room;
}

TEST(Film, ARoomIsSeenFromEveryFramesCamera) {
  const TinyProject project;
  OpenedAvatar opened = tiny_opened();
  opened.avatar.room = random_room();
  std::vector<Camera> cameras(2, typical_camera(opened.avatar));
  cameras[1].cam_from_world.rotate(rotation_about(Vec3d::UnitY(), 0.3));
  const Film film = listed_film(cameras, std::vector(2, typical_state(opened.avatar).pose));
  const fs::path out = project.root / "room";
  ASSERT_TRUE(write_film(opened, film, {.out = out, .background = "room"}, Progress(), {}).ok());
  const RoomScene room = make_room_scene(*opened.avatar.room);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto shown = read_image(out / (i == 0 ? "000000.png" : "000001.png"));
    ASSERT_TRUE(shown.ok());
    const Image8 behind = room_picture(room, cameras[i]);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(shown->at(2, 2)[c], behind.at(2, 2)[c], 1);
  }
  const Image8 first = room_picture(room, cameras[0]), second = room_picture(room, cameras[1]);
  EXPECT_FALSE(std::equal(first.at(2, 2), first.at(2, 2) + 3, second.at(2, 2)));
}

TEST(Film, MissingBackgroundIsReportedWithTheOneThereIs) {
  Avatar avatar = filmed_avatar();
  const auto fault = [&](const std::string& background) {
    const auto checked = check_film(avatar, avatar.intrinsics, 1, {.out = "a.png", .background = background});
    return checked ? std::string() : checked.error().what + " " + checked.error().fix;
  };
  EXPECT_THAT(fault("room"), AllOf(HasSubstr("its camera rested"), HasSubstr("Choose plate")));
  avatar.room = random_room();
  EXPECT_EQ(fault("room"), "");
  avatar.plate = {};
  EXPECT_THAT(fault("plate"), AllOf(HasSubstr("its camera moved"), HasSubstr("Choose room")));
  avatar.room.reset();
  EXPECT_THAT(fault("plate"), AllOf(HasSubstr("its camera moved"), Not(HasSubstr("Choose room"))));
}

TEST(Film, WithoutAPlateARestingCameraSeesTheRoom) {
  const TinyProject project;
  OpenedAvatar opened = tiny_opened();
  opened.avatar.room = random_room(), opened.avatar.plate = {};
  const Film film = resting_film(opened.avatar, 1);
  const auto corner = [&](const FilmOptions& options) {
    EXPECT_TRUE(write_film(opened, film, options, Progress(), {}).ok());
    const auto shown = read_image(options.out);
    return std::vector<int>(shown->at(2, 2), shown->at(2, 2) + 3);
  };
  const auto room = corner({.out = project.root / "a.png", .background = "room"});
  EXPECT_EQ(corner({.out = project.root / "b.png"}), room);
  EXPECT_EQ(corner({.out = project.root / "c.png", .camera_rests = false}),
            (std::vector<int>{230, 230, 230}));
}

TEST(Film, FolderGetsOnePicturePerFrameAndAnMp4AllOfThem) {
  const TinyProject project;
  const OpenedAvatar opened = tiny_opened();
  const Film film = resting_film(opened.avatar, 3);
  const auto pictures = write_film(opened, film, {.out = project.root / "frames"}, Progress(), {});
  ASSERT_TRUE(pictures.ok()) << pictures.error().what;
  EXPECT_EQ(*pictures, 3);
  for (const char* name : {"000000.png", "000001.png", "000002.png"})
    EXPECT_TRUE(read_image(project.root / "frames" / name).ok()) << name;
  ASSERT_TRUE(write_film(opened, film, {.out = project.root / "film.mp4"}, Progress(), {}).ok());
  const auto info = probe_video(project.root / "film.mp4");
  ASSERT_TRUE(info.ok());
  EXPECT_EQ(info->frame_count, 3);
  EXPECT_FALSE(write_film(opened, film, {.out = project.root / "frames"}, Progress(), {}).ok())
      << "a mix of two sequences";
  EXPECT_EQ(info->width, 96);
}

TEST(Film, PicturesThatAKilledProcessLeftAreClearedByTheNext) {
  const TinyProject project;
  const OpenedAvatar opened = tiny_opened();
  const fs::path out = project.root / "frames";
  const auto render = [&] {
    return write_film(opened, resting_film(opened.avatar, 2), {.out = out}, Progress(), {});
  };
  fs::create_directories(out);
  for (const char* name :
       {"000000.png", "000007.png", ".000008.999999999-3.part.png", ".pictures.999999999-2.part"})
    ASSERT_TRUE(write_text(out / name, "").ok());
  const auto written = render();
  ASSERT_TRUE(written.ok()) << written.error().what;
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(out)) names.push_back(entry.path().filename().string());
  EXPECT_THAT(names, testing::UnorderedElementsAre("000000.png", "000001.png"));
  EXPECT_FALSE(render().ok()) << "those are finished";
  // Neither where anything else lies there, nor where their process lives.
  ASSERT_TRUE(write_text(out / ".pictures.999999999-2.part", "").ok());
  ASSERT_TRUE(write_text(out / "notes.txt", "mine").ok());
  EXPECT_FALSE(render().ok());
  EXPECT_TRUE(fs::exists(out / "000001.png"));
  fs::remove(out / "notes.txt");
  ASSERT_TRUE(write_text(out / (".pictures." + std::to_string(::getpid()) + "-2.part"), "").ok());
  EXPECT_FALSE(render().ok());
  EXPECT_TRUE(fs::exists(out / "000001.png"));
}

TEST(Film, FramesStandAtTheirTimes) {
  const TinyProject project;
  const OpenedAvatar opened = tiny_opened();
  const Film film = resting_film(opened.avatar, 4);
  FilmOptions options{.out = project.root / "film.mp4", .frames_per_second = 30};
  options.times_s = {0, 1.0 / 30, 0.35, 4};
  ASSERT_TRUE(write_film(opened, film, options, Progress(), {}).ok());
  auto reader = VideoReader::open(options.out);
  ASSERT_TRUE(reader.ok());
  for (const double time_s : options.times_s) {
    const auto frame = reader->next();
    ASSERT_TRUE(frame.ok() && *frame);
    EXPECT_NEAR((*frame)->time_s, time_s, 1e-4);
  }
  options.out = project.root / "frames";
  ASSERT_TRUE(write_film(opened, film, options, Progress(), {}).ok());
  const auto list = read_text(options.out / "pictures.ffconcat");
  ASSERT_TRUE(list.ok());
  EXPECT_THAT(*list, HasSubstr("file 000002.png\nduration 3.650000\nfile 000003.png\n"));
}

TEST(Film, AlphaIsStoredStraightAndCompositesOverTheBackground) {
  const TinyProject project;
  const OpenedAvatar opened = tiny_opened();
  const Film film = resting_film(opened.avatar, 1);
  const fs::path clear = project.root / "clear.png", white = project.root / "white.png";
  ASSERT_TRUE(write_film(opened, film, {.out = clear, .alpha = true}, Progress(), {}).ok());
  ASSERT_TRUE(write_film(opened, film, {.out = white, .background = "#ffffff"}, Progress(), {}).ok());
  const auto rgba = read_image(clear), rgb = read_image(white);
  ASSERT_TRUE(rgba.ok() && rgb.ok());
  ASSERT_EQ(rgba->channels, 4);
  int opaque = 0, open = 0;
  for (std::size_t i = 0; i < rgba->pixels(); ++i) {
    const double alpha = rgba->data[4 * i + 3] / 255.0;
    opaque += alpha > 0.9, open += alpha < 0.1;
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(rgba->data[4 * i + c] * alpha + 255 * (1 - alpha), rgb->data[3 * i + c], 2.5);
  }
  EXPECT_GT(opaque, 20);
  EXPECT_GT(open, 20);
}

TEST(Film, SideBySidePicturesAreOnTheLeft) {
  const TinyProject project;
  const OpenedAvatar opened = tiny_opened();
  FilmOptions options{.out = project.root / "both.png", .beside_width = 10};
  options.beside = [](std::size_t) { return Result<Image8>(Image8(10, 64, 3, 200)); };
  ASSERT_TRUE(write_film(opened, resting_film(opened.avatar, 1), options, Progress(), {}).ok());
  const auto both = read_image(project.root / "both.png");
  ASSERT_TRUE(both.ok());
  EXPECT_EQ(both->width, 106);
  EXPECT_EQ(*both->at(5, 32), 200);
  EXPECT_EQ(*both->at(12, 2), 77);  // the avatar's plate
}

TEST(Film, StoppingHalfwayLeavesNothing) {
  const OpenedAvatar opened = tiny_opened();
  for (const char* out : {"film.mp4", "frames"}) {
    const TinyProject project;
    std::stop_source stop;
    const Progress watch([&](const ProgressReport& report) {
      if (report.fraction > 0.3) stop.request_stop();
    });
    const auto written = write_film(opened, resting_film(opened.avatar, 6), {.out = project.root / out},
                                    watch, stop.get_token());
    ASSERT_FALSE(written.ok()) << out;
    EXPECT_EQ(written.error().code, ErrorCode::cancelled);
    EXPECT_TRUE(stop.stop_requested());
    int left = 0;
    for (const auto& entry : fs::recursive_directory_iterator(project.root)) left += entry.is_regular_file();
    const TinyProject untouched;
    int before = 0;
    for (const auto& entry : fs::recursive_directory_iterator(untouched.root))
      before += entry.is_regular_file();
    EXPECT_EQ(left, before) << out;
  }
}

}  // namespace
}  // namespace likeness::test
