// Claims about performances: values between keys; files are whole, exact and strictly read.
#include "core/direct/performance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>

#include <nlohmann/json.hpp>

#include "core/base/files.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

std::vector<Key> keys_of(Easing easing, const std::vector<std::pair<double, float>>& points) {
  std::vector<Key> keys;
  for (const auto& [t, value] : points) keys.push_back({t, value, easing});
  return keys;
}

TEST(ValueAt, EveryEasingMeetsItsKeysAndHoldsBeyondThem) {
  for (const Easing easing :
       {Easing::linear, Easing::smooth, Easing::hold, Easing::ease_in, Easing::ease_out}) {
    const auto keys = keys_of(easing, {{1, 2}, {2, 5}, {4, -1}});
    for (const Key& key : keys) EXPECT_FLOAT_EQ(value_at(keys, key.time_s, 9), key.value);
    EXPECT_FLOAT_EQ(value_at(keys, 0, 9), 2);
    EXPECT_FLOAT_EQ(value_at(keys, 5, 9), -1);
    EXPECT_FLOAT_EQ(value_at(std::vector<Key>{}, 1, 9), 9);
  }
}

TEST(ValueAt, EasingsDifferAsTheirNamesSay) {
  const auto at = [](Easing easing, double t) { return value_at(keys_of(easing, {{0, 0}, {1, 1}}), t, 0); };
  EXPECT_FLOAT_EQ(at(Easing::linear, 0.25), 0.25f);
  EXPECT_FLOAT_EQ(at(Easing::smooth, 0.5), 0.5f);
  EXPECT_LT(at(Easing::smooth, 0.1), 0.05f);
  EXPECT_GT(at(Easing::smooth, 0.9), 0.95f);
  EXPECT_FLOAT_EQ(at(Easing::hold, 0.99), 0);
  EXPECT_LT(at(Easing::ease_in, 0.5), 0.2f);
  EXPECT_GT(at(Easing::ease_out, 0.5), 0.8f);
}

TEST(ValueAt, SmoothNeverOvershootsItsKeysAndHasNoCorner) {
  const auto keys = keys_of(Easing::smooth, {{0, 0}, {0.2, 0.1f}, {1, 4}, {1.5, 4}, {2.5, -3}, {2.6, -3.2f}});
  for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
    const float low = std::min(keys[i].value, keys[i + 1].value),
                high = std::max(keys[i].value, keys[i + 1].value);
    for (int s = 0; s <= 100; ++s) {
      const double t = keys[i].time_s + s / 100.0 * (keys[i + 1].time_s - keys[i].time_s);
      EXPECT_GE(value_at(keys, t, 0), low - 1e-5f);
      EXPECT_LE(value_at(keys, t, 0), high + 1e-5f);
    }
  }
  const double step = 1e-3;
  for (std::size_t i = 1; i + 1 < keys.size(); ++i) {
    const double t = keys[i].time_s, v = value_at(keys, t, 0);
    const double before = (v - value_at(keys, t - step, 0)) / step,
                 after = (value_at(keys, t + step, 0) - v) / step;
    EXPECT_NEAR(before, after, 0.1) << "corner at " << t;
  }
  // Through a key on the way there is no pause.
  const auto rising = keys_of(Easing::smooth, {{0, 0}, {1, 1}, {2, 2}});
  EXPECT_NEAR((value_at(rising, 1 + step, 0) - value_at(rising, 1 - step, 0)) / (2 * step), 1, 0.05);
}

TEST(Performance, ChannelsWithoutKeysAreAtRest) {
  const Performance performance;
  EXPECT_FLOAT_EQ(value_at(performance, "head yaw", 1), 0);
  EXPECT_FLOAT_EQ(value_at(performance, "camera distance", 1), 1);
  EXPECT_EQ(frame_count(performance), 100);
}

class PerformanceFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_performance_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    performance_.duration_s = 3.5;
    performance_.frames_per_second = 29.97;
    performance_.channels["head yaw"] = {{0, 0.1f, Easing::ease_in}, {1.0 / 3, -20, Easing::hold}};
    performance_.channels["action jawOpen"] = {{0.7, 0.3f, Easing::linear}};
    ASSERT_TRUE(write_performance(path(), performance_).ok());
    file_ = json::parse(*read_text(path()));
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path path() const { return folder_ / "p.json"; }

  // The reader's error for the changed file.
  std::string refusal(const json& changed) {
    EXPECT_TRUE(write_text(path(), changed.dump()).ok());
    const auto read = read_performance(path());
    if (read.ok()) return "";
    EXPECT_EQ(read.error().code, ErrorCode::bad_input);
    EXPECT_FALSE(read.error().fix.empty());
    return read.error().what;
  }

  fs::path folder_;
  Performance performance_;
  json file_;
};

TEST_F(PerformanceFile, RoundTripsExactly) {
  const auto read = read_performance(path());
  ASSERT_TRUE(read.ok()) << read.error().what;
  EXPECT_EQ(*read, performance_);
}

TEST_F(PerformanceFile, NamesTheFieldThatIsWrong) {
  const auto changed = [&](const char* pointer, const json& value) {
    json copy = file_;
    copy[json::json_pointer(pointer)] = value;
    return refusal(copy);
  };
  EXPECT_THAT(changed("/version", 2), HasSubstr("version"));
  EXPECT_THAT(changed("/format", "likeness track"), HasSubstr("format"));
  EXPECT_THAT(changed("/duration_s", -1), HasSubstr("duration_s"));
  EXPECT_THAT(changed("/frames_per_second", "25"), HasSubstr("frames_per_second"));
  EXPECT_THAT(changed("/colour", 1), HasSubstr("colour"));
  EXPECT_THAT(changed("/channels/head yaw/1/time_s", 0), HasSubstr("channels.\"head yaw\"[1].time_s"));
  EXPECT_THAT(changed("/channels/head yaw/0/value", nullptr), HasSubstr("channels.\"head yaw\"[0].value"));
  EXPECT_THAT(changed("/channels/head yaw/0/value", 1e30), HasSubstr("channels.\"head yaw\"[0].value"));
  EXPECT_THAT(changed("/channels/head yaw/0/easing", "bounce"), HasSubstr("channels.\"head yaw\"[0].easing"));
  EXPECT_THAT(changed("/channels/head yaw/0/tension", 1), HasSubstr("channels.\"head yaw\"[0].tension"));
  EXPECT_THAT(changed("/channels/jawOpen", json::array()), HasSubstr("jawOpen"));
  EXPECT_THAT(changed("/channels/head roll", json::array()), HasSubstr("head roll"));
  json without = file_;
  without.erase("duration_s");
  EXPECT_THAT(refusal(without), HasSubstr("duration_s is missing"));
  EXPECT_THAT(refusal(json::array()), HasSubstr("not an object"));
}

TEST_F(PerformanceFile, RefusesATruncatedFile) {
  const std::string whole = *read_text(path());
  ASSERT_TRUE(write_text(path(), whole.substr(0, whole.size() / 2)).ok());
  EXPECT_FALSE(read_performance(path()).ok());
  EXPECT_EQ(read_performance(folder_ / "absent.json").error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace likeness::test
