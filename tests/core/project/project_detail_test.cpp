// Claims about a project's detail maps: only training frames teach, what was learnt comes back from the file,
// a project without maps is as it was, and what is missing or damaged is told.
#include "core/project/project_detail.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <random>

#include "core/base/files.h"
#include "core/base/npz.h"
#include "core/head/builtin_head.h"
#include "core/project/staleness.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 40, kFirstHeldOut = 32, kSide = 32;

class ProjectDetailTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_detail_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    auto made = open_or_create_project(root_ / "p", {.shared = {.video = root_ / "gone.mp4"}});
    ASSERT_TRUE(made.ok());
    project_ = *made;
    for (int i = 0; i < kFrames; ++i) {
      CaptureFrame& frame = capture_.frames.emplace_back();
      frame.frame = 2 * i;  // a clip of which every other frame was read
      frame.held_out = i >= kFirstHeldOut, frame.used = !frame.held_out;
      TrackedFrame& tracked = track_.frames.emplace_back();
      tracked.frame = 2 * i;
      tracked.pose.articulation = neutral_articulation(model_);
      tracked.pose.articulation.expression[2] = float(0.5 + 0.5 * std::sin(0.4 * i));
    }
  }
  void TearDown() override { fs::remove_all(root_); }

  // mm: the expression times a hill, and `more` everywhere.
  void put_map(int frame, float expression, float more = 0) const {
    std::vector<float> map;
    for (int i = 0; i < kSide * kSide; ++i)
      map.push_back(more + 2 * expression * std::sin(0.2f * float(i % kSide)));
    std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (32, 32), }";
    while ((header.size() + 11) % 64 != 0) header += ' ';
    header += '\n';
    std::string bytes("\x93NUMPY\x01\x00", 8);
    bytes += char(header.size() & 255), bytes += char(header.size() >> 8);
    bytes += header;
    bytes.append(reinterpret_cast<const char*>(map.data()), map.size() * sizeof(float));
    ASSERT_TRUE(write_text(root_ / "maps" / (std::to_string(frame) + ".npy"), bytes).ok());
  }
  void put_maps(int first, int last) const {
    for (int i = first; i < last; ++i)
      put_map(2 * i, track_.frames[std::size_t(i)].pose.articulation.expression[2]);
  }
  Result<ProjectDetail> learn() {
    report_ = {};
    return learn_project_detail(root_ / "maps", capture_, track_, model_, report_);
  }

  const HeadModel model_ = make_builtin_head();
  fs::path root_;
  Project project_;
  Capture capture_;
  Track track_;
  DetailReport report_;
};

TEST_F(ProjectDetailTest, WhatWasLearntComesBack) {
  put_maps(0, 25);  // the others have none
  auto learnt = learn();
  ASSERT_TRUE(learnt.ok()) << learnt.error().what;
  EXPECT_EQ(learnt->detail.components(), 1);
  EXPECT_EQ(learnt->scores.size(), 25u);
  EXPECT_NE(report_.message.find("25 of 32 training frames"), std::string::npos) << report_.message;
  EXPECT_TRUE(report_.warnings.empty());
  learnt->track_inputs = "0123abcd";
  EXPECT_FALSE(read_project_detail(project_, model_)->has_value());
  ASSERT_TRUE(write_project_detail(project_, *learnt).ok());
  const auto read = read_project_detail(project_, model_);
  ASSERT_TRUE(read.ok()) << read.error().what;
  ASSERT_TRUE(read->has_value());
  EXPECT_EQ((*read)->track_inputs, "0123abcd");
  EXPECT_EQ((*read)->detail.vertices, learnt->detail.vertices);
  EXPECT_EQ((*read)->detail.basis, learnt->detail.basis);
  EXPECT_EQ((*read)->detail.rows, learnt->detail.rows);
  EXPECT_EQ((*read)->scores.at(8), learnt->scores.at(8));

  TrainingSet set;
  for (const int frame : {8, 60}) set.views.emplace_back().camera.frame = frame;
  take_detail(**read, set);
  EXPECT_EQ(set.views[0].pose.detail, learnt->scores.at(8));
  EXPECT_EQ(set.views[1].pose.detail.size(), 0);  // what its expression tells
  ASSERT_TRUE(forget_project_detail(project_).ok());
  EXPECT_FALSE(read_project_detail(project_, model_)->has_value());
}

TEST_F(ProjectDetailTest, HeldOutFramesTeachNothing) {
  put_maps(0, kFirstHeldOut);
  const auto without = learn();
  for (int i = kFirstHeldOut; i < kFrames; ++i) put_map(2 * i, 0, 9);
  const auto with = learn();
  ASSERT_TRUE(without.ok() && with.ok());
  EXPECT_EQ(with->detail.mean, without->detail.mean);
  EXPECT_EQ(with->detail.basis, without->detail.basis);
  EXPECT_EQ(with->detail.rows, without->detail.rows);
  EXPECT_FALSE(with->scores.contains(2 * kFirstHeldOut));
}

TEST_F(ProjectDetailTest, MapsThatTellNothingAreWarnedOf) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> any(-1, 1);
  for (int i = 0; i < kFrames; ++i) put_map(2 * i, any(random));
  ASSERT_TRUE(learn().ok());
  ASSERT_EQ(report_.warnings.size(), 1u);
  EXPECT_NE(report_.warnings[0].find("hardly follow the expression"), std::string::npos);
}

TEST_F(ProjectDetailTest, TooFewMapsOfTrainingFramesAreReported) {
  put_maps(28, kFrames);
  for (int i = 0; i < 6; ++i) put_map(2 * i + 1, 0);  // of frames that nobody read
  const auto refused = learn();
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().what.find("Of the 18 maps"), std::string::npos) << refused.error().what;
  EXPECT_NE(refused.error().what.find("12 are of frames of this clip and 4 of tracked"), std::string::npos)
      << refused.error().what;
}

TEST_F(ProjectDetailTest, ADamagedFileIsReported) {
  put_maps(0, 20);
  const auto learnt = learn();
  ASSERT_TRUE(learnt.ok());
  ASSERT_TRUE(write_project_detail(project_, *learnt).ok());
  auto archive = read_npz(detail_path(project_));
  ASSERT_TRUE(archive.ok());
  archive->erase("rows");
  ASSERT_TRUE(write_npz(detail_path(project_), *archive).ok());
  const auto read = read_project_detail(project_, model_);
  ASSERT_FALSE(read.ok());
  EXPECT_NE(read.error().what.find("damaged"), std::string::npos);
}

TEST_F(ProjectDetailTest, MapsCountForTheFitOnlyWhereTheyAreGiven) {
  const std::string before = input_hash(project_, Stage::fit), train = input_hash(project_, Stage::train);
  put_maps(0, 12);
  EXPECT_EQ(input_hash(project_, Stage::fit), before);
  project_.options.fit.displacement = root_ / "maps";
  const std::string with = input_hash(project_, Stage::fit);
  EXPECT_NE(with, before);
  put_map(4, 0.9f);
  EXPECT_NE(input_hash(project_, Stage::fit), with);
  EXPECT_EQ(input_hash(project_, Stage::train), train);
  ASSERT_TRUE(write_project_detail(project_, *learn()).ok());
  EXPECT_NE(input_hash(project_, Stage::train), train);
  ASSERT_TRUE(save_project(project_).ok());
  EXPECT_EQ(open_project(project_.folder)->options.fit.displacement, root_ / "maps");
}

TEST_F(ProjectDetailTest, AProjectFromBeforeThemOpens) {
  std::string json = *read_text(project_.folder / "project.json");
  const std::size_t at = json.find("\"displacement\": \"\",");
  ASSERT_NE(at, std::string::npos);
  json.erase(at, std::string("\"displacement\": \"\",").size());
  ASSERT_TRUE(write_text(project_.folder / "project.json", json).ok());
  const auto opened = open_project(project_.folder);
  ASSERT_TRUE(opened.ok()) << opened.error().what;
  EXPECT_TRUE(opened->options.fit.displacement.empty());
}

}  // namespace
}  // namespace likeness
