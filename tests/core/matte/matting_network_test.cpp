// Claims about networks from files: their output is scaled to the picture's size, for each output format, and
// files that are not such networks are refused with a reason.
#include "core/matte/matting_network.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "core/base/files.h"
#include "tests/support/onnx_bytes.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Network : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("likeness_network_" + std::to_string(::getpid()) + "_" +
                                           testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path write(const std::string& network, const std::string& format) {
    EXPECT_TRUE(write_text(folder_ / "net.onnx", network));
    if (!format.empty()) {
      EXPECT_TRUE(write_text(folder_ / "net.json", format));
    }
    return folder_ / "net.onnx";
  }
  // Red where the person is, blue elsewhere.
  static Image8 scene() {
    Image8 picture(96, 64, 3);
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 96; ++x) picture.at(x, y)[x < 48 ? 0 : 2] = 255;
    return picture;
  }
  static void expect_left_half(const Result<Image8>& alpha) {
    ASSERT_TRUE(alpha.ok()) << alpha.error().what;
    ASSERT_EQ(alpha->width, 96);
    ASSERT_EQ(alpha->height, 64);
    ASSERT_EQ(alpha->channels, 1);
    EXPECT_GT(*alpha->at(20, 32), 250);
    EXPECT_LT(*alpha->at(76, 32), 5);
  }
  fs::path folder_;
};

TEST_F(Network, MapIsTheAlpha) {
  // Red minus blue of channels in -1..1: 1 for the person, -1 elsewhere, cut at nought.
  const auto network =
      MattingNetwork::load(write(tiny_network(32, {0.5f, 0, -0.5f}, {0}), R"({"size_px": 32})"));
  ASSERT_TRUE(network.ok()) << network.error().what;
  expect_left_half(network->alpha(scene()));
}

TEST_F(Network, LogitsAndClassesAreTurnedIntoShares) {
  {
    const auto network = MattingNetwork::load(
        write(tiny_network(32, {10, 0, -10}, {0}), R"({"size_px": 32, "activation": "sigmoid"})"));
    ASSERT_TRUE(network.ok()) << network.error().what;
    expect_left_half(network->alpha(scene()));
  }
  // Three classes: background likes blue, skin and hair share the red. Given as 0..1, without a mean.
  const auto network = MattingNetwork::load(
      write(tiny_network(32, {0, 0, 20, 20, 0, 0, 20, 0, 0}, {0, 0, 0}),
            R"({"size_px": 32, "mean": [0, 0, 0], "scale": 0.00392157, "activation": "softmax",
                "person_channels": [1, 2], "output": "map"})"));
  ASSERT_TRUE(network.ok()) << network.error().what;
  expect_left_half(network->alpha(scene()));
}

TEST_F(Network, HashCoversNetworkAndFormat) {
  const fs::path file = write(tiny_network(32, {1, 0, 0}, {0}), R"({"size_px": 32})");
  const std::string before = matting_network_hash(file);
  write(tiny_network(32, {1, 0, 0}, {0}), R"({"size_px": 48})");
  EXPECT_NE(matting_network_hash(file), before);
}

TEST_F(Network, RefusesFilesThatAreNotSuchANetwork) {
  EXPECT_EQ(MattingNetwork::load(folder_ / "none.onnx").error().code, ErrorCode::not_found);
  const auto text = MattingNetwork::load(write("Dear diary, this is no network.", ""));
  ASSERT_FALSE(text.ok());
  EXPECT_THAT(text.error().what, HasSubstr("no ONNX file"));
  EXPECT_FALSE(text.error().fix.empty());
  const auto lacking = MattingNetwork::load(
      write(tiny_network(32, {1, 0, 0}, {0}), R"({"size_px": 32, "person_channels": [4]})"));
  ASSERT_FALSE(lacking.ok());
  EXPECT_THAT(lacking.error().what, HasSubstr("1 channels; the person is said to be in channel 4"));
  const auto odd =
      MattingNetwork::load(write(tiny_network(32, {1, 0, 0}, {0}), R"({"activation": "guesswork"})"));
  ASSERT_FALSE(odd.ok());
  EXPECT_THAT(odd.error().what, HasSubstr("guesswork"));
  const auto broken = MattingNetwork::load(write(tiny_network(32, {1, 0, 0}, {0}), "{\"size_px\": "));
  ASSERT_FALSE(broken.ok());
  EXPECT_THAT(broken.error().where, HasSubstr("net.json"));
}

}  // namespace
}  // namespace likeness
