// --consent, and the question on a terminal where it was not given: did the filmed person agree?
#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "core/base/result.h"
#include "core/project/project.h"

namespace likeness::app {

void add_consent_option(CLI::App& verb, std::string& given);

// What was given; otherwise, where ask is set, what whoever sits at the terminal answers. not_asked where
// nobody does. An Error where nobody agreed.
Result<Consent> answered_consent(const std::string& given, bool ask);

}  // namespace likeness::app
