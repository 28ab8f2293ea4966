// Claims about the whole matte stage on a small made scene: a textured wall and a person whose outline is
// known.
#include "core/matte/matte.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <utility>

#include "core/base/files.h"
#include "core/image/files.h"
#include "core/matte/plate_file.h"
#include "tests/core/matte/made_scene.h"
#include "tests/support/onnx_bytes.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;
using namespace test;

TEST(MatteClip, StaticCameraGivesAlphaAndPlateCloseToTheTruth) {
  const Scene scene("static");
  std::mutex mutex;
  double fraction = 0;
  bool rising = true;
  const auto result = scene.matte(Progress([&](const ProgressReport& report) {
    const std::lock_guard lock(mutex);
    rising = rising && report.fraction >= fraction;
    fraction = report.fraction;
  }));
  ASSERT_TRUE(result.ok()) << result.error().what;
  EXPECT_TRUE(rising);
  EXPECT_DOUBLE_EQ(fraction, 1);
  EXPECT_TRUE(result->has_plate);
  EXPECT_EQ(int(result->plate_frames.size()), kFrames);
  for (int frame = 0; frame < kFrames; ++frame) EXPECT_GT(scene.overlap(frame), 0.95) << frame;

  const auto plate = read_image(scene.folder / "plate.png");
  ASSERT_TRUE(plate.ok());
  const auto known = read_image(scene.folder / "plate_known.png");
  ASSERT_TRUE(known.ok());
  EXPECT_EQ(known->channels, 1);
  // Where the person never leaves is flagged, and the rest adds up to the coverage.
  EXPECT_EQ(*known->at(kSize / 2, kSize - 6), 0);
  EXPECT_NEAR(double(std::count(known->data.begin(), known->data.end(), 255)) / (kSize * kSize),
              result->plate_coverage, 1e-9);
  double sum = 0;
  int seen = 0, free_pixels = 0;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      int free_frames = 0;
      for (int frame = 0; frame < kHeldFrom; ++frame)
        free_frames += *scene.alpha[std::size_t(frame)].at(x, y) == 0;
      free_pixels += free_frames > 2;
      if (free_frames < 10) continue;
      for (int c = 0; c < 3; ++c) sum += std::abs(double(plate->at(x, y)[c]) - scene.wall[0].at(x, y)[c]) / 3;
      ++seen;
    }
  EXPECT_LT(sum / seen, 1.5);
  EXPECT_NEAR(result->plate_coverage, double(free_pixels) / (kSize * kSize), 0.08);
}

TEST(MatteClip, NothingIsKnownOfWhatWasNotFilmed) {
  Scene scene("outside");
  scene.capture.inside = {24, 0, 84, kSize};
  for (const CaptureFrame& frame : scene.capture.frames) {
    auto picture = read_image(scene.folder / frame_name(frame.frame));
    ASSERT_TRUE(picture);
    fill_outside(*picture, scene.capture.inside, kUnfilmed);
    ASSERT_TRUE(write_image(scene.folder / frame_name(frame.frame), *picture).ok());
    fill_outside(scene.alpha[std::size_t(frame.frame)], scene.capture.inside, 0);
  }
  const auto result = scene.matte();
  ASSERT_TRUE(result.ok()) << result.error().what;
  for (int frame = 0; frame < kFrames; ++frame) EXPECT_GT(scene.overlap(frame), 0.94) << frame;
  const auto known = read_image(scene.folder / "plate_known.png");
  ASSERT_TRUE(known.ok());
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      if (!scene.capture.inside.contains(x, y)) {
        ASSERT_EQ(*known->at(x, y), 0) << x << " " << y;
      }
  EXPECT_GT(std::count(known->data.begin(), known->data.end(), 255), kSize * kSize / 6);
}

TEST(MatteClip, WhatThePersonAlwaysCoversIsSolid) {
  const Scene scene("solid");
  ASSERT_TRUE(scene.matte().ok());
  for (int frame = 0; frame < kFrames; ++frame) {
    const auto mask = read_image(scene.folder / "masks" / frame_name(frame).filename());
    ASSERT_TRUE(mask.ok());
    for (int y = kSize - 12; y < kSize; ++y)
      for (int x = kSize / 2 - 14; x < kSize / 2 + 14; ++x) EXPECT_EQ(*mask->at(x, y), 255) << frame;
  }
}

TEST(MatteClip, HeldOutPicturesChangeNeitherPlateNorTrainingMasks) {
  Scene scene("leak");
  ASSERT_TRUE(scene.matte().ok());
  const std::string plate = bytes_of(scene.folder / "plate.png"),
                    info = bytes_of(scene.folder / "plate.json");
  std::vector<std::string> masks;
  for (int frame = 0; frame < kHeldFrom; ++frame)
    masks.push_back(bytes_of(scene.folder / "masks" / frame_name(frame).filename()));
  for (int frame = kHeldFrom; frame < kFrames; ++frame) {
    Image8 noise(kSize, kSize, 3);
    for (std::size_t i = 0; i < noise.data.size(); ++i)
      noise.data[i] = std::uint8_t(i * 7919 + std::size_t(frame));
    ASSERT_TRUE(write_image(scene.folder / frame_name(frame), noise).ok());
  }
  ASSERT_TRUE(scene.matte().ok());
  EXPECT_EQ(bytes_of(scene.folder / "plate.png"), plate);
  EXPECT_EQ(bytes_of(scene.folder / "plate.json"), info);
  for (int frame = 0; frame < kHeldFrom; ++frame)
    EXPECT_EQ(bytes_of(scene.folder / "masks" / frame_name(frame).filename()), masks[std::size_t(frame)])
        << frame;
}

// The learner's room is the mean of its training pictures' colours, so that it depends on all of them.
TEST(MatteClip, HeldOutPicturesChangeNeitherARoomNorThePlateItCompletes) {
  const Scene scene("leak_room", Moves::at_first);
  std::vector<double> learnt;
  const LearnRoom learn = [&](const std::vector<RoughMatte>& mattes, RoomPass, const Progress&,
                              std::stop_token) -> Result<RoomBehind> {
    double sum = 0, count = 0;
    for (const RoughMatte& matte : mattes) {
      const auto picture = read_image(scene.folder / frame_name(matte.frame));
      if (!picture) return picture.error();
      for (std::size_t i = 0; i < matte.alpha.data.size(); ++i)
        if (matte.alpha.data[i] == 0) sum += picture->data[3 * i], ++count;
    }
    learnt.push_back(sum / count);
    return RoomBehind([&, colour = std::uint8_t(sum / count)](int frame) {
      Image8 room = scene.wall[std::size_t(std::min(frame, kHeldFrom - 1))];
      for (std::uint8_t& value : room.data) value = std::uint8_t((3 * value + colour) / 4);
      return room;
    });
  };
  ASSERT_TRUE(scene.matte({}, {}, {}, learn).ok());
  const auto shared = [&] {
    std::string bytes = bytes_of(scene.folder / "plate.png") + bytes_of(scene.folder / "plate_known.png");
    for (int frame = 0; frame < kHeldFrom; ++frame)
      bytes += bytes_of(scene.folder / "masks" / frame_name(frame).filename());
    return bytes;
  };
  const std::string before = shared();
  for (int frame = kHeldFrom; frame < kFrames; ++frame)
    ASSERT_TRUE(write_image(scene.folder / frame_name(frame), Image8(kSize, kSize, 3, 200)).ok());
  ASSERT_TRUE(scene.matte({}, {}, {}, learn).ok());
  EXPECT_TRUE(shared() == before);
  ASSERT_EQ(learnt.size(), 4u);
  EXPECT_EQ(learnt[0], learnt[2]);
  EXPECT_EQ(learnt[1], learnt[3]);
}

TEST(MatteClip, AMovingCameraGetsMattesButNoPlate) {
  const Scene scene("moving", Moves::always);
  const auto result = scene.matte();
  ASSERT_TRUE(result.ok()) << result.error().what;
  EXPECT_FALSE(result->has_plate);
  EXPECT_TRUE(result->plate_frames.empty());
  EXPECT_FALSE(fs::exists(scene.folder / "plate.png"));
  double sum = 0;
  for (int frame = 0; frame < kFrames; ++frame) sum += scene.overlap(frame) / kFrames;
  EXPECT_GT(sum, 0.9);
}

TEST(MatteClip, TheRoomBehindAMovingCameraSharpensItsMattes) {
  const Scene scene("room", Moves::always);
  const auto error = [&] {
    double sum = 0;
    for (int frame = 0; frame < kFrames; ++frame) sum += (1 - scene.overlap(frame)) / kFrames;
    return sum;
  };
  ASSERT_TRUE(scene.matte().ok());
  const double without = error();
  // A model of the room that is right but for a constant error.
  std::set<int> learnt_from;
  std::map<RoomPass, double> person;  // share of the pictures that is left out
  const LearnRoom learn = [&](const std::vector<RoughMatte>& mattes, RoomPass pass, const Progress&,
                              std::stop_token) -> Result<RoomBehind> {
    for (const RoughMatte& matte : mattes) {
      learnt_from.insert(matte.frame);
      const auto out = std::ranges::count_if(matte.alpha.data, [](auto a) { return a > 0; });
      person[pass] += double(out) / double(matte.alpha.data.size() * mattes.size());
    }
    return RoomBehind([&](int frame) {
      Image8 room = scene.wall[std::size_t(frame)];
      for (std::uint8_t& value : room.data) value = std::uint8_t(std::min(255, value + 8));
      return room;
    });
  };
  const auto result = scene.matte({}, {}, {}, learn);
  ASSERT_TRUE(result.ok()) << result.error().what;
  EXPECT_FALSE(result->has_plate);
  EXPECT_LT(error(), 0.7 * without);
  EXPECT_EQ(learnt_from.size(), std::size_t(kHeldFrom));  // every training frame, no held-out one
  EXPECT_LT(*learnt_from.rbegin(), kHeldFrom);
  ASSERT_EQ(person.size(), 2u);  // generously, then from the cuts
  EXPECT_LT(person[RoomPass::last], 0.9 * person[RoomPass::first]);

  const Scene resting("room_resting");
  learnt_from.clear();
  ASSERT_TRUE(resting.matte({}, {}, {}, learn).ok());
  EXPECT_TRUE(learnt_from.empty());
}

TEST(MatteClip, FailsWhenTheRoomCannotBeLearnt) {
  const Scene scene("no_room", Moves::always);
  const auto result =
      scene.matte({}, {}, {}, [](const auto&, RoomPass, const auto&, auto) -> Result<RoomBehind> {
        return Error{ErrorCode::no_space, "The disk is full.", "Free some space.", ""};
      });
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::no_space);
  EXPECT_FALSE(fs::exists(scene.folder / "masks"));
}

TEST(MatteClip, FollowsTheNetworkWhereItIsConfident) {
  const Scene scene("network", Moves::always);
  const fs::path network = scene.folder / "net.onnx";
  const std::string format = R"({"size_px": 128, "mean": [0, 0, 0], "scale": 1, "activation": "sigmoid"})";
  ASSERT_TRUE(write_text(scene.folder / "net.json", format));
  const auto matted_by = [&](const std::vector<float>& weights, float bias) {
    EXPECT_TRUE(write_text(network, tiny_network(kSize, weights, {bias})));
    const auto result = scene.matte({}, {}, network);
    EXPECT_TRUE(result.ok()) << (result ? "" : result.error().what);
    std::size_t person = 0;
    for (int frame = 0; frame < kFrames; ++frame) {
      const auto mask = read_image(scene.folder / "masks" / frame_name(frame).filename());
      EXPECT_TRUE(mask.ok());
      if (mask) person += std::size_t(std::ranges::count_if(mask->data, [](auto a) { return a > 127; }));
    }
    return person;
  };
  // Skin and cloth are redder than green, the wall never is.
  const std::size_t whole = matted_by({0.1f, -0.1f, 0}, -2.5f);
  double overlap = 0;
  for (int frame = 0; frame < kFrames; ++frame) overlap += scene.overlap(frame) / kFrames;
  EXPECT_GT(overlap, 0.97);
  // Only skin is bright red: by this network the cloth is no part of the person.
  EXPECT_LT(matted_by({0.1f, 0, 0}, -19), whole * 95 / 100);

  const auto absent = scene.matte({}, {}, scene.folder / "none.onnx");
  ASSERT_FALSE(absent.ok());
  EXPECT_EQ(absent.error().code, ErrorCode::not_found);
}

// By which the share of person is how much redder than green a pixel is: skin and cloth are, the wall never
// is.
std::shared_ptr<const PersonNetwork> red_network(const Scene& scene) {
  const fs::path file = scene.folder / "person.onnx";
  EXPECT_TRUE(write_text(file, tiny_network(256, {20, -20, 0}, {-1})).ok());
  auto network = PersonNetwork::load(file);
  EXPECT_TRUE(network.ok()) << (network ? "" : network.error().what);
  return std::make_shared<const PersonNetwork>(std::move(*network));
}

// An arm in every picture, at rest on something beside the person, farther out than any shoulder.
void lay_down_an_arm(Scene& scene) {
  for (int frame = 0; frame < kFrames; ++frame) {
    auto picture = read_image(scene.folder / frame_name(frame));
    ASSERT_TRUE(picture.ok());
    for (int y = kSize - 18; y < kSize; ++y)
      for (int x = 0; x < kSize / 2; ++x) {
        const std::uint8_t cloth[] = {155, 36, 46};
        std::copy_n(cloth, 3, picture->at(x, y));
        *scene.alpha[std::size_t(frame)].at(x, y) = 255;
      }
    ASSERT_TRUE(write_image(scene.folder / frame_name(frame), *picture).ok());
  }
}

TEST(MatteClip, WhatRestsThroughoutIsThePersonsWhereThePersonNetworkSaysSo) {
  Scene scene("arm");
  lay_down_an_arm(scene);
  const auto arm = [&] {
    double least = 255;
    for (int frame = 0; frame < kFrames; ++frame) {
      const auto mask = read_image(scene.folder / "masks" / frame_name(frame).filename());
      EXPECT_TRUE(mask.ok());
      for (int x = 2; x < 20 && mask; ++x) least = std::min(least, double(*mask->at(x, kSize - 6)));
    }
    return least;
  };
  const auto result = scene.matte({}, {}, {}, {}, {}, red_network(scene));
  ASSERT_TRUE(result.ok()) << result.error().what;
  EXPECT_EQ(arm(), 255);
  for (int frame = 0; frame < kFrames; ++frame) EXPECT_GT(scene.overlap(frame), 0.97) << frame;
  const auto known = read_image(scene.folder / "plate_known.png");
  ASSERT_TRUE(known.ok());
  EXPECT_EQ(*known->at(10, kSize - 6), 0);  // nobody saw what is behind the arm
}

TEST(MatteClip, TheMaskThatAClipBringsIsItsMatte) {
  Scene scene("own");
  for (int frame = 0; frame < kFrames; ++frame) {
    Image8& own = scene.alpha[std::size_t(frame)];  // a hand that nobody would look for there
    for (int y = 4; y < 20; ++y)
      for (int x = 4; x < 20; ++x) *own.at(x, y) = std::uint8_t(80 + frame);
    ASSERT_TRUE(write_image(scene.folder / alpha_name(frame), own).ok());
  }
  const auto result = scene.matte();
  ASSERT_TRUE(result.ok()) << result.error().what;
  EXPECT_EQ(result->report.prior, MaskPrior::clip);
  for (int frame = 0; frame < kFrames; ++frame) {
    const auto mask = read_image(scene.folder / "masks" / frame_name(frame).filename());
    ASSERT_TRUE(mask.ok());
    EXPECT_EQ(mask->data, scene.alpha[std::size_t(frame)].data) << frame;
  }
}

TEST(MatteClip, AMovingCameraIsMattedByThePersonNetworkToo) {
  const Scene scene("moving_person", Moves::always);
  const auto result = scene.matte({}, {}, {}, {}, {}, red_network(scene));
  ASSERT_TRUE(result.ok()) << result.error().what;
  EXPECT_EQ(result->report.prior, MaskPrior::person_network);
  EXPECT_GT(result->report.prior_frames, kFrames * 9 / 10);
  for (int frame = 0; frame < kFrames; ++frame) EXPECT_GT(scene.overlap(frame), 0.97) << frame;
}

TEST(MatteClip, HeldOutPicturesReachNoTrainingMaskThroughThePersonNetwork) {
  const Scene scene("leak_person");
  const auto network = red_network(scene);
  const auto shared = [&] {
    EXPECT_TRUE(scene.matte({}, {}, {}, {}, {}, network).ok());
    std::string bytes = bytes_of(scene.folder / "plate.png");
    for (int frame = 0; frame < kHeldFrom; ++frame)
      bytes += bytes_of(scene.folder / "masks" / frame_name(frame).filename());
    return bytes;
  };
  const std::string before = shared();
  for (int frame = kHeldFrom; frame < kFrames; ++frame)
    ASSERT_TRUE(write_image(scene.folder / frame_name(frame), Image8(kSize, kSize, 3, 200)).ok());
  EXPECT_TRUE(shared() == before);
}

TEST(MatteClip, AMattingNetworkIsHeardInsteadOfThePersonNetwork) {
  const Scene scene("both_networks", Moves::always);
  const fs::path network = scene.folder / "net.onnx";
  ASSERT_TRUE(write_text(scene.folder / "net.json",
                         R"({"size_px": 128, "mean": [0, 0, 0], "scale": 1, "activation": "sigmoid"})"));
  ASSERT_TRUE(write_text(network, tiny_network(kSize, {0.1f, -0.1f, 0}, {-2.5f})));
  const auto masks = [&](std::shared_ptr<const PersonNetwork> person) {
    EXPECT_TRUE(scene.matte({}, {}, network, {}, {}, std::move(person)).ok());
    std::string bytes;
    for (int frame = 0; frame < kFrames; ++frame)
      bytes += bytes_of(scene.folder / "masks" / frame_name(frame).filename());
    return bytes;
  };
  const std::string alone = masks({});
  EXPECT_TRUE(masks(red_network(scene)) == alone);
}

// Painted strokes are harder than the network.
TEST(MatteClip, StrokesOutrankThePersonNetwork) {
  Scene scene("strokes_person");
  lay_down_an_arm(scene);
  FrameStrokes strokes;
  Stroke background;
  background.mark = StrokeMark::background;
  background.radius = 4;
  background.points = {{5, kSize - 8}, {25, kSize - 8}};
  strokes[4].push_back(background);
  ASSERT_TRUE(scene.matte({}, {}, {}, {}, strokes, red_network(scene)).ok());
  const auto painted = read_image(scene.folder / "masks" / frame_name(4).filename()),
             other = read_image(scene.folder / "masks" / frame_name(5).filename());
  ASSERT_TRUE(painted.ok() && other.ok());
  EXPECT_EQ(*painted->at(15, kSize - 8), 0);
  EXPECT_EQ(*other->at(15, kSize - 8), 255);
}

TEST(MatteClip, AMixedClipGetsThePlateOfItsRest) {
  const Scene scene("mixed", Moves::at_first);
  const auto result = scene.matte();
  ASSERT_TRUE(result.ok()) << result.error().what;
  EXPECT_TRUE(result->has_plate);
  ASSERT_FALSE(result->plate_frames.empty());
  EXPECT_EQ(result->plate_frames.front(), 14);
  EXPECT_EQ(result->plate_frames.back(), kFrames - 1);
  const auto info = read_plate_info(scene.folder / "plate.json");
  ASSERT_TRUE(info.ok());
  EXPECT_EQ(info->frames, result->plate_frames);
  for (int frame : result->plate_frames) EXPECT_GT(scene.overlap(frame), 0.93) << frame;
}

TEST(MatteClip, TheRoomCompletesThePlateOfARest) {
  const Scene scene("completed", Moves::at_first);
  const Image8& wall = scene.wall.back();
  const auto error_of_plate = [&](bool seen) {
    const auto plate = read_image(scene.folder / "plate.png"),
               known = read_image(scene.folder / "plate_known.png");
    EXPECT_TRUE(plate.ok() && known.ok());
    double sum = 0, count = 0;
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x)
        for (int c = 0; c < 3 && (*known->at(x, y) == 255) == seen; ++c, ++count)
          sum += std::abs(int(plate->at(x, y)[c]) - int(wall.at(x, y)[c]));
    return sum / count;
  };
  ASSERT_TRUE(scene.matte().ok());
  const double guessed = error_of_plate(false);
  const LearnRoom learn = [&](const auto&, RoomPass, const Progress&, std::stop_token) -> Result<RoomBehind> {
    return RoomBehind([&](int frame) { return scene.wall[std::size_t(frame)]; });
  };
  const auto result = scene.matte({}, {}, {}, learn);
  ASSERT_TRUE(result.ok()) << result.error().what;
  EXPECT_LT(error_of_plate(false), 0.2 * guessed);
  EXPECT_LT(error_of_plate(true), 3);
  for (int frame : result->plate_frames) EXPECT_GT(scene.overlap(frame), 0.93) << frame;
}

TEST(MatteClip, RegionsOfHeldOutFramesAreNestedAndStayFrozen) {
  const Scene scene("regions");
  ASSERT_TRUE(scene.matte().ok());
  for (int frame = 0; frame < kFrames; ++frame)
    EXPECT_EQ(fs::exists(scene.folder / "regions" / frame_name(frame).filename()), frame >= kHeldFrom);
  const auto regions = read_image(scene.folder / "regions" / frame_name(kHeldFrom).filename());
  ASSERT_TRUE(regions.ok());
  EXPECT_EQ(regions->width, kSize);
  int person = 0, head = 0, face = 0, face_in_head = 0;
  for (int i = 0; i < kSize * kSize; ++i) {
    const std::uint8_t* pixel = regions->data.data() + 3 * i;
    person += pixel[0] == 255, head += pixel[1] == 255, face += pixel[2] == 255;
    face_in_head += pixel[1] == 255 && pixel[2] == 255;
  }
  EXPECT_GT(person, head / 2);
  EXPECT_GT(face, 200);
  EXPECT_GT(head, face);
  EXPECT_EQ(face_in_head, face);
  const auto before = bytes_of(scene.folder / "regions" / frame_name(kHeldFrom).filename());
  const auto marker = scene.folder / "regions" / frame_name(kHeldFrom + 1).filename();
  ASSERT_TRUE(write_image(marker, Image8(kSize, kSize, 3, 1)).ok());
  const auto altered = bytes_of(marker);
  // One frame without regions must not cause the others to be made again.
  fs::remove(scene.folder / "regions" / frame_name(kHeldFrom + 2).filename());
  ASSERT_TRUE(scene.matte().ok());
  EXPECT_TRUE(fs::exists(scene.folder / "regions" / frame_name(kHeldFrom + 2).filename()));
  EXPECT_EQ(bytes_of(scene.folder / "regions" / frame_name(kHeldFrom).filename()), before);
  EXPECT_EQ(bytes_of(marker), altered);
}

TEST(MatteClip, StoppedMidwayLeavesTheOldMasksAsTheyWere) {
  const Scene scene("stopped");
  fs::create_directories(scene.folder / "masks");
  std::ofstream(scene.folder / "masks" / "000000.png") << "old";
  std::stop_source stop;
  const Progress progress([&](const ProgressReport& report) {
    if (report.fraction > 0.4) stop.request_stop();
  });
  const auto result = scene.matte(progress, stop.get_token());
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::cancelled);
  EXPECT_EQ(bytes_of(scene.folder / "masks" / "000000.png"), "old");
  EXPECT_FALSE(fs::exists(scene.folder / "plate.png"));
  EXPECT_FALSE(fs::exists(scene.folder / "masks.part"));
}

TEST(MatteClip, AStoppedRunGoesOnToTheSameMasks) {
  const Scene uncut("uncut"), cut("cut");
  ASSERT_TRUE(uncut.matte().ok());
  int written = 0;
  for (const double until : {0.85, 2.0}) {
    std::stop_source stop;
    const Progress progress([&](const ProgressReport& report) {
      if (report.fraction > until) stop.request_stop();
    });
    MatteOptions options;
    options.size = kSize;
    options.kept = std::make_shared<KeptWork>(cut.folder / "decoded" / "mattes.kept", "inputs");
    const auto result = matte_clip(cut.folder, cut.capture, cut.cameras, cut.track, head_model(), options,
                                   progress, stop.get_token());
    ASSERT_EQ(result.ok(), until > 1);
    if (fs::exists(cut.folder / "masks.part"))
      written = int(std::distance(fs::directory_iterator(cut.folder / "masks.part"), {}));
  }
  EXPECT_GT(written, 0) << "none was written before the last stop";
  EXPECT_FALSE(fs::exists(cut.folder / "masks.part"));
  EXPECT_FALSE(fs::exists(cut.folder / "decoded"));
  for (int frame = 0; frame < kFrames; ++frame) {
    const fs::path name = frame_name(frame).filename();
    EXPECT_EQ(bytes_of(cut.folder / "masks" / name), bytes_of(uncut.folder / "masks" / name)) << frame;
  }
  EXPECT_EQ(bytes_of(cut.folder / "plate.png"), bytes_of(uncut.folder / "plate.png"));
}

TEST(MatteClip, AMissingFrameIsAnErrorThatNamesTheFile) {
  const Scene scene("missing");
  fs::remove(scene.folder / frame_name(3));
  const auto result = scene.matte();
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.error().where.find("000003"), std::string::npos);
}

}  // namespace
}  // namespace likeness
