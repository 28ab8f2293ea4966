// Claims about the machine's energy counters: packages are added up, parts of them and other devices are not,
// and without readable counters there is no result.
#include "core/base/energy.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

namespace likeness {
namespace {

namespace fs = std::filesystem;

TEST(Energy, PackagesAreAddedUp) {
  const fs::path folder = fs::temp_directory_path() / ("likeness_energy_" + std::to_string(getpid()));
  const auto counter = [&](const char* name, const char* text) {
    fs::create_directories(folder / name);
    std::ofstream(folder / name / "energy_uj") << text;
  };
  fs::create_directories(folder);
  EXPECT_FALSE(processor_joules(folder));
  EXPECT_FALSE(processor_joules(folder / "absent"));
  counter("intel-rapl:0", "1500000\n");
  counter("intel-rapl:1", "2000000\n");
  counter("intel-rapl:0:0", "900000\n");
  counter("dtpm", "7000000\n");
  counter("intel-rapl:2", "");
  EXPECT_DOUBLE_EQ(processor_joules(folder).value_or(0), 3.5);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace likeness
