// Damaged files of what a study compares with: published cameras. A track's or a camera path's truth has the
// format of track.json or cameras.json.
#include <gtest/gtest.h>

#include "core/image/files.h"
#include "core/study/camera_truth.h"
#include "tests/fuzz/fuzz.h"

namespace likeness {
namespace {

TEST(Fuzz, PublishedCameras) {
  const ScratchFolder scratch;
  std::filesystem::create_directories(scratch.path() / "images");
  std::string frames;
  for (const char* name : {"a", "b", "c"}) {
    ASSERT_TRUE(write_image(scratch.path() / "images" / (std::string(name) + ".png"), Image8(4, 4, 3)));
    frames += std::string(frames.empty() ? "" : ",") + R"({"file_path": "./images/)" + name +
              R"(.png", "transform_matrix": [[1,0,0,0.5],[0,1,0,2],[0,0,1,3],[0,0,0,1]]})";
  }
  FuzzTarget target;
  target.name = "transforms.json";
  target.seeds = {R"({"fl_x": 700.5, "fl_y": 701, "frames": [)" + frames + "]}"};
  target.read = [&](std::span<const std::byte> bytes) {
    scratch.put("transforms.json", bytes);
    return read_camera_truth(scratch.path()).ok();
  };
  fuzz(target);
}

}  // namespace
}  // namespace likeness
