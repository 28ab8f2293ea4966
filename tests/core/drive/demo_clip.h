// A few seconds of the demo person, written once, and the built-in head as the driven avatar.
#pragma once

#include <stdlib.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "core/drive/drive.h"
#include "core/head/builtin_head.h"
#include "core/synth/demo_capture.h"
#include "core/video/decode.h"
#include "core/video/encode.h"
#include "core/video/frame_source.h"

namespace likeness::test {

inline const HeadModel& driven_head() {
  static const HeadModel model = make_builtin_head();
  return model;
}

inline DriveSubject driven_subject() {
  const HeadModel& model = driven_head();
  DriveSubject subject{
      &model, {Eigen::VectorXf::Zero(model.identity_count()), {}}, neutral_articulation(model), {}};
  subject.world_from_head.translate(Vec3d(0, 0, 0.8));
  subject.world_from_torso = subject.world_from_head;
  return subject;
}

// Its folder: demo.mp4 with its truth. Removed when the program ends.
inline const std::filesystem::path& demo_folder() {
  struct Folder {
    std::filesystem::path path;
    Folder() {
      std::string name = (std::filesystem::temp_directory_path() / "likeness_live_XXXXXX").string();
      if (::mkdtemp(name.data()) == nullptr) std::abort();
      path = name;
      const DemoOptions options{
          .width = 320, .height = 320, .frames = 75, .moving_share = 0, .samples_per_pixel = 1};
      if (!write_demo_capture(path, options, Progress(), {}).ok()) std::abort();
    }
    ~Folder() { std::filesystem::remove_all(path); }
  };
  static const Folder folder;
  return folder.path;
}

inline const std::vector<VideoFrame>& demo_frames() {
  static const std::vector<VideoFrame> frames = [] {
    std::vector<VideoFrame> all;
    auto reader = VideoReader::open(demo_folder() / "demo.mp4");
    while (reader) {
      auto next = reader->next();
      if (!next || !*next) break;
      all.push_back(std::move(**next));
    }
    return all;
  }();
  return frames;
}

// The same forth and back, so long that even a busy computer learns the rest and then drives: live driving
// drops what it is too slow for.
inline const std::filesystem::path& long_clip() {
  static const std::filesystem::path path = [] {
    constexpr int kTurns = 12;
    const std::vector<VideoFrame>& frames = demo_frames();
    const Image8& first = frames.front().rgb;
    auto writer = VideoWriter::create(demo_folder() / "long.mp4", first.width, first.height);
    if (!writer) std::abort();
    for (int turn = 0; turn < kTurns; ++turn)
      for (std::size_t i = 0; i < frames.size(); ++i)
        if (!writer->add(frames[turn % 2 ? frames.size() - 1 - i : i].rgb).ok()) std::abort();
    if (!writer->finish().ok()) std::abort();
    return demo_folder() / "long.mp4";
  }();
  return path;
}

}  // namespace likeness::test
