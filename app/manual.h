// A program's manual page, made of the same options that --help lists: it cannot say anything else.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

namespace likeness::app {

// What a page says beside the options.
struct ManualText {
  std::string version, summary;          // summary: one line, no full stop
  std::vector<std::string> description;  // paragraphs
  std::vector<std::pair<std::string, std::string>> exit_codes, files, examples;  // term, explanation
  std::vector<std::string> see_also;                                             // "likeness-studio(1)"
};

// The page in man's roff: the program's options, then every verb with its own.
std::string manual_page(const CLI::App& program, const ManualText& text);

// Adds --man, which --help does not list: it prints the page and ends the program.
void add_manual_flag(CLI::App& program, ManualText text);

}  // namespace likeness::app
