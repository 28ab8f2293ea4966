// What of a clip's picture was filmed: the rest are bars, by which an editor fitted it into another shape.
#pragma once

#include <filesystem>
#include <memory>
#include <stop_token>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/image/pixel_rect.h"
#include "core/video/decode.h"

namespace likeness {

// Bars have one colour, the same at all times and all along them, but for subtitles that lie in them; or they
// are a blurred copy of the film, as wide on either side. They end in a straight edge that stays where it is
// through the whole clip, to the pixel: by that they differ from a dark scene and from a plain wall.
class FilmFinder {
 public:
  explicit FilmFinder(const VideoInfo& info);
  ~FilmFinder();
  FilmFinder(FilmFinder&&) noexcept;
  FilmFinder& operator=(FilmFinder&&) noexcept;

  // Every frame, of luma or RGB; about five a second are looked at.
  void add(const VideoFrame& frame);
  // Source px, whole pixels that show nothing of a bar. Empty: there are none. Bars on two sides only are
  // found, where there are more; the rest where it is looked for within these.
  PixelRect film() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// By a decoding of its own. The whole picture of a folder of photographs.
Result<PixelRect> find_film(const std::filesystem::path& video, const Progress& progress,
                            std::stop_token stop);

}  // namespace likeness
