// Claims about the studio's comparison with other methods, without a window or a training.
#include "ui/studio/study_session.h"

#include <gtest/gtest.h>

#include "tests/ui/studio/session_home.h"

namespace likeness::ui {
namespace {

class StudySessionTest : public testing::Test {
 protected:
  bool until(const std::function<bool()>& so) {
    return home_.until([this] { session_.tick(); }, so);
  }

  test::SessionHome home_;
  StudySession session_{home_.context};
};

TEST_F(StudySessionTest, ThePageNeedsAProject) {
  home_.shown.step = Step::film;
  session_.open_page();
  EXPECT_FALSE(session_.view().open);
  EXPECT_EQ(home_.shown.step, Step::film);
  home_.open_project();
  session_.open_page();
  EXPECT_TRUE(session_.view().open);
  EXPECT_EQ(home_.shown.step, Step::train);
  EXPECT_FALSE(home_.shown.follow) << "a stage at work would take the page away";
  session_.apply({.close = true});
  EXPECT_FALSE(session_.view().open);
}

// The tiny project has an avatar but no track: nothing that another method could learn from.
TEST_F(StudySessionTest, WhatIsMissingIsSaid) {
  EXPECT_TRUE(session_.view().missing.empty());
  home_.open_project();
  EXPECT_NE(session_.view().missing.find("Make the avatar first"), std::string::npos);
  auto old = std::make_shared<ProjectContents>(*home_.open.contents);
  old->stale[std::size_t(Stage::fit)] = true;
  home_.open.contents = old;
  EXPECT_NE(session_.view().missing.find("again first"), std::string::npos) << session_.view().missing;
  auto made = std::make_shared<ProjectContents>(*home_.open.contents);
  made->stale = {};
  made->current.fill(true);
  home_.open.contents = made;
  EXPECT_TRUE(session_.view().missing.empty());
}

TEST_F(StudySessionTest, AForecastIsOfTheChoiceThereIs) {
  home_.open_project();
  session_.open_page();
  ASSERT_TRUE(until([this] { return session_.view().forecast.has_value(); }));
  const double once = session_.view().forecast->seconds;
  session_.apply({.choice = StudyChoice{.tables = {"models"}, .seconds = 90, .seeds = 3}});
  EXPECT_FALSE(session_.view().forecast.has_value()) << "that of another choice is shown";
  ASSERT_TRUE(until([this] { return session_.view().forecast.has_value(); }));
  // Some of the models are trained once, whatever the seeds.
  EXPECT_GT(session_.view().forecast->seconds, 1.5 * once);
  session_.apply({.choice = StudyChoice{.tables = {}}});
  for (int i = 0; i < 20; ++i) home_.background.deliver();
  EXPECT_FALSE(session_.view().forecast.has_value());
}

TEST_F(StudySessionTest, AFailedComparisonIsReportedWhereItsPageIsNotShown) {
  home_.open_project();
  session_.start(home_.open.contents->project);  // nothing of its stages is there
  ASSERT_TRUE(until([this] { return !session_.is_working(); }));
  session_.tick();
  EXPECT_EQ(session_.view().job.state, JobState::failed);
  EXPECT_TRUE(home_.notices.error.has_value());
  session_.forget();
  EXPECT_EQ(session_.view().job.state, JobState::none);
}

}  // namespace
}  // namespace likeness::ui
