// An avatar trained on the middle of a turning head and measured at its sides, through the real command line.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "core/image/files.h"
#include "tests/support/run_program.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class SidesStudyCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string name = (fs::temp_directory_path() / "likeness_sides_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    const ProgramResult demo = likeness({"demo", (folder_ / "demo").string(), "--size", "224", "--frames",
                                         "60", "--moving-share", "0", "--samples", "1"});
    ASSERT_EQ(demo.exit_code, 0) << demo.err;
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }
  static std::string project() { return (folder_ / "p.likeness").string(); }
  static ProgramResult build(const std::string& inside, const std::string& beyond) {
    return likeness({"build", (folder_ / "demo" / "demo.mp4").string(), "--project", project(), "--steps",
                     "40", "--split", "sides", "--inside", inside, "--beyond", beyond, "--json"});
  }

  static inline fs::path folder_;
};

TEST_F(SidesStudyCommand, ATurnThatIsNotThereIsRefusedInWords) {
  const ProgramResult result = build("22", "70");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("degrees off its typical side"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("--beyond"), std::string::npos) << result.err;
}

TEST_F(SidesStudyCommand, ScoresBothKindsOfHeldOutFramesAndShowsThem) {
  const ProgramResult built = build("22", "28");
  ASSERT_EQ(built.exit_code, 0) << built.err;
  const fs::path out = folder_ / "out";
  const ProgramResult result = likeness({"study", "beyond", project(), "--out", out.string(), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json study = json::parse(result.out);
  EXPECT_EQ(study.at("inside_deg"), 22);
  EXPECT_EQ(study.at("beyond_deg"), 28);
  EXPECT_EQ(study.at("holds").at("yaw").size(), 2u);
  EXPECT_TRUE(study.at("holds").at("actions").contains("jawOpen"));
  EXPECT_EQ(study.at("actions").at(0).at("name"), "jawOpen") << "by the avatar's own check";
  const json& frames = study.at("frames");
  EXPECT_GE(frames.at("trained").get<int>(), 20);
  EXPECT_GE(frames.at("inside").get<int>(), 2);
  EXPECT_GE(frames.at("beyond").get<int>(), 5);
  EXPECT_GE(frames.at("apart").get<int>(), 1);
  EXPECT_EQ(study.at("steps"), 40);
  for (const char* key : {"psnr_head_db", "psnr_face_db", "psnr_person_db"})
    EXPECT_GT(study.at("inside").at(key).get<double>(), 12) << key;
  EXPECT_EQ(study.at("inside").at("drift"), 0);  // off itself
  int counted = study.at("inside").at("frames").get<int>();
  ASSERT_FALSE(study.at("views").empty());
  for (const json& view : study.at("views")) {
    counted += view.at("frames").get<int>();
    EXPECT_GT(std::max(std::abs(view.at("yaw").get<double>()), std::abs(view.at("pitch").get<double>())), 10)
        << view;
    const double main = view.at(view.at("of").get<std::string>()).get<double>();
    EXPECT_GE(main, view.at("from_deg").get<double>()) << view;
    EXPECT_LE(main, view.at("to_deg").get<double>()) << view;
    EXPECT_TRUE(view.at("psnr_head_db").is_number()) << view;
    EXPECT_GT(view.at("iou").get<double>(), 0.3) << view;
    EXPECT_TRUE(view.at("depth_mm").is_null());
  }
  int off = 0;
  for (const json& row : study.at("off")) off += row.at("frames").get<int>();
  EXPECT_EQ(off, counted - study.at("inside").at("frames").get<int>());
  EXPECT_EQ(counted + frames.at("lost").get<int>(),
            frames.at("inside").get<int>() + frames.at("beyond").get<int>());
  const auto sheet = read_image(out / "sides.png");
  ASSERT_TRUE(sheet.ok()) << sheet.error().what;
  EXPECT_EQ(sheet->height % (2 * 256), 0);
  EXPECT_TRUE(fs::exists(out / "views.csv"));
}

TEST_F(SidesStudyCommand, AProjectWithoutAnAvatarIsRefused) {
  const std::string other = (folder_ / "tail.likeness").string();
  const ProgramResult imported =
      likeness({"import", (folder_ / "demo" / "demo.mp4").string(), "--project", other});
  ASSERT_EQ(imported.exit_code, 0) << imported.err;
  const ProgramResult result =
      likeness({"study", "beyond", other, "--out", (folder_ / "none").string(), "--json"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("holds no trained avatar"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace likeness::test
