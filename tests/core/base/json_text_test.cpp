#include "core/base/json_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

namespace likeness {
namespace {

TEST(JsonText, ComesBackAsItWas) {
  const nlohmann::json value{{"name", "Ada"}, {"sizes", {1, 2.5, -3e-9}}, {"none", nullptr}, {"on", true}};
  EXPECT_EQ(parse_json(json_text(value)), value);
  EXPECT_EQ(try_parse_json(json_text(value, 2)), value);
  EXPECT_EQ(json_text(value["sizes"]), "[1,2.5,-3e-09]");
  EXPECT_EQ(json_text(nlohmann::json{{"a", 1}}, 1), "{\n \"a\": 1\n}");
}

TEST(JsonText, TextThatIsNotJsonIsRefused) {
  for (const char* text : {"", "{", "{\"a\":1}}", "[1,]", "nul"}) {
    EXPECT_THROW(parse_json(text), nlohmann::json::parse_error) << text;
    EXPECT_TRUE(try_parse_json(text).is_discarded()) << text;
  }
}

TEST(JsonText, BytesThatAreNotUtf8) {
  const nlohmann::json value{{"file", "caf\xe9.mp4"}};
  EXPECT_EQ(json_text(value), "{\"file\":\"caf\xef\xbf\xbd.mp4\"}");
}

// What is read is compared, handed on and written again by functions that call themselves.
TEST(JsonText, TextThatIsNestedTooDeeplyIsRefused) {
  const auto nested = [](int depth) {
    return std::string(std::size_t(depth), '[') + std::string(std::size_t(depth), ']');
  };
  EXPECT_NO_THROW(parse_json(nested(kDeepestJson)));
  for (const std::string& text : {nested(kDeepestJson + 1), nested(200'000), std::string(200'000, '[')}) {
    EXPECT_THROW(parse_json(text), nlohmann::json::parse_error);
    EXPECT_TRUE(try_parse_json(text).is_discarded());
  }
  EXPECT_EQ(parse_json("[\"" + std::string(100, '[') + "\\\"[\"]").size(), 1u) << "brackets in text are none";
}

// get<int>() makes 1 of it.
TEST(JsonText, WholeNumbersBeyond32BitsAreRefused) {
  const nlohmann::json values = parse_json("[1, -2, 4294967297, 1e300]");
  EXPECT_EQ(whole_number_in(values[1]), -2);
  EXPECT_THROW(whole_number_in(values[2]), nlohmann::json::exception);
  EXPECT_THROW(whole_numbers_in(values), nlohmann::json::exception);
  EXPECT_THROW(whole_numbers_in(values[0]), nlohmann::json::exception);
  EXPECT_THROW(numbers_in(values), nlohmann::json::exception);
  EXPECT_EQ(whole_numbers_in(parse_json("[3, 4]")), (std::vector<int>{3, 4}));
  EXPECT_EQ(numbers_in(parse_json("[0.5, 4]")), (std::vector<float>{0.5f, 4}));
}

TEST(JsonText, NumbersHaveARange) {
  EXPECT_EQ(whole_number_in(nlohmann::json(7), 1, 9), 7);
  EXPECT_EQ(number_in(nlohmann::json(0.5), 0, 1), 0.5);
  for (const char* text : {"10", "1e300", "-1e300", "null", "\"7\""}) {
    EXPECT_THROW(whole_number_in(parse_json(text), 1, 9), nlohmann::json::exception) << text;
    EXPECT_THROW(number_in(parse_json(text), 1, 9), nlohmann::json::exception) << text;
  }
}

}  // namespace
}  // namespace likeness
