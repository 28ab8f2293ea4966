// A second clip of one person through the real command line: added, tracked with the first one's shape,
// trained from, and taken out again.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <nlohmann/json.hpp>

#include "tests/app/ask.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

TEST(FurtherClipsCommand, ASecondClipIsLearntFromAndCanBeTakenOut) {
  std::string name = (fs::temp_directory_path() / "likeness_two_XXXXXX").string();
  ASSERT_NE(::mkdtemp(name.data()), nullptr);
  const fs::path root = name, project = root / "p.likeness";
  const auto film = [&](const char* to, const char* light) {
    const ProgramResult demo = likeness({"demo", (root / to).string(), "--size", "320", "--frames", "32",
                                         "--moving-share", "0", "--samples", "1", "--light", light});
    EXPECT_EQ(demo.exit_code, 0) << demo.err;
    return (root / to / "demo.mp4").string();
  };
  const std::string first = film("first", "0"), second = film("second", "1");
  const json built = ask({"build", first, "--project", project.string(), "--steps", "16", "--json"});
  ASSERT_TRUE(built.at("stages").at("train").at("done").get<bool>());

  const json listed = ask({"clips", project.string(), "--add", second, "--resting-camera", "--json"});
  ASSERT_EQ(listed.at("clips").size(), 2u);
  EXPECT_EQ(listed.at("clips")[1].at("number"), 2);
  EXPECT_EQ(likeness({"clips", project.string(), "--add", second}).exit_code, 1);  // is there already

  const ProgramResult trained = likeness({"train", project.string(), "--steps", "24"});
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  EXPECT_NE(trained.err.find("Clip 2 (demo.mp4)"), std::string::npos) << trained.err;
  const json again = ask({"train", project.string(), "--steps", "24", "--json"});
  for (const auto& [stage, state] : again.at("stages").items())
    EXPECT_TRUE(state.at("done").get<bool>()) << stage;
  // Nothing of the second clip is held out: the first alone is measured.
  EXPECT_EQ(ask({"eval", project.string(), "--json"}).at("frames_test"), 3);
  const json card = ask({"card", project.string(), "--json"});
  // All that were not refused, of both clips.
  const auto taught = [](const fs::path& folder) {
    std::ifstream file(folder / "capture.json");
    return std::ranges::count_if(json::parse(file).at("frames"), [](const json& frame) {
      return frame.at("used").get<bool>() && !frame.at("held_out").get<bool>();
    });
  };
  EXPECT_EQ(card.at("frames").at("trained").get<long>(), taught(project) + taught(project / "clips" / "2"));
  EXPECT_GT(taught(project / "clips" / "2"), 20);
  // One person has one shape.
  const auto identity = [](const fs::path& folder) {
    std::ifstream file(folder / "track.json");
    return json::parse(file).at("identity");
  };
  EXPECT_EQ(identity(project), identity(project / "clips" / "2"));

  ask({"clips", project.string(), "--remove", "2", "--json"});
  EXPECT_FALSE(fs::exists(project / "clips"));
  EXPECT_TRUE(fs::exists(second));
  EXPECT_EQ(likeness({"clips", project.string(), "--remove", "2"}).exit_code, 1);
  fs::remove_all(root);
}

// Made of one film: its begin is the first clip, and later seconds of a longer one are added to it.
TEST(FurtherClipsCommand, SomeSecondsOfAFilmAreAddedAndOnlyTheyAreRead) {
  std::string name = (fs::temp_directory_path() / "likeness_seconds_XXXXXX").string();
  ASSERT_NE(::mkdtemp(name.data()), nullptr);
  const fs::path root = name, project = root / "p.likeness";
  const auto film = [&](const char* to, const char* frames) {
    const ProgramResult demo = likeness({"demo", (root / to).string(), "--size", "320", "--frames", frames,
                                         "--moving-share", "0", "--samples", "1"});
    EXPECT_EQ(demo.exit_code, 0) << demo.err;
    return (root / to / "demo.mp4").string();
  };
  const std::string first = film("first", "32"), second = film("second", "60");
  ask({"import", first, "--project", project.string(), "--json"});
  const auto refused = [&](std::vector<std::string> more, int code, const char* says) {
    std::vector<std::string> words{"clips", project.string()};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramResult result = likeness(words);
    EXPECT_EQ(result.exit_code, code) << says;
    EXPECT_NE(result.err.find(says), std::string::npos) << result.err;
  };
  refused({"--from", "1"}, 2, "--add");
  refused({"--add", second, "--from", "2", "--to", "1"}, 1, "not after second 2");
  refused({"--add", second, "--to", "0"}, 1, "not after second 0");
  refused({"--add", second, "--from", "1", "--to", "100"}, 1, "no second 100");
  refused({"--add", second, "--from", "nan"}, 1, "--from");
  refused({"--add", first, "--from", "0.5"}, 1, "first clip");

  const json listed = ask({"clips", project.string(), "--add", second, "--resting-camera", "--from", "0.8",
                           "--to", "2", "--json"});
  ASSERT_EQ(listed.at("clips").size(), 2u);
  EXPECT_EQ(listed.at("clips")[0].at("from_s"), 0);
  EXPECT_TRUE(listed.at("clips")[0].at("to_s").is_null());
  EXPECT_EQ(listed.at("clips")[1].at("from_s"), 0.8);
  EXPECT_EQ(listed.at("clips")[1].at("to_s"), 2);
  const ProgramResult again = likeness({"import", first, "--project", project.string()});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.err.find("from 0.8 s to 2 s"), std::string::npos) << again.err;
  std::ifstream file(project / "clips" / "2" / "capture.json");
  const json frames = json::parse(file).at("frames");
  ASSERT_FALSE(frames.empty());
  EXPECT_NEAR(frames.front().at("time_s").get<double>(), 0.8, 0.05);
  EXPECT_LT(frames.back().at("time_s").get<double>(), 2);
  EXPECT_GT(frames.back().at("time_s").get<double>(), 1.9);
  fs::remove_all(root);
}

}  // namespace
}  // namespace likeness::test
