// Claims about perceptual distances by a given network: a squared difference is what it says, and what is no
// distance is refused with what was found.
#include "core/lab/score/perceptual_network.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "core/base/files.h"
#include "tests/support/onnx_bytes.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

std::string node(const std::string& operation, const std::vector<std::string>& inputs,
                 const std::string& output) {
  ProtoWriter w;
  for (const std::string& input : inputs) w.bytes(1, input);
  w.bytes(2, output);
  w.bytes(3, output);
  w.bytes(4, operation);
  return w.out();
}

// (a - b)^2, or a + b where `sum`.
std::string comparing_network(const std::string& first, const std::string& second, int side,
                              bool sum = false) {
  ProtoWriter graph, opset, model;
  graph.bytes(1, node(sum ? "Add" : "Sub", {first, second}, "difference"));
  graph.bytes(1, node("Mul", {"difference", "difference"}, "square"));
  graph.bytes(2, "compare");
  for (const std::string& name : {first, second}) graph.bytes(11, onnx_value(name, {1, 3, side, side}));
  graph.bytes(12, onnx_value("square", {1, 3, side, side}));
  opset.bytes(1, "");
  opset.number(2, 11);
  model.number(1, 6);  // of the format
  model.bytes(7, graph.out());
  model.bytes(8, opset.out());
  return model.out();
}

class PerceptualNetworkTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("likeness_lpips_" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path put(const std::string& network, const std::string& format = "") {
    EXPECT_TRUE(write_text(folder_ / "net.onnx", network).ok());
    if (!format.empty()) {
      EXPECT_TRUE(write_text(folder_ / "net.json", format).ok());
    }
    return folder_ / "net.onnx";
  }
  fs::path folder_;
};

TEST_F(PerceptualNetworkTest, TheDistanceIsTheNetworks) {
  const auto network = PerceptualNetwork::load(put(comparing_network("in0", "in1", 64)));
  ASSERT_TRUE(network.ok()) << network.error().what;
  const Image8 a(64, 64, 3, 51), b(64, 64, 3, 102);
  EXPECT_NEAR(*network->distance(a, b), 0.16, 1e-4);  // 51 of 127.5, squared
  EXPECT_NEAR(*network->distance(a, a), 0, 1e-9);
  EXPECT_FALSE(network->distance(a, Image8(32, 64, 3, 0)).ok());
}

TEST_F(PerceptualNetworkTest, ItsInputsAndItsSizeAreReadBesideIt) {
  const auto network = PerceptualNetwork::load(
      put(comparing_network("x", "y", 32), R"({"inputs": ["x", "y"], "size_px": 32})"));
  ASSERT_TRUE(network.ok()) << network.error().what;
  EXPECT_NEAR(*network->distance(Image8(80, 60, 3, 0), Image8(80, 60, 3, 255)), 4, 1e-4);
}

TEST_F(PerceptualNetworkTest, AnOutputThatIsNotADistanceIsRefused) {
  EXPECT_EQ(PerceptualNetwork::load(folder_ / "absent.onnx").error().code, ErrorCode::not_found);
  EXPECT_EQ(PerceptualNetwork::load(put("not a network")).error().code, ErrorCode::bad_input);
  const auto named = PerceptualNetwork::load(put(comparing_network("x", "y", 64)));
  ASSERT_FALSE(named.ok());
  EXPECT_NE(named.error().fix.find("name its inputs"), std::string::npos);
  const auto sum = PerceptualNetwork::load(put(comparing_network("in0", "in1", 64, true)));
  ASSERT_FALSE(sum.ok());
  EXPECT_NE(sum.error().what.find("no distance"), std::string::npos);
  const auto format = PerceptualNetwork::load(put(comparing_network("in0", "in1", 64), R"({"size_px": 3})"));
  EXPECT_FALSE(format.ok());
}

}  // namespace
}  // namespace likeness
