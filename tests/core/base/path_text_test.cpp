// Claims about paths in JSON.
#include "core/base/path_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/base/json_text.h"

namespace likeness {
namespace {

TEST(PathText, NamesInUtf8StayAsTheyAre) {
  for (const char* name : {"", "/clips/a.mp4", "/clips/müller 李 🎬.mp4", "/x/\xf4\x8f\xbf\xbd"})
    EXPECT_EQ(text_of_path(name), name);
}

TEST(PathText, AnyBytesComeBackThroughJson) {
  std::string all = "/";
  for (int byte = 1; byte < 256; ++byte) all += char(byte);
  const std::string cut = "\xe6\x9d", overlong = "\xc0\xaf", surrogate = "\xed\xa0\x80",
                    beyond = "\xf4\x90\x80\x80";
  for (const std::string& name :
       {std::string("m\xfcller.mp4"), all, all + all, "a" + cut, cut + "a", overlong, surrogate, beyond,
        std::string("\xf4\x8f\xb9\x80"), std::string("\xf4\x8f\xb9")}) {
    const std::string text = text_of_path(name);
    const nlohmann::json value = {{"video", text}};
    const nlohmann::json read = parse_json(value.dump());  // which throws where the text is not UTF-8
    EXPECT_EQ(path_of_text(read.at("video").get<std::string>()).native(), name);
  }
}

}  // namespace
}  // namespace likeness
