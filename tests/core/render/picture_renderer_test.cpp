// Claims about core/render/picture_renderer.h: pictures follow the current avatar, and a device that cannot
// be opened or fails loses none of them. On the emulated device.
#include "core/render/picture_renderer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/device/emulated_device.h"
#include "tests/core/render/posed_tiny_avatar.h"

namespace likeness {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

struct Shown {
  std::shared_ptr<const Avatar> avatar = std::make_shared<const Avatar>(posable_avatar());
  std::vector<std::string> said;
  RenderOptions options = device_options(render_options(RenderQuality::preview));

  Shown() { options.precision = FieldPrecision::exact; }
  PictureRenderer renderer(OpenBackend open) {
    return {std::move(open), [this](const std::string& text) { said.push_back(text); }};
  }
  Image picture(PictureRenderer& renderer, const std::shared_ptr<const Avatar>& of) const {
    return renderer.render(of, typical_camera(*of), posed_state(*of, 0), options).rgba;
  }
  double off(const Image& picture, const Avatar& of) const {
    const Image truth = render_frame(of, typical_camera(of), posed_state(of, 0), options).rgba;
    double sum = 0;
    for (std::size_t i = 0; i < truth.data.size(); ++i)
      sum += double(std::abs(picture.data[i] - truth.data[i]));
    return sum / double(truth.data.size());
  }
};

OpenBackend emulated(const EmulatedFaults& faults = {}) {
  return [faults]() -> Result<std::shared_ptr<Backend>> {
    return device_backend(emulated_device(faults), false);
  };
}

TEST(PictureRenderer, FollowsTheCurrentAvatarAndReleasesTheLastOne) {
  Shown shown;
  PictureRenderer renderer = shown.renderer(emulated());
  Avatar changed = *shown.avatar;
  for (float& parameter : changed.head.field.parameters) parameter *= 0.5f;
  const auto other = std::make_shared<const Avatar>(std::move(changed));
  EXPECT_LT(shown.off(shown.picture(renderer, shown.avatar), *shown.avatar), 2e-5);
  const std::size_t of_one = emulated_counts().bytes;
  EXPECT_LT(shown.off(shown.picture(renderer, other), *other), 2e-5);
  EXPECT_GT(shown.off(shown.picture(renderer, other), *shown.avatar), 1e-3);
  EXPECT_EQ(emulated_counts().bytes, of_one);
  EXPECT_EQ(shown.avatar.use_count(), 1);
  EXPECT_TRUE(renderer.on_device());
  renderer.let_go();
  EXPECT_EQ(emulated_counts().bytes, 0u);
  EXPECT_EQ(other.use_count(), 1);
}

TEST(PictureRenderer, OpensTheDeviceOnce) {
  Shown shown;
  int opened = 0;
  PictureRenderer renderer = shown.renderer([&]() -> Result<std::shared_ptr<Backend>> {
    ++opened;
    return Error{ErrorCode::missing_dependency, "There is none.", "Buy one.", "CUDA"};
  });
  for (int k = 0; k < 3; ++k) EXPECT_EQ(shown.off(shown.picture(renderer, shown.avatar), *shown.avatar), 0);
  EXPECT_EQ(opened, 1);
  EXPECT_FALSE(renderer.on_device());
  EXPECT_THAT(shown.said, ElementsAre(HasSubstr("There is none. Continuing on the processor.")));
}

TEST(PictureRenderer, FailingDeviceLosesNoPicture) {
  for (const EmulatedFaults& faults :
       {EmulatedFaults{.memory_bytes = 5000}, EmulatedFaults{.lost_after = 10}}) {
    Shown shown;
    PictureRenderer renderer = shown.renderer(emulated(faults));
    for (int k = 0; k < 3; ++k)
      EXPECT_LT(shown.off(shown.picture(renderer, shown.avatar), *shown.avatar), 2e-5);
    EXPECT_FALSE(renderer.on_device());
    EXPECT_THAT(shown.said, ElementsAre(HasSubstr("Continuing on the processor.")));
  }
}

TEST(PictureRenderer, WithoutABackendItIsTheProcessor) {
  Shown shown;
  PictureRenderer renderer;
  EXPECT_EQ(shown.off(shown.picture(renderer, shown.avatar), *shown.avatar), 0);
  EXPECT_FALSE(renderer.on_device());
}

}  // namespace
}  // namespace likeness
