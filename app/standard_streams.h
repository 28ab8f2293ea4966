// The program's own input and outputs, whatever state they were handed over in: closed, full, or a pipe that
// nobody reads any more.
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace likeness::app {

inline constexpr int kExitDone = 0, kExitFailed = 1, kExitUsage = 2, kExitStopped = 130;

// Opens those of descriptors 0 to 2 that are closed, on nothing, and lets a reader that leaves end no work.
// First thing: the next file that is opened would take their number, and messages would end up in it.
void open_standard_streams();

// What a terminal does not take for a command: control characters, which names of files may hold, become "?".
std::string visible(std::string_view text);

// Before a message that takes a progress line's place: takes it off the terminal, if standard error is one.
void clear_line() noexcept;

// To standard error. A message that cannot be written is lost, and the work goes on.
void tell_text(std::string_view text) noexcept;
template <class... T>
void tell(fmt::format_string<T...> format, T&&... arguments) {
  tell_text(visible(fmt::format(format, std::forward<T>(arguments)...)));
}

// Flushes standard output. `exit_code`, or that of a failure, which is told, where a command succeeded and
// what it printed did not reach its reader.
int after_output(int exit_code);

}  // namespace likeness::app
