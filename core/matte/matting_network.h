// A third-party matting or parsing network, as an ONNX file.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness {

// The format of a network's input and the meaning of its output. Read from FILE.json beside FILE.onnx if it
// exists: {"size_px":512,"mean":[127.5,127.5,127.5],"scale":0.00784,"output":"","activation":"none",
// "person_channels":[0]}, all of them optional.
struct MattingNetworkFormat {
  int size_px = 512;  // side of the square picture it is given, RGB, one picture a batch
  std::array<double, 3> mean{127.5, 127.5, 127.5};  // subtracted from the 8-bit channels,
  double scale = 1 / 127.5;                         // then multiplied by this
  std::string output;                               // name of the output; empty: the last
  std::string activation = "none";                  // none, sigmoid, or softmax over the channels
  std::vector<int> person_channels{0};              // their sum is the share of person
};

class MattingNetwork {
 public:
  // Reads the file and tries it on a picture: a network whose output is not a map is refused here.
  static Result<MattingNetwork> load(const std::filesystem::path& onnx);
  ~MattingNetwork();
  MattingNetwork(MattingNetwork&&) noexcept;
  MattingNetwork& operator=(MattingNetwork&&) noexcept;

  // Alpha of the person, 0..255, at the picture's size. May be called by several threads; they take turns.
  Result<Image8> alpha(const Image8& rgb) const;

 private:
  struct Impl;
  explicit MattingNetwork(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// One hash of the network and its format.
std::string matting_network_hash(const std::filesystem::path& onnx);

}  // namespace likeness
