#include "core/base/json_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

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

}  // namespace
}  // namespace likeness
