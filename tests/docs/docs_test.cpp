// Claims about every page of the repository: links and anchors lead somewhere, files that are named exist,
// and commands that are shown are understood. Nothing here knows a verb or an option: commands are given to
// the program itself, with --parse-only.
//
// Rules, for whoever writes a page:
// - `code` stands on one line. Links are `[words](target)` and `<img src="target">`; a target with a scheme
//   is not looked at.
// - A file or folder is named by `code` without blanks that begins with a top-level folder and a slash, or
//   that is a page of the root (`CONTRIBUTING.md`). Without an ending it stands for all files of that stem
//   (`core/base/result`); code with one of <>*{}$ names none.
// - A command is what begins with `likeness ` or with the path of one of our scripts, in a code block or in
//   `code`: so the whole of it has to be there, and a verb by itself is written without the program. A word
//   that begins with # begins a remark, a backslash at the end of a line joins the next, and && ; | separate
//   commands.
// - [An optional part] is tried as if it were there, "..." is left out, and of a word with a | each
//   alternative is tried, with the first of all others.
// - Placeholders are in capitals. DIR is a folder and FILE or FILE.mp4 a file that is there; those of
//   kNumbers stand for that number; any other stands for itself, and so does a clip's or a project's name.
// - A script's options must stand in its own text: it is not run.
// - The changelog speaks of earlier versions: only its links are looked at.
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "core/base/files.h"
#include "tests/docs/source_folder.h"
#include "tests/support/run_program.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;
using Command = std::vector<std::string>;  // words

const std::map<std::string, std::string> kNumbers{{"N", "2"},        {"SECONDS", "60"}, {"STEPS", "400"},
                                                  {"SEED", "1"},     {"FRAME", "120"},  {"MM", "28"},
                                                  {"WEIGHT", "0.1"}, {"AMOUNT", "0.5"}};

bool is_page(const fs::path& file) { return file.extension() == ".md"; }

// Folders that hold what is made, not what is written.
bool is_made(const fs::path& folder) {
  const std::string name = folder.filename();
  return name == "build" || name == "likeness-out" || name == ".git" || name == ".cache" ||
         folder.extension() == ".likeness";
}

struct Page {
  fs::path file, name;            // name: from the root
  std::string text;               // without code blocks
  std::string blocks;             // the code blocks' lines
  std::vector<std::string> code;  // `code` in the text
};

// A line of four blanks after an empty one, or after another such line, is code; in a list it is not.
Page read_page(const fs::path& file) {
  Page page{file, file.lexically_relative(kSource), "", "", {}};
  const auto text = read_text(file);
  EXPECT_TRUE(text.ok()) << file;
  std::istringstream lines(text.ok() ? *text : "");
  bool fenced = false, block = false, empty = true, list = false;
  for (std::string line; std::getline(lines, line); empty = line.empty()) {
    if (line.find_first_not_of(' ') != std::string::npos &&
        line.substr(line.find_first_not_of(' ')).starts_with("```")) {
      fenced = !fenced;
      continue;
    }
    if (!line.empty() && line[0] != ' ') list = std::regex_search(line, std::regex(R"(^([-*]|\d+\.) )"));
    block = !fenced && !list && line.starts_with("    ") && (empty || block);
    (fenced || block ? page.blocks : page.text) += line + "\n";
  }
  static const std::regex ticks("`([^`\n]+)`");
  for (std::sregex_iterator it(page.text.begin(), page.text.end(), ticks), end; it != end; ++it)
    page.code.push_back((*it)[1]);
  return page;
}

std::vector<Page> all_pages() {
  std::vector<Page> pages;
  for (auto it = fs::recursive_directory_iterator(kSource); it != fs::recursive_directory_iterator(); ++it) {
    if (it->is_directory() && is_made(it->path())) it.disable_recursion_pending();
    if (it->is_regular_file() && is_page(it->path())) pages.push_back(read_page(it->path()));
  }
  return pages;
}

bool is_history(const Page& page) { return page.name == "CHANGELOG.md"; }

TEST(Docs, CodeStandsOnOneLine) {
  for (const Page& page : all_pages()) {
    std::istringstream lines(page.text);
    for (std::string line; std::getline(lines, line);)
      EXPECT_EQ(std::count(line.begin(), line.end(), '`') % 2, 0) << page.name << ": " << line;
  }
}

// -- Links

// What GitHub makes of a heading: lower case, blanks as hyphens, no punctuation but hyphens and underscores.
std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (const char c : heading) {
    if (c == ' ')
      anchor += '-';
    else if (std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' || (c & 0x80))
      anchor += char(std::tolower(static_cast<unsigned char>(c)));
  }
  return anchor;
}

std::set<std::string> anchors_of(const Page& page) {
  std::set<std::string> anchors;
  std::istringstream lines(page.text);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("#")) anchors.insert(anchor_of(line.substr(line.find_first_not_of("# "))));
  return anchors;
}

std::vector<std::string> links_of(const Page& page) {
  const std::string text = std::regex_replace(page.text, std::regex("`[^`\n]+`"), "");
  std::vector<std::string> links;
  for (const char* form : {R"(\]\(([^)\s]+)\))", R"re(<img[^>]* src="([^"]+)")re"}) {
    const std::regex link(form);
    for (std::sregex_iterator it(text.begin(), text.end(), link), end; it != end; ++it)
      links.push_back((*it)[1]);
  }
  return links;
}

TEST(Docs, LinksAndAnchorsLeadSomewhere) {
  std::size_t looked_at = 0;
  for (const Page& page : all_pages()) {
    for (const std::string& link : links_of(page)) {
      if (std::regex_search(link, std::regex("^[a-z]+:"))) continue;
      ++looked_at;
      const std::string path = link.substr(0, link.find('#'));
      const fs::path target = path.empty() ? page.file : page.file.parent_path() / path;
      EXPECT_TRUE(fs::exists(target)) << page.name << ": " << link;
      if (link.find('#') == std::string::npos || !is_page(target) || !fs::exists(target)) continue;
      EXPECT_TRUE(anchors_of(read_page(target)).contains(link.substr(link.find('#') + 1)))
          << page.name << ": " << link;
    }
  }
  EXPECT_GT(looked_at, 20u);
}

// -- Files

// What begins as a path of the repository's does.
bool names_a_file(const std::string& code) {
  if (code.find_first_of(" <>*{}$\u2026") != std::string::npos) return false;
  if (code.find('/') == std::string::npos) return std::regex_match(code, std::regex("[A-Z_]+\\.md"));
  static const std::set<std::string> tops = [] {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(kSource))
      if (entry.is_directory() && !is_made(entry.path())) names.insert(entry.path().filename());
    return names;
  }();
  return tops.contains(code.substr(0, code.find('/')));
}

bool file_exists(const std::string& code) {
  const fs::path path = kSource / code;
  if (fs::exists(path)) return true;
  if (path.has_extension() || !fs::is_directory(path.parent_path())) return false;
  for (const auto& entry : fs::directory_iterator(path.parent_path()))
    if (entry.path().stem() == path.filename()) return true;
  return false;
}

TEST(Docs, FilesThatAreNamedExist) {
  std::size_t looked_at = 0;
  for (const Page& page : all_pages()) {
    if (is_history(page)) continue;
    for (const std::string& code : page.code) {
      if (!names_a_file(code)) continue;
      ++looked_at;
      EXPECT_TRUE(file_exists(code)) << page.name << ": " << code;
    }
  }
  EXPECT_GT(looked_at, 50u);
  EXPECT_FALSE(names_a_file("likeness eval"));
  EXPECT_TRUE(file_exists("core/base/result"));
  EXPECT_FALSE(file_exists("core/base/nothing"));
}

// -- Commands

// A shell's words of one line, cut where another command begins. Quotes hold a word together.
std::vector<Command> commands_in(const std::string& line) {
  std::vector<Command> commands(1);
  std::string word;
  bool any = false;  // of the word, be it empty
  char quote = 0;
  const auto end_word = [&] {
    if (any) commands.back().push_back(word);
    word.clear();
    any = false;
  };
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quote) {
      if (c == quote)
        quote = 0;
      else
        word += c;
    } else if (c == '"' || c == '\'') {
      quote = c, any = true;
    } else if (c == '#' && !any) {
      break;
    } else if (c == ' ') {
      end_word();
    } else if (line.compare(i, 2, "&&") == 0 || c == ';' || (c == '|' && !any)) {
      end_word();
      commands.emplace_back();
      if (c == '&') ++i;
    } else {
      word += c, any = true;
    }
  }
  end_word();
  return commands;
}

bool is_script(const std::string& word) {
  return word.find('/') != std::string::npos && names_a_file(word) && fs::is_regular_file(kSource / word) &&
         ::access((kSource / word).c_str(), X_OK) == 0;
}

bool is_ours(const Command& command) {
  return command.size() > 1 ? command[0] == "likeness" || is_script(command[0])
                            : command.size() == 1 && is_script(command[0]);
}

// Without the brackets of optional parts and without dots; one command for each alternative, with the first
// of all others.
std::vector<Command> spelled_out(const Command& command) {
  std::vector<Command> choices;  // of each word
  for (const std::string& shown : command) {
    std::istringstream word(std::regex_replace(shown, std::regex(R"(\[|\]|\.\.\.)"), ""));
    Command alternatives;
    for (std::string one; std::getline(word, one, '|');) alternatives.push_back(one);
    if (!alternatives.empty()) choices.push_back(alternatives);
  }
  Command first;
  for (const Command& choice : choices) first.push_back(choice[0]);
  std::vector<Command> all{first};
  for (std::size_t w = 0; w < choices.size(); ++w)
    for (std::size_t a = 1; a < choices[w].size(); ++a) {
      all.push_back(first);
      all.back()[w] = choices[w][a];
    }
  return all;
}

class DocsCommands : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_docs_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  // A word with what its placeholder stands for; NAME=AMOUNT has two.
  std::string filled_in(const std::string& word) {
    if (const auto equals = word.find('='); equals != std::string::npos && equals > 0)
      return word.substr(0, equals + 1) + filled_in(word.substr(equals + 1));
    if (const auto number = kNumbers.find(word); number != kNumbers.end()) return number->second;
    if (word == "DIR") return folder_.string();
    if (word == "FILE" || word.starts_with("FILE.")) {
      std::ofstream(folder_ / word).put('\n');
      return (folder_ / word).string();
    }
    return word;
  }

  // A script's options must stand in its text; what the program is to judge is collected.
  void take(const Command& shown, const std::string& where) {
    for (Command command : spelled_out(shown)) {
      if (command[0] == "likeness") {
        std::string line;
        for (std::size_t w = 1; w < command.size(); ++w) line += (w > 1 ? "\t" : "") + filled_in(command[w]);
        lines_.emplace(line, where);
        continue;
      }
      const auto text = read_text(kSource / command[0]);
      ASSERT_TRUE(text.ok()) << where;
      for (const std::string& word : command)
        EXPECT_TRUE(!word.starts_with("--") || text->find(word) != std::string::npos)
            << where << ": " << word;
    }
  }

  // Gives the collected lines to the program, all at once: it takes longer to start than to understand them.
  ProgramResult judge() {
    std::ofstream file(folder_ / "lines");
    for (const auto& [line, where] : lines_) file << line << "\n";
    file.close();
    return run_program({"sh", "-c", likeness_path() + " --parse-only < " + (folder_ / "lines").string()});
  }

  fs::path folder_;
  std::map<std::string, std::string> lines_;  // and the page that shows it
};

TEST_F(DocsCommands, ThoseThatAreShownAreUnderstood) {
  for (const Page& page : all_pages()) {
    if (is_history(page)) continue;
    std::string lines = std::regex_replace(page.blocks, std::regex(R"(\\\n)"), " ");
    for (const std::string& code : page.code) lines += code + "\n";
    std::istringstream all(lines);
    for (std::string line; std::getline(all, line);)
      for (const Command& command : commands_in(line))
        if (is_ours(command)) take(command, page.name.string());
  }
  EXPECT_GT(lines_.size(), 40u);
  const ProgramResult result = judge();
  std::istringstream said(result.out);
  for (std::string line; std::getline(said, line);)
    ADD_FAILURE() << (lines_.contains(line) ? lines_[line] + ": " : "") << line;
  EXPECT_EQ(result.exit_code, 0) << result.err;
}

TEST_F(DocsCommands, PlaceholdersAndOptionalPartsAreTried) {
  const auto commands =
      commands_in("likeness eval me.likeness --quality final|preview [--lpips FILE.onnx]  # twice");
  ASSERT_EQ(commands.size(), 1u);
  ASSERT_EQ(spelled_out(commands[0]).size(), 2u);
  take(commands[0], "here");
  EXPECT_EQ(lines_.size(), 2u);
  EXPECT_EQ(judge().exit_code, 0);
  take({"likeness", "eval", "me.likeness", "--quality", "rough"}, "here");
  const ProgramResult result = judge();
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.out.find("eval\tme.likeness\t--quality\trough\n"), 0u) << result.out;
}

// -- Lengths

TEST(Docs, TheFirstPagesStayShort) {
  for (const auto& [name, most] :
       std::map<std::string, long>{{"README.md", 120}, {"docs/ARCHITECTURE.md", 200}}) {
    const auto text = read_text(kSource / name);
    ASSERT_TRUE(text.ok()) << name;
    EXPECT_LE(std::count(text->begin(), text->end(), '\n'), most) << name;
  }
}

}  // namespace
}  // namespace likeness::test
