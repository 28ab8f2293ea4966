// Claims about core/device/load_device.h: the reasons why there is no CUDA device are distinguished, and
// nothing is loaded unnecessarily.
#include "core/device/load_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/device/emulated_device.h"

namespace likeness {
namespace {

using testing::HasSubstr;

struct Setting {
  bool module = true, driver = true;
  std::string broken;  // the loader's error for the module
  EmulatedFaults faults;
  int loads = 0;

  ModuleLoader loader() {
    return {{"/nowhere/likeness.so", "/lib/likeness.so"},
            [this](const std::filesystem::path& path) { return module && path == "/lib/likeness.so"; },
            [this] { return driver; },
            [this](const std::filesystem::path& path, std::string& why) -> const DeviceApi* {
              EXPECT_EQ(path, "/lib/likeness.so");
              ++loads;
              why = broken;
              return broken.empty() ? &emulated_api(faults) : nullptr;
            }};
  }
};

TEST(OpenCudaDevice, OpensTheFirstModuleThereIs) {
  Setting setting;
  const auto device = open_cuda_device(setting.loader());
  ASSERT_TRUE(device.ok()) << device.error().what;
  EXPECT_STREQ((*device)->facts().name, "emulated device");
}

TEST(OpenCudaDevice, SaysWhatIsMissing) {
  Setting setting;
  setting.module = false;
  EXPECT_THAT(open_cuda_device(setting.loader()).error().what, HasSubstr("computes on the processor"));
  setting.module = true, setting.driver = false;
  EXPECT_THAT(open_cuda_device(setting.loader()).error().what, HasSubstr("no NVIDIA driver"));
  EXPECT_EQ(setting.loads, 0);  // a module without a driver is not even loaded
  setting.driver = true, setting.broken = "undefined symbol";
  const auto broken = open_cuda_device(setting.loader());
  EXPECT_THAT(broken.error().what, HasSubstr("undefined symbol"));
  EXPECT_FALSE(broken.error().fix.empty());
  setting.broken.clear(), setting.faults.open = DeviceStatus::no_device;
  EXPECT_THAT(open_cuda_device(setting.loader()).error().what, HasSubstr("finds no GPU"));
}

TEST(SystemLoader, LooksOnlyWhereTheVariableSays) {
  ::setenv("LIKENESS_CUDA_MODULE", "/somewhere/else.so", 1);
  const ModuleLoader loader = system_loader();
  ::unsetenv("LIKENESS_CUDA_MODULE");
  EXPECT_EQ(loader.places, std::vector<std::filesystem::path>{"/somewhere/else.so"});
  EXPECT_THAT(open_cuda_device(loader).error().what, HasSubstr("computes on the processor"));
}

TEST(SystemLoader, NamesAFileThatIsNotAModule) {
  const ModuleLoader loader = system_loader();
  std::string why;
  EXPECT_EQ(loader.load("/proc/self/status", why), nullptr);
  EXPECT_FALSE(why.empty());
}

}  // namespace
}  // namespace likeness
