// See installed_networks.h.
#include "core/network/installed_networks.h"

#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <vector>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/program_files.h"
#include "core/base/sha256.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

// tests/structure/check_networks.py holds these hashes against those of packaging/networks.
constexpr std::array<InstalledNetworkFile, 4> kFiles{{
    {InstalledNetwork::person, "person.onnx", 256, "which pixels are the person",
     "71f4af1f6f2a6db3954ab2c98fa730907000d9c81cd88f00bdcfcd2b138881c0"},
    {InstalledNetwork::face468, "face468.onnx", 192, "468 points of a face",
     "eb0231bb517e962443bced54eba7a179b46eb30453cb6c0d5dad98ce749f0320"},
    {InstalledNetwork::iris, "iris.onnx", 64, "the irises",
     "364e631347b48480739757a21d852c1c48c8a8e2d16c309305dee7b31c57b924"},
    {InstalledNetwork::face_detector, "face_detector.onnx", 128, "where faces are",
     "459860e57cff29e7dce281644a6a5e1afb16338fbf24fe92ba3474a1c4d5bff7"},
}};

constexpr const char* kVariable = "LIKENESS_NETWORKS";

// The folders that are looked at, first to last.
std::vector<fs::path> places() {
  if (const char* given = std::getenv(kVariable); given != nullptr && *given != '\0') return {given};
  const fs::path program = program_file();
  if (program.empty()) return {};
  const fs::path prefix = program.parent_path().parent_path();
  return {prefix / "share/likeness/networks", prefix.parent_path() / "networks"};
}

std::string remedy() {
  return fmt::format(
      "Run packaging/networks in the checkout, or set {} to a folder that holds what it makes.", kVariable);
}

}  // namespace

std::span<const InstalledNetworkFile> installed_network_files() { return kFiles; }

const InstalledNetworkFile& installed_network_file(InstalledNetwork network) {
  return kFiles[std::size_t(network)];
}

Result<fs::path> find_installed_network(InstalledNetwork network) {
  const InstalledNetworkFile& wanted = installed_network_file(network);
  std::string seen;
  for (const fs::path& folder : places()) {
    fs::path file = folder / wanted.file;
    std::error_code unknown;
    if (fs::is_regular_file(file, unknown)) return file;
    seen += (seen.empty() ? "" : " nor in ") + folder.string();
  }
  return Error{ErrorCode::missing_dependency,
               seen.empty() ? fmt::format("The network {} is not there.", wanted.file)
                            : fmt::format("The network {} is not in {}.", wanted.file, seen),
               remedy(), wanted.file};
}

Result<OnnxNetwork> load_installed_network(InstalledNetwork network, int max_concurrent) {
  const auto file = find_installed_network(network);
  if (!file) return file.error();
  auto bytes = read_file(*file);
  if (!bytes) return bytes.error();
  const std::string hash = sha256(*bytes);
  if (hash != installed_network_file(network).sha256)
    return Error{
        ErrorCode::bad_input,
        fmt::format("{} is not the network this program was written for: {} bytes with the SHA-256 {}..., "
                    "not {}....",
                    file->string(), bytes->size(), hash.substr(0, 12),
                    std::string(installed_network_file(network).sha256).substr(0, 12)),
        remedy(), file->string()};
  return OnnxNetwork::load(std::move(*bytes), *file, max_concurrent);
}

std::string installed_network_hash(InstalledNetwork network) {
  const auto file = find_installed_network(network);
  if (!file) return "absent";
  const auto hash = hash_file(*file);
  return hash ? *hash : "absent";
}

}  // namespace likeness
