// Verbs and options of earlier versions: they answer with what to write now, as an error of usage.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace likeness::app {

// now: what to write, "drive PROJECT CLIP --out FILE". Not listed in --help.
void add_removed_option(CLI::App& verb, const std::string& option, const std::string& now);

// Of `study`'s first word: refuses the name of a removed verb unless a project lies there.
CLI::Validator no_removed_study();

}  // namespace likeness::app
