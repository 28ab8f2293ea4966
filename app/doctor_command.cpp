// likeness doctor: what is installed, what is missing, what to do.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/camera/process.h"
#include "core/device/load_device.h"
#include "core/face/landmarks.h"
#include "core/network/installed_networks.h"

namespace likeness::app {

namespace {

struct Finding {
  std::string part;
  bool ok = false;
  bool needed = true;  // a missing optional part is not a failure
  std::string found, remedy;
};

Finding check_landmarks() {
  const auto detector = FaceDetector::load();
  if (detector)
    return {"face landmarks", true, true, "dlib's 68-point model (for research use: trained on iBUG 300-W)",
            ""};
  return {"face landmarks", false, true, detector.error().what, detector.error().fix};
}

// Read and held against its hash.
Finding check_network(const InstalledNetworkFile& file) {
  const auto network = load_installed_network(file.network);
  const std::string part = "network " + std::filesystem::path(file.file).stem().string();
  if (!network) return {part, false, false, network.error().what, network.error().fix};
  return {part, true, false, fmt::format("{}: {}", file.what, network->origin().string()), ""};
}

Finding check_colmap() {
  const auto program = find_program("colmap");
  if (program) return {"colmap", true, true, program->string(), ""};
  return {"colmap", false, true, "not on the PATH; clips with a moving camera need it",
          "Install the package colmap."};
}

Finding check_memory() {
  const double gib = double(::sysconf(_SC_PHYS_PAGES)) * double(::sysconf(_SC_PAGE_SIZE)) / double(1 << 30);
  return {"memory", gib >= 3.5, true, fmt::format("{:.1f} GiB", gib),
          gib >= 3.5 ? "" : "Use --size 256 and close other programs."};
}

Finding check_display() {
  const bool shown = std::getenv("DISPLAY") != nullptr || std::getenv("WAYLAND_DISPLAY") != nullptr;
  return {"display", shown, false, shown ? "present" : "none; the command line needs none", ""};
}

// Used by `build`, `train`, `render`, `drive`, `eval` and `bench` with --backend cuda.
Finding check_cuda() {
  const auto device = open_cuda_device();
  if (!device) return {"CUDA", false, false, device.error().what, device.error().fix};
  const DeviceFacts& facts = (*device)->facts();
  return {
      "CUDA", true, false,
      fmt::format("{}, {:.1f} GiB of which {:.1f} are free, driver for CUDA {}.{}", facts.name,
                  double(facts.memory_bytes) / double(1 << 30), double(facts.free_bytes) / double(1 << 30),
                  facts.driver / 1000, facts.driver % 1000 / 10),
      ""};
}

int run(const CommonOptions& common) {
  std::vector<Finding> findings{{"processor", true, true, fmt::format("{} threads", hardware_threads()), ""},
                                check_memory(),
                                check_landmarks()};
  for (const InstalledNetworkFile& file : installed_network_files()) findings.push_back(check_network(file));
  findings.push_back(check_colmap());
  findings.push_back({"head models", true, false,
                      "the built-in one; --head-model takes FLAME's .pkl, ICT-FaceKit's folder or a .npz",
                      ""});
  findings.push_back(check_display());
  findings.push_back(check_cuda());
  bool healthy = true;
  nlohmann::json list = nlohmann::json::array();
  for (std::size_t i = 0; i < findings.size(); ++i) {
    const Finding& f = findings[i];
    healthy &= f.ok || !f.needed;
    list.push_back(
        {{"part", f.part}, {"ok", f.ok}, {"needed", f.needed}, {"found", f.found}, {"remedy", f.remedy}});
    if (common.json) continue;
    fmt::print("{:>8}  {:<21} {}\n", f.ok ? "ok" : f.needed ? "MISSING" : "-", f.part, f.found);
    const bool said_next = i + 1 < findings.size() && findings[i + 1].remedy == f.remedy;  // once for all
    if (!f.remedy.empty() && !said_next) fmt::print("{:>8}  {:<21} {}\n", "", "", f.remedy);
  }
  if (common.json) print_json({{"healthy", healthy}, {"findings", list}});
  return healthy ? kExitDone : kExitFailed;
}

}  // namespace

void add_doctor_command(CLI::App& program, int& exit_code) {
  auto common = std::make_shared<CommonOptions>();
  CLI::App* verb = program.add_subcommand("doctor", "What is installed, what is missing, what to do");
  add_common_options(*verb, *common);
  verb->callback([common, &exit_code] { exit_code = run(*common); });
}

}  // namespace likeness::app
