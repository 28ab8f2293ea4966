// The whole path through the real command line on a small demo capture: film, build, measure, render, kill,
// resume.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <thread>

#include <nlohmann/json.hpp>

#include "core/image/files.h"
#include "core/video/decode.h"
#include "tests/support/run_program.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// One demo capture and one finished project, shared by the tests below in their order.
class EndToEnd : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string name = (fs::temp_directory_path() / "likeness_e2e_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
#ifndef __SANITIZE_ADDRESS__  // which must be loaded first
    watch_calls(folder_ / "calls");
#endif
    const ProgramResult demo = likeness({"demo", (folder_ / "demo").string(), "--size", "320", "--frames",
                                         "32", "--moving-share", "0", "--samples", "1"});
    ASSERT_EQ(demo.exit_code, 0) << demo.err;
    const ProgramResult built = build(folder_ / "p.likeness");
    ASSERT_EQ(built.exit_code, 0) << built.err;
    summary_ = json::parse(built.out);
    track_ = text_of(folder_ / "p.likeness" / "track.json");
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  static std::vector<std::string> build_command(const fs::path& project) {
    return {
        "build", (folder_ / "demo" / "demo.mp4").string(), "--project", project.string(), "--steps", kSteps,
        "--json"};
  }
  static ProgramResult build(const fs::path& project) { return likeness(build_command(project)); }

  static std::string text_of(const fs::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  static json evaluate(const fs::path& project) {
    const ProgramResult result = likeness({"eval", project.string(), "--json"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return json::parse(result.out);
  }
  // Of the finished project, measured once.
  static const json& report() {
    static const json measured = evaluate(folder_ / "p.likeness");
    return measured;
  }

  static constexpr const char* kSteps = "60";
  static inline fs::path folder_;
  static inline json summary_;
  static inline std::string track_;  // of the finished project, as the build left it
};

TEST_F(EndToEnd, EveryStageIsDoneAndSaysWhatItFound) {
  for (const char* stage : {"import", "align", "fit", "matte", "train"}) {
    EXPECT_TRUE(summary_.at("stages").at(stage).at("done").get<bool>()) << stage;
    EXPECT_FALSE(summary_.at("stages").at(stage).at("message").get<std::string>().empty()) << stage;
  }
}

TEST_F(EndToEnd, TheAvatarsPartsAreListedWithTheirReasons) {
  std::map<std::string, bool> on;
  for (const json& part : summary_.at("parts")) {
    on[part.at("part")] = part.at("on");
    EXPECT_EQ(part.at("by"), "capture") << part;
    EXPECT_FALSE(part.at("reason").get<std::string>().empty()) << part;
  }
  // Somebody who speaks, head and shoulders, before a camera that rests.
  for (const char* part : {"expression", "deformation", "torso", "background", "code", "grid"})
    EXPECT_TRUE(on.contains(part) && on[part]) << part;
  const ProgramResult card = likeness({"card", (folder_ / "p.likeness").string(), "--json"});
  ASSERT_EQ(card.exit_code, 0) << card.err;
  EXPECT_EQ(json::parse(card.out).at("parts"), summary_.at("parts"));
}

TEST_F(EndToEnd, AShapeThatCannotBeTheirsIsRefusedAndNothingChanges) {
  const fs::path project = folder_ / "p.likeness", shape = folder_ / "identity.obj";
  std::ofstream(shape) << "v 0 0 0\nv 0 18 0\nv 1 0 0\n";
  const auto before = fs::last_write_time(project / "project.json");
  const ProgramResult refused = likeness({"fit", project.string(), "--identity", shape.string()});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("3 vertices"), std::string::npos) << refused.err;
  EXPECT_EQ(fs::last_write_time(project / "project.json"), before);
}

TEST_F(EndToEnd, MapsThatCannotBeTheirsAreRefusedAndNothingChanges) {
  const fs::path project = folder_ / "p.likeness", maps = folder_ / "maps";
  fs::create_directories(maps);
  std::ofstream(maps / "000003.png") << "no picture";
  const auto before = fs::last_write_time(project / "project.json");
  for (const auto& [folder, words] : {std::pair(maps, "000003.png"), {folder_ / "no maps", "no folder"}}) {
    const ProgramResult refused = likeness({"fit", project.string(), "--displacement", folder.string()});
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_NE(refused.err.find(words), std::string::npos) << refused.err;
  }
  EXPECT_EQ(fs::last_write_time(project / "project.json"), before);
}

TEST_F(EndToEnd, MapsOfOtherFramesCostNoNewTrack) {
  const fs::path project = folder_ / "p.likeness", maps = folder_ / "foreign maps";
  fs::create_directories(maps);
  std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (16, 16), }";
  header.resize(117, ' ');
  header += '\n';
  std::ofstream(maps / "777777.npy", std::ios::binary)
      << std::string("\x93NUMPY\x01\x00\x76\x00", 10) << header << std::string(16 * 16 * sizeof(float), '\0');
  const auto track = fs::last_write_time(project / "track.json"),
             avatar = fs::last_write_time(project / "avatar.bin");
  const ProgramResult refused = likeness({"fit", project.string(), "--displacement", maps.string()});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("frames of this clip"), std::string::npos) << refused.err;
  ASSERT_EQ(likeness({"fit", project.string(), "--displacement", "none"}).exit_code, 0);
  ASSERT_EQ(likeness({"train", project.string()}).exit_code, 0);
  EXPECT_EQ(fs::last_write_time(project / "track.json"), track);
  EXPECT_EQ(fs::last_write_time(project / "avatar.bin"), avatar);
}

TEST_F(EndToEnd, TheAvatarResemblesFramesItNeverSaw) {
  EXPECT_EQ(report().at("frames_test"), 3);
  EXPECT_EQ(report().at("split"), "tail");
  // A person painted as one mean colour scores about 14 dB on the head.
  EXPECT_GT(report().at("psnr_db").get<double>(), 22);
  EXPECT_GT(report().at("psnr_head_db").get<double>(), 18);
  EXPECT_LE(report().at("samples_per_ray").get<double>(), 22);  // 20, and the strata of a block
}

TEST_F(EndToEnd, TheModelsStandSideBySideAreTrainedOnceAndCanBeTrainedAgain) {
  const fs::path out = folder_ / "models", again = folder_ / "models again";
  const std::vector<std::string> names{"moved-picture", "concat-grid", "warp+hyper-grid", "concat-mlp",
                                       "painted-grid"};
  const auto command = [&](const fs::path& to, const std::vector<std::string>& models,
                           const std::vector<std::string>& how) {
    std::vector<std::string> all{"study", (folder_ / "p.likeness").string(), "--out", to.string(),
                                 "--models"};
    all.insert(all.end(), models.begin(), models.end());
    all.insert(all.end(), {"--rays", "512", "--size", "32", "--frames", "2", "--seeds", "1", "--baked-cells",
                           "24", "--json"});
    all.insert(all.end(), how.begin(), how.end());
    return likeness(all);
  };
  const std::vector<std::string> steps{"--steps", "8", "--mlp-steps", "2"};
  const ProgramResult first = command(out, names, steps);
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const json table = json::parse(first.out);
  ASSERT_EQ(table.at("rows").size(), 5u);
  for (const json& row : table.at("rows")) {
    const json& score = row.at("scores").at(0);
    EXPECT_EQ(score.at("steps"), row.at("kind") == "grid" ? 8 : row.at("kind") == "mlp" ? 2 : 0);
    EXPECT_GT(score.at("psnr_head_db").get<double>(), 3) << row;
    EXPECT_GT(score.at("frames_per_second").get<double>(), 0);
    EXPECT_FALSE(score.at("marks").empty());
    EXPECT_EQ(score.at("qualities").empty(), row.at("name") != "warp+hyper-grid");
    int stored = 0;
    for (const json& quality : score.at("qualities")) {
      stored += quality.at("name").get<std::string>().starts_with("baked, 24 cells");
      EXPECT_GT(quality.at("psnr_face_db").get<double>(), 3) << quality;
      EXPECT_GT(quality.at("bytes").get<double>(), 1000) << quality;
    }
    EXPECT_EQ(stored, score.at("qualities").empty() ? 0 : 2);
  }
  for (const char* name :
       {"results.csv", "results.json", "report.html", "psnr_over_seconds.png", "qualities.png"})
    EXPECT_TRUE(fs::exists(out / name)) << name;

  // Again: nothing is trained, so that even the seconds are the same; but a row that is gone is made anew.
  const auto before = fs::last_write_time(out / "concat-grid-0.json");
  ASSERT_TRUE(fs::remove(out / "concat-mlp-0.json"));
  const ProgramResult second = command(out, names, steps);
  ASSERT_EQ(second.exit_code, 0) << second.err;
  EXPECT_EQ(json::parse(second.out).at("rows").at(0), table.at("rows").at(0));
  EXPECT_EQ(fs::last_write_time(out / "concat-grid-0.json"), before);
  EXPECT_TRUE(fs::exists(out / "concat-mlp-0.json"));

  // By the steps that it took elsewhere: the same to the last bit.
  const ProgramResult replayed =
      command(again, {"concat-grid", "concat-mlp"}, {"--replay", (out / "results.json").string()});
  ASSERT_EQ(replayed.exit_code, 0) << replayed.err;
  const json repeated = json::parse(replayed.out);
  ASSERT_EQ(repeated.at("rows").size(), 2u);
  for (const json& row : repeated.at("rows")) {
    const auto first_row = std::ranges::find_if(
        table.at("rows"), [&](const json& other) { return other.at("name") == row.at("name"); });
    ASSERT_NE(first_row, table.at("rows").end());
    for (const char* figure : {"steps", "psnr_head_db", "psnr_person_db", "ssim", "face_mse"})
      EXPECT_EQ(row.at("scores").at(0).at(figure), first_row->at("scores").at(0).at(figure)) << figure;
  }

  // What this capture or these options cannot teach one model says nothing of the others.
  const ProgramResult partly =
      likeness({"study", (folder_ / "p.likeness").string(), "--out", (folder_ / "partly").string(),
                "--models", "static-grid", "landmark-loss", "--rays", "400", "--steps", "2", "--size", "32",
                "--frames", "1", "--seeds", "1", "--json"});
  ASSERT_EQ(partly.exit_code, 0) << partly.err;
  const json some = json::parse(partly.out).at("rows");
  ASSERT_EQ(some.size(), 2u);
  EXPECT_EQ(some.at(0).at("failed"), "");
  EXPECT_EQ(some.at(0).at("scores").size(), 1u);
  EXPECT_NE(some.at(1).at("failed").get<std::string>().find("400 rays"), std::string::npos) << some;
  EXPECT_TRUE(some.at(1).at("scores").empty());
  EXPECT_TRUE(fs::exists(folder_ / "partly" / "report.html"));

  EXPECT_EQ(command(out, names, {"--tables", "magic"}).exit_code, 2);
  EXPECT_EQ(command(out, names, {"--tables", "time"}).exit_code, 1);  // concat-grid stands in none of them
  const ProgramResult larger =                                        // than the pictures are
      likeness({"study", (folder_ / "p.likeness").string(), "--out", out.string(), "--size", "999"});
  EXPECT_EQ(larger.exit_code, 1);
  EXPECT_NE(larger.err.find("fewer than 999"), std::string::npos) << larger.err;
  EXPECT_EQ(command(out, names, {"--baked-cells", "20"}).exit_code, 1);
  EXPECT_EQ(likeness({"study", (folder_ / "p.likeness").string()}).exit_code, 1);  // where to?
}

TEST_F(EndToEnd, ThePreviewLosesLittleAgainstTheFinalPicture) {
  const ProgramResult quick =
      likeness({"eval", (folder_ / "p.likeness").string(), "--quality", "preview", "--json"});
  ASSERT_EQ(quick.exit_code, 0) << quick.err;
  const json preview = json::parse(quick.out), &final = report();
  EXPECT_LT(preview.at("samples_per_ray").get<double>(), final.at("samples_per_ray").get<double>());
  EXPECT_GT(preview.at("psnr_db").get<double>(), final.at("psnr_db").get<double>() - 2);
  EXPECT_EQ(likeness({"eval", (folder_ / "p.likeness").string(), "--quality", "fast"}).exit_code, 2);
}

TEST_F(EndToEnd, ABenchOfTheProjectMeasuresPicturesAndTrainingAndLeavesItAsItIs) {
  const fs::path project = folder_ / "p.likeness";
  const auto written = [&] {
    std::map<std::string, fs::file_time_type> times;
    for (const auto& entry : fs::recursive_directory_iterator(project))
      times[entry.path().string()] = entry.last_write_time();
    return times;
  };
  const auto before = written();
  const ProgramResult bench =
      likeness({"bench", project.string(), "--rounds", "1", "--batch", "512", "--json"});
  ASSERT_EQ(bench.exit_code, 0) << bench.err;
  const json speed = json::parse(bench.out).at("project");
  EXPECT_EQ(speed.at("size"), 256);
  for (const char* key : {"final_fps", "preview_fps", "rays_per_s"})
    EXPECT_GT(speed.at(key).get<double>(), 0);
  EXPECT_LT(std::abs(speed.at("preview_loss_db").get<double>()), 2);
  EXPECT_EQ(written(), before);
}

TEST_F(EndToEnd, ARepeatedBuildHasNothingToDo) {
  const auto before = fs::last_write_time(folder_ / "p.likeness" / "avatar.bin");
  ASSERT_EQ(build(folder_ / "p.likeness").exit_code, 0);
  EXPECT_EQ(fs::last_write_time(folder_ / "p.likeness" / "avatar.bin"), before);
}

TEST_F(EndToEnd, SpansAreFittedAgainInAnyOrderAndTakenBack) {
  const fs::path folder = folder_ / "p.likeness", file = folder / "track.json";
  const auto lines = [&] {
    std::ifstream in(file);
    std::vector<std::string> read;
    for (std::string line; std::getline(in, line);) read.push_back(line);
    return read;
  };
  const auto fit = [&](const std::vector<std::string>& more) {
    std::vector<std::string> command{"fit", folder.string(), "--json"};
    for (const std::string& span : more) command.insert(command.end(), {"--refit", span});
    const ProgramResult result = likeness(command);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return json::parse(result.out).at("stages");
  };
  const std::vector<std::string> first = lines();
  EXPECT_EQ(likeness({"fit", folder.string(), "--refit", "30-400"}).exit_code, 1);
  const json both = fit({"10-12", "20,21"});
  const std::string words = both.at("fit").at("message");
  EXPECT_NE(words.find("Frames 10 to 12 fitted again"), std::string::npos) << words;
  EXPECT_NE(words.find("Frames 20 to 21 fitted again"), std::string::npos) << words;
  EXPECT_TRUE(both.at("fit").at("done").get<bool>());
  const std::vector<std::string> fitted = lines();
  ASSERT_EQ(fitted.size(), first.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    if (fitted[i] == first[i]) continue;
    const int frame = json::parse(fitted[i].substr(0, fitted[i].find_last_of('}') + 1)).at("frame");
    EXPECT_TRUE((frame >= 10 && frame <= 12) || frame == 20 || frame == 21) << frame;
  }
  fit({"none"});
  EXPECT_EQ(lines(), first);
  fit({"20-21"});
  fit({"10-12"});
  EXPECT_EQ(lines(), fitted);
  // All taken back, the masks and the avatar are what they were made from.
  const json back = fit({"none"});
  for (const char* stage : {"fit", "matte", "train"})
    EXPECT_TRUE(back.at(stage).at("done").get<bool>()) << stage;
}

TEST_F(EndToEnd, NoPictureIsWrittenOverTheClipOrTheFrames) {
  const fs::path project = folder_ / "p.likeness", clip = folder_ / "demo" / "demo.mp4";
  const auto before = fs::last_write_time(clip);
  const ProgramResult film = likeness({"eval", project.string(), "--video", clip.string()});
  EXPECT_EQ(film.exit_code, 1);
  EXPECT_NE(film.err.find("--video names a clip"), std::string::npos) << film.err;
  EXPECT_EQ(fs::last_write_time(clip), before);
  EXPECT_EQ(likeness({"eval", project.string(), "--pictures", (project / "frames").string()}).exit_code, 1);
  // What the cameras say is not asked for twice.
  const std::string out = (folder_ / "x.mp4").string();
  for (const std::vector<std::string>& twice :
       {std::vector<std::string>{"--camera", (project / "cameras.json").string(), "--frames", "10"}}) {
    std::vector<std::string> command{"render", project.string(), "--out", out};
    command.insert(command.end(), twice.begin(), twice.end());
    const ProgramResult refused = likeness(command);
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_NE(refused.err.find("Leave out"), std::string::npos) << refused.err;
  }
}

TEST_F(EndToEnd, AnOrbitIsAVideoOfItsLength) {
  const fs::path out = folder_ / "orbit.mp4";
  const ProgramResult result = likeness({"render", (folder_ / "p.likeness").string(), "--camera", "orbit",
                                         "--frames", "8", "--out", out.string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  auto reader = VideoReader::open(out);
  ASSERT_TRUE(reader.ok()) << reader.error().what;
  int frames = 0;
  while (true) {
    const auto frame = reader->next();
    ASSERT_TRUE(frame.ok());
    if (!*frame) break;
    ++frames;
  }
  EXPECT_EQ(frames, 8);
}

double mean_difference(const Image8& a, const Image8& b, int y0, int y1) {
  double sum = 0;
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < a.width * a.channels; ++x) {
      sum += std::abs(int(a.data[std::size_t(y) * a.width * a.channels + x]) -
                      int(b.data[std::size_t(y) * b.width * b.channels + x]));
    }
  }
  return sum / (double(y1 - y0) * a.width * a.channels);
}

TEST_F(EndToEnd, TurningTheHeadMovesNoShoulder) {
  const std::string project = (folder_ / "p.likeness").string();
  const fs::path straight = folder_ / "straight.png", turned = folder_ / "turned.png";
  ASSERT_EQ(likeness({"render", project, "--out", straight.string()}).exit_code, 0);
  ASSERT_EQ(likeness({"render", project, "--pose=25,0,0", "--out", turned.string()}).exit_code, 0);
  const auto a = read_image(straight), b = read_image(turned);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_GT(mean_difference(*a, *b, a->height / 4, a->height * 5 / 8), 2);  // the face turned
  EXPECT_LT(mean_difference(*a, *b, a->height * 15 / 16, a->height), 0.5);  // the shoulders stayed
}

TEST_F(EndToEnd, AStudyOfPartsMeasuresWhatOneBringsAndGoesOnWhereItStopped) {
  const fs::path project = folder_ / "p.likeness", out = folder_ / "parts";
  const auto track_before = fs::last_write_time(project / "track.json");
  const auto study = [&](const std::vector<std::string>& models) {
    std::vector<std::string> words{"study",    project.string(),
                                   "--out",    out.string(),
                                   "--tables", "parts",
                                   "--size",   "0",
                                   "--frames", "0",
                                   "--steps",  "30",
                                   "--rays",   "2048",
                                   "--seeds",  "1",
                                   "--json",   "--models"};
    words.insert(words.end(), models.begin(), models.end());
    return likeness(words);
  };
  const std::vector<std::string> models{"warp+hyper-grid", "no-torso-track"};
  const ProgramResult first = study(models);
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const json rows = json::parse(first.out).at("rows");
  ASSERT_EQ(rows.size(), 2u);
  const json with = rows[0].at("scores").at(0), without = rows[1].at("scores").at(0);
  EXPECT_EQ(json::parse(first.out).at("frames").size(), 3u);
  // A dark hole where the shoulders should be costs the whole person, not the head.
  EXPECT_GT(with.at("psnr_person_db").get<double>(), without.at("psnr_person_db").get<double>() + 1);
  EXPECT_GT(with.at("samples_per_ray").get<double>(), 1);
  EXPECT_TRUE(with.at("lmk_eyes_px").is_number());
  EXPECT_TRUE(with.at("psnr_refit_db").is_null());
  EXPECT_EQ(fs::last_write_time(project / "track.json"), track_before);

  const auto trained = fs::last_write_time(out / "no-torso-track-0.json");
  const ProgramResult again = study(models);
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(again.out, first.out);
  EXPECT_EQ(fs::last_write_time(out / "no-torso-track-0.json"), trained);
  for (const char* name : {"parts.csv", "tables.json", "results.csv", "report.html"})
    EXPECT_TRUE(fs::exists(out / name)) << name;

  const ProgramResult unknown = study({"magic"});
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_NE(unknown.err.find("no-torso-track"), std::string::npos) << unknown.err;
  const ProgramResult unpainted = study({"attribute"});
  ASSERT_EQ(unpainted.exit_code, 0) << unpainted.err;
  EXPECT_NE(json::parse(unpainted.out).at("rows").at(0).at("failed").get<std::string>().find("no painted"),
            std::string::npos)
      << unpainted.out;
}

TEST_F(EndToEnd, TheDemosTruthJudgesMattesAndGivesDetailMaps) {
  const std::string demo = (folder_ / "demo").string(), project = (folder_ / "p.likeness").string();
  const ProgramResult mattes = likeness({"study", "truth", demo, project, "--tables", "mattes", "--json"});
  ASSERT_EQ(mattes.exit_code, 0) << mattes.err;
  const json rows = json::parse(mattes.out).at("mattes");
  ASSERT_FALSE(rows.empty());
  for (const json& row : rows) EXPECT_GT(row.at("iou_mean").get<double>(), 0.9) << row;
  const ProgramResult again =
      likeness({"study", "truth", demo, project, "--tables", "mattes", "--networks", "none", "--json"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  const json both = json::parse(again.out).at("mattes");
  ASSERT_EQ(both.size(), 2 * rows.size());
  for (std::size_t i = 0; i < both.size(); ++i) {
    EXPECT_EQ(both[i].at("network"), i < rows.size() ? "as it is" : "none");
    EXPECT_EQ(both[i].at("frames"), rows[i % rows.size()].at("frames"));
    EXPECT_GT(both[i].at("iou_mean").get<double>(), 0.9) << both[i];
  }
  const fs::path maps = folder_ / "true maps";
  const ProgramResult written =
      likeness({"demo", demo, "--displacement", project, "--out", maps.string(), "--json"});
  ASSERT_EQ(written.exit_code, 0) << written.err;
  const json report = json::parse(written.out);
  EXPECT_EQ(report.at("frames"), std::distance(fs::directory_iterator(maps), fs::directory_iterator()));
  EXPECT_GT(report.at("rms_mm").get<double>(), 0);
}

TEST_F(EndToEnd, ATableOfOccupancyTrainsNothing) {
  const fs::path project = folder_ / "p.likeness";
  const auto before = fs::last_write_time(project / "avatar.bin");
  const ProgramResult result =
      likeness({"study", project.string(), "--tables", "occupancy", "--frames", "1", "--csv"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out.find("rays,lookup,samples_per_ray"), 0u) << result.out;
  EXPECT_EQ(std::count(result.out.begin(), result.out.end(), '\n'), 1 + 2 * 5);
  EXPECT_EQ(fs::last_write_time(project / "avatar.bin"), before);
}

TEST_F(EndToEnd, AnUnknownExpressionListsTheKnownOnes) {
  const ProgramResult result = likeness({"render", (folder_ / "p.likeness").string(), "--expression",
                                         "grin=1", "--out", (folder_ / "x.png").string()});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE((result.err).find("jawOpen"), std::string::npos) << result.err;
  EXPECT_FALSE(fs::exists(folder_ / "x.png"));
}

TEST_F(EndToEnd, TheCheckNamesWhatIsWrongWithAClip) {
  const fs::path clip = folder_ / "demo" / "demo.mp4";
  const auto faults = [](const fs::path& video) {
    const ProgramResult checked = likeness({"check", video.string(), "--json"});
    EXPECT_EQ(checked.exit_code, 0) << checked.err;
    const json report = json::parse(checked.out);
    std::set<std::string> names;
    for (const json& remark : report.at("remarks")) {
      names.insert(remark.at("fault").get<std::string>());
      EXPECT_FALSE(remark.at("remedy").get<std::string>().empty());
      EXPECT_LE(remark.at("from_s"), remark.at("to_s"));
    }
    return names;
  };
  const std::set<std::string> as_filmed = faults(clip);
  EXPECT_EQ(as_filmed.count("too_short"), 1u) << "two seconds";
  for (const auto& [fault, filter] :
       {std::pair("blurred", "gblur=sigma=4"), std::pair("too_dark", "lutyuv=y='16+(val-16)*0.12'"),
        std::pair("head_cut", "crop=iw:ih*0.62:0:ih*0.36")}) {
    EXPECT_EQ(as_filmed.count(fault), 0u) << fault;
    const fs::path spoilt = folder_ / (std::string(fault) + ".mp4");
    const ProgramResult made = run_program(
        {"ffmpeg", "-loglevel", "error", "-y", "-i", clip.string(), "-vf", filter, spoilt.string()});
    if (made.exit_code == 127) GTEST_SKIP() << "the ffmpeg program is not installed";
    ASSERT_EQ(made.exit_code, 0) << made.err;
    EXPECT_EQ(faults(spoilt).count(fault), 1u) << fault;
  }
}

TEST_F(EndToEnd, AFolderOfPhotographsBecomesAnAvatarLikeAClip) {
  const fs::path photos = folder_ / "photos", project = folder_ / "photos.likeness";
  fs::create_directories(photos);
  int taken = 0;
  Image8 picture;
  for (int i = 0; i < 32; ++i) {
    auto frame = read_image(folder_ / "p.likeness" / "frames" / fmt::format("{:06}.png", i));
    if (frame) picture = std::move(*frame);  // else refused by the import: the one before once more
    if (picture.empty()) continue;
    ASSERT_TRUE(write_image(photos / fmt::format("IMG_{:03}.jpg", i), picture).ok());
    ++taken;
  }
  ASSERT_GE(taken, 30);
  const ProgramResult built = likeness({"build", photos.string(), "--project", project.string(), "--steps",
                                        "30", "--resting-camera", "--json"});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  const json measured = evaluate(project);
  EXPECT_EQ(measured.at("frames_test"), taken / 10);
  EXPECT_GT(measured.at("psnr_db").get<double>(), 20);
  EXPECT_GT(measured.at("psnr_head_db").get<double>(), 16);
  const fs::path still = folder_ / "photographed.png";
  EXPECT_EQ(likeness({"render", project.string(), "--out", still.string()}).exit_code, 0);
  EXPECT_TRUE(read_image(still).ok());
}

TEST_F(EndToEnd, TwoPeopleInViewAreRefused) {
  const fs::path clip = folder_ / "two.mp4", project = folder_ / "two.likeness";
  const ProgramResult stacked =
      run_program({"ffmpeg", "-v", "error", "-i", (folder_ / "demo" / "demo.mp4").string(), "-filter_complex",
                   "[0:v]split[a][b];[a][b]hstack", clip.string()});
  if (stacked.exit_code == 127) GTEST_SKIP() << "the ffmpeg program is not installed";
  ASSERT_EQ(stacked.exit_code, 0) << stacked.err;
  const ProgramResult result = likeness({"build", clip.string(), "--project", project.string()});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("Two faces are in view"), std::string::npos) << result.err;
  EXPECT_FALSE(fs::exists(project));
}

TEST_F(EndToEnd, TrainingThatWillNotFitInMemoryIsRefusedAndNothingIsLost) {
  if (run_program({"sh", "-c", "ulimit -v 900000 && exec \"$1\" --version", "sh", likeness_path()})
          .exit_code != 0)
    GTEST_SKIP() << "built with a sanitizer, which reserves more address space than any limit";
  const fs::path project = folder_ / "large.likeness";
  fs::copy(folder_ / "p.likeness", project, fs::copy_options::recursive);
  const auto before = fs::last_write_time(project / "avatar.bin");
  const auto train = [&](const char* kib) {
    return run_program({"sh", "-c", "ulimit -v \"$1\" && exec \"$2\" train \"$3\" --steps 8 --threads 1",
                        "sh", kib, likeness_path(), project.string()});
  };
  // Room for the program, but not for its fields.
  const ProgramResult refused = train("900000");
  EXPECT_EQ(refused.exit_code, 1) << refused.err;
  EXPECT_NE(refused.err.find("GiB are free"), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("--size"), std::string::npos) << refused.err;
  EXPECT_EQ(fs::last_write_time(project / "avatar.bin"), before);
  const ProgramResult trained = train("unlimited");
  EXPECT_EQ(trained.exit_code, 0) << trained.err;
}

// kill -9 in the stage that is running after `wait_for` has appeared, then the same command again.
void kill_when(const fs::path& wait_for, pid_t child) {
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::minutes(3);
  while (!fs::exists(wait_for) && std::chrono::steady_clock::now() < give_up) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  ::kill(child, SIGKILL);
}

TEST_F(EndToEnd, AKilledBuildContinuesToTheSameQuality) {
  const fs::path project = folder_ / "killed.likeness";
  std::vector<std::string> command = build_command(project);
  command.insert(command.begin(), likeness_path());
  for (const char* option : {"--checkpoint-every", "1"}) command.push_back(option);
  // After the import, after the cameras, after the track, and in the middle of training.
  for (const std::string landmark : {"capture.json", "cameras.json", "track.json", "checkpoint.bin"}) {
    const pid_t child = start_program(command, folder_);
    kill_when(project / landmark, child);
    EXPECT_NE(wait_program(child), 0) << "it ended before it could be killed";
    // The fit then decodes the clip itself, and finds what the uncut build's found in what import had kept.
    if (landmark == "cameras.json") fs::remove_all(project / "decoded");
  }
  EXPECT_FALSE(track_.empty());
  EXPECT_TRUE(text_of(project / "track.json") == track_) << "another track";
  const ProgramResult resumed = build(project);
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  const json &uncut = report(), cut = evaluate(project);
  EXPECT_EQ(cut.at("steps"), uncut.at("steps"));
  EXPECT_NEAR(cut.at("psnr_db").get<double>(), uncut.at("psnr_db").get<double>(), 0.3);
  EXPECT_NEAR(cut.at("psnr_head_db").get<double>(), uncut.at("psnr_head_db").get<double>(), 0.5);
}

TEST_F(EndToEnd, AnInterruptIsAStopNotAFailure) {
  const fs::path project = folder_ / "stopped.likeness";
  std::vector<std::string> command = build_command(project);
  command.insert(command.begin(), likeness_path());
  const pid_t child = start_program(command, folder_);
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!fs::exists(project / "capture.json") && std::chrono::steady_clock::now() < give_up) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  ::kill(child, SIGINT);
  EXPECT_EQ(wait_program(child), 130);
  EXPECT_TRUE(fs::exists(project / "capture.json"));
}

// The last of them: nothing that was started above, nor what that started, turned to a network.
TEST_F(EndToEnd, NobodyIsCalledOverANetwork) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the sanitizer must be loaded before what would watch";
#endif
  EXPECT_EQ(text_of(folder_ / "calls"), "");
  const ProgramResult caller = run_program({"bash", "-c", "exec 3<>/dev/tcp/127.0.0.1/9"});
  if (caller.exit_code != 127) {
    EXPECT_NE(text_of(folder_ / "calls"), "") << "nobody watches";
  }
}

}  // namespace
}  // namespace likeness::test
