// Names of files that the command line takes for options.
#pragma once

namespace likeness::app {

// After a command line that was not understood: says of each word that is the name of a file, but begins with
// a dash, how to write it.
void tell_names_like_options(int argc, char** argv);

}  // namespace likeness::app
