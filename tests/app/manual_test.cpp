// Claims about the manual pages: they name every verb and option that --help names, and man reads them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <set>

#include "tests/support/run_program.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsSubsetOf;
using testing::Not;

std::string program_path(const std::string& name) { return std::string(LIKENESS_BIN) + "/" + name; }

// A page's words without roff's escapes.
std::string page_of(const std::string& program) {
  const ProgramResult page = run_program({program_path(program), "--man"});
  EXPECT_EQ(page.exit_code, 0) << page.err;
  std::string words = std::regex_replace(page.out, std::regex(R"(\\f[BIR])"), "");
  words = std::regex_replace(words, std::regex(R"(\\-)"), "-");
  return std::regex_replace(words, std::regex(R"(\\\(aq)"), "'");
}

std::set<std::string> options_in(const std::string& text) {
  static const std::regex option("(^|[^a-z-])(--[a-z][a-z-]+)");
  std::set<std::string> found;
  for (std::sregex_iterator it(text.begin(), text.end(), option), end; it != end; ++it)
    found.insert((*it)[2]);
  return found;
}

// First words of the lines under a heading of --help.
std::vector<std::string> listed_under(const std::string& help, const std::string& heading) {
  std::vector<std::string> names;
  std::istringstream lines(help.substr(std::min(help.size(), help.find(heading))));
  std::string line;
  for (std::getline(lines, line); std::getline(lines, line) && line.starts_with("  ");)
    if (line[2] != ' ') names.push_back(line.substr(2, line.find(' ', 2) - 2));
  return names;
}

std::string section(const std::string& page, const std::string& title) {
  const std::size_t begin = page.find(title);
  if (begin == std::string::npos) return {};
  const std::size_t end = page.find("\n.S", begin + 1);
  return page.substr(begin, end == std::string::npos ? end : end - begin);
}

// Every verb of this help, and its own verbs, with all of its options under its name.
void expect_verbs(const std::string& page, const std::vector<std::string>& before) {
  std::vector<std::string> ask = before;
  ask.push_back("--help");
  const ProgramResult help = likeness(ask);
  ASSERT_EQ(help.exit_code, 0);
  const auto verbs = listed_under(help.out, "Subcommands:");
  if (before.empty()) {
    EXPECT_GE(verbs.size(), 15u);
  } else if (verbs.empty()) {
    std::string name = before[0];
    for (std::size_t i = 1; i < before.size(); ++i) name += " " + before[i];
    EXPECT_THAT(options_in(help.out), IsSubsetOf(options_in(section(page, ".SS " + name + "\n")))) << name;
  }
  for (const std::string& verb : verbs) {
    std::vector<std::string> inner = before;
    inner.push_back(verb);
    expect_verbs(page, inner);
  }
}

TEST(Manual, NamesEveryVerbWithEveryOptionOfItsHelp) { expect_verbs(page_of("likeness"), {}); }

TEST(Manual, OfTheStudioNamesEveryOptionOfItsHelp) {
  const ProgramResult help = run_program({program_path("likeness-studio"), "--help"});
  ASSERT_EQ(help.exit_code, 0) << help.err;
  const std::set<std::string> options = options_in(help.out);
  EXPECT_GE(options.size(), 3u);
  EXPECT_THAT(options, IsSubsetOf(options_in(section(page_of("likeness-studio"), ".SH OPTIONS"))));
}

TEST(Manual, IsRoffThatManReadsWithoutAComplaint) {
  for (const char* program : {"likeness", "likeness-studio"}) {
    const fs::path file = fs::temp_directory_path() / (std::string(program) + "_manual_test.1");
    std::ofstream(file) << run_program({program_path(program), "--man"}).out;
    const ProgramResult read = run_program({"man", "--warnings=all", "--local-file", file.string()});
    fs::remove(file);
    if (read.exit_code == 127) GTEST_SKIP() << "the man program is not installed";
    EXPECT_EQ(read.exit_code, 0);
    EXPECT_EQ(read.err, "");
    EXPECT_THAT(read.out, HasSubstr("EXIT STATUS"));
    EXPECT_THAT(read.out, Not(HasSubstr("\\")));
  }
}

}  // namespace
}  // namespace likeness::test
