// Naming the processor: see processor.h.
#include "core/lab/bench/processor.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>

#include "core/lab/bench/ceiling_kernels.h"

namespace likeness {
namespace {

// A value of the first processor in Linux's list; empty elsewhere.
std::string cpu_info(const std::string& key) {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(':');
    if (line.rfind(key, 0) != 0 || colon == std::string::npos) continue;
    const std::size_t end = line.find_last_not_of("\t ", colon - 1);
    if (line.substr(0, end + 1) == key) return line.substr(std::min(line.size(), colon + 2));
  }
  return "";
}

constexpr std::size_t kKnownTable = std::size_t{1} << 19;

}  // namespace

Processor this_processor() {
  Processor processor{cpu_info("model name"), instruction_set()};
  if (processor.name.empty()) processor.name = "unknown";
  return processor;
}

std::optional<KnownCeilings> known_ceilings() {
  std::istringstream flags(cpu_info("flags"));
  const bool bf16 = std::find(std::istream_iterator<std::string>(flags), {}, "avx512_bf16") !=
                    std::istream_iterator<std::string>();
  const bool zen4 = bf16 && cpu_info("vendor_id") == "AuthenticAMD" && cpu_info("cpu family") == "25";
  if (zen4) return KnownCeilings{"AMD Zen 4", 115, 1870, 1740};
  return std::nullopt;
}

double share_of_known(const Ceilings& one_thread, const KnownCeilings& known) {
  return std::min({one_thread.fma_gflops / known.fma_gflops,
                   1e-6 / gather_seconds(one_thread, kKnownTable) / known.gather_mps,
                   1e-6 / read_modify_write_seconds(one_thread, kKnownTable) / known.read_modify_write_mps});
}

}  // namespace likeness
