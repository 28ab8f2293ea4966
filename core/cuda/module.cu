// The module's table of functions (core/device/device_api.h) on the CUDA runtime, which is linked in: only
// the driver need be installed, and only where the module is opened.
#include <cuda_runtime.h>

#include <cstring>
#include <new>
#include <string>

#include "core/device/cuda_launchers.h"
#include "core/device/device_api.h"
#include "core/device/kernel_ids.h"
#include "core/field/cuda_launchers.h"
#include "core/render/cuda_launchers.h"
#include "core/train/cuda_launchers.h"

namespace likeness::cuda {
namespace {

constexpr int kMarks = 8;

struct Context {
  cudaStream_t stream = nullptr;
  cudaEvent_t marks[kMarks] = {};
  DeviceFacts facts{};
};

thread_local std::string last_said;  // of the opening thread, then of the one that owns the context

DeviceStatus status_of(cudaError_t error) {
  if (error == cudaSuccess) return DeviceStatus::ok;
  last_said = cudaGetErrorString(error);
  (void)cudaGetLastError();
  switch (error) {
    case cudaErrorMemoryAllocation:
      return DeviceStatus::out_of_memory;
    case cudaErrorInsufficientDriver:
      return DeviceStatus::driver_too_old;
    case cudaErrorNoDevice:
      return DeviceStatus::no_device;
    case cudaErrorNoKernelImageForDevice:
    case cudaErrorInvalidDeviceFunction:
    case cudaErrorUnsupportedPtxVersion:
      return DeviceStatus::device_too_old;
    case cudaErrorLaunchOutOfResources:
      return DeviceStatus::too_large;
    case cudaErrorIllegalAddress:
    case cudaErrorLaunchFailure:
    case cudaErrorLaunchTimeout:
    case cudaErrorECCUncorrectable:
    case cudaErrorHardwareStackError:
    case cudaErrorIllegalInstruction:
    case cudaErrorMisalignedAddress:
    case cudaErrorDevicesUnavailable:
    case cudaErrorUnknown:
      return DeviceStatus::lost;
    default:
      return DeviceStatus::failed;
  }
}

Context& of(void* context) { return *static_cast<Context*>(context); }

DeviceStatus find_device(DeviceFacts& facts) {
  (void)cudaRuntimeGetVersion(&facts.toolkit);
  if (cudaDriverGetVersion(&facts.driver) != cudaSuccess || facts.driver == 0) return DeviceStatus::no_driver;
  int count = 0;
  const cudaError_t counted = cudaGetDeviceCount(&count);
  if (counted != cudaSuccess) return status_of(counted);
  if (count == 0) return DeviceStatus::no_device;
  cudaDeviceProp properties;
  if (const cudaError_t failed = cudaGetDeviceProperties(&properties, 0); failed != cudaSuccess)
    return status_of(failed);
  std::memcpy(facts.name, properties.name, sizeof(facts.name) - 1);  // the rest is zero
  facts.major = properties.major, facts.minor = properties.minor;
  facts.multiprocessors = properties.multiProcessorCount;
  facts.matrix_units = properties.major >= 8;
  facts.shared_bytes = properties.sharedMemPerBlockOptin;
  std::size_t free_bytes = 0, all_bytes = 0;
  if (const cudaError_t failed = cudaMemGetInfo(&free_bytes, &all_bytes); failed != cudaSuccess)
    return status_of(failed);
  facts.free_bytes = free_bytes, facts.memory_bytes = all_bytes;
  return status_of(has_code());
}

void close(void* context) {
  for (cudaEvent_t mark : of(context).marks)
    if (mark) (void)cudaEventDestroy(mark);
  if (of(context).stream) (void)cudaStreamDestroy(of(context).stream);
  delete &of(context);
}

DeviceStatus open(void** context, DeviceFacts* facts) {
  *facts = {};
  if (const DeviceStatus found = find_device(*facts); found != DeviceStatus::ok) return found;
  auto* made = new Context;
  made->facts = *facts;
  cudaError_t failed = cudaStreamCreateWithFlags(&made->stream, cudaStreamNonBlocking);
  for (int i = 0; i < kMarks && failed == cudaSuccess; ++i) failed = cudaEventCreate(&made->marks[i]);
  if (failed != cudaSuccess) {
    close(made);
    return status_of(failed);
  }
  *context = made;
  return DeviceStatus::ok;
}

template <class Args>
DeviceStatus run(Context& c, cudaError_t (*launcher)(const Launch&, const Args&, std::size_t),
                 const void* args, std::size_t bytes, std::size_t items) {
  if (bytes != sizeof(Args)) return DeviceStatus::unknown_request;
  Args copy;
  std::memcpy(&copy, args, sizeof(copy));
  return status_of(launcher({c.stream, c.facts}, copy, items));
}

DeviceStatus launch(void* context, std::int32_t kernel, const void* args, std::size_t bytes,
                    std::size_t items) {
  Context& c = of(context);
  switch (Kernel(kernel)) {
    case Kernel::encode:
      return run<EncodeArgs>(c, encode, args, bytes, items);
    case Kernel::encode_backward:
      return run<EncodeBackwardArgs>(c, encode_backward, args, bytes, items);
    case Kernel::network_forward:
      return run<NetworkArgs>(c, network_forward, args, bytes, items);
    case Kernel::network_backward:
      return run<NetworkArgs>(c, network_backward, args, bytes, items);
    case Kernel::adam_lines:
      return run<AdamLinesArgs>(c, adam_lines, args, bytes, items);
    case Kernel::adam_networks:
      return run<AdamNetworksArgs>(c, adam_networks, args, bytes, items);
    case Kernel::adam_codes:
      return run<AdamCodesArgs>(c, adam_codes, args, bytes, items);
    case Kernel::ray_loss:
      return run<RayLossArgs>(c, ray_loss, args, bytes, items);
    case Kernel::neck_cells:
      return run<NeckCellsArgs>(c, neck_cells, args, bytes, items);
    case Kernel::march_strata:
      return run<MarchStrataArgs>(c, march_strata, args, bytes, items);
    case Kernel::march_rays:
      return run<MarchRaysArgs>(c, march_rays, args, bytes, items);
    case Kernel::ray_offsets:
      return run<RayOffsetsArgs>(c, ray_offsets, args, bytes, items);
    case Kernel::gather_samples:
      return run<GatherArgs>(c, gather_samples, args, bytes, items);
    case Kernel::refine_strata:
      return run<RefineArgs>(c, refine_strata, args, bytes, items);
    case Kernel::pick_samples:
      return run<PickArgs>(c, pick_samples, args, bytes, items);
    case Kernel::composite_pixels:
      return run<CompositeArgs>(c, composite_pixels, args, bytes, items);
    case Kernel::choose_rays:
      return run<ChooseRaysArgs>(c, choose_rays, args, bytes, items);
    case Kernel::march_chosen:
      return run<MarchChosenArgs>(c, march_chosen, args, bytes, items);
    case Kernel::ordered_offsets:
      return run<OrderedOffsetsArgs>(c, ordered_offsets, args, bytes, items);
    case Kernel::gather_chosen:
      return run<GatherChosenArgs>(c, gather_chosen, args, bytes, items);
    case Kernel::look_up_cells:
      return run<LookUpArgs>(c, look_up_cells, args, bytes, items);
    case Kernel::decay_cells:
      return run<DecayArgs>(c, decay_cells, args, bytes, items);
    case Kernel::set_cell_bits:
      return run<CellBitsArgs>(c, set_cell_bits, args, bytes, items);
    case Kernel::mark_bricks:
      return run<BricksArgs>(c, mark_bricks, args, bytes, items);
    case Kernel::bound_layers:
      return run<LayersArgs>(c, bound_layers, args, bytes, items);
    case Kernel::bound_necks:
      return run<NeckBoxArgs>(c, bound_necks, args, bytes, items);
    case Kernel::fill_necks:
      return run<FillNecksArgs>(c, fill_necks, args, bytes, items);
    case Kernel::read_write:
      return run<CeilingArgs>(c, read_write, args, bytes, items);
    case Kernel::matrix_rate:
      return run<CeilingArgs>(c, matrix_rate, args, bytes, items);
    case Kernel::count:
      break;
  }
  return DeviceStatus::unknown_request;
}

DeviceStatus end_record(void* context, void** recording) {
  cudaGraph_t graph = nullptr;
  if (const cudaError_t failed = cudaStreamEndCapture(of(context).stream, &graph); failed != cudaSuccess)
    return status_of(failed);
  cudaGraphExec_t made = nullptr;
  const cudaError_t failed = cudaGraphInstantiateWithFlags(&made, graph, 0);
  (void)cudaGraphDestroy(graph);
  *recording = made;
  return status_of(failed);
}

DeviceStatus between(void* context, std::int32_t first, std::int32_t second, double* seconds) {
  float ms = 0;
  const cudaError_t failed = cudaEventElapsedTime(&ms, of(context).marks[first], of(context).marks[second]);
  *seconds = 1e-3 * double(ms);
  return status_of(failed);
}

const DeviceApi kApi = {
    kDeviceApiVersion,
    open,
    close,
    [](void*, std::size_t bytes, void** memory) { return status_of(cudaMalloc(memory, bytes)); },
    [](void*, void* memory) { (void)cudaFree(memory); },
    [](void* c, void* to, const void* from, std::size_t bytes) {
      return status_of(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, of(c).stream));
    },
    [](void* c, void* to, const void* from, std::size_t bytes) {
      return status_of(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, of(c).stream));
    },
    [](void* c, void* memory, std::size_t bytes) {
      return status_of(cudaMemsetAsync(memory, 0, bytes, of(c).stream));
    },
    launch,
    [](void* c) { return status_of(cudaStreamBeginCapture(of(c).stream, cudaStreamCaptureModeThreadLocal)); },
    end_record,
    [](void* c, void* recording) {
      return status_of(cudaGraphLaunch(static_cast<cudaGraphExec_t>(recording), of(c).stream));
    },
    [](void*, void* recording) { (void)cudaGraphExecDestroy(static_cast<cudaGraphExec_t>(recording)); },
    [](void* c) { return status_of(cudaStreamSynchronize(of(c).stream)); },
    [](void* c, std::int32_t number) {
      return status_of(cudaEventRecord(of(c).marks[number], of(c).stream));
    },
    between,
    [](void*) { return last_said.c_str(); }};

}  // namespace
}  // namespace likeness::cuda

extern "C" __attribute__((visibility("default"))) const likeness::DeviceApi* likeness_device_api(
    std::uint32_t version) {
  return version == likeness::kDeviceApiVersion ? &likeness::cuda::kApi : nullptr;
}
