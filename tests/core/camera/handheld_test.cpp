// Claims about solving a hand-held camera, on walls filmed with known turns, zooms and shifts.
#include "core/camera/handheld.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "core/camera/align_view.h"
#include "core/camera/camera_kind.h"
#include "core/camera/grey_pyramid.h"
#include "core/camera/view_pairs.h"
#include "core/video/decode.h"
#include "core/video/encode.h"
#include "tests/core/camera/swaying_wall.h"

namespace likeness {
namespace {

HandheldSolve solved(const SwayingClip& clip, const std::vector<HandheldFrame>& frames) {
  auto solve = solve_handheld(frames, clip.lens, {}, {}, {});
  if (!solve) throw std::runtime_error(solve.error().what);
  return std::move(*solve);
}
HandheldSolve solved(const SwayingClip& clip) { return solved(clip, clip.frames()); }

HandheldView gentle(int frame) { return hand_sway(frame / 10.0, 3, 0.04); }

TEST(HandheldView, SlopesAreFiniteDifferences) {
  const Intrinsics lens = sway_lens();
  Intrinsics mosaic = lens;
  mosaic.cx += 31, mosaic.cy += 17;
  const HandheldView view{turn_from_vector({0.21, -0.34, 0.12}), 0.15, {4, -3}};
  const auto value = [](double u, double v) {
    return std::sin(0.07 * u) * std::cos(0.05 * v) + 0.002 * u * v;
  };
  for (const Vec2d& at : {Vec2d(12.5, 20.5), Vec2d(120, 68), Vec2d(231, 9), Vec2d(200.5, 130)}) {
    const auto read = [&](const HandheldView& from) {
      const auto place = view_place(view_map<double>(mosaic, lens, from), at.x(), at.y());
      return value(place.u, place.v);
    };
    const auto map = view_map<double>(mosaic, lens, view);
    const auto place = view_place(map, at.x(), at.y());
    const double gu = 0.07 * std::cos(0.07 * place.u) * std::cos(0.05 * place.v) + 0.002 * place.v,
                 gv = -0.05 * std::sin(0.07 * place.u) * std::sin(0.05 * place.v) + 0.002 * place.u;
    double slopes[kViewParameters];
    view_slopes(map, at.x(), at.y(), gu, gv, slopes);
    for (int i = 0; i < kViewParameters; ++i) {
      const double h = i < 4 ? 1e-6 : 1e-4;
      ViewStep step = ViewStep::Zero();
      step[i] = h;
      const double difference = (read(stepped(view, step)) - read(stepped(view, -step))) / (2 * h);
      EXPECT_NEAR(slopes[i], difference, 1e-6 * std::max(1.0, std::abs(difference))) << "parameter " << i;
    }
  }
}

TEST(HandheldView, AStepLeadsFromOneViewToTheOther) {
  const HandheldView from{turn_from_vector({0.1, 0.2, -0.3}), 0.1, {3, 4}},
      to{turn_from_vector({-0.2, 0.1, 0.05}), -0.2, {-1, 2}};
  const HandheldView there = stepped(from, view_step(from, to));
  EXPECT_LT((there.turn - to.turn).norm(), 1e-12);
  EXPECT_NEAR(there.log_zoom, to.log_zoom, 1e-12);
  EXPECT_LT((there.shift - to.shift).norm(), 1e-12);
}

TEST(GreyPyramid, PlacesHalveExactly) {
  Image8 ramp(61, 47, 1);
  for (int y = 0; y < ramp.height; ++y)
    for (int x = 0; x < ramp.width; ++x) *ramp.at(x, y) = std::uint8_t(2 * x + y);
  const GreyPicture half = halved(grey_picture(ramp, nullptr, 0));
  ASSERT_EQ(half.width, 31);
  ASSERT_EQ(half.height, 24);
  for (int y = 1; y < half.height - 2; ++y)
    for (int x = 1; x < half.width - 2;
         ++x)  // the ramp at the place (2x + 1, 2y + 1), whose pixels end there
      EXPECT_NEAR(*half.at(x, y), 2 * (2 * x + 0.5) + 2 * y + 0.5, 1e-4);
}

TEST(GreyPyramid, HolesSpreadNothingIntoThePicture) {
  Image8 grey(64, 48, 1, 100), person(64, 48, 1);
  for (int y = 10; y < 30; ++y)
    for (int x = 20; x < 40; ++x) *person.at(x, y) = 255, *grey.at(x, y) = 255;
  const auto pyramid = grey_pyramid(grey_picture(grey, &person, 1), 3);
  int known = 0;
  for (const GreyPicture& level : pyramid)
    for (const float value : level.data)
      if (value == value) {
        ++known;
        EXPECT_FLOAT_EQ(value, 100);
      }
  EXPECT_GT(known, 2500);
  EXPECT_NE(*pyramid[2].at(7, 5), *pyramid[2].at(7, 5));  // NaN
}

TEST(GreyPyramid, NoiseIsMeasuredBesideEdges) {
  std::mt19937 random(5);
  std::normal_distribution<double> spread(0, 3);
  Image8 grey(200, 150, 1);
  for (int y = 0; y < grey.height; ++y)
    for (int x = 0; x < grey.width; ++x) {
      const double off = spread(random);
      *grey.at(x, y) = std::uint8_t((x / 25 % 2 ? 60 : 180) + off);
    }
  EXPECT_NEAR(pixel_noise(grey_picture(grey, nullptr, 0)), 3, 0.4);
}

TEST(AlignView, FindsAViewFromAMosaicAndSaysHowSurely) {
  const Intrinsics lens = sway_lens();
  std::mt19937 random(3);
  const int levels = pyramid_levels(lens.width, lens.height);
  ViewTarget target{
      lens,
      grey_pyramid(grey_picture(wall_picture(lens, {}, textured_wall, 1, 0, random), nullptr, 0), levels)};
  const HandheldView truth{turn_from_vector({0.01, -0.02, 0.015}), 0.02, {0, 0}};
  const auto picture = grey_pyramid(
      grey_picture(wall_picture(lens, truth, textured_wall, 0.9, 2, random), nullptr, 2), levels);
  ViewPrior prior;
  prior.shift_px = 1.2, prior.log_zoom = 0.03;
  AlignedView view = align_view(picture, lens, target, {}, prior, levels - 1, 0);
  measure_view(picture, lens, target, prior, view);
  EXPECT_LT(57.3 * rotation_angle(view.view.turn * truth.turn.transpose()), 0.05);
  EXPECT_NEAR(view.view.log_zoom, truth.log_zoom, 0.003);
  EXPECT_NEAR(view.gain, 0.9, 0.02);
  EXPECT_GT(view.inliers, 0.95);
  EXPECT_LT(view.sigma_px, 0.1);
  EXPECT_LT(view.misfit_px, 0.35);  // of a limit of 0.96
  EXPECT_LT(view_badness(picture, lens, target, view, 0), view_badness(picture, lens, target, {}, 0));
}

TEST(Handheld, RecoversTurnsAndZooms) {
  const SwayingClip clip = swaying_clip(sway_lens(), 60, gentle);
  const HandheldSolve solve = solved(clip);
  const SwayErrors errors = sway_errors(clip, solve, all_of(clip));
  EXPECT_LT(errors.turn_deg, 0.1);
  EXPECT_LT(errors.zoom, 0.01);
  EXPECT_LT(errors.place_px, 0.25);
  EXPECT_FALSE(solve.shifts);
  EXPECT_EQ(solve.explained, 1);
  EXPECT_NEAR(solve.zoom_high / solve.zoom_low, std::exp(0.04), 0.005);
  EXPECT_NEAR(solve.noise, 2, 1);
  EXPECT_EQ(judge_camera_kind(solve).explanation, CameraExplanation::handheld)
      << judge_camera_kind(solve).reason;
  EXPECT_GT(solve.extent.width, clip.lens.width + 10);
}

TEST(Handheld, APersonWhomTheMaskMissesInPartMovesNothing) {
  SwayOptions options;
  options.masked = 0.8;
  const SwayingClip clip = swaying_clip(sway_lens(), 50, gentle, options);
  const SwayErrors errors = sway_errors(clip, solved(clip), all_of(clip));
  EXPECT_LT(errors.turn_deg, 0.1);
  EXPECT_LT(errors.zoom, 0.01);
}

TEST(Handheld, NeedsNoCorners) {
  SwayOptions options;
  options.wall = shaded_wall;
  options.exposure = 0.03;
  const SwayingClip clip = swaying_clip(sway_lens(), 50, gentle, options);
  const HandheldSolve solve = solved(clip);
  const SwayErrors errors = sway_errors(clip, solve, all_of(clip));
  EXPECT_LT(errors.turn_deg, 0.1);
  EXPECT_LT(errors.zoom, 0.01);
  EXPECT_EQ(judge_camera_kind(solve).explanation, CameraExplanation::handheld)
      << judge_camera_kind(solve).reason;
}

TEST(Handheld, ABlankWallIsSaidToShowNothing) {
  SwayOptions options;
  options.wall = blank_wall;
  const SwayingClip clip = swaying_clip(sway_lens(), 30, gentle, options);
  const HandheldSolve solve = solved(clip);
  const CameraVerdict verdict = judge_camera_kind(solve);
  EXPECT_EQ(verdict.explanation, CameraExplanation::no_texture) << verdict.reason << solve.evidence;
  EXPECT_THAT(verdict.reason, testing::HasSubstr("texture"));
  EXPECT_LT(solve.motion, 5);  // noise is no motion
}

TEST(Handheld, TextureIsSeenWithoutASolve) {
  EXPECT_EQ(share_with_texture(swaying_clip(sway_lens(), 6, gentle).frames()), 1);
  SwayOptions options;
  options.wall = blank_wall, options.noise = 0;
  EXPECT_EQ(share_with_texture(swaying_clip(sway_lens(), 6, gentle, options).frames()), 0);
  EXPECT_EQ(share_with_texture({}), 0);
}

TEST(Handheld, TurnsTellTheLens) {
  SwayingClip clip = swaying_clip(sway_lens(), 60, [](int frame) { return hand_sway(frame / 10.0, 4); });
  const double truth = clip.lens.fx;
  for (const double assumed : {0.8, 1.25}) {
    Intrinsics lens = clip.lens;
    lens.fx = lens.fy = assumed * truth;
    const auto solve = solve_handheld(clip.frames(), lens, {}, {}, {});
    ASSERT_TRUE(solve.ok());
    EXPECT_NEAR(solve->reference.fx / truth, 1, 0.01);
    EXPECT_GT(solve->focal_sigma, 0);
    EXPECT_FALSE(solve->shifts);
    EXPECT_LT(sway_errors(clip, *solve, all_of(clip)).turn_deg, 0.1);
    // A lens that is known stays.
    HandheldOptions known;
    known.lens_sigma = 0;
    EXPECT_EQ(solve_handheld(clip.frames(), lens, known, {}, {})->reference.fx, lens.fx);
  }
}

TEST(ViewPairs, AreFarApartAndShowTheSame) {
  std::vector<HandheldView> views;
  for (int i = 0; i < 50; ++i) views.push_back({turn_from_vector({0, 0.02 * i, 0}), 0, {0, 0}});
  views[30].log_zoom = 0.5;
  const Intrinsics lens = sway_lens();  // shows 64 degrees
  const auto pairs = distant_pairs(lens, views, 10);
  ASSERT_GE(pairs.size(), 10u);
  for (const ViewPair& pair : pairs) {
    const double turn = rotation_angle(views[pair.first].turn * views[pair.second].turn.transpose());
    EXPECT_GT(turn, 0.25);
    EXPECT_LT(turn, 0.6);
    EXPECT_NE(pair.second, 30u);
  }
  EXPECT_TRUE(distant_pairs(lens, std::vector<HandheldView>(1)).empty());
  EXPECT_TRUE(distant_pairs(lens, {}).empty());
}

TEST(ViewPairs, AreNotLaidOverEachOtherOnceAStopIsRequested) {
  const SwayingClip clip = swaying_clip(sway_lens(), 16, gentle);
  PairPictures pictures;
  pictures.reference = clip.lens;
  pictures.views = clip.truth;
  for (const Image8& grey : clip.greys)
    pictures.pyramids.push_back(grey_pyramid(grey_picture(grey, {}, 0), 3));
  const std::vector<ViewPair> pairs{{0, 8, true}, {2, 12, true}, {4, 15, true}};
  const auto works = [](const PairFits& fits) {
    return std::ranges::count_if(fits.nats, [](double nats) { return nats != 0; });
  };
  EXPECT_EQ(works(fit_pairs(pictures, pairs, {})), 3);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(works(fit_pairs(pictures, pairs, {}, stop.get_token())), 0);
  const PairLens lens = lens_of_pairs(pictures, pairs, 0.25, stop.get_token());
  EXPECT_EQ(lens.focal, 1);
  EXPECT_EQ(lens.sigma, 1);
}

TEST(Handheld, ARestingCameraRests) {
  const SwayingClip clip = swaying_clip(sway_lens(), 40, [](int) { return HandheldView(); });
  const HandheldSolve solve = solved(clip);
  EXPECT_LT(solve.motion, 0.5);
  EXPECT_EQ(judge_camera_kind(solve).explanation, CameraExplanation::resting)
      << judge_camera_kind(solve).reason;
}

TEST(Handheld, ACropThatSlidesIsAShift) {
  // Over a picture filmed from afar: a long lens, whose pictures shift without any change of perspective.
  Intrinsics lens = sway_lens(200, 200);
  const SwayingClip clip = swaying_clip(lens, 50, [](int frame) {
    HandheldView view;
    view.shift = {24 * std::sin(frame * 0.13), 9 * std::cos(frame * 0.09)};
    return view;
  });
  const HandheldSolve solve = solved(clip);
  EXPECT_TRUE(solve.shifts);
  EXPECT_LT(sway_errors(clip, solve, all_of(clip)).place_px, 0.3);
  const auto shift = [&](std::size_t i) { return solve.cameras[i].shift_px.x(); };
  EXPECT_NEAR(shift(12) - shift(36), clip.truth[12].shift.x() - clip.truth[36].shift.x(), 6);
  EXPECT_EQ(judge_camera_kind(solve).explanation, CameraExplanation::handheld)
      << judge_camera_kind(solve).reason;
}

TEST(Handheld, AQuickShakeIsCaught) {
  const SwayingClip clip = swaying_clip(sway_lens(), 40, [](int frame) {
    HandheldView view = hand_sway(frame / 10.0, 1);
    if (frame >= 20) view.turn = turn_from_vector({0.05, 0.26, 0}) * view.turn;  // 50 px at once
    return view;
  });
  const HandheldSolve solve = solved(clip);
  EXPECT_LT(sway_errors(clip, solve, all_of(clip)).turn_deg, 0.1);
  EXPECT_EQ(solve.explained, 1);
}

TEST(Handheld, HeldOutFramesAreFoundAndLeaveNoTrace) {
  const SwayingClip clip = swaying_clip(sway_lens(), 60, gentle);
  auto frames = clip.frames();
  std::vector<int> held;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (i >= 50 || i % 7 == 3) frames[i].held_out = true, held.push_back(int(i));
  const HandheldSolve solve = solved(clip, frames);
  const SwayErrors errors = sway_errors(clip, solve, held);
  EXPECT_LT(errors.turn_deg, 0.1);
  EXPECT_LT(errors.zoom, 0.01);
  // With other pictures in their place nothing of the others changes.
  std::mt19937 random(9);
  const Image8 other = wall_picture(clip.lens, {turn_from_vector({0.3, 0.5, 0.2}), 0.2, {0, 0}},
                                    textured_wall, 0.7, 5, random);
  for (auto& frame : frames)
    if (frame.held_out) frame.grey = &other, frame.person = nullptr;
  const HandheldSolve again = solved(clip, frames);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].held_out) continue;
    EXPECT_EQ(again.cameras[i].rotation, solve.cameras[i].rotation);
    EXPECT_EQ(again.cameras[i].zoom, solve.cameras[i].zoom);
    EXPECT_EQ(again.cameras[i].shift_px, solve.cameras[i].shift_px);
  }
}

TEST(Handheld, ALongSwayDoesNotDrift) {
  const SwayingClip clip =
      swaying_clip(sway_lens(), 300, [](int frame) { return hand_sway(frame / 12.0, 7, 0.03); });
  const HandheldSolve solve = solved(clip);
  const SwayErrors errors = sway_errors(clip, solve, all_of(clip));
  EXPECT_LT(errors.turn_deg, 0.1);
  EXPECT_LT(errors.zoom, 0.01);
}

TEST(Handheld, ParallaxIsNotExplained) {
  SwayingClip clip;
  clip.lens = sway_lens();
  for (int i = 0; i < 40; ++i) {
    const double x = -0.5 + i / 40.0;
    const Image8 rgb = render_room(clip.lens, look_at({x, 0, -1}, {0.2, 0, 1.4}));
    Image8 grey(rgb.width, rgb.height, 1);
    for (std::size_t p = 0; p < grey.data.size(); ++p) grey.data[p] = rgb.data[3 * p + 1];
    clip.greys.push_back(std::move(grey));
  }
  const HandheldSolve solve = solved(clip);
  EXPECT_EQ(judge_camera_kind(solve).explanation, CameraExplanation::unexplained)
      << judge_camera_kind(solve).reason << solve.evidence;
}

TEST(Handheld, SurvivesACodec) {
  // Encoded and decoded again, with blocks and all.
  const SwayingClip clip = swaying_clip(sway_lens(), 40, gentle);
  const auto file =
      std::filesystem::temp_directory_path() / ("likeness_handheld_" + std::to_string(::getpid()) + ".mp4");
  auto writer = VideoWriter::create(file, clip.lens.width, clip.lens.height, {30, 26});
  ASSERT_TRUE(writer.ok());
  for (const Image8& grey : clip.greys) {
    Image8 rgb(grey.width, grey.height, 3);
    for (std::size_t p = 0; p < grey.data.size(); ++p)
      for (std::size_t c = 0; c < 3; ++c) rgb.data[3 * p + c] = grey.data[p];
    ASSERT_TRUE(writer->add(rgb).ok());
  }
  ASSERT_TRUE(writer->finish().ok());
  auto reader = VideoReader::open(file, VideoPixels::luma);
  ASSERT_TRUE(reader.ok());
  SwayingClip coded = clip;
  for (Image8& grey : coded.greys) {
    auto next = reader->next();
    ASSERT_TRUE(next.ok() && next->has_value());
    grey = (*next)->rgb;
  }
  std::filesystem::remove(file);
  const SwayErrors errors = sway_errors(coded, solved(coded), all_of(coded));
  EXPECT_LT(errors.turn_deg, 0.1);
  EXPECT_LT(errors.zoom, 0.01);
}

TEST(Handheld, CamerasComeAtTheSourcesSize) {
  const SwayingClip clip = swaying_clip(sway_lens(), 12, gentle);
  const HandheldSolve solve = solved(clip);
  const Camera camera = handheld_camera(solve, 5, 960, 544);
  EXPECT_EQ(camera.frame, 5);
  EXPECT_EQ(camera.intrinsics.width, 960);
  EXPECT_EQ(camera.intrinsics.height, 544);
  EXPECT_NEAR(camera.intrinsics.fx, 4 * solve.reference.fx * solve.cameras[5].zoom, 1e-9);
  EXPECT_NEAR(camera.intrinsics.cx, 4 * (clip.lens.cx + solve.cameras[5].shift_px.x()), 1e-9);
  EXPECT_EQ(camera.cam_from_world.translation(), Vec3d::Zero());
  EXPECT_LT((camera.cam_from_world.linear() - turn_from_vector(solve.cameras[5].rotation)).norm(), 1e-12);
}

TEST(Handheld, StopsOnRequestAndReportsRisingProgress) {
  const SwayingClip clip = swaying_clip(sway_lens(), 16, gentle);
  std::stop_source before;
  before.request_stop();
  const auto none = solve_handheld(clip.frames(), clip.lens, {}, {}, before.get_token());
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().code, ErrorCode::cancelled);
  std::stop_source midway;
  const Progress stopping([&](const ProgressReport& report) {
    if (report.fraction > 0.3) midway.request_stop();
  });
  const auto half = solve_handheld(clip.frames(), clip.lens, {}, stopping, midway.get_token());
  ASSERT_FALSE(half.ok());
  EXPECT_EQ(half.error().code, ErrorCode::cancelled);
  // Late, too, where frames are held out and pairs are laid over each other.
  std::stop_source late;
  const Progress nearly([&](const ProgressReport& report) {
    if (report.fraction >= 0.9) late.request_stop();
  });
  const auto whole = solve_handheld(clip.frames(), clip.lens, {}, nearly, late.get_token());
  ASSERT_FALSE(whole.ok());
  EXPECT_EQ(whole.error().code, ErrorCode::cancelled);
  double last = 0;
  const Progress rising([&](const ProgressReport& report) {
    EXPECT_GE(report.fraction, last);
    last = report.fraction;
  });
  ASSERT_TRUE(solve_handheld(clip.frames(), clip.lens, {}, rising, {}).ok());
  EXPECT_EQ(last, 1);
}

TEST(Handheld, RefusesWhatHasNoBackground) {
  SwayingClip clip = swaying_clip(sway_lens(), 4, gentle);
  for (Image8& mask : clip.persons) mask = Image8(mask.width, mask.height, 1, 255);
  const auto hidden = solve_handheld(clip.frames(), clip.lens, {}, {}, {});
  ASSERT_FALSE(hidden.ok());
  EXPECT_EQ(hidden.error().code, ErrorCode::bad_input);
  EXPECT_FALSE(solve_handheld({}, clip.lens, {}, {}, {}).ok());
  clip.greys[2] = Image8(100, 50, 1);
  EXPECT_FALSE(solve_handheld(clip.frames(), clip.lens, {}, {}, {}).ok());
}

TEST(CameraKind, EachReasonNamesItsFiguresAndLimits) {
  HandheldSolve solve;
  solve.reference = sway_lens();
  solve.explained = 1, solve.motion = 40, solve.judged = 0.9;
  EXPECT_EQ(judge_camera_kind(solve).explanation, CameraExplanation::handheld);
  solve.motion = 300;  // the person stays in the picture
  EXPECT_EQ(judge_camera_kind(solve).explanation, CameraExplanation::unexplained);
  EXPECT_THAT(judge_camera_kind(solve).reason, testing::HasSubstr("300"));
  solve.motion = 40, solve.misfitting = 0.8, solve.misfit_px = 1;
  EXPECT_EQ(judge_camera_kind(solve).explanation, CameraExplanation::unexplained);
  EXPECT_THAT(judge_camera_kind(solve).reason, testing::HasSubstr("80 %"));
  solve.motion = 1;  // people who walk by do not move a tripod
  EXPECT_EQ(judge_camera_kind(solve).explanation, CameraExplanation::resting);
  solve.explained = 0.7;
  EXPECT_EQ(judge_camera_kind(solve).explanation, CameraExplanation::unexplained);
  EXPECT_THAT(judge_camera_kind(solve).reason, testing::HasSubstr("70 %"));
  solve.judged = 0.4;
  EXPECT_EQ(judge_camera_kind(solve).explanation, CameraExplanation::no_texture);
  EXPECT_THAT(judge_camera_kind(solve).reason, testing::HasSubstr("40 %"));
}

}  // namespace
}  // namespace likeness
