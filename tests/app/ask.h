// What the command line answers with --json.
#pragma once

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/run_program.h"

namespace likeness::test {

// Runs the command, which must succeed; null where it does not.
inline nlohmann::json ask(const std::vector<std::string>& command) {
  const ProgramResult result = likeness(command);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return result.exit_code == 0 ? nlohmann::json::parse(result.out) : nlohmann::json();
}

}  // namespace likeness::test
