// Claims about the studio's exports, without a window: what is asked for becomes files of a tiny project.
#include "ui/studio/export_session.h"

#include <gtest/gtest.h>

#include "core/base/files.h"
#include "core/image/files.h"
#include "tests/ui/studio/session_home.h"

namespace likeness::ui {
namespace {

namespace fs = std::filesystem;

class ExportSessionTest : public testing::Test {
 protected:
  void SetUp() override { home_.open_project(); }
  bool until_done() {
    return home_.until([this] { session_.tick(); }, [this] { return !session_.is_working(); });
  }
  static ExportMoment now() { return {std::make_shared<const Performance>(), 0, {}}; }

  test::SessionHome home_;
  ExportSession session_{home_.context};
};

TEST_F(ExportSessionTest, EachExportHasAFileOfItsOwn) {
  session_.start(ExportKind::mesh, now());
  session_.start(ExportKind::mesh, now());
  EXPECT_TRUE(session_.goes_on());
  ASSERT_TRUE(until_done());
  const ExportsView view = session_.view();
  ASSERT_EQ(view.items.size(), 2u);
  EXPECT_NE(view.items[0].out, view.items[1].out);
  for (const ExportItem& item : view.items) {
    EXPECT_EQ(item.status.state, JobState::done);
    EXPECT_TRUE(fs::exists(item.out)) << item.out;
  }
  EXPECT_EQ(view.written, view.items[1].out);
  EXPECT_EQ(view.choice.kind, ExportKind::mesh);
}

TEST_F(ExportSessionTest, AChoiceThatCannotBeMetIsAnErrorAtOnce) {
  session_.start(ExportKind::driven, now());  // no clip is chosen that would drive
  EXPECT_TRUE(session_.view().items.empty());
  ASSERT_TRUE(home_.notices.error.has_value());
  EXPECT_FALSE(home_.notices.error->fix.empty());
}

TEST_F(ExportSessionTest, AFailedExportIsTriedAgainOnlyWhereExportsArePossible) {
  const fs::path wall = home_.project.root / "wall.png";
  ASSERT_TRUE(write_image(wall, Image8(8, 8, 3, 90)).ok());
  session_.apply({.choice = ExportChoice{.ground = ExportGround::picture, .picture = wall}}, true);
  session_.start(ExportKind::still, now());
  ASSERT_TRUE(write_text(wall, "no picture").ok());
  ASSERT_TRUE(until_done());
  ASSERT_EQ(session_.view().items.front().status.state, JobState::failed);
  ASSERT_TRUE(write_image(wall, Image8(8, 8, 3, 90)).ok());
  const int number = session_.view().items.front().number;
  session_.apply({.retry = number}, false);
  EXPECT_FALSE(session_.is_working());
  EXPECT_TRUE(home_.notices.error.has_value());
  session_.apply({.retry = number}, true);
  ASSERT_TRUE(until_done());
  EXPECT_EQ(session_.view().items.front().status.state, JobState::done);
}

TEST_F(ExportSessionTest, AClosedProjectLeavesNoListAndKeepsItsFiles) {
  session_.start(ExportKind::mesh, now());
  ASSERT_TRUE(until_done());
  const fs::path written = session_.view().written;
  session_.close();
  EXPECT_TRUE(session_.view().items.empty());
  EXPECT_TRUE(fs::exists(written));
}

}  // namespace
}  // namespace likeness::ui
