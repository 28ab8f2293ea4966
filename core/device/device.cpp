// The table of functions, its errors turned into messages: see device.h.
#include "core/device/device.h"

#include <fmt/format.h>

namespace likeness {
namespace {

std::string version_text(std::int32_t version) {
  return fmt::format("{}.{}", version / 1000, version % 1000 / 10);
}

std::string device_name(const DeviceFacts& facts) { return facts.name[0] ? facts.name : "The GPU"; }

constexpr const char* kUseProcessor = "Without --backend cuda the work is done on the processor.";

}  // namespace

Error device_error(DeviceStatus status, const DeviceFacts& facts, const std::string& said,
                   const std::string& doing) {
  const std::string where = doing.empty() ? "CUDA" : "CUDA, " + doing;
  switch (status) {
    case DeviceStatus::no_driver:
      return {ErrorCode::missing_dependency, "There is no NVIDIA driver, or it does not respond.",
              fmt::format("Install NVIDIA's driver, or load its kernel module. {}", kUseProcessor), where};
    case DeviceStatus::driver_too_old:
      return {ErrorCode::missing_dependency,
              fmt::format("The NVIDIA driver supports CUDA {}, but this program was built with CUDA {}.",
                          version_text(facts.driver), version_text(facts.toolkit)),
              fmt::format("Install a newer driver, or build with an older toolkit. {}", kUseProcessor),
              where};
    case DeviceStatus::no_device:
      return {ErrorCode::missing_dependency, "The NVIDIA driver finds no GPU.",
              fmt::format("Check that `nvidia-smi` lists one and that CUDA_VISIBLE_DEVICES hides none. {}",
                          kUseProcessor),
              where};
    case DeviceStatus::device_too_old:
      return {ErrorCode::missing_dependency,
              fmt::format("{} has compute capability {}.{}, for which this build has no code.",
                          device_name(facts), facts.major, facts.minor),
              fmt::format("Build with -DLIKENESS_CUDA_ARCHITECTURES={}{}. {}", facts.major, facts.minor,
                          kUseProcessor),
              where};
    case DeviceStatus::out_of_memory:
      return {ErrorCode::failed,
              fmt::format("{} is out of memory ({:.1f} GiB in all).", device_name(facts),
                          double(facts.memory_bytes) / double(1 << 30)),
              fmt::format("Close other programs that use the GPU, or use --backend cpu. {}",
                          "The training is kept up to the last checkpoint."),
              where};
    case DeviceStatus::too_large:
      return {ErrorCode::failed,
              fmt::format("This avatar's networks need more shared memory than {} has ({} KiB a block).",
                          device_name(facts), facts.shared_bytes / 1024),
              "Use --backend cpu.", where};
    case DeviceStatus::lost:
      return {ErrorCode::failed,
              fmt::format("{} stopped responding ({}).", device_name(facts), said.empty() ? "lost" : said),
              "The same command continues from the last checkpoint, and does so on the processor with "
              "--backend cpu. If it happens again, see the driver's messages (dmesg).",
              where};
    case DeviceStatus::unknown_request:
      return {ErrorCode::missing_dependency, "The CUDA module and this program differ in version.",
              fmt::format("Install both from one build. {}", kUseProcessor), where};
    case DeviceStatus::ok:
    case DeviceStatus::failed:
      break;
  }
  return {ErrorCode::failed, fmt::format("CUDA reports an error: {}.", said.empty() ? "unknown" : said),
          "Try again, or use the processor: --backend cpu.", where};
}

Result<std::shared_ptr<Device>> Device::open(const DeviceApi& api) {
  DeviceFacts facts{};
  if (api.version != kDeviceApiVersion) return device_error(DeviceStatus::unknown_request, facts, "", "");
  void* context = nullptr;
  const DeviceStatus status = api.open(&context, &facts);
  if (status != DeviceStatus::ok || !context)
    return device_error(status, facts, api.last_message(nullptr), "");
  return std::shared_ptr<Device>(new Device(api, context, facts));
}

Device::~Device() { api_.close(context_); }

Result<void> Device::checked(DeviceStatus status) {
  if (status == DeviceStatus::ok) return {};
  return device_error(status, facts_, api_.last_message(context_), "");
}

Result<void*> Device::allocate(std::size_t bytes) {
  void* memory = nullptr;
  if (auto done = checked(api_.allocate(context_, bytes, &memory)); !done) return done.error();
  return memory;
}

void Device::release(void* memory) { api_.release(context_, memory); }

Result<void> Device::copy_in(void* to, const void* from, std::size_t bytes) {
  return bytes == 0 ? Result<void>() : checked(api_.copy_in(context_, to, from, bytes));
}

Result<void> Device::copy_out(void* to, const void* from, std::size_t bytes) {
  return bytes == 0 ? Result<void>() : checked(api_.copy_out(context_, to, from, bytes));
}

Result<void> Device::clear(void* memory, std::size_t bytes) {
  return bytes == 0 ? Result<void>() : checked(api_.clear(context_, memory, bytes));
}

Result<void> Device::launch_bytes(Kernel kernel, const void* args, std::size_t bytes, std::size_t items) {
  return checked(api_.launch(context_, std::int32_t(kernel), args, bytes, items));
}

Result<void> Device::record() { return checked(api_.record(context_)); }

Result<void*> Device::end_record() {
  void* recording = nullptr;
  if (auto done = checked(api_.end_record(context_, &recording)); !done) return done.error();
  return recording;
}

Result<void> Device::replay(void* recording) { return checked(api_.replay(context_, recording)); }
void Device::forget(void* recording) { api_.forget(context_, recording); }
Result<void> Device::wait() { return checked(api_.wait(context_)); }
Result<void> Device::mark(int number) { return checked(api_.mark(context_, number)); }

Result<double> Device::between(int first, int second) {
  double seconds = 0;
  if (auto done = checked(api_.between(context_, first, second, &seconds)); !done) return done.error();
  return seconds;
}

}  // namespace likeness
