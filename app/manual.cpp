// roff of a CLI11 parser: see manual.h.
#include "app/manual.h"

#include <cctype>
#include <string_view>

#include <fmt/format.h>

namespace likeness::app {

namespace {

// Escapes words so that roff shows them unchanged: no escapes or requests are read from them, and hyphens can
// be copied into a shell.
std::string plain(std::string_view words) {
  std::string roff;
  bool line_start = true;
  for (const char c : words) {
    if (line_start && (c == '.' || c == '\'')) roff += "\\&";
    line_start = c == '\n';
    if (c == '\\') {
      roff += "\\e";
    } else if (c == '-') {
      roff += "\\-";
    } else if (c == '\'') {
      roff += "\\(aq";
    } else {
      roff += c;
    }
  }
  return roff;
}

std::string capitals(std::string words) {
  for (char& c : words) c = char(std::toupper(static_cast<unsigned char>(c)));
  return words;
}

// Opens what --help's formatter writes beside an option: its kind of value and what it may be.
struct HelpWords : CLI::Formatter {
  std::string value(const CLI::Option& option) const {
    std::string words = make_option_opts(&option);  // " INT:INT in [0 - 9]"
    const std::string kind = option.get_type_name();
    const std::size_t colon = kind.find(':');
    if (colon == std::string::npos) return words;
    const std::string name = kind.substr(0, colon), twice = name + ":" + name;
    const std::size_t at = words.find(twice);
    return at == std::string::npos ? words : words.replace(at, twice.size(), name);
  }
};

// A flag that turns something off carries its value in its name.
std::string without_value(std::string name) { return name.substr(0, name.find('{')); }

void add_term(std::string& page, const std::string& bold, const std::string& after,
              const std::string& words) {
  page += fmt::format(".TP\n\\fB{}\\fR{}\n{}\n", plain(bold), plain(after), plain(words));
}

void add_options(std::string& page, const CLI::App& verb) {
  const HelpWords help;
  for (const bool positional : {true, false}) {
    for (const CLI::Option* option : verb.get_options()) {
      if (option->get_group().empty() || option->get_positional() != positional) continue;
      const std::string name =
          positional ? option->get_name(true) : without_value(option->get_name(false, true));
      add_term(page, name, help.value(*option), option->get_description());
    }
  }
}

void add_verb(std::string& page, const CLI::App& verb, const std::string& before) {
  const std::string name = before + verb.get_name();
  page += fmt::format(".SS {}\n{}.\n", plain(name), plain(verb.get_description()));
  if (verb.get_subcommands({}).empty()) add_options(page, verb);
  for (const CLI::App* inner : verb.get_subcommands({})) add_verb(page, *inner, name + " ");
}

void add_terms(std::string& page, std::string_view title,
               const std::vector<std::pair<std::string, std::string>>& terms) {
  if (terms.empty()) return;
  page += fmt::format(".SH {}\n", title);
  for (const auto& [term, words] : terms) add_term(page, term, "", words);
}

}  // namespace

std::string manual_page(const CLI::App& program, const ManualText& text) {
  const std::string& name = program.get_name();
  const auto verbs = program.get_subcommands({});
  std::string page =
      fmt::format(".TH {} 1 \"\" \"Likeness {}\" \"Likeness\"\n.SH NAME\n{} \\- {}\n", capitals(plain(name)),
                  plain(text.version), plain(name), plain(text.summary));
  page += fmt::format(".SH SYNOPSIS\n.B {}\n{}\n", plain(name),
                      verbs.empty() ? "[\\fIOPTIONS\\fR] [\\fICLIP\\fR | \\fIPROJECT\\fR]"
                                    : "\\fIVERB\\fR [\\fIOPTIONS\\fR] ...");
  page += ".SH DESCRIPTION\n";
  for (std::size_t i = 0; i < text.description.size(); ++i)
    page += (i > 0 ? ".PP\n" : "") + plain(text.description[i]) + "\n";
  page += ".SH OPTIONS\n";
  add_options(page, program);
  if (!verbs.empty()) page += ".SH VERBS\n";
  for (const CLI::App* verb : verbs) add_verb(page, *verb, "");
  add_terms(page, "EXIT STATUS", text.exit_codes);
  add_terms(page, "FILES", text.files);
  add_terms(page, "EXAMPLES", text.examples);
  if (!text.see_also.empty())
    page += fmt::format(".SH SEE ALSO\n{}\n", plain(fmt::format("{}", fmt::join(text.see_also, ", "))));
  return page;
}

void add_manual_flag(CLI::App& program, ManualText text) {
  program
      .add_flag_callback(
          "--man",
          [&program, text = std::move(text)] {
            fmt::print("{}", manual_page(program, text));
            throw CLI::Success();
          },
          "Print this program's manual page")
      ->group("");
}

}  // namespace likeness::app
