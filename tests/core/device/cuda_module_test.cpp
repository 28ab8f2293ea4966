// Claims about the CUDA module as built: it loads without a driver, fills the whole table, and reports what
// prevents its use.
#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "core/device/load_device.h"

namespace likeness {
namespace {

const DeviceApi* module() {
  std::string why;
  const ModuleLoader loader = system_loader();
  const DeviceApi* api = loader.load(loader.places.front(), why);
  EXPECT_NE(api, nullptr) << why;
  return api;
}

TEST(CudaModule, LoadsWithoutADriverAndFillsItsTable) {
  const DeviceApi* api = module();
  ASSERT_NE(api, nullptr);
  EXPECT_EQ(api->version, kDeviceApiVersion);
  const auto* first = reinterpret_cast<const char*>(&api->open);
  for (std::size_t at = 0; at < sizeof(DeviceApi) - offsetof(DeviceApi, open); at += sizeof(void*)) {
    void* function = nullptr;
    std::memcpy(&function, first + at, sizeof(function));
    EXPECT_NE(function, nullptr) << at;
  }
}

TEST(CudaModule, RejectsOtherVersions) {
  ASSERT_NE(module(), nullptr);
  void* library = ::dlopen(system_loader().places.front().c_str(), RTLD_NOW | RTLD_LOCAL);
  ASSERT_NE(library, nullptr);
  const auto function = reinterpret_cast<DeviceApiFunction>(::dlsym(library, kDeviceApiSymbol));
  ASSERT_NE(function, nullptr);
  EXPECT_EQ(function(kDeviceApiVersion + 1), nullptr);
}

TEST(CudaModule, OpensADeviceOrSaysWhyNot) {
  const DeviceApi* api = module();
  ASSERT_NE(api, nullptr);
  void* context = nullptr;
  DeviceFacts facts{};
  const DeviceStatus status = api->open(&context, &facts);
  EXPECT_GE(facts.toolkit, 11000);
  if (status == DeviceStatus::ok) {
    ASSERT_NE(context, nullptr);
    EXPECT_NE(facts.name[0], 0);
    api->close(context);
  } else {
    EXPECT_EQ(context, nullptr);
    EXPECT_NE(status, DeviceStatus::failed) << api->last_message(nullptr);
    EXPECT_NE(status, DeviceStatus::unknown_request);
  }
}

}  // namespace
}  // namespace likeness
