// Claims about the inside of a mouth that was never seen open: it is dark, darker farther back, its teeth are
// the lightest of it, and what was seen stays.
#include "core/train/mouth_colours.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/head/builtin_head.h"

namespace likeness {
namespace {

const Vec3f kSkinColour(0.8f, 0.6f, 0.5f), kWhite(0.85f, 0.85f, 0.85f);

struct ShutMouth {
  HeadModel model = make_builtin_head();
  std::vector<Vec3f> rest =
      pose_head(model, shape_head(model, Eigen::VectorXf()), neutral_articulation(model));
  std::vector<std::uint8_t> inside = inside_mouth(model);
  std::vector<float> known;
  std::vector<Vec3f> colours;

  ShutMouth() {
    for (std::size_t v = 0; v < rest.size(); ++v) {
      const bool eye = model.parts[v] == HeadPart::left_eyeball || model.parts[v] == HeadPart::right_eyeball;
      known.push_back(inside[v] ? 0.f : 1.f);
      colours.push_back(inside[v] ? Vec3f::Zero() : eye ? kWhite : kSkinColour);
    }
  }
  float brightness(HeadPart part) const {
    float sum = 0;
    int count = 0;
    for (std::size_t v = 0; v < rest.size(); ++v)
      if (model.parts[v] == part) sum += colours[v].mean(), ++count;
    return sum / float(count);
  }
};

TEST(MouthColours, AreDarkWithLightTeeth) {
  ShutMouth mouth;
  ASSERT_GT(std::ranges::count(mouth.inside, 1), 100);
  colour_mouth(mouth.model, mouth.rest, mouth.known, mouth.colours);
  for (std::size_t v = 0; v < mouth.rest.size(); ++v) {
    EXPECT_EQ(mouth.known[v], 1.f);
    if (!mouth.inside[v]) {
      EXPECT_EQ(mouth.colours[v], mouth.model.parts[v] == HeadPart::left_eyeball ||
                                          mouth.model.parts[v] == HeadPart::right_eyeball
                                      ? kWhite
                                      : kSkinColour);
    }
  }
  EXPECT_LT(mouth.brightness(HeadPart::mouth_socket), 0.6f * kSkinColour.mean());
  EXPECT_GT(mouth.brightness(HeadPart::teeth), 1.3f * mouth.brightness(HeadPart::gums_tongue));
}

TEST(MouthColours, FadeBackwards) {
  ShutMouth mouth;
  colour_mouth(mouth.model, mouth.rest, mouth.known, mouth.colours);
  float front = 0, back = 1, front_z = -1, back_z = 1;
  for (std::size_t v = 0; v < mouth.rest.size(); ++v) {
    if (mouth.model.parts[v] != HeadPart::teeth) continue;
    if (mouth.rest[v].z() > front_z) front_z = mouth.rest[v].z(), front = mouth.colours[v].mean();
    if (mouth.rest[v].z() < back_z) back_z = mouth.rest[v].z(), back = mouth.colours[v].mean();
  }
  EXPECT_GT(front, 1.2f * back);
}

TEST(MouthColours, KeepWhatWasSeen) {
  ShutMouth mouth;
  const auto seen = std::size_t(std::ranges::find(mouth.inside, 1) - mouth.inside.begin());
  mouth.known[seen] = 1, mouth.colours[seen] = {0.1f, 0.9f, 0.1f};
  colour_mouth(mouth.model, mouth.rest, mouth.known, mouth.colours);
  EXPECT_EQ(mouth.colours[seen], Vec3f(0.1f, 0.9f, 0.1f));
}

TEST(MouthColours, SayNothingWithoutLips) {
  ShutMouth mouth;
  std::ranges::fill(mouth.known, 0.f);
  const std::vector<Vec3f> before = mouth.colours;
  colour_mouth(mouth.model, mouth.rest, mouth.known, mouth.colours);
  EXPECT_EQ(mouth.colours, before);
}

}  // namespace
}  // namespace likeness
