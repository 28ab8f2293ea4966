// A perceptual distance between pictures by a network that others trained, such as LPIPS (Zhang et al.
// 2018): an ONNX file. None is part of this program.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness {

// The network takes two pictures (1, 3, h, w), RGB in [-1, 1], by the names below, and gives a distance or a
// map of distances, whose mean is taken; one that was exported at a fixed size says it. Read from FILE.json
// beside FILE.onnx where there is one: {"inputs":["in0","in1"],"size_px":0}.
struct PerceptualFormat {
  std::string inputs[2] = {"in0", "in1"};
  int size_px = 0;  // side of the pictures it is given; 0: as they are
};

class PerceptualNetwork {
 public:
  // Reads the file and tries it: a picture has to be nearer to itself than to another.
  static Result<PerceptualNetwork> load(const std::filesystem::path& onnx);
  ~PerceptualNetwork();
  PerceptualNetwork(PerceptualNetwork&&) noexcept;
  PerceptualNetwork& operator=(PerceptualNetwork&&) noexcept;

  // 0 for equal pictures. (h, w, 3) of one size. May be called by several threads; they take turns.
  Result<double> distance(const Image8& a, const Image8& b) const;

 private:
  struct Impl;
  explicit PerceptualNetwork(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace likeness
