// Every panel in every state, from snapshots made by hand: nothing crashes, every view has pixels, at every
// scale and in light and dark.
#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <set>

#include "core/base/rigid.h"
#include "tests/core/train/ball_scene.h"
#include "tests/golden/expect_golden.h"
#include "tests/ui/studio_window.h"

namespace likeness::ui {
namespace {

using test::draw_frame;
using test::keep_shot;
using test::liveliness;
using test::TestWindow;

Image8 patterned(int width, int height, int step) {
  Image8 image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      std::uint8_t* p = image.at(x, y);
      p[0] = std::uint8_t(40 + 150 * x / width);
      p[1] = std::uint8_t((x / step + y / step) % 2 ? 190 : 70);
      p[2] = std::uint8_t(60 + 120 * y / height);
    }
  return image;
}

FramePicture frame_picture(int frame) {
  return {frame, 1, std::make_shared<const Image8>(patterned(96, 96, 8)), ""};
}

// A ball with a face's landmarks, hardly trained: enough for every panel.
std::shared_ptr<const ProjectContents> ball_contents() {
  static const auto contents = [] {
    const TrainingSet set = ball_set(24, 32);
    TrainOptions options;
    options.schedule.steps = 30;
    options.rays.per_step = 256;
    auto avatar = train_avatar(set, options, {}, Progress(), {}, {});
    auto made = std::make_shared<ProjectContents>();
    made->project.folder = "/home/me/Likeness/Ball.likeness";
    made->project.options.shared.video = "/home/me/Videos/Ball.mp4";
    made->project.consent = Consent::own;
    made->current.fill(true);
    made->clip =
        VideoInfo{.width = 1080, .height = 1920, .frames_per_second = 30, .duration_s = 62, .codec = "h264"};
    auto model = set.model;
    for (int e = 0; e < 2; ++e)
      for (const char* name : {e ? "mouthSmile_L" : "jawOpen", e ? "mouthSmile_R" : "browInnerUp"}) {
        NamedAction action{name, Eigen::VectorXf::Zero(2)};
        action.expression[e] = 1;
        model.actions.push_back(action);
      }
    made->model = std::make_shared<const HeadModel>(model);
    Capture capture;
    CameraSet cameras;
    cameras.cameras = {set.views.front().camera};
    cameras.cameras.front().frame = -1;
    Track track;
    track.person = set.person;
    track.neutral = set.neutral;
    capture.crop.side = capture.width = capture.height = capture.size = 32;
    for (int i = 0; i < 24; ++i) {
      capture.frames.push_back({i, i / 30.0, 100.0 + 40 * std::sin(i * 0.7), i > 20, i <= 20 && i % 7 != 3,
                                i <= 20 && i % 7 == 3 ? "blurred beside its neighbours" : ""});
      TrackedFrame frame;
      frame.frame = i;
      frame.time_s = i / 30.0;
      frame.pose = set.views[std::size_t(i)].pose;
      frame.inner_error_px = 1 + 0.8 * std::sin(i * 0.5);
      frame.status = i == 9 ? FrameStatus::lost : i % 6 == 5 ? FrameStatus::weak : FrameStatus::good;
      frame.reason = i == 9 ? "no face was found" : "";
      track.frames.push_back(frame);
    }
    made->capture = std::make_shared<const Capture>(capture);
    made->cameras = std::make_shared<const CameraSet>(cameras);
    made->track = std::make_shared<const Track>(track);
    made->facts = {{CameraKind::resting, true, false,
                    "The camera rests: the background moves by 0.31 thousandths of the picture's width over "
                    "24 frames (180 feature tracks on average; limit 1.50)."},
                   {MaskPrior::person_network, 24, 23},
                   {.seconds = 0.8, .frames = 24, .repeated = 3, .width = 32, .height = 32}};
    auto directed = ProjectAvatar::make(avatar.ok() ? std::move(*avatar) : Avatar{}, made->model,
                                        seen_views(capture, cameras, track));
    const std::vector<SeenAction> seen{{"jawOpen", 0, 0.6f}, {"mouthSmile_L", 0, 0.3f}};
    for (const SeenAction& action : seen)
      directed->limits[action_channel(action.name)] = {action.low, action.high};
    directed->limits["head yaw"] = {-25, 30};
    directed->presets = presets(*made->model, seen);
    made->avatar = directed;
    made->card = std::make_shared<const Card>(
        Card{.trained = 310,
             .weak = 2,
             .lost = 1,
             .refused = 12,
             .low = {-0.45, -0.2, -0.1},
             .high = {0.5, 0.22, 0.1},
             .expressions = {{"jawOpen", 0.6f, Learnt::well},
                             {"mouthSmile", 0.5f, Learnt::well},
                             {"mouthPucker", 0.2f, Learnt::little},
                             {"browInnerUp", 0, Learnt::never}},
             .gaps = {{"The head was hardly seen from above.", "Bow the head slowly, and rest there."}},
             .parts = {{"expression", true, false, "chooses a slice of a hyper-space",
                        "The face moves by 2.1 mm."},
                       {"torso", false, false, "none",
                        "Below and beside the neck the person fills 1 % of the picture."},
                       {"code", false, true, "none", "You asked for --no-latent."}},
             .worst = {{0.1, 0.4, 2.1, "The pictures are blurred.", "Move more slowly there."}}});
    return std::shared_ptr<const ProjectContents>(made);
  }();
  return contents;
}

enum class Look { empty, loading, running, failed, done };
constexpr const char* kLookWords[] = {"empty", "loading", "running", "failed", "done"};

void add_training(PipelineStatus& pipeline) {
  for (int i = 0; i < 200; ++i)
    pipeline.training.push_back({std::uint64_t(3 * i), 1.0 * i, 0.01, 30 - 14 * std::exp(-i / 40.0), 45000});
  pipeline.curve.training = pipeline.training;
  for (int i = 0; i < 6; ++i) pipeline.curve.held_out.push_back({20.0 + 30 * i, 28 - 9 * std::exp(-i / 2.0)});
  PreviewPictures pictures;
  pictures.frame = 812, pictures.held_out = true;
  pictures.truth = patterned(64, 64, 8);
  pictures.same = pictures.turned = pictures.expression = patterned(64, 64, 7);
  pictures.turned_words = "From 20\u00b0 left", pictures.expression_words = "Smile";
  pictures.psnr_db = 24.3;
  static const auto kept = std::make_shared<const PreviewPictures>(pictures);
  pipeline.preview = kept;
}

void add_exports(Snapshot& s) {
  s.exports.first = frame_picture(0);
  const std::filesystem::path folder = "/home/me/Likeness/Ball.likeness/exports";
  s.exports.status = {
      .state = JobState::running, .fraction = 0.4, .text = "frame 40 of 100", .seconds_left = 24};
  s.exports.items = {
      {1, folder / "still-001.png", {.state = JobState::done, .seconds = 2, .outcome = "written"}},
      {2,
       folder / "driven-001.mp4",
       {.state = JobState::failed,
        .error = Error{ErrorCode::no_face, "No face was found in friend.mp4.",
                       "Use a driving clip in which the face is close and well lit.", ""}}},
      {3, folder / "head-001.glb", {.state = JobState::stopped}},
      {4, folder / "orbit-001.mp4", s.exports.status},
      {5, folder / "orbit-002.mp4", {}}};
}

Snapshot snapshot_of(Step step, Look look) {
  Snapshot s;
  s.shown = step;
  s.system = {.threads = 2, .memory = 1'200'000'000, .available = 9'000'000'000};
  if (look == Look::loading) s.project.loading = true;
  if (look != Look::loading) {
    auto contents = std::make_shared<ProjectContents>(*ball_contents());
    if (look != Look::done) {
      contents->current.fill(false);
      contents->capture.reset(), contents->cameras.reset(), contents->track.reset(), contents->avatar.reset();
      if (look == Look::empty) contents->project.consent = Consent::not_asked;
    }
    s.project.contents = look == Look::done ? ball_contents() : contents;
    s.project.clip_picture = frame_picture(0);
    if (look == Look::done)
      s.project.check_picture = s.project.face_picture = s.direct.compare_picture = frame_picture(8);
    if (look == Look::running) {
      s.project.pipeline.job = {.state = JobState::running,
                                .fraction = 0.6,
                                .text = "step 600, training PSNR 29.1 dB",
                                .seconds_left = 130};
      constexpr Stage kStage[] = {Stage::import, Stage::import, Stage::align, Stage::fit,
                                  Stage::train,  Stage::train,  Stage::train};
      s.project.pipeline.stage = kStage[std::size_t(step)];
      s.project.pipeline.stage_fraction = 0.3;
      s.project.pipeline.stage_seconds_left = 90;
      add_training(s.project.pipeline);
      if (step == Step::export_out) {
        s.project.contents = ball_contents();
        add_exports(s);
      }
    }
    if (look == Look::failed) {
      for (StageRecord& record : contents->project.stages)
        record = {StageState::failed, "", 3, "Face found in 12 of 900 frames.", {"The picture is dark."}};
      contents->clip.reset();
      s.exports.status = {
          .state = JobState::failed,
          .error = Error{ErrorCode::no_space, "The disk is full.", "Free 200 MB and export again.", ""}};
      s.error = Error{ErrorCode::no_face, "Face found in 12 of 900 frames.",
                      "Film again, facing the light, head and shoulders in the picture.", ""};
    }
    if (look == Look::done) {
      add_training(s.project.pipeline);
      s.project.pipeline.job.state = JobState::done;
      s.project.pipeline.finished.fill(true);
      s.exports.written = "/home/me/Likeness/Ball.likeness/exports/orbit-001.mp4";
      auto picture = std::make_shared<AvatarPicture>();
      const ProjectAvatar& a = *s.project.contents->avatar;
      const DirectedMoment rest = direct_moment(a.directed, {}, 0);
      picture->rgba = render_frame(a.avatar, resized(rest.camera, 64), pose_avatar(a.rig, rest.pose)).rgba;
      picture->last = true;
      s.direct.picture = picture;
    }
  }
  s.project.curve = s.project.pipeline.curve;
  s.steps = view_steps(s.project.contents.get(), s.project.loading, s.project.pipeline, s.exports.status,
                       s.exports.written);
  s.situation = {.project = s.project.contents != nullptr,
                 .clip_there = true,
                 .running = look == Look::running,
                 .training = look == Look::running && step == Step::train,
                 .finished = look == Look::done,
                 .avatar = look == Look::done || (look == Look::running && step == Step::export_out),
                 .exporting = look == Look::running && step == Step::export_out,
                 .directing = step == Step::direct,
                 .can_undo = true,
                 .consent = look != Look::empty};
  return s;
}

class Panels : public testing::Test {
 protected:
  void TearDown() override {
    InjectedInput away;
    TestWindow::get().window->inject(away);
  }
  static Image8 settled(const Snapshot& snapshot) {
    InjectedInput away;
    TestWindow::get().window->inject(away);
    for (int i = 0; i < 3; ++i) draw_frame(snapshot);
    return TestWindow::get().window->read_pixels();
  }
};

// Frames marked by dragging over the error strip, and what can be asked for them.
TEST_F(Panels, ASpanOfTheErrorStripIsMarkedAndAskedFor) {
  const Snapshot snapshot = snapshot_of(Step::face, Look::done);
  Requests last;
  const auto frame = [&] {
    const Requests now = draw_frame(snapshot);
    if (now.project.refit || now.project.take_back || now.project.face_frame) last = now;
  };
  (void)settled(snapshot);
  EXPECT_FALSE(noted_widgets().contains("Fit this span again"));
  const Rectangle strip = noted_widgets().at("face strip");
  const float column = (strip.high.x - strip.low.x) / 24;
  test::drag("face strip", 5.5f * column, 0, 0, frame);
  (void)settled(snapshot);
  ASSERT_TRUE(noted_widgets().contains("Fit this span again"));
  keep_shot("panel_Face_marked");
  test::click("Fit this span again", frame);
  ASSERT_TRUE(last.project.refit.has_value());
  EXPECT_EQ(last.project.refit->first, 12);
  EXPECT_EQ(last.project.refit->last, 17);
  // A click shows a frame, and nothing is marked any more.
  test::click("face strip", frame);
  ASSERT_TRUE(last.project.face_frame.has_value());
  EXPECT_EQ(*last.project.face_frame, 12);
  (void)settled(snapshot);
  EXPECT_FALSE(noted_widgets().contains("Fit this span again"));
  // Of a span that was fitted again: what came of it, and the way back.
  Snapshot again = snapshot;
  auto contents = std::make_shared<ProjectContents>(*snapshot.project.contents);
  contents->project.options.fit.refits = {{6, 9}};
  contents->refits = {{{6, 9}, 4, 3, 2, 1}};
  again.project.contents = contents;
  (void)settled(again);
  keep_shot("panel_Face_refitted");
  last = {};
  test::click("Undo the re-fit", [&] {
    if (const Requests now = draw_frame(again); now.project.take_back) last = now;
  });
  ASSERT_TRUE(last.project.take_back.has_value());
  EXPECT_EQ(*last.project.take_back, (RefitSpan{6, 9}));
}

// Why an avatar is made as it is: one line until somebody wants to know.
TEST_F(Panels, ThePartsOfAnAvatarOpenWithTheirReasons) {
  const char* heading = "Parts of this avatar, and why";
  const Snapshot done = snapshot_of(Step::train, Look::done);
  const Image8 closed = settled(done);
  ASSERT_TRUE(noted_widgets().contains(heading));
  test::click(heading, [&] { (void)draw_frame(done); });
  EXPECT_NE(settled(done).data, closed.data);
  keep_shot("panel_Train_parts");
  test::click(heading, [&] { (void)draw_frame(done); });
  EXPECT_EQ(settled(done).data, closed.data);
  // While it is trained, as soon as they are chosen.
  Snapshot running = snapshot_of(Step::train, Look::running);
  (void)settled(running);
  EXPECT_FALSE(noted_widgets().contains(heading));
  running.project.pipeline.parts = done.project.contents->card->parts;
  const auto heading_at = [&] {
    (void)settled(running);
    EXPECT_TRUE(noted_widgets().contains(heading));
    const auto found = noted_widgets().find(heading);
    return found == noted_widgets().end() ? 0.f : found->second.low.x;
  };
  const float line = heading_at();
  test::click(heading, [&] { (void)draw_frame(running); });
  EXPECT_GT(heading_at(), line + 4);  // in a card of its own
  keep_shot("panel_Train_parts_running");
  test::click(heading, [&] { (void)draw_frame(running); });
  EXPECT_EQ(heading_at(), line);
}

TEST_F(Panels, EveryStepIsDrawnInEveryState) {
  for (const Step step : kSteps) {
    std::array<Image8, 5> shown;
    for (const Look look : {Look::empty, Look::loading, Look::running, Look::failed, Look::done}) {
      const Image8 screen = settled(snapshot_of(step, look));
      const std::string name = fmt::format("{}_{}", step_words(step), kLookWords[std::size_t(look)]);
      for (const Step other : kSteps)
        EXPECT_GT(liveliness(screen, fmt::format("step {}", step_words(other))), 3) << name;
      const Rectangle panel = test::panel_of(screen);
      const Palette& p = theme().colours;
      // Not only ground: words at least, in every state; while the project is read, one line.
      EXPECT_LT(test::ink_share(screen, panel, p.ground) + test::ink_share(screen, panel, p.panel),
                look == Look::loading ? 0.9995 : 0.998)
          << name;
      const bool works =
          step == Step::check || step == Step::cameras || step == Step::face || step == Step::train;
      if (look == Look::failed && works) {
        EXPECT_GT(test::ink_share(screen, panel, p.bad), 1e-4) << name << ": the failure has no mark";
        EXPECT_GT(test::ink_share(screen, panel, p.warn), 1e-4) << name << ": the warning has no mark";
      }
      if (look == Look::running && works) {
        EXPECT_GT(test::ink_share(screen, panel, p.accent), 5e-4) << name << ": no progress is seen";
      }
      shown[std::size_t(look)] =
          crop(screen, int(panel.low.x), int(panel.low.y), screen.width - int(panel.low.x), 300);
      keep_shot("panel_" + name);
    }
    for (std::size_t a = 0; a < shown.size(); ++a)
      for (std::size_t b = 0; b < a; ++b) {
        // Before there is an avatar, Direct and Export have one thing to say.
        const bool same_words = (step == Step::direct || step == Step::export_out) && a != 4 && b != 4;
        if (!same_words) {
          EXPECT_NE(shown[a].data, shown[b].data)
              << step_words(step) << ": " << kLookWords[a] << " looks like " << kLookWords[b];
        }
      }
  }
}

// Reduced to a fifth: letters blur to lines, so that a hinting of theirs does not matter, but colours, order
// and size of everything do.
TEST_F(Panels, LookAsTheyDid) {
  const auto expect_look = [](const Snapshot& s, const std::string& name) {
    const Image8 screen = settled(s);
    likeness::test::expect_golden(resize(screen, screen.width / 5, screen.height / 5), "panel_" + name,
                                  {.mean = 1.5, .off = 24, .off_share = 0.01, .worst = 160});
  };
  Snapshot start;
  start.settings.recent = {"/home/me/Likeness/Ada.likeness"};
  expect_look(start, "start");
  for (const auto& [step, name] : std::vector<std::pair<Step, const char*>>{{Step::film, "film"},
                                                                            {Step::check, "check"},
                                                                            {Step::cameras, "cameras"},
                                                                            {Step::face, "face"},
                                                                            {Step::train, "train"},
                                                                            {Step::direct, "direct"}})
    expect_look(snapshot_of(step, Look::done), name);
  // The choices beside a queue with something of every kind in it.
  expect_look(snapshot_of(Step::export_out, Look::running), "export");
}

StudyView study_view(Look look) {
  StudyView view;
  view.open = true;
  view.forecast = StudyForecast{.trainings = 9, .finished = 0, .seconds = 1500, .left_seconds = 1500};
  if (look == Look::empty) {
    view.missing = "There is nothing to compare yet. Make the avatar first.";
    view.forecast.reset();
  }
  if (look == Look::running)
    view.job = {.state = JobState::running,
                .fraction = 0.37,
                .stage = "concat-mlp",
                .text = "step 600, training PSNR 29.1 dB",
                .seconds_left = 930};
  if (look == Look::failed) {
    view.forecast->finished = 4, view.forecast->left_seconds = 700;
    view.job = {.state = JobState::failed,
                .error = Error{ErrorCode::no_space, "The disk is full.", "Free 200 MB and go on.", ""}};
  }
  if (look == Look::done) {
    view.choice.tables = {"models", "parts"};
    view.choice.seeds = 3;
    view.job = {.state = JobState::done,
                .outcome = "3 methods were compared on 8 frames that none had seen."};
    FinishedStudy finished;
    finished.summary.size = 128, finished.summary.frames = 8, finished.summary.seconds = 90;
    const SummaryRow ours{.name = "warp+hyper-grid",
                          .about = "deformation and slice: what a build makes",
                          .seeds = 3,
                          .psnr_db = 31.2,
                          .head_db = 27.1,
                          .face_db = 28.4,
                          .head_spread_db = 0.2,
                          .train_seconds = 90.2,
                          .frames_per_second = 14.2};
    SummaryRow slow = ours, moved = ours;
    slow.name = "concat-mlp", slow.about = "NeRFace-like", slow.head_db = 22.4, slow.frames_per_second = 0.14;
    moved.name = "moved-picture", moved.about = "FOMM-like: one picture moved by landmarks";
    moved.psnr_db.reset(), moved.head_spread_db.reset();
    finished.summary.tables = {{"models", "The papers' models", {moved, slow, ours}},
                               {"parts", "With a part more or less", {ours, moved}}};
    finished.summary.plots = {{"a.png", "Speed", "Means of the seeds, at the end."},
                              {"b.png", "Size", "By the side of the picture."}};
    finished.plots = {patterned(1040, 560, 40), patterned(1040, 560, 70)};
    static const auto kept = std::make_shared<const FinishedStudy>(finished);
    view.finished = kept;
  }
  return view;
}

// Widgets that stand beside each other do not lie over each other, whatever the size of the letters.
TEST_F(Panels, TheComparisonIsDrawnInEveryStateAndSize) {
  for (const int scale : {100, 150, 200}) {
    std::vector<Image8> shown;
    for (const Look look : {Look::empty, Look::running, Look::failed, Look::done}) {
      Snapshot s = snapshot_of(Step::train, Look::done);
      s.settings.scale_percent = scale;
      s.study = study_view(look);
      s.situation.studying = look == Look::running;
      s.situation.can_study = look != Look::empty;
      s.situation.studied = look == Look::done;
      const Image8 screen = settled(s);
      const std::string name = fmt::format("study_{}_{}", kLookWords[std::size_t(look)], scale);
      keep_shot(name);
      EXPECT_TRUE(noted_widgets().contains("Back to the training")) << name;
      EXPECT_FALSE(noted_widgets().contains("training curve")) << name;
      EXPECT_EQ(noted_widgets().contains("Start the comparison"), look == Look::failed || look == Look::done)
          << name;
      EXPECT_EQ(noted_widgets().contains("Stop the comparison"), look == Look::running) << name;
      EXPECT_EQ(noted_widgets().contains("study table models"), look == Look::done) << name;
      const Palette& p = theme().colours;
      const Rectangle panel = test::panel_of(screen);
      if (look == Look::failed) {
        EXPECT_GT(test::ink_share(screen, panel, p.bad), 1e-4) << name;
      }
      if (look == Look::running) {
        EXPECT_GT(test::ink_share(screen, panel, p.accent), 2e-4) << name;
      }
      for (const Image8& other : shown) EXPECT_NE(other.data, screen.data) << name;
      shown.push_back(screen);
      constexpr const char* kWidgets[] = {"Back to the training",
                                          "Other methods",
                                          "How soon",
                                          "What each part brings",
                                          "30 s",
                                          "1.5 min",
                                          "5 min",
                                          "Once",
                                          "Three times",
                                          "Start the comparison",
                                          "Stop the comparison"};
      for (const char* a : kWidgets)
        for (const char* b : kWidgets) {
          const auto first = noted_widgets().find(a), second = noted_widgets().find(b);
          if (a == b || first == noted_widgets().end() || second == noted_widgets().end()) continue;
          const Rectangle &r = first->second, &q = second->second;
          const bool apart = r.high.x <= q.low.x + 1 || q.high.x <= r.low.x + 1 || r.high.y <= q.low.y + 1 ||
                             q.high.y <= r.low.y + 1;
          EXPECT_TRUE(apart) << name << ": " << a << " and " << b;
        }
    }
  }
}

TEST_F(Panels, TheComparisonIsAskedForByItsWidgets) {
  Snapshot s = snapshot_of(Step::train, Look::done);
  s.study = study_view(Look::failed);
  s.situation.can_study = true;
  Requests last;
  const auto frame = [&] {
    Requests now = draw_frame(s);
    if (now.study.choice || now.study.close || !now.commands.empty()) last = std::move(now);
  };
  (void)settled(s);
  test::click("How soon", frame);
  ASSERT_TRUE(last.study.choice.has_value());
  EXPECT_EQ(last.study.choice->tables, (std::vector<std::string>{"models", "time"}));
  last = {};
  test::click("Other methods", frame);
  ASSERT_TRUE(last.study.choice.has_value());
  EXPECT_TRUE(last.study.choice->tables.empty());
  last = {};
  test::click("5 min", frame);
  ASSERT_TRUE(last.study.choice.has_value());
  EXPECT_EQ(last.study.choice->seconds, 300);
  last = {};
  test::click("Start the comparison", frame);
  EXPECT_EQ(last.commands, std::vector<Command>{Command::start_study});
  last = {};
  test::click("Back to the training", frame);
  EXPECT_TRUE(last.study.close);
  // The avatar's parts lead there.
  s.study.open = false;
  (void)settled(s);
  EXPECT_FALSE(noted_widgets().contains("Compare with other methods..."));
  test::click("Parts of this avatar, and why", frame);
  (void)settled(s);
  ASSERT_TRUE(noted_widgets().contains("Compare with other methods..."));
  test::click("Parts of this avatar, and why", frame);
}

TEST_F(Panels, EveryViewHasPixels) {
  struct View {
    Step step;
    const char* widget;
  };
  for (const View& view : {View{Step::film, "clip picture"}, View{Step::check, "check strip"},
                           View{Step::check, "check picture"}, View{Step::cameras, "camera view"},
                           View{Step::face, "face strip"}, View{Step::face, "face picture"},
                           View{Step::train, "training curve"}, View{Step::train, "preview truth"},
                           View{Step::train, "preview same"}, View{Step::train, "preview turned"},
                           View{Step::train, "preview expression"}, View{Step::direct, "avatar view"}})
    EXPECT_GT(liveliness(settled(snapshot_of(view.step, Look::done)), view.widget), 4) << view.widget;
}

TEST_F(Panels, ASolveAtWorkIsSeenBeforeAnybodyKnowsWhereTheHeadIs) {
  ColmapModel model;
  model.cameras[1] = {540, 360, 500, 500, 270, 180, 0, 0, 0, 0};
  for (int i = 0; i < 12; ++i) {
    ColmapImage image;
    image.camera = 1;
    const double angle = 0.15 * (i - 6);
    image.cam_from_world.translate(Vec3d(0, 0, 1)).rotate(rotation_about(Vec3d::UnitY(), angle));
    model.images.push_back(image);
  }
  for (int i = 0; i < 400; ++i)
    model.points[i] = {Vec3d(0.1 * (i % 20) - 1, 0.1 * (i / 20) - 1, 0.8 + 0.02 * (i % 7)), 0.5, 3};
  Snapshot s = snapshot_of(Step::cameras, Look::running);
  s.project.solving = solving_cameras(model);
  ASSERT_NE(s.project.solving, nullptr);
  EXPECT_GT(liveliness(settled(s), "camera view"), 1);
  keep_shot("cameras_solving");
  s.project.solving.reset();
  settled(s);
  EXPECT_EQ(noted_widgets().count("camera view"), 0u);
}

TEST_F(Panels, LettersDoubleAndLightTurnsDark) {
  for (const Step step : kSteps)
    for (const bool dark : {true, false})
      for (const int scale : {100, 200}) {
        if (dark && scale == 100) continue;  // drawn above
        Snapshot s = snapshot_of(step, Look::done);
        s.settings.dark = dark;
        s.settings.scale_percent = scale;
        const Image8 screen = settled(s);
        const std::uint8_t* corner = screen.at(screen.width - 3, screen.height / 2);
        EXPECT_EQ(corner[1] > 128, !dark) << step_words(step);
        keep_shot(fmt::format("scale_{}_{}_{}", step_words(step), scale, dark ? "dark" : "light"));
      }
}

TEST_F(Panels, TheStartScreenOffersWaysToBegin) {
  Snapshot s;
  s.settings.recent = {"/home/me/Likeness/Ada.likeness",
                       "/home/me/Likeness/a very long name of a project.likeness"};
  settled(s);
  keep_shot("start_dark");
  for (const auto& [widget, command] :
       std::vector<std::pair<const char*, Command>>{{"Open a clip", Command::open_clip},
                                                    {"Record a clip", Command::record_clip},
                                                    {"Try the demo", Command::try_demo},
                                                    {"How to film", Command::film_guide}}) {
    Requests asked;
    test::click(widget, [&] {
      const Requests requests = draw_frame(s);
      asked.commands.insert(asked.commands.end(), requests.commands.begin(), requests.commands.end());
    });
    EXPECT_EQ(asked.commands, std::vector{command}) << widget;
  }
  std::optional<std::filesystem::path> opened;
  test::click("recent Ada.likeness", [&] {
    if (const Requests requests = draw_frame(s); requests.open) opened = requests.open;
  });
  EXPECT_EQ(opened, s.settings.recent[0]);
  s.settings.dark = false;
  for (const int scale : {150, 200}) {
    s.settings.scale_percent = scale;
    settled(s);
    keep_shot(fmt::format("start_light_{}", scale));
  }
}

TEST_F(Panels, TheQuestionOfConsentIsAnsweredByAClick) {
  const Snapshot s = snapshot_of(Step::film, Look::empty);
  settled(s);
  std::optional<Consent> answer;
  test::click("They agreed", [&] {
    if (const Requests requests = draw_frame(s); requests.project.consent) answer = requests.project.consent;
  });
  EXPECT_EQ(answer, Consent::given);
}

CaptureVerdict bad_clip() {
  return {Verdict::refilm,
          {{Fault::too_dark, true, 0, 12, "The face is too dark in 80 % of the pictures looked at.",
            "Face a window or a lamp behind the camera; do not film against the light."},
           {Fault::few_angles, false, 0.3, 8, "The head is seen from 8 degrees side to side.",
            "Turn the head slowly to both sides as far as to a half profile."}}};
}

TEST_F(Panels, TheVerdictOnAClipIsShownBeforeItIsImportedAndAfter) {
  for (const Look look : {Look::empty, Look::done}) {
    Snapshot s = snapshot_of(Step::check, look);
    s.situation.consent = s.situation.can_check = true;
    s.project.checking.state = JobState::done;
    s.project.verdict = std::make_shared<const CaptureVerdict>(bad_clip());
    add_verdict(s.project.checking, s.project.verdict.get(), s.steps);
    settled(s);
    keep_shot(fmt::format("verdict_{}", kLookWords[std::size_t(look)]));
    Requests asked;
    test::click(command_info(Command::check_clip).words.data(), [&] {
      const Requests requests = draw_frame(s);
      asked.commands.insert(asked.commands.end(), requests.commands.begin(), requests.commands.end());
    });
    EXPECT_EQ(asked.commands, std::vector{Command::check_clip});
  }
  // A remark's time leads to its frame.
  Snapshot s = snapshot_of(Step::check, Look::done);
  s.project.verdict = std::make_shared<const CaptureVerdict>(bad_clip());
  settled(s);
  std::optional<int> frame;
  test::click("0\u20138 s", [&] {
    if (const Requests requests = draw_frame(s); requests.project.check_frame)
      frame = requests.project.check_frame;
  });
  EXPECT_EQ(frame, 9);  // the first at 0.3 s
}

TEST_F(Panels, OfAClipThatWillMakeNoGoodAvatarAnotherOneIsTheMainButton) {
  Snapshot s = snapshot_of(Step::film, Look::empty);
  auto contents = std::make_shared<ProjectContents>(*s.project.contents);
  contents->project.consent = Consent::own;
  s.project.contents = contents;
  s.situation.consent = s.situation.film_again = true;
  CaptureVerdict verdict = bad_clip();
  const auto shown = [&](const char* shot) {
    s.project.verdict = std::make_shared<const CaptureVerdict>(verdict);
    s.steps = view_steps(contents.get(), false, {}, {}, {});
    add_verdict({}, &verdict, s.steps);
    const Image8 screen = settled(s);
    keep_shot(shot);
    return screen;
  };
  const Image8 screen = shown("film_again");
  const auto blue = [&](const char* widget) {
    return test::ink_share(screen, noted_widgets().at(widget), theme().colours.accent);
  };
  EXPECT_GT(blue("Open another clip"), 0.4);
  EXPECT_LT(blue("Make it anyway"), 0.1);
  for (const auto& [widget, command] : {std::pair("Open another clip", Command::open_clip),
                                        std::pair("Make it anyway", Command::make_avatar)}) {
    Requests asked;
    test::click(widget, [&] {
      const Requests requests = draw_frame(s);
      asked.commands.insert(asked.commands.end(), requests.commands.begin(), requests.commands.end());
    });
    EXPECT_EQ(asked.commands, std::vector{command}) << widget;
  }
  verdict.faceless = s.situation.faceless = true;
  (void)shown("film_faceless");
  EXPECT_FALSE(noted_widgets().contains("Make it anyway"));
  EXPECT_FALSE(is_enabled(Command::make_avatar, s.situation));
}

TEST_F(Panels, WorkThatWasInterruptedIsContinuedAndSaysWhatIsLeft) {
  for (const Step step : {Step::film, Step::train}) {
    Snapshot s = snapshot_of(step, Look::empty);
    auto contents = std::make_shared<ProjectContents>(*s.project.contents);
    contents->project.consent = Consent::own;
    contents->plan.seconds = 55;
    s.project.contents = contents;
    s.situation.consent = s.situation.interrupted = true;
    (void)settled(s);
    keep_shot(fmt::format("interrupted_{}", step_words(step)));
    EXPECT_TRUE(noted_widgets().contains("Continue (about 1 min left)"));
    EXPECT_FALSE(noted_widgets().contains("Make the avatar"));
    Requests asked;
    test::click("Continue", [&] {
      const Requests requests = draw_frame(s);
      asked.commands.insert(asked.commands.end(), requests.commands.begin(), requests.commands.end());
    });
    EXPECT_EQ(asked.commands, std::vector{Command::make_avatar});
  }
}

TEST_F(Panels, AProjectOfAnotherWindowIsOpenedToLookAtOnly) {
  Snapshot s;
  s.project.elsewhere = "/home/me/Likeness/Ada.likeness";
  (void)settled(s);
  keep_shot("elsewhere");
  for (const auto& [button, look] :
       {std::pair("Open to look at only", true), std::pair("Do not open", false)}) {
    std::optional<bool> answer;
    test::click(button, [&] {
      if (const Requests requests = draw_frame(s); requests.project.look_only)
        answer = requests.project.look_only;
    });
    EXPECT_EQ(answer, look) << button;
    (void)settled(s);
  }
  s.project.elsewhere.reset();
  (void)settled(s);
  EXPECT_FALSE(noted_widgets().contains("Do not open"));
}

// Two of them that stand side by side, or one below the other, with room between.
bool lie_apart(const Rectangle& a, const Rectangle& b) {
  return a.high.x <= b.low.x || b.high.x <= a.low.x || a.high.y <= b.low.y || b.high.y <= a.low.y;
}

// Everything that can be wrong with a clip and its background at once.
Snapshot doubtful_clip() {
  Snapshot s = snapshot_of(Step::check, Look::done);
  auto contents = std::make_shared<ProjectContents>(*s.project.contents);
  contents->facts.mask = {MaskPrior::person_network, 1800, 610};
  contents->facts.parts.film = {4, 0, 24, 32}, contents->facts.parts.faceless_s = 0.6;
  MatteReport report;
  report.plate_look_back = {100, 0.62};
  report.plate = BackgroundFit{20, true, 12.3, 14};
  contents->look_back = look_back_warning(report, CameraKind::resting);
  contents->background_fault = background_fault(report);
  s.project.contents = contents;
  return s;
}

TEST_F(Panels, WhatTheCameraDoesIsSaidAndChosenByAClick) {
  constexpr std::array kChoices{"Find out", "Resting", "Held in the hand", "Walking"};
  for (const int scale : {80, 100, 150, 200}) {
    Snapshot s = doubtful_clip();
    s.settings.scale_percent = scale;
    const Image8 screen = settled(s);
    keep_shot(fmt::format("check_facts_{}", scale));
    const Rectangle panel = test::panel_of(screen);
    for (std::size_t i = 0; i < kChoices.size(); ++i) {
      const auto own = noted_widgets().find(kChoices[i]);
      if (own == noted_widgets().end()) continue;  // scrolled out of sight by large letters
      EXPECT_LE(own->second.high.x, panel.high.x) << kChoices[i] << " at " << scale;
      for (std::size_t j = 0; j < i; ++j)
        if (const auto other = noted_widgets().find(kChoices[j]); other != noted_widgets().end()) {
          EXPECT_TRUE(lie_apart(own->second, other->second)) << kChoices[i] << " at " << scale;
        }
    }
    InjectedInput input;  // the rest of the card
    input.mouse_x = 0.75f * float(screen.width), input.mouse_y = 0.7f * float(screen.height);
    for (int turn = 0; turn < 2; ++turn) {
      input.wheel = -9;
      TestWindow::get().window->inject(input);
      for (int i = 0; i < 3; ++i) draw_frame(s), input.wheel = 0, TestWindow::get().window->inject(input);
      if (scale >= 100) {
        EXPECT_NE(TestWindow::get().window->read_pixels().data, screen.data) << "at " << scale;
      }
      keep_shot(fmt::format("check_facts_{}_{}", scale, turn));
    }
    input.wheel = 90;
    TestWindow::get().window->inject(input);
    for (int i = 0; i < 3; ++i) draw_frame(s), input.wheel = 0, TestWindow::get().window->inject(input);
  }
  Snapshot s = snapshot_of(Step::check, Look::done);
  (void)settled(s);
  std::optional<std::optional<CameraKind>> asked;
  const auto frame = [&] {
    if (const Requests requests = draw_frame(s); requests.project.camera_kind)
      asked = requests.project.camera_kind;
  };
  test::click("Held in the hand", frame);
  ASSERT_TRUE(asked.has_value());
  EXPECT_EQ(*asked, CameraKind::handheld);
  asked.reset();
  test::click("Find out", frame);
  ASSERT_TRUE(asked.has_value());
  EXPECT_FALSE(asked->has_value());
  // Nothing is chosen while the stages read it.
  asked.reset();
  s.situation.running = true;
  test::click("Walking", frame);
  EXPECT_FALSE(asked.has_value());
}

TEST_F(Panels, WithoutABackgroundTheTrainingShowsThePersonsFigures) {
  const Snapshot whole = snapshot_of(Step::train, Look::running);
  const Image8 before = settled(whole);
  // The background was learnt badly, or - a white wall, a walking camera - not at all.
  for (const auto& [scale, badly] : {std::pair(100, true), std::pair(200, true), std::pair(100, false)}) {
    Snapshot s = snapshot_of(Step::train, Look::running);
    s.settings.scale_percent = scale;
    auto contents = std::make_shared<ProjectContents>(*s.project.contents);
    MatteReport report;
    report.room = BackgroundFit{20, true, 5.4, 12.8};
    if (badly) contents->background_fault = background_fault(report);
    s.project.contents = contents;
    auto pictures = std::make_shared<PreviewPictures>(*s.project.pipeline.preview);
    pictures->psnr_db = 24.3, pictures->of_person = true, pictures->head_db = 26.1, pictures->face_db = 27.4;
    s.project.pipeline.preview = pictures;
    const Image8 screen = settled(s);
    keep_shot(fmt::format("train_person_{}{}", scale, badly ? "" : "_unknown"));
    if (scale == 100) {
      EXPECT_GT(test::ink_share(screen, test::panel_of(screen), theme().colours.warn), 1e-4);
    }
    EXPECT_GT(liveliness(screen, "preview same"), 5);
    EXPECT_NE(screen.data, before.data);
  }
}

// A snapshot's performance takes what was asked for.
void take(Snapshot& s, const Requests& requests) {
  if (requests.direct.performance)
    s.direct.directing.performance = std::make_shared<const Performance>(*requests.direct.performance);
}

TEST_F(Panels, TheMouseTurnsPansAndZoomsTheAvatar) {
  Snapshot s = snapshot_of(Step::direct, Look::done);
  settled(s);
  const auto frame = [&] { take(s, draw_frame(s)); };
  const auto at = [&](const char* channel) { return value_at(*s.direct.directing.performance, channel, 0); };
  test::drag("avatar view", 60, 20, 0, frame);
  EXPECT_LT(at("camera yaw"), -5);
  EXPECT_GT(at("camera pitch"), 1);
  test::drag("avatar view", 60, 0, 1, frame);
  EXPECT_GT(at("camera shift x"), 0.02f);
  InjectedInput input;
  const Rectangle view = noted_widgets().at("avatar view");
  input.mouse_x = 0.5f * (view.low.x + view.high.x), input.mouse_y = 0.5f * (view.low.y + view.high.y);
  for (const bool ctrl : {false, true}) {
    input.ctrl = ctrl;
    input.wheel = 0;
    TestWindow::get().window->inject(input);
    frame();
    input.wheel = 3;
    TestWindow::get().window->inject(input);
    frame();
  }
  EXPECT_GT(at("camera zoom"), 1.1f);
  EXPECT_LT(at("camera distance"), 0.9f);
  EXPECT_EQ(at("head yaw"), 0);  // the head stays
}

TEST_F(Panels, ASliderMovesTheJawAndLetsGoOnce) {
  Snapshot s = snapshot_of(Step::direct, Look::done);
  settled(s);
  int finished = 0;
  test::drag("##head yaw", 40, 0, 0, [&] {
    const Requests requests = draw_frame(s);
    take(s, requests);
    finished += requests.direct.finished;
  });
  EXPECT_GT(value_at(*s.direct.directing.performance, "head yaw", 0), 1);
  EXPECT_EQ(finished, 1);
}

TEST_F(Panels, KeysDoWhatTheTableSays) {
  const Snapshot s = snapshot_of(Step::direct, Look::done);
  settled(s);
  InjectedInput keys;
  keys.key = 'Z', keys.ctrl = true;
  TestWindow::get().window->inject(keys);
  EXPECT_EQ(draw_frame(s).commands, std::vector{Command::undo});
  TestWindow::get().window->inject(InjectedInput{});
  EXPECT_TRUE(draw_frame(s).commands.empty());
  // A plus is a plus with Shift, without it, and on the number pad.
  for (const auto& [key, shift] : {std::pair{GLFW_KEY_EQUAL, true}, std::pair{GLFW_KEY_EQUAL, false},
                                   std::pair{GLFW_KEY_KP_ADD, false}}) {
    keys.key = key, keys.shift = shift;
    TestWindow::get().window->inject(keys);
    EXPECT_EQ(draw_frame(s).commands, std::vector{Command::larger}) << key;
    TestWindow::get().window->inject(InjectedInput{});
    draw_frame(s);
  }
}

// Tab goes through the panels, Enter presses: from wherever it begins, once round asks for everything.
TEST_F(Panels, TabReachesWhatCanBePressed) {
  Snapshot s;
  s.settings.recent = {"/home/me/Likeness/Ada.likeness"};
  settled(s);
  std::vector<Command> asked;
  std::optional<std::filesystem::path> opened;
  const auto press = [&](int key) {
    InjectedInput keys;
    for (const int now : {key, 0}) {
      keys.key = now;
      TestWindow::get().window->inject(keys);
      const Requests requests = draw_frame(s);
      asked.insert(asked.end(), requests.commands.begin(), requests.commands.end());
      if (requests.open) opened = requests.open;
    }
  };
  for (int i = 0; i < 6; ++i) {
    press(GLFW_KEY_TAB);
    if (i == 0) keep_shot("start_keyboard");
    press(GLFW_KEY_ENTER);
  }
  EXPECT_EQ((std::set<Command>(asked.begin(), asked.end())),
            (std::set{Command::open_clip, Command::record_clip, Command::open_project, Command::try_demo,
                      Command::film_guide}));
  EXPECT_EQ(opened, s.settings.recent[0]);
  // The menus: the first opens, and its second item is asked for.
  asked.clear();
  for (const int key : {GLFW_KEY_F10, GLFW_KEY_DOWN, GLFW_KEY_DOWN, GLFW_KEY_ENTER}) press(key);
  EXPECT_EQ(asked, std::vector{Command::record_clip});
  // What cannot be pressed is passed over: there is no way into it.
  s.situation.running = true;
  settled(s);
  asked.clear();
  for (int i = 0; i < 6; ++i) press(GLFW_KEY_TAB), press(GLFW_KEY_ENTER);
  EXPECT_EQ((std::set<Command>(asked.begin(), asked.end())), std::set{Command::film_guide});
}

TEST_F(Panels, ArrowKeysStepThroughAStripThatTabReached) {
  const Snapshot s = snapshot_of(Step::check, Look::done);
  settled(s);
  std::optional<int> frame;
  const auto press = [&](int key) {
    InjectedInput keys;
    for (const int now : {key, 0}) {
      keys.key = now;
      TestWindow::get().window->inject(keys);
      if (const Requests requests = draw_frame(s); requests.project.check_frame)
        frame = requests.project.check_frame;
    }
  };
  for (int i = 0; i < 20 && !frame; ++i) press(GLFW_KEY_TAB), press(GLFW_KEY_RIGHT);
  EXPECT_EQ(frame, 9);  // after the one that is shown
  press(GLFW_KEY_LEFT);
  EXPECT_EQ(frame, 7);
}

// All of it is in the view, and it lies in the middle.
TEST_F(Panels, TheCamerasAndTheHeadFillTheirView) {
  for (const int scale : {100, 200}) {
    Snapshot s = snapshot_of(Step::cameras, Look::done);
    s.settings.scale_percent = scale;
    settled(s);
    test::click("Look at all", [&] { draw_frame(s); });
    const Image8 screen = settled(s);
    const Rectangle view = noted_widgets().at("camera view");
    const ImVec4& ground = theme().colours.panel;
    const Rectangle inside{{view.low.x + 2, view.low.y + 2}, {view.high.x - 2, view.high.y - 2}};
    float left = inside.high.x, right = inside.low.x, top = inside.high.y, bottom = inside.low.y;
    for (float y = inside.low.y; y < inside.high.y; ++y)
      for (float x = inside.low.x; x < inside.high.x; ++x) {
        if (test::ink_share(screen, {{x, y}, {x + 1, y + 1}}, ground) > 0) continue;
        left = std::min(left, x), right = std::max(right, x), top = std::min(top, y),
        bottom = std::max(bottom, y);
      }
    const float width = inside.high.x - inside.low.x, height = inside.high.y - inside.low.y;
    EXPECT_GT(std::max((right - left) / width, (bottom - top) / height), 0.75f) << scale;
    EXPECT_NEAR((left + right) / 2, (inside.low.x + inside.high.x) / 2, 0.08f * width) << scale;
    EXPECT_NEAR((top + bottom) / 2, (inside.low.y + inside.high.y) / 2, 0.08f * height) << scale;
  }
}

TEST_F(Panels, LargeLettersLeaveThePicturesTheirRoom) {
  for (const auto& [step, widget] :
       {std::pair{Step::check, "check picture"}, std::pair{Step::face, "face picture"}}) {
    Snapshot s = snapshot_of(step, Look::done);
    s.settings.scale_percent = 200;
    const Image8 screen = settled(s);
    const Rectangle picture = noted_widgets().at(widget);
    EXPECT_GT(picture.high.y - picture.low.y, 0.4f * float(screen.height)) << widget;
  }
}

// A warning does not push the picture away under the hand that turns it.
TEST_F(Panels, AWarningLeavesTheAvatarWhereItIs) {
  Snapshot s = snapshot_of(Step::direct, Look::done);
  settled(s);
  EXPECT_FALSE(noted_widgets().contains("beyond"));
  const Rectangle before = noted_widgets().at("avatar view");
  s.direct.directing.beyond = {0.6, {"jawOpen"}};
  settled(s);
  keep_shot("direct_beyond");
  const Rectangle after = noted_widgets().at("avatar view"), warning = noted_widgets().at("beyond");
  EXPECT_EQ(after.low.y, before.low.y);
  EXPECT_EQ(after.high.y, before.high.y);
  EXPECT_GT(warning.low.y, after.low.y + 0.5f * (after.high.y - after.low.y));
  EXPECT_EQ(warning.high.y, after.high.y);
}

// Nor does it cover much of a small one: the words are cut short, and the pointer brings them.
TEST_F(Panels, AWarningLeavesASmallAvatarInSight) {
  for (const int scale : {100, 125, 150, 200}) {
    Snapshot s = snapshot_of(Step::direct, Look::done);
    s.settings.scale_percent = scale;
    s.direct.directing.beyond = {0.6, {"jawOpen", "mouthSmile_L", "browInnerUp"}};
    settled(s);
    keep_shot(fmt::format("direct_beyond_{}", scale));
    const Rectangle view = noted_widgets().at("avatar view"), warning = noted_widgets().at("beyond");
    EXPECT_LE(warning.high.y - warning.low.y,
              std::max(0.21f * (view.high.y - view.low.y), 42.f * float(scale) / 100))
        << scale;
    EXPECT_GE(warning.low.y, view.low.y) << scale;
  }
}

TEST_F(Panels, TheListOfKeysIsScrolledByKeys) {
  Snapshot s = snapshot_of(Step::train, Look::running);
  s.settings.scale_percent = 200;
  settled(s);
  TestWindow::get().shell->ask(Question::shortcuts);
  const auto list = [&] {
    const Image8 screen = settled(s);
    const Rectangle place = noted_widgets().at("key list");
    std::vector<std::uint8_t> pixels;
    for (int y = int(place.low.y); y < int(place.high.y); ++y)
      for (int x = int(place.low.x); x < int(place.high.x); ++x) pixels.push_back(screen.at(x, y)[1]);
    return pixels;
  };
  const auto press = [&](int key) {
    InjectedInput input;
    input.key = key;
    TestWindow::get().window->inject(input);
    draw_frame(s);
    TestWindow::get().window->inject(InjectedInput{});
    draw_frame(s);
  };
  const auto top = list();
  press(GLFW_KEY_DOWN);
  const auto line = list();
  EXPECT_NE(line, top);
  press(GLFW_KEY_END);
  const auto end = list();
  EXPECT_NE(end, line);
  press(GLFW_KEY_PAGE_DOWN);  // no further
  EXPECT_EQ(list(), end);
  press(GLFW_KEY_HOME);
  EXPECT_EQ(list(), top);
  test::click("Close", [&] { draw_frame(s); });
  draw_frame(s);
}

TEST_F(Panels, QuestionsAreShownAndClosed) {
  const Snapshot s = snapshot_of(Step::train, Look::running);
  Shell& shell = *TestWindow::get().shell;
  for (const auto& [question, name] :
       std::vector<std::pair<Question, const char*>>{{Question::shortcuts, "shortcuts"},
                                                     {Question::film_guide, "guide"},
                                                     {Question::licences, "licences"}}) {
    shell.ask(question);
    settled(s);
    keep_shot(std::string("question_") + name);
    test::click("Close", [&] { draw_frame(s); });
    draw_frame(s);
    EXPECT_FALSE(noted_widgets().contains("Close")) << name;
  }
  shell.ask(Question::closing);
  settled(s);
  keep_shot("question_closing");
  test::click("Keep and stop", [&] { draw_frame(s); });
  EXPECT_EQ(shell.take_closing(), Closing::keep_and_stop);
  EXPECT_EQ(shell.take_closing(), Closing::none);
  draw_frame(s);
  // Of exports alone nothing is promised to be kept.
  Snapshot exporting = s;
  exporting.project.pipeline = {};
  exporting.situation.running = false;
  exporting.situation.exporting = true;
  shell.ask(Question::closing);
  settled(exporting);
  keep_shot("question_closing_exports");
  EXPECT_FALSE(noted_widgets().contains("Keep and stop"));
  test::click("Stop and quit", [&] { draw_frame(exporting); });
  EXPECT_EQ(shell.take_closing(), Closing::keep_and_stop);
}

// Every rule has its drawing, nothing lies over anything else, and what does not fit is scrolled to.
TEST_F(Panels, TheFilmGuideIsDrawnAtEveryScale) {
  Shell& shell = *TestWindow::get().shell;
  for (const bool dark : {true, false})
    for (const int scale : {100, 150, 200}) {
      Snapshot s;
      s.settings.dark = dark, s.settings.scale_percent = scale;
      settled(s);
      shell.ask(Question::film_guide);
      const Image8 screen = settled(s);
      const std::string look = fmt::format("guide_{}_{}", scale, dark ? "dark" : "light");
      keep_shot(look);
      ASSERT_TRUE(noted_widgets().contains("film guide")) << look;
      const Rectangle guide = noted_widgets().at("film guide"), close = noted_widgets().at("Close");
      EXPECT_GE(guide.low.x, 0) << look;
      EXPECT_LE(guide.high.x, float(screen.width)) << look;
      EXPECT_GE(close.low.y, guide.high.y) << look;
      EXPECT_LE(close.high.y, float(screen.height)) << look;
      std::vector<Rectangle> rules;
      for (const auto& [name, place] : noted_widgets())
        if (name.starts_with("rule ")) rules.push_back(place);
      EXPECT_EQ(rules.size(), 6u) << look;
      int drawn = 0;
      for (std::size_t a = 0; a < rules.size(); ++a) {
        EXPECT_GE(rules[a].low.x, guide.low.x) << look;
        EXPECT_LE(rules[a].high.x, guide.high.x) << look;
        for (std::size_t b = 0; b < a; ++b)
          EXPECT_TRUE(rules[a].high.x <= rules[b].low.x || rules[b].high.x <= rules[a].low.x ||
                      rules[a].high.y <= rules[b].low.y || rules[b].high.y <= rules[a].low.y)
              << look;
        if (rules[a].high.y > guide.high.y) continue;  // to be scrolled to
        ++drawn;
        EXPECT_GT(test::ink_share(screen, rules[a], theme().colours.accent), 1e-3) << look;
        EXPECT_GT(test::ink_share(screen, rules[a], theme().colours.text), 1e-3) << look;
      }
      EXPECT_GE(drawn, 1) << look;
      EXPECT_TRUE(scale > 100 || drawn == 6) << look << " is scrolled though there is room";
      test::click("Close", [&] { draw_frame(s); });
      draw_frame(s);
    }
}

TEST_F(Panels, AWorstMomentOfTheCardLeadsToItsFrame) {
  const Snapshot s = snapshot_of(Step::train, Look::done);
  settled(s);
  // It is the last of the card: scrolled to.
  InjectedInput over = test::mouse_over("Parts of this avatar, and why");
  for (const float wheel : {0.f, -20.f, 0.f, 0.f}) {
    over.wheel = wheel;
    TestWindow::get().window->inject(over);
    (void)draw_frame(s);
  }
  Requests asked;
  test::click("Look at 0.1\u20130.4 s", [&] {
    if (const Requests requests = draw_frame(s); requests.project.face_frame) asked = requests;
  });
  EXPECT_EQ(asked.show, Step::face);
  ASSERT_TRUE(asked.project.face_frame.has_value());
  EXPECT_NEAR(*asked.project.face_frame / 30.0, 0.25, 0.02);
}

TEST_F(Panels, ATrainingFrameIsLeftOutByAClickAndAHeldOutOneCannotBe) {
  Snapshot s = snapshot_of(Step::face, Look::done);
  settled(s);
  std::optional<std::vector<int>> left_out;
  const auto watch = [&] {
    if (const Requests requests = draw_frame(s); requests.project.left_out)
      left_out = requests.project.left_out;
  };
  test::click("Leave it out of the training", watch);
  EXPECT_EQ(left_out, std::vector<int>{8});
  auto contents = std::make_shared<ProjectContents>(*s.project.contents);
  contents->project.options.train.left_out = {8, 12};
  s.project.contents = contents;
  settled(s);
  keep_shot("face_left_out");
  test::click("Use it again", watch);
  EXPECT_EQ(left_out, std::vector<int>{12});
  s.project.face_picture = frame_picture(22);  // held out
  settled(s);
  EXPECT_FALSE(noted_widgets().contains("Leave it out of the training"));
  EXPECT_FALSE(noted_widgets().contains("Use it again"));
}

TEST_F(Panels, AFrameIsNamedAsTheRestingFaceAndTheChoiceIsTakenBack) {
  Snapshot s = snapshot_of(Step::face, Look::done);
  auto contents = std::make_shared<ProjectContents>(*s.project.contents);
  auto track = std::make_shared<Track>(*contents->track);
  track->rest = {{0, 1, 2, 6}, false, 1, "The calmest of 20 frames with a closed mouth.", ""};
  contents->track = track;
  s.project.contents = contents;
  settled(s);
  keep_shot("face_rest");
  EXPECT_FALSE(noted_widgets().contains("Choose it again by itself"));
  std::optional<std::vector<int>> rest;
  const auto watch = [&] {
    if (const Requests requests = draw_frame(s); requests.project.rest_frames)
      rest = requests.project.rest_frames;
  };
  test::click("This is my resting face", watch);
  EXPECT_EQ(rest, std::vector<int>{8});
  contents = std::make_shared<ProjectContents>(*s.project.contents);
  contents->project.options.fit.rest_frames = {8};
  s.project.contents = contents;
  settled(s);
  EXPECT_FALSE(noted_widgets().contains("This is my resting face"));
  test::click("Choose it again by itself", watch);
  EXPECT_EQ(rest, std::vector<int>{});
  s.project.face_picture = frame_picture(22);  // held out
  settled(s);
  EXPECT_FALSE(noted_widgets().contains("This is my resting face"));
}

TEST_F(Panels, APlanThatWillNotFitOffersASmallerOne) {
  Snapshot s = snapshot_of(Step::film, Look::done);
  auto contents = std::make_shared<ProjectContents>(*s.project.contents);
  contents->current.fill(false);
  BuildForecast forecast;
  forecast.frames = 1800, forecast.disk = 4'200'000'000, forecast.memory = 9'100'000'000;
  forecast.seconds = {60, 40, 380, 70, 300};
  forecast.seconds_if_moving = 900;
  contents->plan = {
      forecast, forecast.total_seconds(),
      Error{ErrorCode::no_space, "The project will take about 4.2 GB more of the disk, and 3.0 GB are free.",
            "Free some of the disk, make smaller pictures, or use a shorter clip.", ""},
      512};
  s.project.contents = contents;
  s.situation.finished = false;
  s.steps = view_steps(s.project.contents.get(), false, {}, {}, {});
  settled(s);
  keep_shot("plan_too_large");
  std::optional<int> size;
  test::click("Make pictures of 512 px instead", [&] {
    if (const Requests requests = draw_frame(s); requests.project.picture_size)
      size = requests.project.picture_size;
  });
  EXPECT_EQ(size, 512);
}

TEST_F(Panels, FurtherClipsAreListedAddedAndTakenOut) {
  Snapshot s = snapshot_of(Step::film, Look::done);
  auto contents = std::make_shared<ProjectContents>(*s.project.contents);
  contents->further = {
      {2, "ada-at-the-window-with-a-very-long-name-from-her-phone.mp4", std::nullopt, StageState::done,
       "Built-in head; 180 frames good, 4 weak, 0 lost; landmarks 1.26 px off on average."},
      {3, "wall.mp4", std::nullopt, StageState::failed, "A face was found in 0 of 180 frames."},
      {4, "new.mp4", std::nullopt, StageState::to_do, ""}};
  s.project.contents = contents;
  for (const int percent : {100, 200}) {
    s.settings.scale_percent = percent;
    settled(s);
    keep_shot(fmt::format("further_clips_{}", percent));
    const Rectangle button = noted_widgets().at("Take out");
    EXPECT_LT(button.high.x, ImGui::GetIO().DisplaySize.x) << percent;
  }
  s.settings.scale_percent = 100;
  settled(s);
  std::vector<Command> asked;
  std::optional<int> taken;
  const auto watch = [&] {
    const Requests requests = draw_frame(s);
    asked.insert(asked.end(), requests.commands.begin(), requests.commands.end());
    if (requests.project.remove_clip) taken = requests.project.remove_clip;
  };
  test::click("Take out", watch);
  EXPECT_EQ(taken, 4);
  test::click("Add a clip of this person...", watch);
  EXPECT_EQ(asked, std::vector{Command::add_clip});
}

TEST_F(Panels, ADeletionIsAskedForAndAnswered) {
  const Snapshot s = snapshot_of(Step::film, Look::done);
  std::optional<bool> answer;
  const auto watch = [&] {
    if (const Requests requests = draw_frame(s); requests.project.delete_person)
      answer = requests.project.delete_person;
  };
  Shell& shell = *TestWindow::get().shell;
  for (const auto& [button, expected] :
       std::vector<std::pair<const char*, std::optional<bool>>>{{"Keep the person", std::nullopt},
                                                                {"Delete, but keep the exports", true},
                                                                {"Delete all, exports too", false}}) {
    answer.reset();
    shell.ask(Question::delete_person);
    settled(s);
    keep_shot("question_delete");
    test::click(button, watch);
    EXPECT_EQ(answer, expected) << button;
    draw_frame(s);
    EXPECT_FALSE(noted_widgets().contains("Keep the person"));
  }
}

TEST_F(Panels, ADamagedProjectIsRepairedOrDeletedByAButton) {
  Snapshot s;
  const std::filesystem::path folder = "/home/me/Likeness/Ada.likeness";
  s.settings.recent = {folder};
  s.project.damaged = DamagedProject{.folder = folder};
  s.error = Error{ErrorCode::bad_input, (folder / "project.json").string() + " cannot be read: cut off.",
                  "Put a good copy of this file back, or let it be made again from the rest.", ""};
  s.situation = {.damaged = true, .repairable = true};
  settled(s);
  keep_shot("damaged");
  for (const Command command : {Command::repair_project, Command::delete_person}) {
    Requests asked;
    test::click(command_info(command).words.data(), [&] {
      const Requests requests = draw_frame(s);
      asked.commands.insert(asked.commands.end(), requests.commands.begin(), requests.commands.end());
    });
    EXPECT_EQ(asked.commands, std::vector{command});
  }
  // Which film is the clip is not known: the question says what is kept.
  Shell& shell = *TestWindow::get().shell;
  shell.ask(Question::delete_person);
  settled(s);
  keep_shot("question_delete_damaged");
  std::optional<bool> answer;
  test::click("Delete all, exports too", [&] {
    if (const Requests requests = draw_frame(s); requests.project.delete_person)
      answer = requests.project.delete_person;
  });
  EXPECT_EQ(answer, false);
  // One of a newer Likeness can only be deleted.
  s.situation.repairable = false;
  settled(s);
  EXPECT_FALSE(noted_widgets().contains(command_info(Command::repair_project).words.data()));
  EXPECT_TRUE(noted_widgets().contains(command_info(Command::delete_person).words.data()));
}

TEST_F(Panels, AClipThatMovedIsLookedForByAButton) {
  Snapshot s = snapshot_of(Step::film, Look::failed);
  s.error.reset();
  s.situation.clip_missing = true;
  settled(s);
  keep_shot("clip_missing");
  Requests asked;
  test::click(command_info(Command::find_clip).words.data(), [&] {
    const Requests requests = draw_frame(s);
    asked.commands.insert(asked.commands.end(), requests.commands.begin(), requests.commands.end());
  });
  EXPECT_EQ(asked.commands, std::vector{Command::find_clip});
}

TEST_F(Panels, TheExportPanelAsksForWhatItsKindNeeds) {
  for (const ExportKind kind : kExportKinds) {
    Snapshot s = snapshot_of(Step::export_out, Look::done);
    s.exports.choice.kind = kind;
    s.exports.choice.moving = kind == ExportKind::mesh;
    s.exports.choice.ground = kind == ExportKind::still    ? ExportGround::colour
                              : kind == ExportKind::driven ? ExportGround::picture
                                                           : ExportGround::light;
    settled(s);
    keep_shot(fmt::format("export_{}", int(kind)));
    EXPECT_EQ(noted_widgets().contains("Choose a clip..."), kind == ExportKind::driven);
    EXPECT_EQ(noted_widgets().contains("Choose a picture..."), kind == ExportKind::driven);
    EXPECT_EQ(noted_widgets().contains("##colour"), kind == ExportKind::still);
    EXPECT_FALSE(noted_widgets().contains("##orbit angle")) << "as far as it holds";
    EXPECT_EQ(noted_widgets().contains("My own"), kind == ExportKind::orbit);
    EXPECT_EQ(noted_widgets().contains("Choose a performance..."),
              kind == ExportKind::performance || kind == ExportKind::mesh);
    EXPECT_EQ(noted_widgets().contains("glTF (.glb)"), kind == ExportKind::mesh);
  }
}

TEST_F(Panels, WhatIsMissingIsSaidBeforeItIsExported) {
  Snapshot s = snapshot_of(Step::export_out, Look::done);
  const auto asked = [&](ExportKind kind) {
    s.exports.choice.kind = kind;
    settled(s);
    bool any = false;
    const Command command = kind == ExportKind::driven ? Command::export_driven : Command::export_performance;
    test::click(command_info(command).words.data(), [&] { any |= !draw_frame(s).commands.empty(); });
    return any;
  };
  EXPECT_FALSE(asked(ExportKind::driven));
  keep_shot("export_missing");
  EXPECT_FALSE(asked(ExportKind::performance));
  s.exports.choice.clip = "/home/me/Videos/friend.mp4";
  s.exports.choice.performance = "/home/me/Likeness/hello.json";
  EXPECT_TRUE(asked(ExportKind::driven));
  EXPECT_TRUE(asked(ExportKind::performance));
}

TEST_F(Panels, ExportsAreStoppedTriedAgainAndTakenOffTheList) {
  Snapshot s = snapshot_of(Step::export_out, Look::running);
  s.project.contents = ball_contents();
  s.exports.items = {{7, "a.mp4", {}}};
  settled(s);
  Requests last;
  const auto watch = [&] {
    const Requests requests = draw_frame(s);
    if (requests.exports.stop || requests.exports.retry || requests.exports.forget) last = requests;
  };
  test::click("Stop", watch);
  EXPECT_EQ(last.exports.stop, 7);
  s.exports.items[0].status.state = JobState::failed;
  settled(s);
  test::click("Try again", watch);
  EXPECT_EQ(last.exports.retry, 7);
  test::click("Remove from the list", watch);
  EXPECT_EQ(last.exports.forget, 7);
  std::vector<Command> commands;
  test::click("Show the exports' folder", [&] {
    for (const Command command : draw_frame(s).commands) commands.push_back(command);
  });
  EXPECT_EQ(commands, std::vector{Command::show_exports});
}

}  // namespace
}  // namespace likeness::ui
