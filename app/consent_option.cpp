// See consent_option.h.
#include "app/consent_option.h"

#include <unistd.h>

#include <iostream>

#include "app/standard_streams.h"

namespace likeness::app {

namespace {

// What --consent says, and the letters of the question.
Consent consent_of(const std::string& answer) {
  if (answer == "self" || answer == "s") return Consent::own;
  if (answer == "given" || answer == "g") return Consent::given;
  // No letter: "n" is no.
  return answer == "nobody" ? Consent::no_real_person : Consent::not_asked;
}

}  // namespace

void add_consent_option(CLI::App& verb, std::string& given) {
  verb.add_option(
          "--consent", given,
          "Who is filmed: you yourself (self), somebody who agreed (given), or nobody real (nobody); a "
          "terminal asks")
      ->check(CLI::IsMember({"self", "given", "nobody"}));
}

Result<Consent> answered_consent(const std::string& given, bool ask) {
  if (!given.empty()) return consent_of(given);
  if (!ask || ::isatty(STDIN_FILENO) == 0 || ::isatty(STDERR_FILENO) == 0) return Consent::not_asked;
  tell(
      "Did the filmed person agree? An avatar can be made to say and do what the person never did.\n"
      "  s  it is me    g  they agreed    nobody  nobody real is filmed    anything else: no\n");
  std::string answer;
  std::getline(std::cin, answer);
  const Consent consent = consent_of(answer);
  if (consent != Consent::not_asked) return consent;
  return Error{ErrorCode::failed, "Without the person's agreement no avatar is made.",
               "Ask them first: say what it is for, and what it can be made to do.", ""};
}

}  // namespace likeness::app
