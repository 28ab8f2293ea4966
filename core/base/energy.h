// What the processor has used, where the system reports it (the kernel's powercap interface to RAPL).
#pragma once

#include <filesystem>
#include <optional>

namespace likeness {

// Joules of all packages since some moment; they only grow until a counter wraps round (minutes to hours).
// nullopt where there is no counter, or it may not be read: since 2020 Linux lets only root.
std::optional<double> processor_joules(const std::filesystem::path& powercap = "/sys/class/powercap");

}  // namespace likeness
