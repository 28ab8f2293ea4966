// A claim about what is saved for a question: it says of every network where it is, or where it was looked
// for.
#include "ui/studio/diagnostics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include "core/network/installed_networks.h"

namespace likeness::ui {
namespace {

TEST(Diagnostics, NameEveryNetwork) {
  const char* before = ::getenv("LIKENESS_NETWORKS");
  const std::string kept = before ? before : "";
  ::setenv("LIKENESS_NETWORKS", "/nowhere", 1);
  const std::string text = diagnostics_text({}, nullptr);
  if (before)
    ::setenv("LIKENESS_NETWORKS", kept.c_str(), 1);
  else
    ::unsetenv("LIKENESS_NETWORKS");
  for (const InstalledNetworkFile& network : installed_network_files())
    EXPECT_THAT(text,
                testing::HasSubstr("The network " + std::string(network.file) + " is not in /nowhere.\n"));
}

}  // namespace
}  // namespace likeness::ui
