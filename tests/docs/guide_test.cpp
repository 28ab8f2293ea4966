// Claims about the guide: the messages it quotes are the program's own, it calls things as the window does,
// and pictures are small. Links, files and commands of all pages: docs_test.
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>

#include "core/base/files.h"
#include "core/image/files.h"
#include "tests/docs/source_folder.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPlaceholder = "\u2026";

std::string text_of(const fs::path& file) {
  const auto text = read_text(file);
  EXPECT_TRUE(text.ok()) << file;
  return text.ok() ? *text : "";
}

// The string literals of a source, adjoining ones joined, one a line.
std::string literals(const std::string& source) {
  std::string words;
  bool inside = false;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const char c = source[i];
    if (!inside && source.compare(i, 2, "//") == 0) {
      i = std::min(source.find('\n', i), source.size());
    } else if (!inside && source.compare(i, 3, "'\"'") == 0) {
      i += 2;
    } else if (c == '"') {
      inside = !inside;
    } else if (inside) {
      words += c == '\\' ? source[++i] : c;
    } else if (!std::isspace(static_cast<unsigned char>(c)) && !words.empty() && words.back() != '\n') {
      words += '\n';
    }
  }
  return words + "\n";
}

std::string all_literals() {
  std::string words;
  for (const char* folder : {"app", "core", "ui"})
    for (const auto& file : fs::recursive_directory_iterator(kSource / folder))
      if (file.path().extension() == ".cpp") words += literals(text_of(file.path()));
  return words;
}

std::vector<std::string> quoted_messages() {
  const std::string page = text_of(kSource / "docs/guide/TROUBLESHOOTING.md");
  std::vector<std::string> messages;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("> ")) messages.push_back(line.substr(2));
  return messages;
}

// The message's text between its placeholders stands in the literals, in its order and close together.
bool is_said(const std::string& words, const std::string& message) {
  std::vector<std::string> parts;
  std::size_t at = 0;
  for (std::size_t end = 0; end != std::string::npos; at = end + kPlaceholder.size()) {
    end = message.find(kPlaceholder, at);
    if (const std::string part = message.substr(at, end == std::string::npos ? end : end - at); !part.empty())
      parts.push_back(part);
  }
  for (std::size_t start = words.find(parts[0]); start != std::string::npos;
       start = words.find(parts[0], start + 1)) {
    std::size_t end = start + parts[0].size(), next = 1;
    for (; next < parts.size(); ++next) {
      const std::size_t found = words.find(parts[next], end);
      if (found == std::string::npos || found > end + 60) break;
      end = found + parts[next].size();
    }
    if (next == parts.size()) return true;
  }
  return false;
}

TEST(Guide, QuotesMessagesThatTheProgramSays) {
  const std::string words = all_literals();
  ASSERT_GT(words.size(), 20000u);
  const auto messages = quoted_messages();
  ASSERT_GE(messages.size(), 25u);
  for (const std::string& message : messages) EXPECT_TRUE(is_said(words, message)) << message;
  EXPECT_FALSE(is_said(words, "Only \u2026 of \u2026 frames show a blunt face."));
}

// What stands between single asterisks, beginning with a capital: what something in the window is called. A
// menu and its entry are joined by " > ".
std::vector<std::string> named_in(const std::string& page) {
  std::vector<std::string> names;
  const std::regex emphasis(R"((^|[^*])\*([A-Z][^*]+)\*(?!\*))");
  for (std::sregex_iterator it(page.begin(), page.end(), emphasis), end; it != end; ++it) {
    std::string name = std::regex_replace((*it)[2].str(), std::regex("\n"), " ");
    for (std::size_t arrow; (arrow = name.find(" > ")) != std::string::npos; name = name.substr(arrow + 3))
      names.push_back(name.substr(0, arrow));
    names.push_back(name);
  }
  return names;
}

TEST(Guide, CallsThingsAsTheWindowDoes) {
  std::string words = text_of(kSource / "packaging/desktop/likeness-studio.desktop");
  for (const auto& file : fs::recursive_directory_iterator(kSource / "ui"))
    if (file.path().extension() == ".cpp") words += literals(text_of(file.path()));
  std::size_t named = 0;
  for (const char* page : {"docs/guide/README.md", "docs/guide/TROUBLESHOOTING.md"})
    for (const std::string& name : named_in(text_of(kSource / page))) {
      ++named;
      EXPECT_NE(words.find(name), std::string::npos) << page << ": \"" << name << "\"";
    }
  EXPECT_GT(named, 20u);
  EXPECT_EQ(words.find("Make an avatar now"), std::string::npos);
}

TEST(Guide, PicturesAreSmall) {
  int pictures = 0;
  for (const auto& file : fs::recursive_directory_iterator(kSource / "docs")) {
    if (file.path().extension() != ".png") continue;
    ++pictures;
    EXPECT_LE(file.file_size(), 200'000u) << file.path();
    EXPECT_TRUE(read_image(file.path()).ok()) << file.path();
  }
  EXPECT_GE(pictures, 8);  // the start screen and the seven steps
}

}  // namespace
}  // namespace likeness::test
