// Small grey pictures of a clip's frames in one file, uncompressed, for stages that would otherwise decode
// the clip again. Written one after the other, read in the same order.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/image/image.h"

namespace likeness {

// What the file says of itself before the pictures.
struct GreyPictures {
  std::string inputs;         // what the pictures were made from; for the reader to compare
  int width = 0, height = 0;  // px
  std::vector<int> frames;    // numbers in the source, in the order of the pictures
};

class GreyPictureWriter {
 public:
  static Result<GreyPictureWriter> create(const std::filesystem::path& path, const GreyPictures& about);
  ~GreyPictureWriter();
  GreyPictureWriter(GreyPictureWriter&&) noexcept;
  GreyPictureWriter& operator=(GreyPictureWriter&&) noexcept;

  // (height, width, 1)
  Result<void> add(const Image8& picture);
  // Puts everything on the disk; an Error where pictures are missing.
  Result<void> finish();

 private:
  struct State;
  explicit GreyPictureWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

class GreyPictureReader {
 public:
  // Refuses a file that is not whole.
  static Result<GreyPictureReader> open(const std::filesystem::path& path);
  ~GreyPictureReader();
  GreyPictureReader(GreyPictureReader&&) noexcept;
  GreyPictureReader& operator=(GreyPictureReader&&) noexcept;

  const GreyPictures& about() const;
  // The picture of about().frames[0], [1], ...; an Error after the last one.
  Result<Image8> next();

 private:
  struct State;
  explicit GreyPictureReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace likeness
