// Networks as the bytes of ONNX files, written by hand, among them one 1 x 1 convolution: protocol buffers
// are tags, lengths and values.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace likeness {

class ProtoWriter {
 public:
  void number(int field, std::uint64_t value) {
    varint(std::uint64_t(field) << 3);
    varint(value);
  }
  void bytes(int field, const std::string& value) {
    varint(std::uint64_t(field) << 3 | 2);
    varint(value.size());
    out_ += value;
  }
  const std::string& out() const { return out_; }

 private:
  void varint(std::uint64_t value) {
    for (; value >= 128; value >>= 7) out_ += char(value | 128);
    out_ += char(value);
  }
  std::string out_;
};

inline std::string onnx_tensor(const std::string& name, const std::vector<std::int64_t>& shape,
                               const std::vector<float>& values) {
  ProtoWriter w;
  for (const auto d : shape) w.number(1, std::uint64_t(d));
  w.number(2, 1);  // float
  w.bytes(8, name);
  std::string raw(values.size() * sizeof(float), '\0');
  std::memcpy(raw.data(), values.data(), raw.size());
  w.bytes(9, raw);
  return w.out();
}

inline std::string onnx_value(const std::string& name, const std::vector<std::int64_t>& shape) {
  ProtoWriter dimensions, tensor, type, value;
  for (const auto d : shape) {
    ProtoWriter dimension;
    dimension.number(1, std::uint64_t(d));
    dimensions.bytes(1, dimension.out());
  }
  tensor.number(1, 1);  // float
  tensor.bytes(2, dimensions.out());
  type.bytes(1, tensor.out());
  value.bytes(1, name);
  value.bytes(2, type.out());
  return value.out();
}

// weights: (channels, 3), biases: (channels). Pictures of side x side; output "map".
inline std::string tiny_network(int side, const std::vector<float>& weights,
                                const std::vector<float>& biases) {
  const auto channels = std::int64_t(biases.size());
  ProtoWriter node, kernel, graph, opset, model;
  node.bytes(1, "picture");
  node.bytes(1, "weights");
  node.bytes(1, "biases");
  node.bytes(2, "map");
  node.bytes(3, "colour");
  node.bytes(4, "Conv");
  kernel.bytes(1, "kernel_shape");
  kernel.number(8, 1);
  kernel.number(8, 1);
  kernel.number(20, 7);  // integers
  node.bytes(5, kernel.out());
  graph.bytes(1, node.out());
  graph.bytes(2, "tiny");
  graph.bytes(5, onnx_tensor("weights", {channels, 3, 1, 1}, weights));
  graph.bytes(5, onnx_tensor("biases", {channels}, biases));
  graph.bytes(11, onnx_value("picture", {1, 3, side, side}));
  graph.bytes(12, onnx_value("map", {1, channels, side, side}));
  opset.bytes(1, "");
  opset.number(2, 11);
  model.number(1, 6);  // of the format
  model.bytes(7, graph.out());
  model.bytes(8, opset.out());
  return model.out();
}

}  // namespace likeness
