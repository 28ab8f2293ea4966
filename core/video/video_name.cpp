// See video_name.h.
#include "core/video/video_name.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <string_view>

namespace likeness {

bool is_video_name(const std::filesystem::path& path) {
  constexpr std::array<std::string_view, 9> kEndings{".mp4", ".mov", ".m4v",  ".mkv", ".webm",
                                                     ".avi", ".3gp", ".mpeg", ".mts"};
  std::string ending = path.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return std::ranges::find(kEndings, ending) != kEndings.end();
}

}  // namespace likeness
