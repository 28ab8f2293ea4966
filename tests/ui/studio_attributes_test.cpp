// A finished demo project in a real window: an attribute is named, painted, given its amounts, taken back,
// and becomes a slider by the one button.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/files.h"
#include "core/project/project_attributes.h"
#include "core/project/run_stages.h"
#include "core/synth/demo_capture.h"
#include "tests/ui/driven_studio.h"

namespace likeness::ui {
namespace {

namespace fs = std::filesystem;
using test::TestWindow;

class StudioAttributes : public test::DrivenStudio {
 protected:
  void SetUp() override {
    DrivenStudio::SetUp();
    const DemoOptions demo{
        .width = 320, .height = 320, .frames = 34, .moving_share = 0, .samples_per_pixel = 1, .habit = true};
    const auto filmed = write_demo_capture(folder_ / "demo", demo, Progress(), {});
    ASSERT_TRUE(filmed.ok()) << filmed.error().what;
    project_ = folder_ / "projects" / "demo.likeness";
    ProjectOptions options;
    options.shared.video = folder_ / "demo" / "demo.mp4";
    options.train.steps = 10;
    auto project = open_or_create_project(project_, options);
    ASSERT_TRUE(project.ok()) << project.error().what;
    project->consent = Consent::no_real_person;
    const auto run = run_stages(*project, Stage::train, Progress(), {}, {});
    ASSERT_TRUE(run.ok()) << run.error().what;
  }
  MasksView masks() const { return studio_->snapshot().masks; }
  PaintedAttributes on_disk() const {
    const auto project = open_project(project_);
    const auto read =
        project ? read_project_attributes(*project) : Result<PaintedAttributes>(project.error());
    return read ? *read : PaintedAttributes{};
  }
  bool saved(std::size_t annotations) {
    return until(30, [&](const Snapshot&) {
      const PaintedAttributes all = on_disk();
      return annotations == 0 ? all.empty() : !all.empty() && all[0].annotations.size() == annotations;
    });
  }
  void type(const std::string& words) {
    ImGui::GetIO().AddInputCharactersUTF8(words.c_str());
    frame();
    frame();
  }
  void go_to(int wanted) {
    for (int i = 0; i < 40 && masks().frame != wanted; ++i)
      click(masks().frame < wanted ? "Next picture" : "Previous picture");
    ASSERT_EQ(masks().frame, wanted);
    ASSERT_TRUE(until(30, [&](const Snapshot& s) {
      return s.masks.drawn.picture.image && s.masks.drawn.picture.frame == wanted;
    }));
  }
  fs::path project_;
};

TEST_F(StudioAttributes, IsPaintedTakenBackTrainedAndDirected) {
  start();
  TestWindow::get().window->drop({project_});
  ASSERT_TRUE(until(60, [](const Snapshot& s) { return s.project.contents && s.project.contents->avatar; }));
  click("step Cameras");
  click("Masks and background");
  ASSERT_TRUE(until(60, [](const Snapshot& s) { return s.masks.drawn.picture.image != nullptr; }));
  click("Paint an attribute");
  ASSERT_TRUE(masks().attributes.on);
  click("attribute name");
  type("cheek puff");
  click("New attribute");
  ASSERT_EQ(masks().attributes.name, "cheek puff");

  // -- Painted on one frame, with the mouse.
  go_to(9);
  test::drag("mask picture", 20, 6, 0, [this] { frame(); });
  ASSERT_EQ(masks().attributes.all->size(), 1u);
  const AttributeAnnotation* first = find_annotation(*masks().attributes.all, "cheek puff", 9);
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first->value, 1);
  ASSERT_EQ(first->region.size(), 1u);
  EXPECT_TRUE(masks().corrected.empty()) << "the mask itself was left alone";
  EXPECT_TRUE(saved(1));
  click("Undo");
  EXPECT_TRUE(masks().attributes.all->empty());
  EXPECT_TRUE(saved(0));
  click("Redo");
  EXPECT_TRUE(saved(1));

  // -- What a command line painted meanwhile stays, whatever is painted here.
  {
    const auto project = open_project(project_);
    ASSERT_TRUE(project.ok());
    PaintedAttributes theirs = *read_project_attributes(*project);
    annotate(theirs, "wink", {10, 1, {{StrokeMark::person, 3, {{5, 5}}}}});
    ASSERT_TRUE(save_project_attributes(*project, theirs).ok());
    click("Undo");
    click("Redo");
    ASSERT_TRUE(until(30, [&](const Snapshot&) { return read_project_attributes(*project)->size() == 2; }));
    ASSERT_TRUE(until(60, [](const Snapshot& s) { return s.masks.attributes.all->size() == 2; }))
        << "it is read again once the window rests";
    click("wink");
    click("Delete wink");
    click("cheek puff");
    EXPECT_TRUE(saved(1));
  }

  // -- Others that show none.
  for (const int none : {6, 14, 20}) {
    go_to(none);
    click("None of it here");
  }
  EXPECT_TRUE(saved(4));
  EXPECT_TRUE(until(60, [](const Snapshot& s) { return s.step(Step::train).state == StepState::stale; }));
  EXPECT_TRUE(masks().attributes.unlearnt);
  go_to(9);
  ASSERT_TRUE(until(30, [](const Snapshot& s) { return s.masks.drawn.edit == s.masks.edit; }));
  for (const bool dark : {true, false}) {
    Snapshot s = studio_->snapshot();
    s.settings.dark = dark;
    for (int i = 0; i < 3; ++i) test::draw_frame(s);
    test::keep_shot(fmt::format("attributes_{}", dark ? "dark" : "light"));
  }

  // -- The one button makes a slider of it.
  click("Make the avatar");
  ASSERT_TRUE(studio_->is_working());
  ASSERT_TRUE(until(300, [](const Snapshot& s) { return !is_working(s.project.pipeline.job); }));
  ASSERT_TRUE(until(60, [](const Snapshot& s) { return s.situation.finished; }))
      << studio_->snapshot().project.pipeline.job.error.value_or(Error{}).what;
  ASSERT_EQ(studio_->snapshot().project.contents->avatar->avatar.attributes.size(), 1u);
  click("step Direct");
  frame();
  EXPECT_TRUE(noted_widgets().contains("Painted"));

  // -- Deleted again.
  click("step Cameras");
  click("Delete cheek puff");
  EXPECT_TRUE(saved(0));
}

}  // namespace
}  // namespace likeness::ui
