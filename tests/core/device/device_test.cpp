// Claims about core/device/device.h: a device's status becomes a sentence with a remedy.
#include "core/device/device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "tests/core/device/emulated_device.h"

namespace likeness {
namespace {

using testing::HasSubstr;

TEST(DeviceErrors, EachHasItsOwnSentenceAndARemedy) {
  DeviceFacts facts{};
  facts.driver = 12020, facts.toolkit = 13000, facts.major = 6, facts.minor = 1;
  std::set<std::string> said;
  for (int s = int(DeviceStatus::no_driver); s <= int(DeviceStatus::failed); ++s) {
    const Error error = device_error(DeviceStatus(s), facts, "code 719", "training");
    EXPECT_FALSE(error.fix.empty()) << s;
    EXPECT_TRUE(said.insert(error.what).second) << error.what;
  }
  const Error old = device_error(DeviceStatus::driver_too_old, facts, "", "");
  EXPECT_THAT(old.what, HasSubstr("12.2"));
  EXPECT_THAT(old.what, HasSubstr("13.0"));
  EXPECT_THAT(device_error(DeviceStatus::device_too_old, facts, "", "").fix, HasSubstr("ARCHITECTURES=61"));
  EXPECT_THAT(device_error(DeviceStatus::lost, facts, "code 719", "").what, HasSubstr("code 719"));
}

TEST(DeviceOpen, FailureNamesItsCause) {
  const std::pair<DeviceStatus, const char*> cases[] = {
      {DeviceStatus::no_driver, "no NVIDIA driver"},
      {DeviceStatus::driver_too_old, "driver supports CUDA 12.4"},
      {DeviceStatus::no_device, "finds no GPU"},
      {DeviceStatus::device_too_old, "has no code"},
      {DeviceStatus::out_of_memory, "out of memory"}};
  for (const auto& [status, words] : cases) {
    const auto device = Device::open(emulated_api({.open = status}));
    ASSERT_FALSE(device.ok());
    EXPECT_THAT(device.error().what, HasSubstr(words));
  }
}

TEST(DeviceOpen, AModuleOfAnotherVersionIsRefused) {
  DeviceApi other = emulated_api();
  other.version = kDeviceApiVersion + 1;
  const auto device = Device::open(other);
  ASSERT_FALSE(device.ok());
  EXPECT_THAT(device.error().what, HasSubstr("differ in version"));
}

TEST(DeviceArrays, ReleaseTheirMemoryAndReportWhenItRunsOut) {
  const auto device = emulated_device({.memory_bytes = 1000});
  {
    auto first = DeviceArray<float>::make(device, 200);
    ASSERT_TRUE(first.ok());
    const auto second = DeviceArray<float>::make(device, 200);
    ASSERT_FALSE(second.ok());
    EXPECT_THAT(second.error().what, HasSubstr("out of memory"));
    DeviceArray<float> moved = std::move(*first);
    EXPECT_EQ(emulated_counts().bytes, 800u);
  }
  EXPECT_EQ(emulated_counts().bytes, 0u);
  EXPECT_TRUE(DeviceArray<float>::make(device, 250).ok());
}

TEST(DeviceArrays, RoundTripUnchanged) {
  const auto device = emulated_device();
  auto array = DeviceArray<int>::make(device, 3);
  const int in[3] = {1, 2, 3};
  int out[3] = {};
  EXPECT_TRUE(device->copy_in(array->data(), in, sizeof(in)).ok());
  EXPECT_TRUE(device->clear(array->data() + 1, sizeof(int)).ok());
  EXPECT_TRUE(device->copy_out(out, array->data(), sizeof(out)).ok());
  EXPECT_TRUE(device->wait().ok());
  EXPECT_THAT(out, testing::ElementsAre(1, 0, 3));
}

}  // namespace
}  // namespace likeness
