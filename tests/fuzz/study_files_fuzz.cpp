// Damaged files of what a study reads: published cameras, marks of landmarks seen by a person, pictures of
// regions, rows that an earlier run finished. A track's or a camera path's truth has the format of track.json
// or cameras.json.
#include <gtest/gtest.h>

#include "core/image/files.h"
#include "core/lab/score/held_out.h"
#include "core/lab/study/finished_rows.h"
#include "core/lab/truth/camera_truth.h"
#include "core/lab/truth/face_marks.h"
#include "core/lab/truth/person_marks.h"
#include "tests/fuzz/fuzz.h"

namespace likeness {
namespace {

TEST(FuzzStudyFiles, PublishedCameras) {
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

TEST(FuzzStudyFiles, FaceMarks) {
  const ScratchFolder scratch;
  FuzzTarget target;
  target.name = "marks";
  target.seeds = {R"({"version": 1, "frames": [4, 9, 120], "mouth": "co?", "eyes": "os?"})"};
  target.read = [&](std::span<const std::byte> bytes) {
    return read_face_marks(scratch.put("marks.json", bytes)).ok();
  };
  fuzz(target);
}

TEST(FuzzStudyFiles, PersonMarks) {
  const ScratchFolder scratch;
  FuzzTarget target;
  target.name = "person marks";
  target.seeds = {
      R"({"version": 1, "clip": "a.mp4", "video_hash": "0f", "size": [64, 48], "frames": [{"frame": 3,)"
      R"( "person": [[[4,48],[9.5,2],[40,48]]], "holes": [[[8,9],[9,9],[9,10]]],)"
      R"( "head": [[[6,20],[9.5,2],[20,20]]], "unsure": [[[1,1],[2,1],[1,2]]]}]})"};
  target.read = [&](std::span<const std::byte> bytes) {
    return read_person_marks(scratch.put("marks.json", bytes)).ok();
  };
  fuzz(target);
}

TEST(FuzzStudyFiles, Regions) {
  const ScratchFolder scratch;
  Image8 picture(24, 16, 3);
  for (std::size_t i = 0; i < picture.data.size(); ++i) picture.data[i] = i % 5 < 2 ? 255 : 0;
  ASSERT_TRUE(write_image(scratch.path() / "000007.png", picture));
  Capture capture;
  capture.width = 24, capture.height = 16, capture.size = 8;
  capture.crop = {4, 2, 12};
  FuzzTarget target;
  target.name = "regions";
  target.seeds = {scratch.get("000007.png")};
  target.memory_floor = std::size_t(512) << 20;  // as of any picture
  target.memory_times = 8000;
  target.max_kept = std::size_t(1) << 20;
  target.read = [&](std::span<const std::byte> bytes) {
    scratch.put("000007.png", bytes);
    return read_regions(scratch.path(), capture, 7).ok();
  };
  fuzz(target);
}

TEST(FuzzStudyFiles, FinishedRows) {
  const ScratchFolder scratch;
  ASSERT_TRUE(write_finished(scratch.path() / "row.json", "print", {{"psnr_db", 31.5}, {"seed", 3}}));
  FuzzTarget target;
  target.name = "row of a study";
  target.seeds = {scratch.get("row.json")};
  target.read = [&](std::span<const std::byte> bytes) {
    return read_finished(scratch.put("row.json", bytes), "print").has_value();
  };
  fuzz(target);
}

}  // namespace
}  // namespace likeness
