// Claims about the thread that renders what is directed: rough first, better after, and the newest request
// wins.
#include "ui/avatar_renderer.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/core/film/tiny_project.h"

namespace likeness::ui {
namespace {

std::shared_ptr<const ProjectAvatar> tiny_project_avatar() {
  static const std::shared_ptr<const ProjectAvatar> one = [] {
    Avatar avatar = test::filmed_avatar();
    avatar.size = 64;
    avatar.intrinsics = {64, 64, 120, 120, 32, 32, 0, 0, 0, 0};
    avatar.plate = Image8(64, 64, 3, 77);
    return ProjectAvatar::make(std::move(avatar), std::make_shared<const HeadModel>(test::tiny_head()), {});
  }();
  return one;
}

PictureRequest at_rest(std::uint64_t moment) {
  const auto avatar = tiny_project_avatar();
  DirectedMoment shown = direct_moment(avatar->directed, {}, 0);
  PictureRequest request;
  request.avatar = avatar;
  request.camera = shown.camera;
  request.pose = {shown.pose.world_from_head, shown.pose.world_from_torso, shown.pose.articulation, {}};
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

}  // namespace
}  // namespace likeness::ui
