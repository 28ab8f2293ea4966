// The capture: what was decoded from a clip, which frames train, which are held out, and the square crop.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/clip_seconds.h"
#include "core/base/frame_span.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/capture/split.h"
#include "core/image/pixel_rect.h"

namespace likeness {

// From where a frame sees the head, degrees off the clip's typical side of it: the camera stands this far
// towards the subject's left, and above.
struct HeadView {
  double yaw_deg = 0, pitch_deg = 0;
};
double angle_deg(const HeadView& view);  // off the typical side, >= 0

struct CaptureFrame {
  int frame = 0;  // number in the source video
  double time_s = 0;
  double sharpness = 0;   // variance of the Laplacian inside the face box
  bool held_out = false;  // never filtered
  bool used = false;      // trains; false for held-out and refused frames
  std::string refused;    // why it does not train; empty when it does or is held out
  // Refused by the split: it is not scored either, and nothing that frames share is learnt from it.
  bool apart = false;
  std::optional<HeadView> view{};  // of Split::sides; nullopt where the landmarks do not tell it
};

// A stretch of the clip between two cuts, frames first..last.
struct ClipShot {
  int first = 0, last = 0;
  double from_s = 0, to_s = 0;  // to_s: when its last frame ends
  bool used = true;             // of the place from which the person is seen longest
  std::string reason{};         // why it is not used
};

// Square in source pixels. It reaches beyond what was filmed only where the heads do not fit into a square
// that stays within it (core/capture/choose_crop.h).
struct SquareCrop {
  int x = 0, y = 0, side = 0;
};

// Of all channels in the pictures of frames/, beyond what was filmed.
inline constexpr std::uint8_t kUnfilmed = 128;

struct Capture {
  std::filesystem::path video;
  std::string video_hash;
  int width = 0, height = 0;  // px of the source, rotation applied
  double frames_per_second = 0;
  // What was filmed, px of the source: without the bars that an editor added (core/capture/find_film.h);
  // empty: all of it.
  PixelRect film;
  SquareCrop crop;
  int size = 256;  // px of the pictures in frames/
  // The part of those pictures that was filmed, in their pixels; empty: all of them. Nothing is known of the
  // rest: it is not learnt from, not scored and not shown.
  PixelRect inside;
  Split split = Split::tail;
  SideRange sides{};      // of Split::sides
  ClipSeconds seconds{};  // of the video that were read: nothing else of it is looked at
  std::vector<std::string> warnings;
  std::vector<CaptureFrame> frames;  // every frame read (core/video/decode.h: sampled), ascending
  // In order, at least one where there are frames. Frames between two belong to a dissolve or fade.
  std::vector<ClipShot> shots{};
};

// Of a frame that was read; of another what the mean rate makes of its number.
double time_of_frame(const Capture& capture, int frame);
// Those that measure.
std::set<int> held_out_frames(const Capture& capture);
// Those and the ones kept apart: what stages must not learn from for other frames.
std::set<int> silent_frames(const Capture& capture);
// The first and the last frame read, where only some seconds were; nullopt: the whole clip.
std::optional<FrameSpan> frames_of_seconds(const Capture& capture);
// The spans of the used shots; empty where the clip is one shot from its first frame to its last, and was
// read as a whole.
std::vector<FrameSpan> spans_where_cut(const Capture& capture);
// The same for who does not mind a cut in place: shots that follow each other are one.
std::vector<FrameSpan> stretches_that_serve(const Capture& capture);

// The part of the source within which the person is tracked.
PixelRect tracked_part(const Capture& capture);

// The whole pixels of the crop, at size x size px, that show the film (source px); empty: all of them do.
PixelRect filmed_part(const SquareCrop& crop, const PixelRect& film, int size);

Result<void> write_capture(const std::filesystem::path& path, const Capture& capture);
Result<Capture> read_capture(const std::filesystem::path& path);

// frames/000123.png
std::filesystem::path frame_name(int frame);
// frames/000123.alpha.png: one channel, the mask that the source itself brings; only of pictures that have
// one.
std::filesystem::path alpha_name(int frame);

class KeptWork;  // core/base/kept_work.h

struct ImportOptions {
  int size = 256;         // 256, 512 or 1024 px
  int max_frames = 2000;  // training frames kept; more cost memory and time
  Split split = Split::tail;
  SideRange sides{};                // of Split::sides
  double held_out_share = 0.1;      // of the frames, of the moving or of the near ones; not of random30
  std::optional<FrameSpan> moving;  // the frames that a moving camera filmed; needed for Split::views
  double blur_ratio = 0.5;          // a frame is refused below this share of its neighbours' median sharpness
  std::filesystem::path landmark_model;  // as landmark_source takes it
  ClipSeconds seconds{};                 // of the video that are read; whole: of photographs
  // Bytes that decoded frames may take between the two looks at the clip; where they would take more, it is
  // decoded a second time. nullopt: a third of what is free.
  std::optional<std::uint64_t> memory{};
  // Where the faces found are kept until the import is done, for it to go on if it is killed; null: nowhere.
  std::shared_ptr<KeptWork> kept_faces{};
};

struct ImportListeners;  // core/capture/import_listeners.h

// Decodes the clip, finds the face, chooses frames and crop and writes frames/NNNNNN.png (training and
// held-out, cropped, area-filtered to `size`) under `folder`. Refuses clips with no face, two people, or too
// few frames, and for Split::sides those whose head does not turn far enough.
Result<Capture> import_clip(const std::filesystem::path& video, const std::filesystem::path& folder,
                            const ImportOptions& options, const Progress& progress, std::stop_token stop);
// The same, and others look at the frames that import decodes.
Result<Capture> import_clip(const std::filesystem::path& video, const std::filesystem::path& folder,
                            const ImportOptions& options, const ImportListeners& listeners,
                            const Progress& progress, std::stop_token stop);

}  // namespace likeness
