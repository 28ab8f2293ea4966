// See names_like_options.h.
#include "app/names_like_options.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "app/standard_streams.h"

namespace likeness::app {

namespace {

// There is such a file, or it ends as a file's name does; numbers like -0.5 do not.
bool may_be_file(std::string_view word) {
  if (word.size() < 2 || word[0] != '-' || word.find('=') != std::string_view::npos) return false;
  std::error_code ignored;
  if (std::filesystem::exists(word, ignored)) return true;
  const std::string ending = std::filesystem::path(word).extension().string();
  return std::ranges::any_of(ending, [](unsigned char c) { return std::isalpha(c) != 0; });
}

}  // namespace

void tell_names_like_options(int argc, char** argv) {
  for (int i = 1; i < argc; ++i)
    if (may_be_file(argv[i])) tell("{} looks like an option; write ./{}\n", argv[i], argv[i]);
}

}  // namespace likeness::app
