// Claims about the command line that need no clip: usage, doctor, and what bad input is told.
#include <gtest/gtest.h>
#include <pty.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/mount.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/image/image.h"
#include "core/synth/cast.h"
#include "core/video/encode.h"
#include "tests/support/run_program.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;

class CommandLine : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_cli_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  // A clip of moving noise: a real video with nobody in it.
  fs::path write_clip(const std::string& name, int frames) {
    auto writer = VideoWriter::create(folder_ / name, 160, 120);
    EXPECT_TRUE(writer.ok());
    for (int f = 0; f < frames; ++f) {
      Image8 picture(160, 120, 3);
      unsigned state = 12345;
      for (std::size_t i = 0; i < picture.data.size(); ++i) {
        state = state * 1664525u + 1013904223u;
        picture.data[(i + std::size_t(f) * 6) % picture.data.size()] = std::uint8_t(state >> 24);
      }
      EXPECT_TRUE(writer->add(picture).ok());
    }
    EXPECT_TRUE(writer->finish().ok());
    return folder_ / name;
  }

  // The build must fail plainly: exit 1, a fact and a remedy on stderr, no project left behind.
  void expect_refused(const fs::path& video, const std::string& word) {
    const fs::path project = folder_ / "p.likeness";
    const ProgramResult result = likeness({"build", video.string(), "--project", project.string(), "--json"});
    EXPECT_EQ(result.exit_code, 1) << result.err;
    EXPECT_NE(result.err.find(word), std::string::npos) << result.err;
    EXPECT_GE(std::count(result.err.begin(), result.err.end(), '\n'), 2) << "no remedy: " << result.err;
    EXPECT_FALSE(fs::exists(project)) << "something half-written was left";
  }

  fs::path folder_;
};

TEST_F(CommandLine, WrongUsageExitsWithTwo) {
  EXPECT_EQ(likeness({}).exit_code, 2);
  EXPECT_EQ(likeness({"bulid"}).exit_code, 2);
  EXPECT_EQ(likeness({"build", "clip.mp4"}).exit_code, 2);
  EXPECT_EQ(likeness({"build", "clip.mp4", "--project", "p", "--size", "300"}).exit_code, 2);
}

TEST_F(CommandLine, EveryDemoPersonAndLightCanBeChosenAndNoOther) {
  for (const auto& [option, count] :
       {std::pair("--person", demo_people().size()), std::pair("--light", demo_lights().size())}) {
    const auto exit_code = [&, name = option](std::size_t number) {
      return likeness({"--parse-only", "demo", (folder_ / "demo").string(), name, std::to_string(number)})
          .exit_code;
    };
    EXPECT_EQ(exit_code(count - 1), 0) << option;
    EXPECT_EQ(exit_code(count), 2) << option;
  }
}

TEST_F(CommandLine, ParseOnlyJudgesACommandAndDoesNothing) {
  const fs::path demo = folder_ / "demo";
  EXPECT_EQ(likeness({"--parse-only", "demo", demo.string(), "--person", "3"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(demo));
  EXPECT_EQ(likeness({"--parse-only", "eval", "/nowhere.likeness"}).exit_code, 0);
  EXPECT_EQ(likeness({"--parse-only", "demo", demo.string(), "--person", "99"}).exit_code, 2);
  EXPECT_EQ(likeness({"--parse-only", "build", "clip.mp4"}).exit_code, 2);  // no --project
  EXPECT_EQ(likeness({"--parse-only", "bulid"}).exit_code, 2);
  EXPECT_EQ(likeness({"--help"}).out.find("--parse-only"), std::string::npos);
  // Many at once, from standard input.
  std::ofstream(folder_ / "lines") << "demo\t" << demo.string() << "\nbulid\neval\tin two words\n";
  const ProgramResult many =
      run_program({"sh", "-c", likeness_path() + " --parse-only < " + (folder_ / "lines").string()});
  EXPECT_EQ(many.exit_code, 2);
  EXPECT_EQ(many.out.find("bulid\n"), 0u) << many.out;
  EXPECT_EQ(many.out.find("in two words"), std::string::npos) << many.out;
  EXPECT_FALSE(fs::exists(demo));
}

TEST_F(CommandLine, HelpAndVersionExitWithZero) {
  EXPECT_EQ(likeness({"--help"}).exit_code, 0);
  EXPECT_EQ(likeness({"build", "--help"}).exit_code, 0);
  EXPECT_EQ(likeness({"--version"}).exit_code, 0);
}

// Every number in a report is finite and above zero.
void expect_positive(const nlohmann::json& value, const std::string& name) {
  if (value.is_number()) {
    EXPECT_TRUE(std::isfinite(value.get<double>()) && value.get<double>() > 0) << name << ": " << value;
  } else if (value.is_structured()) {
    for (const auto& [key, item] : value.items()) expect_positive(item, name + "." + key);
  } else {
    EXPECT_FALSE(value.is_null()) << name;
  }
}

void erase_bf16(nlohmann::json& value) {
  if (value.is_object())
    for (const char* key : {"bf16", "bf16_gflops"}) value.erase(key);
  if (value.is_structured())
    for (auto& item : value) erase_bf16(item);
}

TEST_F(CommandLine, BenchReportsCeilingsSpeedsAndErrorsOfOneRun) {
  const ProgramResult result =
      likeness({"bench", "--json", "--threads", "2", "--rounds", "1", "--batch", "512", "--batch", "1024"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  auto report = nlohmann::json::parse(result.out);
  for (const char* key : {"fma_gflops", "gather_mps", "rmw_mps", "bandwidth_gbs", "tables", "by_threads",
                          "processor", "instruction_set", "processor_share"})
    EXPECT_TRUE(report.at("machine").contains(key)) << key;
  for (const char* key :
       {"forward_msamples_s", "train_msamples_s", "forward_fraction_of_floor", "train_fraction_of_floor"})
    for (const char* threads : {"1", "2"}) EXPECT_TRUE(report.at("field").at(key).contains(threads)) << key;
  EXPECT_EQ(report.at("field").at("forward_flops"), 24960);
  EXPECT_EQ(report.at("field").at("batches").size(), 4u);  // two thread counts, two batches
  const bool bf16 = report.at("machine").at("bf16_gflops").is_number();
  EXPECT_EQ(report.at("field").at("bf16").is_object(), bf16);
  EXPECT_EQ(report.at("kernels").size(), bf16 ? 5u : 3u);
  for (const auto& kernel : report.at("kernels")) {
    const bool rounded = kernel.at("name").get<std::string>().ends_with("_bf16");
    EXPECT_LE(kernel.at("rel_l2").get<double>(), rounded ? 0.1 : 1e-4) << kernel;
  }
  EXPECT_EQ(report.at("counts").get<bool>(), report.at("doubt").is_null());
  report.erase("doubt");
  EXPECT_TRUE(report.at("project").is_null());
  report.erase("project");
  report.at("field").at("rel_l2").erase("samples_left_out");
  if (bf16)
    report.at("field").at("bf16").at("rel_l2").erase("samples_left_out");
  else
    erase_bf16(report);  // null everywhere
  expect_positive(report, "report");
}

TEST_F(CommandLine, BenchPrintsAndWritesTheSameTables) {
  const fs::path out = folder_ / "tables";
  const ProgramResult result = likeness(
      {"bench", "--csv", "--out", out.string(), "--threads", "1", "--rounds", "1", "--batch", "512"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::string together;
  for (const char* name : {"ceilings", "passes", "errors"}) {
    std::ifstream file(out / (std::string(name) + ".csv"));
    const std::string csv{std::istreambuf_iterator<char>(file), {}};
    EXPECT_FALSE(csv.empty()) << name;
    together += (together.empty() ? "" : "\n") + csv;
  }
  EXPECT_EQ(result.out, together);
  std::ifstream file(out / "tables.json");
  const auto json = nlohmann::json::parse(file);
  EXPECT_EQ(json.at("ceilings").size(), 1u);
  EXPECT_GE(json.at("passes").size(), 2u);
  EXPECT_LE(json.at("errors").at(0).at("outputs").get<double>(), 1e-4);
}

TEST_F(CommandLine, BenchRefusesBatchesItCannotMeasure) {
  EXPECT_EQ(likeness({"bench", "--batch", "0"}).exit_code, 2);
  EXPECT_EQ(likeness({"bench", "--rounds", "0"}).exit_code, 2);
  // A wrong folder is said at once, not after the field was measured.
  const ProgramResult nowhere = likeness({"bench", "/nowhere.likeness", "--rounds", "1000"});
  EXPECT_EQ(nowhere.exit_code, 1);
  EXPECT_NE(nowhere.err.find("/nowhere.likeness"), std::string::npos) << nowhere.err;
}

TEST_F(CommandLine, WhereNoGpuCanBeUsedThatIsSaidAndNothingIsBegun) {
  const fs::path clip = write_clip("nobody.mp4", 5), project = folder_ / "p.likeness";
  const ProgramResult bench = likeness({"bench", "--backend", "cuda", "--json", "--batch", "64"});
  if (bench.exit_code == 0) {
    EXPECT_TRUE(nlohmann::json::parse(bench.out).at("machine").contains("gpu"));
    GTEST_SKIP() << "this machine has a GPU that can be used";
  }
  EXPECT_EQ(bench.exit_code, 1);
  const ProgramResult build =
      likeness({"build", clip.string(), "--project", project.string(), "--backend", "cuda"});
  EXPECT_EQ(build.exit_code, 1);
  EXPECT_EQ(build.err, bench.err);  // the reason, whatever was to be done
  EXPECT_GE(std::count(build.err.begin(), build.err.end(), '\n'), 2) << "no remedy: " << build.err;
  EXPECT_FALSE(fs::exists(project));
  for (const auto& words : std::vector<std::vector<std::string>>{
           {"render", "x.likeness", "--out", "x.png"}, {"drive", "x.likeness", "x.mp4", "--out", "x.mp4"}}) {
    std::vector<std::string> asked = words;
    asked.insert(asked.end(), {"--backend", "cuda"});
    EXPECT_EQ(likeness(asked).err, bench.err) << words.front();
  }
  // The doctor says the same.
  const auto report = nlohmann::json::parse(likeness({"doctor", "--json"}).out);
  for (const auto& finding : report.at("findings"))
    if (finding.at("part") == "CUDA") {
      EXPECT_FALSE(finding.at("ok").get<bool>());
      EXPECT_FALSE(finding.at("needed").get<bool>());
      EXPECT_NE(bench.err.find(finding.at("found").get<std::string>()), std::string::npos) << bench.err;
    }
}

TEST_F(CommandLine, VerbsThatKnowNoGpuSaySo) {
  const ProgramResult result = likeness({"check", "x.mp4", "--backend", "cuda"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE((result.out + result.err).find("computes on the processor"), std::string::npos) << result.err;
}

TEST_F(CommandLine, DoctorReportsEveryPartAsJson) {
  const ProgramResult result = likeness({"doctor", "--json"});
  const auto report = nlohmann::json::parse(result.out);
  EXPECT_GE(report.at("findings").size(), 5u);
  EXPECT_EQ(result.exit_code, report.at("healthy").get<bool>() ? 0 : 1);
}

TEST_F(CommandLine, DoctorSaysWhereNetworksWereLookedForAndWhatToDo) {
  const std::string folder = (folder_ / "networks").string();
  const auto doctor = [&](const std::vector<std::string>& options) {
    std::vector<std::string> command{"/usr/bin/env", "LIKENESS_NETWORKS=" + folder, likeness_path(),
                                     "doctor"};
    command.insert(command.end(), options.begin(), options.end());
    return run_program(command);
  };
  ASSERT_TRUE(write_text(folder_ / "networks/iris.onnx", "no network").ok());
  const auto report = nlohmann::json::parse(doctor({"--json"}).out);
  int networks = 0;
  for (const auto& finding : report.at("findings")) {
    const auto part = finding.at("part").get<std::string>(), found = finding.at("found").get<std::string>();
    if (part.find("network") == std::string::npos) continue;
    ++networks;
    EXPECT_FALSE(finding.at("ok").get<bool>()) << part;
    EXPECT_FALSE(finding.at("needed").get<bool>()) << part;  // everything works without
    EXPECT_NE(found.find(folder), std::string::npos) << found;
    EXPECT_NE(finding.at("remedy").get<std::string>().find("packaging/networks"), std::string::npos);
    if (part == "network iris") {
      EXPECT_NE(found.find("is not the network"), std::string::npos) << found;
    }
  }
  EXPECT_EQ(networks, 4);
  // In words: the remedy once.
  const std::string words = doctor({}).out;
  const std::size_t said = words.find("Run packaging/networks");
  ASSERT_NE(said, std::string::npos) << words;
  EXPECT_EQ(words.find("Run packaging/networks", said + 1), std::string::npos) << words;
}

TEST_F(CommandLine, AMissingClipIsNamed) { expect_refused(folder_ / "absent.mp4", "absent.mp4"); }

TEST_F(CommandLine, ATextFileNamedMp4IsRefused) {
  std::ofstream(folder_ / "notes.mp4") << "This is not a film.\n";
  expect_refused(folder_ / "notes.mp4", "notes.mp4");
}

TEST_F(CommandLine, AClipWithoutAFaceIsRefused) { expect_refused(write_clip("nobody.mp4", 60), "face"); }

TEST_F(CommandLine, AClipOfFiveFramesIsRefused) { expect_refused(write_clip("short.mp4", 5), "5 frames"); }

TEST_F(CommandLine, ATruncatedClipIsRefused) {
  const fs::path whole = write_clip("whole.mp4", 60);
  fs::resize_file(whole, fs::file_size(whole) / 2);
  expect_refused(whole, "is cut short");
}

TEST_F(CommandLine, AFileWhereTheProjectShouldBeIsRefusedAndKept) {
  const fs::path clip = write_clip("clip.mp4", 40);
  std::ofstream(folder_ / "taken") << "keep me";
  const ProgramResult result = likeness({"build", clip.string(), "--project", (folder_ / "taken").string()});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(fs::file_size(folder_ / "taken"), 7u);
}

TEST_F(CommandLine, AFolderOfOtherFilesIsNotTakenForAProject) {
  const fs::path clip = write_clip("clip.mp4", 40);
  fs::create_directories(folder_ / "photos");
  std::ofstream(folder_ / "photos" / "a.txt") << "a";
  const ProgramResult result = likeness({"build", clip.string(), "--project", (folder_ / "photos").string()});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "photos"), fs::directory_iterator()), 1);
}

// A small file system of its own, filled or read-only. Needs the right to mount.
class SmallDisk {
 public:
  explicit SmallDisk(const fs::path& at) : at_(at) {
    fs::create_directories(at);
    mounted_ = ::mount("tmpfs", at.c_str(), "tmpfs", 0, "size=64k") == 0;
  }
  ~SmallDisk() {
    if (mounted_) ::umount(at_.c_str());
  }
  bool mounted() const { return mounted_; }
  bool make_read_only() const {
    return ::mount("tmpfs", at_.c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, nullptr) == 0;
  }

 private:
  fs::path at_;
  bool mounted_ = false;
};

TEST_F(CommandLine, AFullDiskIsNamedAndNothingIsLeft) {
  const SmallDisk disk(folder_ / "disk");
  if (!disk.mounted()) GTEST_SKIP() << "mounting a small disk is not permitted here";
  std::ofstream(folder_ / "disk" / "filler") << std::string(60000, 'x');
  const ProgramResult result =
      likeness({"demo", (folder_ / "disk" / "demo").string(), "--frames", "8", "--size", "96"});
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_NE(result.err.find("disk space"), std::string::npos) << result.err;
  EXPECT_FALSE(fs::exists(folder_ / "disk" / "demo" / "demo.mp4"));
}

TEST_F(CommandLine, AReadOnlyFolderIsNamed) {
  const fs::path clip = write_clip("clip.mp4", 40);
  const SmallDisk disk(folder_ / "disk");
  if (!disk.mounted() || !disk.make_read_only())
    GTEST_SKIP() << "mounting a small disk is not permitted here";
  const ProgramResult result =
      likeness({"build", clip.string(), "--project", (folder_ / "disk" / "p").string()});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("write"), std::string::npos) << result.err;
}

TEST_F(CommandLine, TrackRefusesAClipWithoutAFaceAndLeavesNothing) {
  std::ofstream(folder_ / "notes.mp4") << "This is not a film.\n";
  const fs::path broken = write_clip("broken.mp4", 40);
  fs::resize_file(broken, fs::file_size(broken) / 2);
  const std::pair<fs::path, std::string> cases[] = {{folder_ / "absent.mp4", "absent.mp4"},
                                                    {folder_ / "notes.mp4", "notes.mp4"},
                                                    {broken, "is cut short"},
                                                    {write_clip("nobody.mp4", 20), "face"}};
  for (const auto& [video, word] : cases) {
    const fs::path out = folder_ / "out";
    const ProgramResult result =
        likeness({"track", video.string(), "--out", (out / "track.json").string(), "--overlay",
                  (out / "over.mp4").string(), "--strip", (out / "strip.png").string(), "--json"});
    EXPECT_EQ(result.exit_code, 1) << video << result.err;
    EXPECT_NE(result.err.find(word), std::string::npos) << result.err;
    EXPECT_GE(std::count(result.err.begin(), result.err.end(), '\n'), 2) << "no remedy: " << result.err;
    EXPECT_FALSE(fs::exists(out)) << "something half-written was left";
  }
}

TEST_F(CommandLine, TrackWantsAFilmAndAPictureByTheirEndings) {
  EXPECT_EQ(likeness({"track", "a.mp4", "--out", "t.json", "--overlay", "over.avi"}).exit_code, 2);
  EXPECT_EQ(likeness({"track", "a.mp4", "--out", "t.json", "--strip", "strip.txt"}).exit_code, 2);
}

// Waits until the program catches SIGINT; before that the signal kills it, which looks like the same exit
// code.
bool listens_for_interrupts(pid_t child) {
  for (int i = 0; i < 500; ++i) {
    std::ifstream status("/proc/" + std::to_string(child) + "/status");
    for (std::string line; std::getline(status, line);)
      if (line.starts_with("SigCgt:") && (std::stoull(line.substr(7), nullptr, 16) >> (SIGINT - 1) & 1))
        return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

// SIGHUP: the terminal was closed.
TEST_F(CommandLine, TrackStopsOnRequestWithItsOwnExitCode) {
  const fs::path clip = write_clip("long.mp4", 600), out = folder_ / "track.json";
  for (const int number : {SIGINT, SIGHUP}) {
    const pid_t child =
        start_program({likeness_path(), "track", clip.string(), "--out", out.string()}, folder_);
    ASSERT_TRUE(listens_for_interrupts(child));
    ::kill(child, number);
    EXPECT_EQ(wait_program(child), 130) << number;
    EXPECT_FALSE(fs::exists(out));
  }
  std::ifstream file(folder_ / "err");
  const std::string said((std::istreambuf_iterator<char>(file)), {});
  EXPECT_NE(said.find("Stopped"), std::string::npos) << said;
  EXPECT_NE(said.find("starts over"), std::string::npos) << said;
}

TEST_F(CommandLine, VerbsOnAFolderThatIsNotAProjectSayWhatToDo) {
  for (const char* verb : {"fit", "train", "eval"}) {
    const ProgramResult result = likeness({verb, folder_.string()});
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_NE(result.err.find("likeness build"), std::string::npos) << result.err;
  }
  EXPECT_EQ(likeness({"render", folder_.string(), "--out", "x.mp4"}).exit_code, 1);
}

TEST_F(CommandLine, StudiesSayWhatTheyNeed) {
  const ProgramResult cameras = likeness({"study", "cameras", folder_.string()});
  EXPECT_EQ(cameras.exit_code, 1);
  EXPECT_NE(cameras.err.find("transforms.json"), std::string::npos) << cameras.err;
  const std::string folder = folder_.string();
  for (const auto& [words, needed] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"study", "truth", folder, folder, "--tables", "mattes"}, "not a Likeness project"},
           {{"study", "truth", folder, "--tables", "drive"}, "for a project"},
           {{"study", "truth", folder, folder}, "need no project"},
           {{"study", "truth", folder, "--marks", "m.json"}, "not a Likeness project"},
           {{"study", "truth", folder, folder, "--marks", "m.json"}, "need no demo"},
           {{"study", folder}, "where its report goes"},
           {{"study", folder, "--tables", "occupancy"}, "not a Likeness project"},
           {{"study", "track", "track.json"}, "--marks"},
           {{"study", "beyond", folder, "--out", folder}, "not a Likeness project"},
           {{"bench", "--tables", "settings"}, "no project"},
           {{"bench", folder, "--tables", "live"}, "--clip"},
           {{"bench", folder, "--tables", "field", "--clip", "x.mp4"}, "--clip"}}) {
    const ProgramResult result = likeness(words);
    EXPECT_EQ(result.exit_code, 1) << needed;
    EXPECT_NE(result.err.find(needed), std::string::npos) << needed << ": " << result.err;
  }
  EXPECT_EQ(likeness({"study", folder, "--tables", "magic"}).exit_code, 2);
  EXPECT_EQ(likeness({"study", "camera-kinds", "--clips", "rest-plain,rest-marble"}).exit_code, 2);
  for (const auto& [words, named] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"study", "beyond"}, "--out"},
           {{"study", "beyond", "--out", folder, "--person", "9"}, "--person"},
           {{"study", "beyond", folder, "--out", folder, "--person", "1"}, "project excludes --person"},
           {{"study", "beyond", "--out", folder, "--head-within", "90"}, "--head-within"},
           {{"study", "beyond", "--out", folder, "--action-share", "0"}, "--action-share"},
           {{"demo", folder, "--head-within", "0"}, "--head-within"},
           {{"demo", folder, "--action-share", "1.5"}, "--action-share"}}) {
    const ProgramResult result = likeness(words);
    EXPECT_EQ(result.exit_code, 2) << named;
    EXPECT_NE(result.err.find(named), std::string::npos) << named << ": " << result.err;
    EXPECT_NE(result.err.find("--help"), std::string::npos) << result.err;
  }
  EXPECT_EQ(likeness({"bench", "--json", "--csv"}).exit_code, 2);
  EXPECT_EQ(likeness({"demo", folder, "--displacement", folder}).exit_code, 2) << "where to?";
}

TEST_F(CommandLine, RemovedVerbsAndOptionsSayWhatToWriteNow) {
  for (const auto& [words, now] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"study", "gains", "p.likeness", "--out", "x", "--variants", "default"}, "--tables parts"},
           {{"study", "--threads", "2", "gains", "p.likeness"}, "--tables parts"},
           {{"study", "occupancy", "p.likeness"}, "study PROJECT --tables occupancy"},
           {{"study", "landmarks", "p.likeness"}, "study PROJECT --tables landmarks"},
           {{"study", "render", "p.likeness", "--frames", "6"}, "bench PROJECT --tables settings"},
           {{"study", "live", "p.likeness", "x.mp4"}, "bench PROJECT --tables live --clip CLIP"},
           {{"study", "marks", "track.json", "marks.json"}, "study track TRACK.json --marks"},
           {{"study", "mattes", "p.likeness", "demo"}, "study truth DEMO PROJECT --tables mattes"},
           {{"study", "drive", "--demo", "p.likeness", "demo"}, "study truth DEMO PROJECT --tables drive"},
           {{"study", "displacement", "p.likeness", "--demo", "demo", "--out", "maps"},
            "demo DEMO --displacement"},
           {{"study", "track", "--demo", "demo"}, "study truth DEMO"},
           {{"render", "p.likeness", "--drive", "x.mp4", "--out", "x.mp4"}, "drive PROJECT CLIP"}}) {
    const ProgramResult result = likeness(words);
    EXPECT_EQ(result.exit_code, 2) << now;
    EXPECT_NE((result.out + result.err).find(now), std::string::npos) << result.err;
  }
  for (const char* verb : {"study", "render"}) {
    const std::string help = likeness({verb, "--help"}).out;
    for (const char* gone : {"gains", "--drive", "was removed"})
      EXPECT_EQ(help.find(gone), std::string::npos) << verb << " " << gone;
  }
  // A project may have such a name.
  fs::create_directories(folder_ / "gains");
  std::ofstream(folder_ / "gains" / "project.json") << "{}";
  const ProgramResult named = run_program(
      {"sh", "-c", "cd \"$1\" && exec \"$2\" study gains --out x", "sh", folder_.string(), likeness_path()});
  EXPECT_EQ(named.exit_code, 1) << named.err;
  EXPECT_EQ((named.out + named.err).find("was removed"), std::string::npos) << named.err;
}

// On a terminal, and only there, it is asked first; whoever says no, or nothing, makes nothing.
TEST_F(CommandLine, ATerminalIsAskedWhetherThePersonAgreed) {
  const std::string clip = write_clip("a.mp4", 5).string(), project = (folder_ / "p.likeness").string();
  const auto at_terminal = [&](const char* answer, const std::vector<std::string>& arguments) {
    int terminal = -1;
    const pid_t child = ::forkpty(&terminal, nullptr, nullptr, nullptr);
    if (child == 0) {
      std::vector<std::string> words = arguments;
      words.insert(words.begin(), likeness_path());
      std::vector<char*> raw;
      for (std::string& word : words) raw.push_back(word.data());
      raw.push_back(nullptr);
      ::execv(raw[0], raw.data());
      ::_exit(127);
    }
    std::string said;
    char part[512];
    bool answered = false;
    for (ssize_t got; (got = ::read(terminal, part, sizeof part)) > 0;) {
      said.append(part, std::size_t(got));
      if (answered || said.find("anything else: no") == std::string::npos) continue;
      answered = ::write(terminal, answer, std::strlen(answer)) > 0;
    }
    ::close(terminal);
    return std::pair(wait_program(child), said);
  };
  const auto [refused, words] = at_terminal("\n", {"build", clip, "--project", project});
  EXPECT_EQ(refused, 1) << words;
  EXPECT_NE(words.find("Did the filmed person agree?"), std::string::npos) << words;
  EXPECT_FALSE(fs::exists(project));
  const auto [agreed, further] = at_terminal("g\n", {"build", clip, "--project", project});
  EXPECT_NE(further.find("5 frames"), std::string::npos) << "it went on: " << further;
  const auto [told, unasked] = at_terminal("", {"build", clip, "--project", project, "--consent", "self"});
  EXPECT_EQ(unasked.find("Did the filmed person agree?"), std::string::npos) << unasked;
  EXPECT_EQ(at_terminal("n\n", {"build", clip, "--project", project}).first, 1) << "no is no";
  EXPECT_EQ(at_terminal("no\n", {"record", (folder_ / "b.mp4").string()}).first, 1);
  EXPECT_FALSE(fs::exists(folder_ / "b.mp4"));
}

TEST_F(CommandLine, RecordNeedsANameAndAWebcam) {
  EXPECT_EQ(likeness({"record"}).exit_code, 2);
  const ProgramResult none =
      likeness({"record", (folder_ / "a.mp4").string(), "--webcam", "/dev/no_such_camera"});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_NE(none.err.find("/dev/no_such_camera"), std::string::npos) << none.err;
  EXPECT_FALSE(fs::exists(folder_ / "a.mp4"));
  const ProgramResult listed = likeness({"record", "--list", "--json"});
  EXPECT_EQ(listed.exit_code, 0);
  EXPECT_TRUE(nlohmann::json::parse(listed.out).at("webcams").is_array());
}

TEST_F(CommandLine, TheCheckDrawsItsPageOfAClipWithoutAFaceToo) {
  const fs::path page = folder_ / "page.png";
  const ProgramResult result =
      likeness({"check", write_clip("a.mp4", 12).string(), "--picture", page.string(), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out).at("verdict"), "refilm");
  EXPECT_GT(fs::file_size(page), 5000u);
}

}  // namespace
}  // namespace likeness::test
