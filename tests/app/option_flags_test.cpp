// Claims about the flags of a project's choices: each is in the help and the manual of its verbs, and a value
// that a choice cannot have is refused by the flag's name.
#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/project/option_table.h"
#include "tests/support/run_program.h"

namespace likeness::test {
namespace {

struct ProjectVerb {
  const char* name;
  bool OptionVerbs::*takes;
  std::vector<std::string> required;
};

const std::vector<ProjectVerb>& project_verbs() {
  static const std::vector<ProjectVerb> verbs{
      {"build", &OptionVerbs::build, {"clip.mp4", "--project", "p"}},
      {"import", &OptionVerbs::import, {"clip.mp4", "--project", "p"}},
      {"align", &OptionVerbs::align, {"p"}},
      {"fit", &OptionVerbs::fit, {"p"}},
      {"train", &OptionVerbs::train, {"p"}}};
  return verbs;
}

// Whether a line of --help is about the flag. Others may mention it.
bool is_in_help(const std::string& help, const std::string& flag) {
  return std::regex_search(help, std::regex("\n  " + flag + "[^a-z-]"));
}

// The verb's own part of the manual, without roff's escapes.
std::string manual_of(const std::string& page, const std::string& verb) {
  const std::size_t begin = page.find(".SS " + verb + "\n");
  if (begin == std::string::npos) return {};
  const std::string own = page.substr(begin, page.find("\n.S", begin + 1) - begin);
  return std::regex_replace(own, std::regex(R"(\\-)"), "-");
}
bool is_in_manual(const std::string& part, const std::string& flag) {
  return part.find("\\fB" + flag + "\\fR") != std::string::npos;
}

// The command is judged and not run.
ProgramResult judged(const ProjectVerb& verb, const OptionRow& row, const std::string& value) {
  std::vector<std::string> words{"--parse-only", verb.name};
  words.insert(words.end(), verb.required.begin(), verb.required.end());
  words.insert(words.end(), {row.flag, value});
  return likeness(words);
}

// Of one verb: all add their flags by the same function.
void expect_refused(const OptionRow& row, const std::string& value) {
  for (const ProjectVerb& verb : project_verbs()) {
    if (!(row.verbs.*verb.takes)) continue;
    const ProgramResult result = judged(verb, row, value);
    EXPECT_EQ(result.exit_code, 2) << verb.name << " " << row.flag << " " << value;
    EXPECT_NE(result.err.find(row.flag), std::string::npos) << result.err;
    return;
  }
}

void expect_taken(const OptionRow& row, const std::string& value) {
  for (const ProjectVerb& verb : project_verbs()) {
    if (!(row.verbs.*verb.takes)) continue;
    EXPECT_EQ(judged(verb, row, value).exit_code, 0) << verb.name << " " << row.flag << " " << value;
    return;
  }
}

TEST(OptionFlags, AreInHelpAndManualOfTheirVerbsAndNoOthers) {
  const std::string page = likeness({"--man"}).out;
  for (const ProjectVerb& verb : project_verbs()) {
    const std::string help = likeness({verb.name, "--help"}).out, manual = manual_of(page, verb.name);
    for (const OptionRow& row : option_table()) {
      if (*row.flag == '\0') continue;
      const bool takes = row.verbs.*verb.takes;
      EXPECT_EQ(is_in_help(help, row.flag), takes) << verb.name << " " << row.flag;
      EXPECT_EQ(is_in_manual(manual, row.flag), takes) << verb.name << " " << row.flag;
    }
  }
}

TEST(OptionFlags, ANumberOutsideItsRangeIsRefusedByName) {
  for (const OptionRow& row : option_table()) {
    const bool whole = std::holds_alternative<OptionMember<int>>(row.member) ||
                       std::holds_alternative<OptionMember<std::uint64_t>>(row.member);
    if (*row.flag == '\0' || (!whole && !std::holds_alternative<OptionMember<double>>(row.member))) continue;
    const auto& [low, high, or_zero] = row.range;
    expect_refused(row, "much");
    expect_refused(row, fmt::format("{}", low > 0 ? low / 2 : -1));
    if (std::isfinite(high)) expect_refused(row, fmt::format("{}", 2 * high));
    if (!row.choices.empty()) {
      for (const int choice : row.choices) expect_taken(row, std::to_string(choice));
      expect_refused(row, std::to_string(row.choices.front() + 1));
      continue;
    }
    expect_taken(row, fmt::format("{}", low));
    if (std::isfinite(high)) expect_taken(row, fmt::format("{}", high));
    if (or_zero) expect_taken(row, "0");
  }
}

TEST(OptionFlags, AnUnknownChoiceIsRefusedByName) {
  for (const char* key : {"split", "mode"}) expect_refused(option_row(key), "guess");
  for (const char* name : {"tail", "views", "random30", "sides"}) expect_taken(option_row("split"), name);
  for (const char* name : {"auto", "static", "concat", "hyper", "warp", "warp+hyper"})
    expect_taken(option_row("mode"), name);
}

// Spans of frames add up; any other choice is given once.
TEST(OptionFlags, WhatIsKeptWithTheClipTakesOneWordEach) {
  const std::vector<std::string> refits{"--parse-only", "fit", "p", "--refit", "3-5", "--refit", "9"};
  EXPECT_EQ(likeness(refits).exit_code, 0);
  EXPECT_EQ(likeness({"--parse-only", "fit", "p", "--refit", "3-5", "9"}).exit_code, 2);
  for (const OptionRow& row : option_table())
    if (row.kept_with_clip) expect_taken(row, row.taken_back);
  EXPECT_EQ(likeness({"--parse-only", "train", "p", "--leave-out", "3", "--leave-out", "4"}).exit_code, 2);
}

}  // namespace
}  // namespace likeness::test
