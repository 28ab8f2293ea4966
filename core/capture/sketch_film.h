// A film in small: of every frame a sketch, and how it moved since the frame before. What cuts are found by
// (find_cuts.h), and which shots show one place (choose_shots.h).
#pragma once

#include <optional>
#include <vector>

#include "core/capture/picture_cells.h"
#include "core/face/landmarks.h"
#include "core/image/image.h"

namespace likeness {

struct VideoInfo;
struct VideoFrame;

inline constexpr int kSketchCell = 8;  // px, of the sketch

struct FrameSketch {
  int frame = 0;
  double time_s = 0;
  Image8 luma;  // the whole picture, its longer side 96 px and both in whole cells; 5 kB
  // Since the frame before, whatever the camera shook; empty for the first one. px of the sketch.
  CellChange whole{};
  // The same of head and hair, in px of a picture of them of 48 px; empty where no face is known yet.
  CellChange head{};
  std::optional<FaceBox> face{};  // where it was last found, px of the sketch
  int shape = 0;                  // of the picture (core/video/decode.h)
};

// Where a person whose face is known may be: head and hair with all below them, shoulders with all below
// them. Shares of the picture's width and height.
struct PersonFigure {
  struct Column {
    double left = 0, right = 0, top = 0;
    bool holds(double x, double y) const { return x > left && x < right && y > top; }
  };
  Column head, body;
  bool holds(double x, double y) const { return head.holds(x, y) || body.holds(x, y); }
};
PersonFigure person_figure(const FaceBox& face, int width, int height);  // source px

// Fed by another's decoding: of every frame, luma, in order.
class FilmSketcher {
 public:
  explicit FilmSketcher(const VideoInfo& info);
  // face: where the main person's was last found, source px.
  void add(const VideoFrame& frame, const std::optional<FaceBox>& face);
  std::vector<FrameSketch> take();  // once all have been seen

 private:
  int width_ = 0, height_ = 0;  // px of the sketches
  Image8 before_;               // the frame before, at its own size
  std::vector<FrameSketch> sketches_;
};

}  // namespace likeness
