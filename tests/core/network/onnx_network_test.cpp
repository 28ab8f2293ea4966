// Claims about networks from files: they compute what the file says, for any number of threads, and what is
// no network or does not fit ends in words.
#include "core/network/onnx_network.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <thread>

#include "core/base/files.h"
#include "tests/support/onnx_bytes.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::byte> bytes_of(const std::string& text) {
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

std::string node_of(const std::string& operation, const std::vector<std::string>& inputs,
                    const std::string& output) {
  ProtoWriter w;
  for (const std::string& input : inputs) w.bytes(1, input);
  w.bytes(2, output);
  w.bytes(3, output);
  w.bytes(4, operation);
  return w.out();
}

// "sum" = a + b and "product" = a b, of shape (1, 1, 2, 2).
std::string two_of_each() {
  ProtoWriter graph, opset, model;
  graph.bytes(1, node_of("Add", {"a", "b"}, "sum"));
  graph.bytes(1, node_of("Mul", {"a", "b"}, "product"));
  graph.bytes(2, "two");
  for (const char* name : {"a", "b"}) graph.bytes(11, onnx_value(name, {1, 1, 2, 2}));
  for (const char* name : {"sum", "product"}) graph.bytes(12, onnx_value(name, {1, 1, 2, 2}));
  opset.bytes(1, "");
  opset.number(2, 11);
  model.number(1, 6);  // of the format
  model.bytes(7, graph.out());
  model.bytes(8, opset.out());
  return model.out();
}

TEST(PictureTensor, ChannelsAreApartAndScaled) {
  Image8 picture(2, 1, 3);
  picture.data = {0, 51, 102, 153, 204, 255};
  const Tensor tensor = picture_tensor(picture, 1 / 51.0, {0, 51, 0});
  EXPECT_THAT(tensor.shape, ElementsAre(1, 3, 1, 2));
  EXPECT_THAT(tensor.values, testing::Pointwise(testing::FloatNear(1e-6f), {0.f, 3.f, 0.f, 3.f, 2.f, 5.f}));
}

TEST(OnnxNetworkTest, ComputesWhatTheFileSays) {
  const auto network = OnnxNetwork::load(bytes_of(tiny_network(2, {1, 2, 3, 0, 0, -1}, {0.5f, 0})), "tiny");
  ASSERT_TRUE(network.ok()) << network.error().what;
  Tensor picture{{1, 3, 2, 2}, {}};
  for (int i = 0; i < 12; ++i) picture.values.push_back(float(i));
  const auto map = network->run(picture);
  ASSERT_TRUE(map.ok()) << map.error().what;
  EXPECT_THAT(map->shape, ElementsAre(1, 2, 2, 2));
  EXPECT_THAT(map->values, ElementsAre(32.5f, 38.5f, 44.5f, 50.5f, -8, -9, -10, -11));
  EXPECT_EQ(network->run(picture, "map")->values, map->values);
}

TEST(OnnxNetworkTest, InputsAndOutputsHaveNames) {
  const auto network = OnnxNetwork::load(bytes_of(two_of_each()), "two");
  ASSERT_TRUE(network.ok()) << network.error().what;
  const Tensor a{{1, 1, 2, 2}, {1, 2, 3, 4}}, b{{1, 1, 2, 2}, {5, 6, 7, 8}};
  const NetworkInput inputs[] = {{"b", b}, {"a", a}};
  const std::string outputs[] = {"product", "sum"};
  const auto computed = network->run(inputs, outputs);
  ASSERT_TRUE(computed.ok()) << computed.error().what;
  ASSERT_EQ(computed->size(), 2u);
  EXPECT_THAT((*computed)[0].values, ElementsAre(5, 12, 21, 32));
  EXPECT_THAT((*computed)[1].values, ElementsAre(6, 8, 10, 12));
}

TEST(OnnxNetworkTest, ThreadsGetTheirOwnResults) {
  for (const int max_concurrent : {1, 3}) {
    const auto network =
        OnnxNetwork::load(bytes_of(tiny_network(16, {1, 2, 3}, {0})), "tiny", max_concurrent);
    ASSERT_TRUE(network.ok()) << network.error().what;
    std::atomic<int> right = 0;
    {
      std::vector<std::jthread> threads;
      for (int t = 0; t < 6; ++t)
        threads.emplace_back([&, t] {
          const Tensor picture{{1, 3, 16, 16}, std::vector<float>(3 * 16 * 16, float(t))};
          const std::vector<float> wanted(16 * 16, float(6 * t));
          for (int i = 0; i < 50; ++i) {
            const auto map = network->run(picture);
            right += map.ok() && map->values == wanted;
          }
        });
    }
    EXPECT_EQ(right, 300) << max_concurrent << " at once";
  }
}

TEST(OnnxNetworkTest, WhatDoesNotFitIsRefusedAndHarmsNothing) {
  const auto network = OnnxNetwork::load(bytes_of(tiny_network(8, {1, 0, 0}, {0})), "some/tiny.onnx");
  ASSERT_TRUE(network.ok()) << network.error().what;
  const Tensor picture{{1, 3, 8, 8}, std::vector<float>(3 * 8 * 8, 2)};
  const auto unknown = network->run(picture, "elsewhere");
  ASSERT_FALSE(unknown.ok());
  EXPECT_EQ(unknown.error().code, ErrorCode::bad_input);
  EXPECT_EQ(unknown.error().where, "some/tiny.onnx");
  const auto misshapen = network->run({{1, 5, 8, 8}, std::vector<float>(5 * 8 * 8, 1)});
  ASSERT_FALSE(misshapen.ok());
  EXPECT_THAT(misshapen.error().what, HasSubstr("cannot be run"));
  const auto again = network->run(picture);
  ASSERT_TRUE(again.ok()) << again.error().what;
  EXPECT_THAT(again->values, testing::Each(2));
}

TEST(OnnxNetworkTest, FilesThatAreNoNetworkAreRefused) {
  const fs::path folder = fs::temp_directory_path() / ("likeness_onnx_" + std::to_string(::getpid()));
  const auto absent = OnnxNetwork::load(folder / "absent.onnx");
  ASSERT_FALSE(absent.ok());
  EXPECT_EQ(absent.error().code, ErrorCode::not_found);
  EXPECT_EQ(OnnxNetwork::load(fs::temp_directory_path()).error().code, ErrorCode::not_found);  // a folder
  const std::string good = tiny_network(8, {1, 0, 0}, {0});
  for (const std::string& damaged :
       {std::string("Dear diary, this is no network."), std::string(), good.substr(0, good.size() / 2)}) {
    ASSERT_TRUE(write_text(folder / "net.onnx", damaged).ok());
    const auto refused = OnnxNetwork::load(folder / "net.onnx");
    ASSERT_FALSE(refused.ok()) << damaged.size();
    EXPECT_EQ(refused.error().code, ErrorCode::bad_input);
    EXPECT_THAT(refused.error().fix, HasSubstr("ONNX"));
    EXPECT_THAT(refused.error().where, HasSubstr("net.onnx"));
  }
  fs::remove_all(folder);
}

}  // namespace
}  // namespace likeness
