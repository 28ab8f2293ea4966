// An attribute through the real command line: the demo person's habit of puffing a cheek, which no expression
// of the head model carries, painted on a few frames; its amounts held against the truth; trained, measured,
// rendered and taken back.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/image/files.h"
#include "tests/app/ask.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double n = double(a.size()), x = 0, y = 0, xx = 0, yy = 0, xy = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    x += a[i], y += b[i], xx += a[i] * a[i], yy += b[i] * b[i], xy += a[i] * b[i];
  return (n * xy - x * y) / std::sqrt(std::max(1e-12, (n * xx - x * x) * (n * yy - y * y)));
}

class AttributeCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string name = (fs::temp_directory_path() / "likeness_attribute_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name, project_ = root_ / "p.likeness";
    const ProgramResult demo = likeness({"demo", (root_ / "demo").string(), "--size", "320", "--frames", "60",
                                         "--moving-share", "0", "--samples", "1", "--habit"});
    ASSERT_EQ(demo.exit_code, 0) << demo.err;
    const ProgramResult built = likeness({"build", (root_ / "demo" / "demo.mp4").string(), "--project",
                                          project_.string(), "--steps", "12", "--json"});
    ASSERT_EQ(built.exit_code, 0) << built.err;
    std::ifstream file(root_ / "demo" / "habit_truth.json");
    strengths_ = json::parse(file).at("strengths").get<std::vector<double>>();
  }
  static void TearDownTestSuite() { fs::remove_all(root_); }

  static ProgramResult add(int frame, double value, std::vector<std::string> region) {
    std::vector<std::string> command{
        "attribute",           "add",     project_.string(),    "cheek puff", "--frame",
        std::to_string(frame), "--value", std::to_string(value)};
    command.insert(command.end(), region.begin(), region.end());
    return likeness(command);
  }
  static std::string truth_mask(int frame) {
    return (root_ / "demo" / "habit_truth" / fmt::format("{:06d}.png", frame)).string();
  }

  inline static fs::path root_, project_;
  inline static std::vector<double> strengths_;
};

TEST_F(AttributeCommand, SaysWhatCannotBePainted) {
  const auto why = [](const ProgramResult& result) {
    EXPECT_EQ(result.exit_code, 1) << result.err;
    return result.err;
  };
  EXPECT_NE(why(add(5, 1, {})).find("Nothing says where"), std::string::npos);
  EXPECT_NE(why(add(59, 1, {"--box", "100,100,150,150"})).find("held out"), std::string::npos);
  EXPECT_NE(why(add(999, 1, {"--box", "100,100,150,150"})).find("does not hold"), std::string::npos);
  EXPECT_NE(why(add(5, 1, {"--box", "9,9,9,20"})).find("empty"), std::string::npos);
  EXPECT_NE(why(add(5, 1, {"--box", "nan,9,0,inf"})).find("empty"), std::string::npos);
  EXPECT_NE(why(add(5, 1, {"--box", "5000,5000,9e9,9e9"})).find("empty"), std::string::npos);
  EXPECT_NE(why(add(5, 1, {"--region", (root_ / "none.png").string()})).find("none.png"), std::string::npos);
  Image8 small(10, 10, 1, 255);
  ASSERT_TRUE(write_image(root_ / "small.png", small).ok());
  EXPECT_NE(why(add(5, 1, {"--region", (root_ / "small.png").string()})).find("10 x 10"), std::string::npos);
  EXPECT_NE(why(likeness({"attribute", "remove", project_.string(), "cheek puff"})).find("no attribute"),
            std::string::npos);
  EXPECT_NE(why(likeness({"attribute", "values", project_.string()})).find("No attributes"),
            std::string::npos);
  EXPECT_FALSE(fs::exists(project_ / "attributes.json"));
}

TEST_F(AttributeCommand, AHabitIsPaintedFoundTrainedAndTakenBack) {
  // -- Frames of each of the two swells, and some without. Import may have refused one or two for their blur.
  int painted = 0;
  for (const int frame : {1, 5, 6, 7, 12, 16, 18, 20, 21, 32, 33, 40}) {
    std::vector<std::string> region;
    if (strengths_[std::size_t(frame)] >= 0.95) region = {"--region", truth_mask(frame)};
    if (painted == 0) {  // somebody starts with one that shows it
      region = {"--region", truth_mask(frame)};
      ASSERT_TRUE(fs::exists(truth_mask(frame))) << frame;
    }
    const ProgramResult added = add(frame, strengths_[std::size_t(frame)], region);
    painted += added.exit_code == 0;
  }
  ASSERT_GE(painted, 7);
  const json list = ask({"attribute", "list", project_.string(), "--json"});
  EXPECT_EQ(list.at("attributes")[0].at("annotations").size(), std::size_t(painted));

  // -- Amounts against the truth, of frames nobody painted on.
  const json values = ask({"attribute", "values", project_.string(), "--json"}).at("attributes")[0];
  std::vector<double> found, truth;
  for (std::size_t i = 0; i < values.at("frames").size(); ++i) {
    found.push_back(values.at("values")[i]);
    truth.push_back(strengths_[values.at("frames")[i].get<std::size_t>()]);
  }
  ASSERT_GT(found.size(), 40u);
  EXPECT_GT(correlation(found, truth), 0.7);

  // -- Trained, measured and used by name.
  const ProgramResult trained = likeness({"train", project_.string(), "--steps", "24"});
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  EXPECT_NE(trained.err.find("cheek puff"), std::string::npos) << "the training says so: " << trained.err;
  EXPECT_GT(ask({"eval", project_.string(), "--json"}).at("frames_test").get<int>(), 2);
  const json actions = ask({"render", project_.string(), "--list-actions", "--json"});
  ASSERT_EQ(actions.at("attributes").size(), 1u);
  EXPECT_GT(actions.at("attributes")[0].at("high").get<double>(), 0.7);
  const auto picture = [&](const std::string& name, const std::vector<std::string>& how) {
    std::vector<std::string> command{"render", project_.string(), "--out", (root_ / name).string()};
    command.insert(command.end(), how.begin(), how.end());
    const ProgramResult result = likeness(command);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const auto image = read_image(root_ / name);
    return image ? image->data : std::vector<std::uint8_t>{};
  };
  const auto rest = picture("rest.png", {}), none = picture("none.png", {"--expression", "cheek puff=0"}),
             most = picture("most.png", {"--expression", "cheek puff=1"}),
             more = picture("more.png", {"--expression", "cheek puff=9"});
  EXPECT_EQ(rest, none);
  EXPECT_NE(rest, most);
  EXPECT_EQ(most, more) << "held within what was seen";
  const ProgramResult unknown = likeness(
      {"render", project_.string(), "--expression", "no such=1", "--out", (root_ / "x.png").string()});
  EXPECT_EQ(unknown.exit_code, 1);
  const ProgramResult driven = likeness({"drive", project_.string(), (root_ / "demo" / "demo.mp4").string(),
                                         "--attribute", "no such=1", "--out", (root_ / "x.mp4").string()});
  EXPECT_EQ(driven.exit_code, 1);
  EXPECT_NE(driven.err.find("cheek puff"), std::string::npos) << driven.err;

  // -- Taken back, the project is as it was.
  ASSERT_EQ(likeness({"attribute", "remove", project_.string(), "cheek puff"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(project_ / "attributes.json"));
}

}  // namespace
}  // namespace likeness::test
