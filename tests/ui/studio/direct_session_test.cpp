// Claims about the studio's Direct step, without a window: what is directed has its file and its picture.
#include "ui/studio/direct_session.h"

#include <gtest/gtest.h>

#include "core/base/files.h"
#include "tests/ui/studio/session_home.h"

namespace likeness::ui {
namespace {

namespace fs = std::filesystem;

class DirectSessionTest : public testing::Test {
 protected:
  void SetUp() override { home_.open_project(); }
  bool until(const std::function<bool()>& so) {
    return home_.until([this] { session_.tick(); }, so);
  }
  fs::path file() const { return home_.project.folder() / "performance.json"; }
  static Performance turned(float yaw_deg) {
    Performance performance;
    performance.channels["head yaw"] = {{0, yaw_deg}};
    return performance;
  }
  void edit(Performance performance) {
    DirectRequests requests;
    requests.edit(std::move(performance), "turn");
    requests.finished = true;
    session_.apply(requests);
  }

  test::SessionHome home_;
  DirectSession session_{home_.context};
};

TEST_F(DirectSessionTest, APictureFollowsWhatIsDirected) {
  session_.open();
  session_.request_picture();
  ASSERT_TRUE(until([this] { return session_.view().picture != nullptr; }));
  const std::uint64_t before = session_.view().moment;
  edit(turned(20));
  EXPECT_GT(session_.view().moment, before);
  ASSERT_TRUE(until([this] { return session_.view().picture->origin.moment == session_.view().moment; }));
}

TEST_F(DirectSessionTest, APerformanceIsWrittenBeforeItsProjectCloses) {
  session_.open();
  edit(turned(20));
  session_.close();
  home_.open = {};
  const auto kept = read_performance(file());
  ASSERT_TRUE(kept.ok());
  EXPECT_EQ(*kept, turned(20));
  EXPECT_TRUE(session_.directing().performance()->channels.empty());
  EXPECT_EQ(session_.view().picture, nullptr);
  // Opened again it is as it was left.
  home_.open_project();
  session_.open();
  ASSERT_TRUE(until([this] { return *session_.directing().performance() == turned(20); }));
  EXPECT_TRUE(session_.view().directing.undo_name.empty());
}

TEST_F(DirectSessionTest, NothingIsSavedOfAProjectThatIsOnlyLookedAt) {
  home_.open.look_only = true;
  session_.open();
  edit(turned(20));
  session_.save_all();
  session_.close();
  EXPECT_FALSE(fs::exists(file()));
  ASSERT_TRUE(write_text(file(), "{ no performance").ok());
  session_.open();
  ASSERT_TRUE(until([this] { return home_.notices.error.has_value(); }));
  EXPECT_TRUE(fs::exists(file())) << "the other window may be writing it";
}

TEST_F(DirectSessionTest, APerformanceThatCannotBeReadIsPutAside) {
  ASSERT_TRUE(write_text(file(), "{ no performance").ok());
  session_.open();
  ASSERT_TRUE(until([this] { return home_.notices.error.has_value(); }));
  EXPECT_NE(home_.notices.error->fix.find("performance-unread.json"), std::string::npos);
  EXPECT_FALSE(fs::exists(file()));
  EXPECT_EQ(*read_text(home_.project.folder() / "performance-unread.json"), "{ no performance");
}

TEST_F(DirectSessionTest, AFileOfSomethingElseIsNotWrittenOver) {
  const fs::path other = home_.project.root / "letter.json";
  ASSERT_TRUE(write_text(other, "a letter").ok());
  DirectRequests requests;
  requests.save_performance = other;
  session_.apply(requests);
  EXPECT_TRUE(home_.notices.error.has_value());
  EXPECT_EQ(*read_text(other), "a letter");
  requests.save_performance = home_.project.root / "new.json";
  session_.apply(requests);
  EXPECT_TRUE(read_performance(home_.project.root / "new.json").ok());
}

TEST_F(DirectSessionTest, EachRandomWalkIsAnotherAndCanBeTakenBack) {
  session_.random_walk();
  const Performance first = *session_.directing().performance();
  session_.directing().undo();
  EXPECT_TRUE(session_.directing().performance()->channels.empty());
  session_.random_walk();
  EXPECT_FALSE(session_.directing().performance()->channels.empty());
  EXPECT_FALSE(*session_.directing().performance() == first);
}

TEST_F(DirectSessionTest, OnePartIsSetToRestAndTheOthersStay) {
  Performance posed = turned(20);
  posed.channels["jawOpen"] = {{0, 0.4f}};
  edit(posed);
  session_.rest(ChannelPart::face);
  const Performance& now = *session_.directing().performance();
  EXPECT_EQ(now.channels.at("head yaw"), posed.channels.at("head yaw"));
  EXPECT_FALSE(now == posed);
}

TEST_F(DirectSessionTest, NothingIsDrivenWithoutAnAvatar) {
  home_.open = {};
  session_.drive([]() -> Result<std::unique_ptr<FrameSource>> {
    ADD_FAILURE() << "a source was opened";
    return Error{};
  });
  EXPECT_FALSE(session_.is_driven());
  EXPECT_EQ(session_.take_driver(), nullptr);
}

}  // namespace
}  // namespace likeness::ui
