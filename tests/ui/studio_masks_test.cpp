// A finished demo project in a real window: its masks are looked at and corrected by the mouse, and what
// follows from that.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/files.h"
#include "core/project/corrections.h"
#include "core/project/run_stages.h"
#include "core/project/staleness.h"
#include "core/synth/demo_capture.h"
#include "tests/ui/driven_studio.h"

namespace likeness::ui {
namespace {

namespace fs = std::filesystem;
using test::TestWindow;

class StudioMasks : public test::DrivenStudio {
 protected:
  // One demo person for all tests; each works on a copy.
  static void SetUpTestSuite() {
    std::string name = (fs::temp_directory_path() / "likeness_masks_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    made_ = name;
    const DemoOptions demo{
        .width = 320, .height = 320, .frames = 34, .moving_share = 0, .samples_per_pixel = 1};
    const auto filmed = write_demo_capture(made_ / "demo", demo, Progress(), {});
    ASSERT_TRUE(filmed.ok()) << filmed.error().what;
    ProjectOptions options;
    options.shared.video = made_ / "demo" / "demo.mp4";
    options.train.steps = 10;
    auto project = open_or_create_project(made_ / "demo.likeness", options);
    ASSERT_TRUE(project.ok()) << project.error().what;
    project->consent = Consent::no_real_person;
    const auto run = run_stages(*project, Stage::train, Progress(), {}, {});
    ASSERT_TRUE(run.ok()) << run.error().what;
  }
  static void TearDownTestSuite() { fs::remove_all(made_); }

  void SetUp() override {
    DrivenStudio::SetUp();
    ASSERT_TRUE(fs::exists(made_ / "demo.likeness" / "avatar.bin"));
    project_ = folder_ / "projects" / "demo.likeness";
    fs::create_directories(project_.parent_path());
    fs::copy(made_ / "demo.likeness", project_, fs::copy_options::recursive);
  }

  // The program started, the project opened, and its masks shown.
  void show_masks() {
    start();
    TestWindow::get().window->drop({project_});
    ASSERT_TRUE(
        until(60, [](const Snapshot& s) { return s.project.contents && s.project.contents->avatar; }));
    click("step Cameras");
    click("Masks and background");
    ASSERT_TRUE(until(60, [](const Snapshot& s) { return s.masks.drawn.picture.image != nullptr; }));
    frame();
  }
  MasksView masks() const { return studio_->snapshot().masks; }
  // The picture has the strokes as they are.
  bool drawn() {
    return until(30, [](const Snapshot& s) {
      return s.masks.drawn.picture.image && s.masks.drawn.edit == s.masks.edit &&
             s.masks.drawn.look == s.masks.look && s.masks.drawn.picture.frame == s.masks.frame;
    });
  }
  Project opened() const {
    const auto project = open_project(project_);
    EXPECT_TRUE(project.ok());
    return project.ok() ? *project : Project{};
  }
  // Alpha in the middle of a frame's mask, 0..255.
  int middle_of_mask(int frame) const {
    const auto mask = read_image(project_ / "masks" / frame_name(frame).filename());
    EXPECT_TRUE(mask.ok());
    return mask.ok() ? *mask->at(mask->width / 2, mask->height / 2) : -1;
  }

  inline static fs::path made_;
  fs::path project_;
};

// The colour in the middle of a widget.
std::array<int, 3> middle_colour(const std::string& widget) {
  const Image8 screen = TestWindow::get().window->read_pixels();
  const Rectangle r = noted_widgets().at(widget);
  const std::uint8_t* p = screen.at(int(0.5f * (r.low.x + r.high.x)), int(0.5f * (r.low.y + r.high.y)));
  return {p[0], p[1], p[2]};
}

// For people: the page in both themes and sizes of letters.
void keep_looks(const Snapshot& snapshot, const std::string& name) {
  for (const bool dark : {true, false})
    for (const int scale : {100, 200}) {
      Snapshot s = snapshot;
      s.settings.dark = dark;
      s.settings.scale_percent = scale;
      for (int i = 0; i < 3; ++i) test::draw_frame(s);
      test::keep_shot(fmt::format("masks_{}_{}_{}", name, dark ? "dark" : "light", scale));
    }
}

// In the Check step: what masks and everything else are made from.
TEST_F(StudioMasks, AnotherKindOfCameraMakesThemStaleAndCanBeTakenBack) {
  start();
  TestWindow::get().window->drop({project_});
  ASSERT_TRUE(until(60, [](const Snapshot& s) { return s.situation.finished; }));
  const Snapshot before = studio_->snapshot();
  EXPECT_EQ(before.project.contents->facts.camera.kind, CameraKind::resting);
  EXPECT_NE(before.project.contents->facts.camera.evidence, "");
  EXPECT_GT(before.project.contents->facts.mask.frames + before.project.contents->facts.parts.frames, 34);
  EXPECT_EQ(before.project.contents->background_fault, "");
  click("step Check");
  EXPECT_FALSE(noted_widgets().contains("Undo"));
  click("Held in the hand");
  ASSERT_TRUE(until(30, [](const Snapshot& s) {
    return s.project.contents->is_stale(Stage::align) && s.project.contents->is_stale(Stage::train);
  }));
  EXPECT_EQ(opened().options.align.camera, CameraKind::handheld);
  for (const Step step : {Step::cameras, Step::face, Step::train})
    EXPECT_EQ(studio_->snapshot().step(step).state, StepState::stale) << step_words(step);
  EXPECT_TRUE(studio_->snapshot().project.contents->facts.camera.stated);
  frame();
  test::keep_shot("check_kind_chosen");
  click("Undo");
  ASSERT_TRUE(until(30, [](const Snapshot& s) { return s.situation.finished; }));
  EXPECT_EQ(opened().options.align.camera, std::nullopt);
  click("Redo");
  ASSERT_TRUE(until(30, [](const Snapshot& s) { return !s.situation.finished; }));
  EXPECT_EQ(opened().options.align.camera, CameraKind::handheld);
}

TEST_F(StudioMasks, AreShownInEveryLook) {
  show_masks();
  ASSERT_FALSE(masks().frames->empty());
  EXPECT_GT(liveliness("mask picture"), 10);
  keep_looks(studio_->snapshot(), "picture");
  for (const auto& [words, look] :
       std::vector<std::pair<const char*, MaskLook>>{{"Matte", MaskLook::matte},
                                                     {"Cut-out", MaskLook::cut_out},
                                                     {"Background plate", MaskLook::plate}}) {
    click(words);
    ASSERT_EQ(masks().look, look);
    ASSERT_TRUE(drawn()) << words;
    EXPECT_GT(liveliness("mask picture"), 5) << words;
    keep_looks(studio_->snapshot(), words);
    if (look != MaskLook::matte) continue;
    const Image8 screen = TestWindow::get().window->read_pixels();
    const Rectangle place = noted_widgets().at("mask picture");
    EXPECT_GT(test::ink_share(screen, place, {1, 1, 1, 1}), 0.05) << "no person";
    EXPECT_GT(test::ink_share(screen, place, {0, 0, 0, 1}), 0.05) << "no background";
  }
  // From frame to frame, by the buttons and by the strip.
  const int frame_before = masks().frame;
  click("Next picture");
  EXPECT_GT(masks().frame, frame_before);
  click("Previous picture");
  EXPECT_EQ(masks().frame, frame_before);
  click("Where the cameras stood");
  frame();
  EXPECT_TRUE(noted_widgets().contains("camera view"));
  EXPECT_FALSE(noted_widgets().contains("mask picture"));
}

TEST_F(StudioMasks, APaintedStrokeIsKeptTakenBackAndMadeIntoTheMask) {
  show_masks();
  ASSERT_TRUE(studio_->snapshot().situation.finished);
  const int number = masks().frame;
  const Stage matte = Stage::matte;
  ASSERT_GT(middle_of_mask(number), 200) << "the person is in the middle";
  const auto before = middle_colour("mask picture");

  click("This is background");
  test::drag("mask picture", 24, 0, 0, [this] { frame(); });
  ASSERT_EQ(masks().strokes->size(), 1u);
  const Stroke stroke = masks().strokes->front();
  EXPECT_EQ(stroke.mark, StrokeMark::background);
  EXPECT_GE(stroke.points.size(), 2u);
  const SquareCrop crop = studio_->snapshot().project.contents->capture->crop;
  const Vec2d centre(crop.x + 0.5 * crop.side, crop.y + 0.5 * crop.side);
  EXPECT_LT((stroke.points.front() - centre).norm(), 0.01 * crop.side) << "painted where the mouse was";
  EXPECT_GT(stroke.points.back().x(), stroke.points.front().x());
  // Seen at once, before the picture is drawn anew, and then in it.
  EXPECT_NE(middle_colour("mask picture"), before);
  ASSERT_TRUE(drawn());
  frame();
  EXPECT_NE(middle_colour("mask picture"), before);

  const fs::path file = strokes_path(opened(), number);
  ASSERT_TRUE(until(30, [&](const Snapshot&) { return fs::exists(file); }));
  click("Undo");
  EXPECT_TRUE(masks().strokes->empty());
  ASSERT_TRUE(until(30, [&](const Snapshot&) { return !fs::exists(file); }));
  ASSERT_TRUE(until(60, [](const Snapshot& s) { return s.situation.finished && !s.masks.unmade; }))
      << "taken back, nothing is to be made anew";
  click("Redo");
  EXPECT_EQ(masks().strokes->size(), 1u);
  ASSERT_TRUE(until(60, [](const Snapshot& s) {
    return s.step(Step::face).state == StepState::stale && s.step(Step::train).state == StepState::stale;
  }));
  EXPECT_TRUE(masks().unmade);
  EXPECT_FALSE(studio_->snapshot().situation.finished);
  EXPECT_TRUE(read_freshness(opened()).stale[std::size_t(matte)]);
  EXPECT_TRUE(noted_widgets().contains("unmade masks"));
  ASSERT_TRUE(drawn());
  keep_looks(studio_->snapshot(), "painted");
  EXPECT_NE(studio_->snapshot().step(Step::face).found.find("brush strokes"), std::string::npos);

  // Opened again, what was painted is still there; the same button makes the masks of it.
  show_masks();
  EXPECT_EQ(masks().corrected, std::set<int>{number});
  EXPECT_EQ(*masks().strokes, Strokes{stroke});
  click("Make the avatar");
  ASSERT_TRUE(studio_->is_working());
  ASSERT_TRUE(until(400, [](const Snapshot& s) { return !is_working(s.project.pipeline.job); }));
  ASSERT_TRUE(until(60, [](const Snapshot& s) { return s.situation.finished; }))
      << studio_->snapshot().project.pipeline.job.error.value_or(Error{}).what;
  EXPECT_EQ(middle_of_mask(number), 0);
  EXPECT_FALSE(masks().unmade);
}

TEST_F(StudioMasks, ADamagedFileIsReportedAndSetAsideByAButton) {
  ASSERT_TRUE(write_text(project_ / "corrections" / "000003.json", "{\"format\":").ok());
  show_masks();
  ASSERT_TRUE(masks().unreadable.contains(3));
  frame();
  EXPECT_TRUE(noted_widgets().contains("unreadable strokes"));
  keep_looks(studio_->snapshot(), "unreadable");
  click("Set it aside");
  ASSERT_TRUE(
      until(60, [](const Snapshot& s) { return s.masks.unreadable.empty() && s.situation.finished; }));
  EXPECT_TRUE(fs::exists(project_ / "corrections" / "000003.damaged.json"));
  EXPECT_FALSE(studio_->snapshot().message.empty());
}

TEST_F(StudioMasks, NothingIsPaintedWhileTheWorkGoesOn) {
  show_masks();
  Snapshot s = studio_->snapshot();
  s.situation.running = true;
  test::draw_frame(s);
  bool painted = false;
  test::drag("mask picture", 20, 0, 0, [&] { painted |= test::draw_frame(s).masks.stroke.has_value(); });
  EXPECT_FALSE(painted);
  s.situation.running = false;
  test::draw_frame(s);
  test::drag("mask picture", 20, 0, 0, [&] { painted |= test::draw_frame(s).masks.stroke.has_value(); });
  EXPECT_TRUE(painted);
}

}  // namespace
}  // namespace likeness::ui
