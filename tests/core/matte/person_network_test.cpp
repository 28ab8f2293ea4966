// Claims about the person network: which part of a picture it sees, and what a project's choice means.
#include "core/matte/person_network.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <filesystem>
#include <random>
#include <string>

#include "core/base/files.h"
#include "core/network/installed_networks.h"
#include "core/video/decode.h"
#include "tests/support/onnx_bytes.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

class PersonNetworkTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_person_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    const char* set = ::getenv("LIKENESS_NETWORKS");
    if (set) before_ = set;
  }
  void TearDown() override {
    before_.empty() ? ::unsetenv("LIKENESS_NETWORKS") : ::setenv("LIKENESS_NETWORKS", before_.c_str(), 1);
    fs::remove_all(folder_);
  }
  // By which the share of person is how red a pixel is.
  fs::path red_network() {
    EXPECT_TRUE(write_text(folder_ / "red.onnx", tiny_network(256, {1, 0, 0}, {0})).ok());
    return folder_ / "red.onnx";
  }
  PersonNetwork red() {
    auto network = PersonNetwork::load(red_network());
    EXPECT_TRUE(network.ok()) << (network ? "" : network.error().what);
    return std::move(*network);
  }

  fs::path folder_;
  std::string before_;
};

// A red rectangle before blue.
Image8 scene(int width, int height, const PictureRect& person) {
  Image8 rgb(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool red =
          x >= person.x && x < person.x + person.width && y >= person.y && y < person.y + person.height;
      rgb.at(x, y)[red ? 0 : 2] = 255;
    }
  return rgb;
}

TEST(PersonRect, LiesInsideThePictureAndHoldsTheHead) {
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    const int width = 100 + int(random() % 1900);
    const int height = 100 + int(random() % 1900);
    FaceBox face;
    face.width = face.height = 10 + double(random() % 300);
    face.x = double(random() % unsigned(width)) - 0.5 * face.width;
    face.y = double(random() % unsigned(height)) - 0.5 * face.height;
    const PictureRect rect = person_rect(face, width, height);
    EXPECT_GE(rect.x, 0);
    EXPECT_GE(rect.y, 0);
    EXPECT_GT(rect.width, 0);
    EXPECT_GT(rect.height, 0);
    EXPECT_LE(rect.x + rect.width, width);
    EXPECT_LE(rect.y + rect.height, height);
    EXPECT_LE(rect.x, std::max(0.0, face.x));
    EXPECT_LE(rect.y, std::max(0.0, face.y - face.height));
    EXPECT_GE(rect.x + rect.width, std::min(double(width), face.x + face.width));
    EXPECT_GE(rect.y + rect.height, std::min(double(height), face.y + 2 * face.height));
  }
}

TEST_F(PersonNetworkTest, TheShareHasThePicturesFormat) {
  const auto share = red().share(scene(300, 120, {0, 0, 150, 120}));
  ASSERT_TRUE(share.ok()) << share.error().what;
  ASSERT_EQ(share->width, 300);
  ASSERT_EQ(share->height, 120);
  ASSERT_EQ(share->channels, 1);
  EXPECT_EQ(*share->at(100, 60), 255);
  EXPECT_EQ(*share->at(200, 60), 0);
}

// Of a network that sees a pixel's own colour, both ways are the same; the mirror image must be turned back.
TEST_F(PersonNetworkTest, BothWaysAgreeOnWhatDoesNotDependOnTheWay) {
  const PersonNetwork network = red();
  const Image8 rgb = scene(256, 256, {30, 40, 90, 120});
  const auto once = network.share(rgb, Looks::once), both = network.share(rgb, Looks::both_ways);
  ASSERT_TRUE(once.ok() && both.ok());
  EXPECT_EQ(once->data, both->data);
}

// Beyond the part is black, as filling may be, or the person's repeated border: neither is seen.
TEST_F(PersonNetworkTest, WhatLiesBeyondThePartIsNotSeen) {
  Image8 rgb = scene(100, 100, {0, 0, 100, 100});
  for (int y = 0; y < 100; ++y)
    for (int x = 20; x < 80; ++x) rgb.at(x, y)[0] = x < 50 ? 255 : 0;
  const auto share = red().share_in(rgb, {20, 0, 60, 100});
  ASSERT_TRUE(share.ok()) << share.error().what;
  ASSERT_EQ(share->width, 100);
  EXPECT_EQ(*share->at(40, 50), 255);
  EXPECT_EQ(*share->at(60, 50), 0);
  EXPECT_EQ(*share->at(10, 50), 255);  // the nearest pixel of the part
  EXPECT_EQ(*share->at(90, 50), 0);    // red, but beyond the part
}

TEST_F(PersonNetworkTest, ASmallPersonInAWidePictureIsPutBackInPlace) {
  const PictureRect person{700, 300, 60, 150};
  const auto share = red().share_about(scene(1600, 600, person), {715, 320, 30, 30});
  ASSERT_TRUE(share.ok()) << share.error().what;
  ASSERT_EQ(share->width, 1600);
  for (const auto& [x, y, is] : {std::tuple{730, 340, true},
                                 {703, 330, true},
                                 {757, 445, true},
                                 {694, 340, false},
                                 {766, 340, false},
                                 {730, 290, false},
                                 {100, 100, false}})
    EXPECT_EQ(*share->at(x, y), is ? 255 : 0) << x << "," << y;
}

TEST_F(PersonNetworkTest, ThePartGrowsWhileThePersonReachesBeyondIt) {
  // Arms held out are wider than the usual part of seven faces.
  const PictureRect arms{600, 350, 400, 30};
  const FaceBox face{785, 320, 30, 30};
  ASSERT_LT(person_rect(face, 1600, 600).width, 300);
  const auto share = red().share_about(scene(1600, 600, arms), face);
  ASSERT_TRUE(share.ok()) << share.error().what;
  EXPECT_EQ(*share->at(610, 365), 255);
  EXPECT_EQ(*share->at(990, 365), 255);
}

TEST_F(PersonNetworkTest, ANetworkOfAnotherFormatIsRefused) {
  ASSERT_TRUE(write_text(folder_ / "two.onnx", tiny_network(256, {1, 0, 0, 0, 1, 0}, {0, 0})).ok());
  const auto two = PersonNetwork::load(folder_ / "two.onnx");
  ASSERT_FALSE(two.ok());
  EXPECT_NE(two.error().what.find("131072"), std::string::npos) << two.error().what;
  EXPECT_EQ(PersonNetwork::load(folder_ / "none.onnx").error().code, ErrorCode::not_found);
}

TEST_F(PersonNetworkTest, WithoutOneInstalledNoneIsChosen) {
  ::setenv("LIKENESS_NETWORKS", folder_.c_str(), 1);
  for (const char* choice : {"", "none"}) {
    const auto chosen = chosen_person_network(choice);
    ASSERT_TRUE(chosen.ok()) << chosen.error().what;
    EXPECT_EQ(*chosen, nullptr);
    EXPECT_EQ(person_network_hash(choice), "");
  }
}

TEST_F(PersonNetworkTest, AFileThatIsNamedIsUsedOrRefusedAndHashedByContent) {
  const fs::path red = red_network();
  const auto chosen = chosen_person_network(red);
  ASSERT_TRUE(chosen.ok()) << chosen.error().what;
  EXPECT_NE(*chosen, nullptr);
  const std::string hash = person_network_hash(red);
  EXPECT_NE(hash, "");
  ASSERT_TRUE(write_text(red, tiny_network(256, {0, 1, 0}, {0})).ok());
  EXPECT_NE(person_network_hash(red), hash);
  EXPECT_FALSE(chosen_person_network(folder_ / "absent.onnx").ok());
}

// Another file under the installed one's name: to go on without it would be to change results in silence.
TEST_F(PersonNetworkTest, ADamagedInstalledNetworkIsAnError) {
  ASSERT_TRUE(write_text(folder_ / "person.onnx", tiny_network(256, {1, 0, 0}, {0})).ok());
  ::setenv("LIKENESS_NETWORKS", folder_.c_str(), 1);
  EXPECT_FALSE(chosen_person_network("").ok());
  EXPECT_NE(person_network_hash(""), "");
  EXPECT_TRUE(chosen_person_network("none").ok());
}

// Of the real network, where it is installed, on a real clip, where there is one.
TEST_F(PersonNetworkTest, TheInstalledNetworkSeesAPerson) {
  if (const auto found = find_installed_network(InstalledNetwork::person); !found)
    GTEST_SKIP() << found.error().what << " " << found.error().fix;
  const fs::path video = fs::path(LIKENESS_SHARED) / "captures" / "wojtek.mp4";
  if (!fs::exists(video)) GTEST_SKIP() << "no capture at " << video;
  const auto network = PersonNetwork::installed();
  ASSERT_TRUE(network.ok()) << network.error().what;
  auto reader = VideoReader::open(video);
  ASSERT_TRUE(reader.ok());
  const auto frame = reader->next();
  ASSERT_TRUE(frame.ok() && frame->has_value());
  const auto share = network->share((**frame).rgb);
  ASSERT_TRUE(share.ok()) << share.error().what;
  for (const auto& [x, y, is] : {std::tuple{256, 250, true},
                                 {256, 130, true},
                                 {60, 490, true},
                                 {450, 490, true},
                                 {256, 505, true},
                                 {30, 30, false},
                                 {480, 30, false},
                                 {20, 250, false}}) {
    EXPECT_EQ(*share->at(x, y) > 127, is) << x << "," << y;
    EXPECT_TRUE(*share->at(x, y) < 13 || *share->at(x, y) > 242) << x << "," << y;
  }
}

}  // namespace
}  // namespace likeness
