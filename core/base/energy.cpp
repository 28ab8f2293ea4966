// Reading the counters.
#include "core/base/energy.h"

#include <algorithm>
#include <fstream>
#include <string>

namespace likeness {

std::optional<double> processor_joules(const std::filesystem::path& powercap) {
  namespace fs = std::filesystem;
  std::optional<double> joules;
  std::error_code failure;
  for (fs::directory_iterator at(powercap, failure), end; !failure && at != end; at.increment(failure)) {
    const std::string name = at->path().filename().string();
    // intel-rapl:0 is a package (for AMD's processors too), intel-rapl:0:1 a part of it.
    if (!name.starts_with("intel-rapl:") || std::ranges::count(name, ':') != 1) continue;
    std::ifstream file(at->path() / "energy_uj");
    double microjoules = 0;
    if (file >> microjoules) joules = joules.value_or(0) + 1e-6 * microjoules;
  }
  return joules;
}

}  // namespace likeness
