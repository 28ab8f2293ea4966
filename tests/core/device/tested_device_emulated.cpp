// Tests of a device on the emulated one.
#include "tests/core/device/emulated_device.h"

namespace likeness {

std::shared_ptr<Device> tested_device(std::string&) { return emulated_device(); }

}  // namespace likeness
