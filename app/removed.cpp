// See removed.h.
#include "app/removed.h"

#include <filesystem>
#include <map>

#include <fmt/format.h>

namespace likeness::app {

void add_removed_option(CLI::App& verb, const std::string& option, const std::string& now) {
  const std::string before = verb.get_name() + " " + option;
  verb.add_option_function<std::vector<std::string>>(
          option,
          [option, before, now](const std::vector<std::string>&) {
            throw CLI::ValidationError(option, fmt::format("{} was removed. Now: likeness {}", before, now));
          })
      ->expected(0, CLI::detail::expected_max_vector_size)
      ->group("");
}

CLI::Validator no_removed_study() {
  static const std::map<std::string, std::string> now{
      {"gains",
       "study PROJECT --out DIR --tables parts --models NAME ... --size 0 --frames 0 --steps 300 --seeds 1"},
      {"occupancy", "study PROJECT --tables occupancy"},
      {"landmarks", "study PROJECT --tables landmarks"},
      {"render", "bench PROJECT --tables settings"},
      {"live", "bench PROJECT --tables live --clip CLIP"},
      {"marks", "study track TRACK.json --marks MARKS.json"},
      {"mattes", "study truth DEMO PROJECT --tables mattes"},
      {"drive", "study truth DEMO PROJECT --tables drive"},
      {"displacement", "demo DEMO --displacement PROJECT --out DIR"}};
  CLI::Validator validator(
      [](std::string& word) {
        const auto found = now.find(word);
        std::error_code ignored;
        if (found == now.end() ||
            std::filesystem::exists(std::filesystem::path(word) / "project.json", ignored))
          return std::string();
        return fmt::format("study {} was removed. Now: likeness {}", word, found->second);
      },
      "");
  return validator;
}

}  // namespace likeness::app
