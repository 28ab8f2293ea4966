// Claims about judging a track by what somebody saw in the pictures.
#include "core/lab/truth/face_marks.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/files.h"
#include "tests/core/lab/truth/acted_track.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

// Ten frames, the mouth wide open in the even ones, the eyes shut in frames 4 and 8.
Track acted(const HeadModel& model) {
  Track track;
  track.person.identity = Eigen::VectorXf::Zero(model.identity_count());
  for (int i = 0; i < 10; ++i) {
    TrackedFrame frame;
    frame.frame = i;
    frame.pose.articulation = neutral_articulation(model);
    if (i % 2 == 0) add_action(frame.pose.articulation, *find_action(model, "jawOpen"), 0.5f);
    if (i == 4 || i == 8)
      for (const char* name : {"eyeBlink_L", "eyeBlink_R"})
        add_action(frame.pose.articulation, *find_action(model, name), 1.0f);
    track.frames.push_back(frame);
  }
  return track;
}

TEST(FaceMarks, AgreeWithATrackThatShowsTheSameAndNameTheFramesThatDoNot) {
  const HeadModel& model = acting_head();
  const Track track = acted(model);
  std::vector<FaceMark> marks;
  for (int i = 0; i < 10; ++i)
    marks.push_back({i, i % 2 == 0 ? Marked::yes : Marked::no, i == 4 || i == 8 ? Marked::yes : Marked::no});
  marks.push_back({77, Marked::yes, Marked::yes});  // not in the track
  const MarkScore right = score_marks(track, model, marks);
  EXPECT_EQ(right.mouths, 10);
  EXPECT_EQ(right.eyes, 10);
  EXPECT_TRUE(right.wrong_mouths.empty());
  EXPECT_TRUE(right.wrong_eyes.empty());

  marks[3].mouth_open = Marked::yes;
  marks[5].mouth_open = Marked::unsure;
  marks[8].eyes_shut = Marked::no;
  const MarkScore wrong = score_marks(track, model, marks);
  EXPECT_EQ(wrong.mouths, 9);
  EXPECT_EQ(wrong.wrong_mouths, std::vector<int>{3});
  EXPECT_EQ(wrong.wrong_eyes, std::vector<int>{8});
}

TEST(FaceMarks, ALostFrameIsWrong) {
  const HeadModel& model = acting_head();
  Track track = acted(model);
  track.frames[2].status = FrameStatus::lost;
  const MarkScore score = score_marks(track, model, {{2, Marked::yes, Marked::no}});
  EXPECT_EQ(score.wrong_mouths, std::vector<int>{2});
  EXPECT_EQ(score.wrong_eyes, std::vector<int>{2});
}

TEST(FaceMarks, OnlyFramesThatTheTrackCallsGoodCanBeMisplaced) {
  const HeadModel& model = acting_head();
  Track track = acted(model);
  track.frames[3].status = FrameStatus::weak;
  std::vector<FaceMark> marks;
  for (int i = 0; i < 10; ++i)
    marks.push_back({i, Marked::unsure, Marked::unsure, i == 3 || i == 6 ? Marked::yes : Marked::no});
  marks[7].misplaced = Marked::unsure;
  const MarkScore score = score_marks(track, model, marks);
  EXPECT_EQ(score.placed, 8);
  EXPECT_EQ(score.misplaced, std::vector<int>{6});
}

TEST(FaceMarks, AreReadFromLettersAndRefusedByName) {
  const fs::path path = fs::temp_directory_path() / "likeness_face_marks.json";
  ASSERT_TRUE(write_text(path, R"({"version":1,"frames":[3,9,12],"mouth":"o?c","eyes":"os?"})"));
  const auto marks = read_face_marks(path);
  ASSERT_TRUE(marks) << marks.error().what;
  ASSERT_EQ(marks->size(), 3u);
  EXPECT_EQ((*marks)[1].frame, 9);
  EXPECT_EQ((*marks)[0].mouth_open, Marked::yes);
  EXPECT_EQ((*marks)[1].mouth_open, Marked::unsure);
  EXPECT_EQ((*marks)[2].mouth_open, Marked::no);
  EXPECT_EQ((*marks)[1].eyes_shut, Marked::yes);
  EXPECT_EQ((*marks)[0].misplaced, Marked::unsure);
  ASSERT_TRUE(
      write_text(path, R"({"version":1,"frames":[3,9,12],"mouth":"o?c","eyes":"os?","placed":"rw?"})"));
  const auto placed = read_face_marks(path);
  ASSERT_TRUE(placed) << placed.error().what;
  EXPECT_EQ((*placed)[0].misplaced, Marked::no);
  EXPECT_EQ((*placed)[1].misplaced, Marked::yes);
  EXPECT_EQ((*placed)[2].misplaced, Marked::unsure);
  for (const char* bad : {R"({"version":1,"frames":[3],"mouth":"o","eyes":"o","placed":"rr"})",
                          R"({"version":1,"frames":[3],"mouth":"oo","eyes":"o"})",
                          R"({"version":1,"frames":[3],"mouth":"x","eyes":"o"})",
                          R"({"version":2,"frames":[3],"mouth":"o","eyes":"o"})", R"({"version":1})", "["}) {
    ASSERT_TRUE(write_text(path, bad));
    EXPECT_FALSE(read_face_marks(path)) << bad;
  }
  fs::remove(path);
}

}  // namespace
}  // namespace likeness
