// A neural network from an ONNX file (opset 9 to 13), run on the processor by OpenCV's dnn. Numbers in,
// numbers out: what they mean is the business of whoever holds the network.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness {

// A box of numbers, the last dimension fastest. Pictures: (pictures, channels, rows, columns).
struct Tensor {
  std::vector<int> shape;     // each > 0
  std::vector<float> values;  // as many as the shape's product
};

// One picture as networks want it: (1, channels, height, width), values (8-bit value - mean) * scale; the
// channels' order is the picture's.
Tensor picture_tensor(const Image8& picture, double scale, const std::array<double, 3>& mean = {0, 0, 0});

// What is given to a network that has several inputs.
struct NetworkInput {
  std::string name;  // as the file calls it; empty: the only one
  Tensor tensor;
};

class OnnxNetwork {
 public:
  // not_found: there is no such file. bad_input: it is damaged, no ONNX file, or uses operators that OpenCV
  // lacks; no size that the file claims is trusted. Errors' `fix` is general: who knows what the network is
  // for may say more. max_concurrent: how many threads may run it at the same time, each in a copy of its
  // own, which is made when first needed and kept; others wait their turn. A copy holds all weights and every
  // layer's output.
  static Result<OnnxNetwork> load(const std::filesystem::path& onnx, int max_concurrent = 1);
  // The same of a file's bytes; `origin` is only named in errors.
  static Result<OnnxNetwork> load(std::vector<std::byte> bytes, const std::filesystem::path& origin,
                                  int max_concurrent = 1);
  ~OnnxNetwork();
  OnnxNetwork(OnnxNetwork&&) noexcept;
  OnnxNetwork& operator=(OnnxNetwork&&) noexcept;

  // The outputs of these names, in this order; one of fewer than two dimensions has (n, 1). bad_input: an
  // unknown name, or a shape the network cannot take. Any number of threads may call. The same input gives
  // the same bits, whichever copy computes it.
  Result<std::vector<Tensor>> run(std::span<const NetworkInput> inputs,
                                  std::span<const std::string> outputs) const;
  // One input, one output; an empty name is the file's last output.
  Result<Tensor> run(const Tensor& input, const std::string& output = {}) const;

  const std::filesystem::path& origin() const;  // the file that was loaded

 private:
  struct Impl;
  explicit OnnxNetwork(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace likeness
