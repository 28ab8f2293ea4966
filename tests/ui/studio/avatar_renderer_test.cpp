// Claims about the thread that renders what is directed: rough first, better after, and the newest request
// wins.
#include "ui/studio/avatar_renderer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "tests/core/device/emulated_device.h"
#include "tests/core/export/tiny_project.h"

namespace likeness::ui {
namespace {

std::shared_ptr<const ProjectAvatar> tiny_project_avatar() {
  static const std::shared_ptr<const ProjectAvatar> one = [] {
    Avatar avatar = likeness::test::filmed_avatar();
    avatar.size = 64;
    avatar.intrinsics = {64, 64, 120, 120, 32, 32, 0, 0, 0, 0};
    avatar.plate = Image8(64, 64, 3, 77);
    return ProjectAvatar::make(std::move(avatar),
                               std::make_shared<const HeadModel>(likeness::test::tiny_head()), {});
  }();
  return one;
}

PictureRequest at_rest(std::uint64_t moment) {
  const auto avatar = tiny_project_avatar();
  DirectedMoment shown = direct_moment(avatar->directed, {}, 0);
  PictureRequest request;
  request.avatar = avatar;
  request.camera = shown.camera;
  request.pose = shown.pose;
  request.origin.moment = moment;
  request.finest = 96;
  return request;
}

std::shared_ptr<const AvatarPicture> wait_for_last(const AvatarRenderer& renderer, std::uint64_t moment,
                                                   std::set<Rung>* rungs = nullptr) {
  for (int i = 0; i < 20000; ++i) {
    const auto picture = renderer.latest();
    if (picture && picture->origin.moment == moment) {
      if (rungs) rungs->insert(picture->rung);
      if (picture->last) return picture;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return nullptr;
}

TEST(AvatarRenderer, EndsWithTheFinestPictureAndRests) {
  AvatarRenderer renderer([] {});
  EXPECT_EQ(renderer.latest(), nullptr);
  renderer.request(at_rest(1));
  const auto picture = wait_for_last(renderer, 1);
  ASSERT_NE(picture, nullptr);
  EXPECT_EQ(picture->rung, Rung::fine);
  EXPECT_EQ(picture->rgba.width, 96);
  EXPECT_EQ(picture->rgba.channels, 4);
  for (int i = 0; i < 2000 && renderer.busy(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_FALSE(renderer.busy());
}

TEST(AvatarRenderer, TheNewestRequestWins) {
  AvatarRenderer renderer([] {});
  for (std::uint64_t moment = 1; moment <= 30; ++moment) renderer.request(at_rest(moment));
  ASSERT_NE(wait_for_last(renderer, 30), nullptr);
  EXPECT_EQ(renderer.latest()->origin.moment, 30u);
}

TEST(AvatarRenderer, ForgetsWhatItShowed) {
  AvatarRenderer renderer([] {});
  renderer.request(at_rest(1));
  ASSERT_NE(wait_for_last(renderer, 1), nullptr);
  renderer.clear();
  EXPECT_EQ(renderer.latest(), nullptr);
}

// -- On a device

OpenBackend on_emulated(const EmulatedFaults& faults) {
  return [faults]() -> Result<std::shared_ptr<Backend>> {
    return device_backend(emulated_device(faults), false);
  };
}

TEST(AvatarRenderer, OnADeviceTheBestIsTheFirstAndItIsTheProcessors) {
  AvatarRenderer here([] {}), there([] {}, on_emulated({}));
  std::set<Rung> rungs;
  here.request(at_rest(1)), there.request(at_rest(1));
  const auto picture = wait_for_last(there, 1, &rungs), truth = wait_for_last(here, 1);
  ASSERT_TRUE(picture && truth);
  EXPECT_EQ(rungs, std::set<Rung>{Rung::fine});
  EXPECT_TRUE(there.on_device());
  EXPECT_FALSE(here.on_device());
  EXPECT_EQ(there.take_note(), std::nullopt);
  ASSERT_EQ(picture->rgba.data.size(), truth->rgba.data.size());
  double apart = 0;
  for (std::size_t i = 0; i < truth->rgba.data.size(); ++i)
    apart += double(std::abs(picture->rgba.data[i] - truth->rgba.data[i]));
  EXPECT_LT(apart / double(truth->rgba.data.size()), 2e-3);  // there in single precision, here in bfloat16
}

TEST(AvatarRenderer, ALostDeviceIsSaidOnceAndNoPictureIsLost) {
  AvatarRenderer renderer([] {}, on_emulated({.lost_after = 40}));
  for (std::uint64_t moment = 1; moment <= 4; ++moment) {
    renderer.request(at_rest(moment));
    ASSERT_NE(wait_for_last(renderer, moment), nullptr) << moment;
  }
  EXPECT_FALSE(renderer.on_device());
  const auto note = renderer.take_note();
  ASSERT_TRUE(note.has_value());
  EXPECT_THAT(*note, testing::HasSubstr("stopped responding"));
  EXPECT_THAT(*note, testing::HasSubstr("Continuing on the processor"));
  EXPECT_EQ(renderer.take_note(), std::nullopt);
}

TEST(AvatarRenderer, ForgettingLetsTheAvatarOnTheDeviceGo) {
  const auto avatar = tiny_project_avatar();
  const long before = avatar.use_count();
  AvatarRenderer renderer([] {}, on_emulated({}));
  renderer.request(at_rest(1));
  ASSERT_NE(wait_for_last(renderer, 1), nullptr);
  EXPECT_GT(avatar.use_count(), before);
  renderer.clear();
  for (int i = 0; i < 2000 && avatar.use_count() > before; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_EQ(avatar.use_count(), before);
}

}  // namespace
}  // namespace likeness::ui
