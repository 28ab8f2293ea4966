// Claims about what of an ONNX file is refused before OpenCV's importer sees it.
#include "core/network/check_onnx.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/network/onnx_network.h"
#include "tests/support/onnx_bytes.h"

namespace likeness {
namespace {

using testing::HasSubstr;

std::string fault_of(const std::string& bytes) { return onnx_fault(std::as_bytes(std::span(bytes))); }

std::string whole_attribute(const std::string& name, std::vector<std::int64_t> values, bool single = false) {
  ProtoWriter w;
  w.bytes(1, name);
  for (const std::int64_t value : values) w.number(single ? 3 : 8, std::uint64_t(value));
  w.number(20, single ? 2 : 7);
  return w.out();
}

// A convolution of 3 x 3 over 4 channels to 8, with a further attribute.
std::string convolution(const std::string& attribute, const std::string& weights = {}) {
  ProtoWriter node, graph, model;
  node.bytes(1, "picture");
  node.bytes(1, "weights");
  node.bytes(2, "map");
  node.bytes(4, "Conv");
  if (!attribute.empty()) node.bytes(5, attribute);
  graph.bytes(1, node.out());
  graph.bytes(5, weights.empty() ? onnx_tensor("weights", {8, 4, 3, 3}, std::vector<float>(288)) : weights);
  model.number(1, 6);
  model.bytes(7, graph.out());
  return model.out();
}

TEST(OnnxFault, AnOrdinaryNetworkHasNone) {
  EXPECT_EQ(fault_of(tiny_network(8, {1, 0, 0}, {0})), "");
  EXPECT_EQ(fault_of(convolution(whole_attribute("group", {2}, true))), "");
  EXPECT_EQ(fault_of(convolution(whole_attribute("strides", {2, 2}))), "");
}

TEST(OnnxFault, NumbersThatAreDividedByAreNotZero) {
  EXPECT_THAT(fault_of(convolution(whole_attribute("group", {0}, true))), HasSubstr("group 0"));
  EXPECT_THAT(fault_of(convolution(whole_attribute("group", {-1}, true))), HasSubstr("group -1"));
  EXPECT_THAT(fault_of(convolution(whole_attribute("group", {3}, true))), HasSubstr("3 groups"));
  for (const char* name : {"strides", "dilations", "kernel_shape"})
    EXPECT_THAT(fault_of(convolution(whole_attribute(name, {1, 0}))), HasSubstr(name));
  EXPECT_THAT(fault_of(convolution(whole_attribute("pads", {0, 0, 1'000'000'000, 0}))), HasSubstr("pads"));
  const std::string file = convolution(whole_attribute("group", {0}, true));
  const auto bytes = std::as_bytes(std::span(file));
  const auto refused = OnnxNetwork::load({bytes.begin(), bytes.end()}, "evil.onnx");
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(refused.error().what, HasSubstr("group 0"));
}

TEST(OnnxFault, WeightsLieInTheFile) {
  EXPECT_NE(fault_of(convolution({}, onnx_tensor("weights", {1 << 30, 1 << 30, 3, 3}, {0}))), "");
  EXPECT_NE(fault_of(convolution({}, onnx_tensor("weights", {8, 4, -3, 3}, std::vector<float>(288)))), "");
  ProtoWriter elsewhere;
  for (const int length : {8, 4, 3, 3}) elsewhere.number(1, std::uint64_t(length));
  elsewhere.bytes(8, "weights");
  elsewhere.bytes(13, "location");
  elsewhere.number(14, 1);
  EXPECT_THAT(fault_of(convolution({}, elsewhere.out())), HasSubstr("another file"));
}

TEST(OnnxFault, CutFilesAreRefusedAtEveryLength) {
  const std::string whole = convolution(whole_attribute("group", {2}, true));
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_NE(fault_of(whole.substr(0, size)), "") << size;
  EXPECT_NE(fault_of("Dear diary, this is no network."), "");
}

}  // namespace
}  // namespace likeness
