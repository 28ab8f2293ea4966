// A device that is the processor: see emulated_device.h.
#include "tests/core/device/emulated_device.h"

#include <barrier>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <functional>
#include <map>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/field/field_bf16.h"
#include "core/field/grid_math.h"
#include "core/field/network_math.h"
#include "core/render/device_loss.h"
#include "core/render/device_picture.h"
#include "core/train/device_rays.h"

namespace likeness {
namespace {

struct Emulated {
  EmulatedFaults faults;
  EmulatedCounts counts;
  std::map<void*, std::size_t> memory;
  bool recording = false, lost = false;
  std::vector<std::function<void()>> recorded;
  double marks[8] = {};
};
Emulated state;

struct Bf16 {
  std::uint16_t bits;
  explicit Bf16(float value) : bits(to_bf16(value)) {}
  explicit operator float() const { return from_bf16(bits); }
};

// One of `count` blocks of a kernel. Its threads share the items and wait for each other at the end of each
// share.
struct Threads {
  std::uint32_t own, count;
  int thread = 0, threads = 1;
  std::barrier<>* all = nullptr;  // of the block's threads; null: there is one

  std::uint32_t index() const { return own; }
  std::uint32_t blocks() const { return count; }
  void sync() const {
    if (all) all->arrive_and_wait();
  }
  template <class F>
  void for_each(int items, const F& f) const {
    for (int i = thread; i < items; i += threads) f(i);
    sync();
  }
};

struct LoopBlock : Threads, LoopProducts<LoopBlock> {
  unsigned char* memory = nullptr;
};

constexpr std::uint32_t kHostBlocks = 3;  // so that several add to one sum, and some find nothing to do
constexpr int kHostThreads = 4;

template <class Value, class Block>
void network(const NetworkArgs& args, bool backward, bool threads) {
  for (std::uint32_t b = 0; b < kHostBlocks; ++b) {
    std::vector<float> shared(network_memory(args, sizeof(Value), backward).end / sizeof(float), NAN);
    std::barrier all(kHostThreads);
    const auto run = [&](int thread) {
      Block block;
      block.own = b, block.count = kHostBlocks;
      block.memory = reinterpret_cast<unsigned char*>(shared.data());
      if (threads) block.thread = thread, block.threads = kHostThreads, block.all = &all;
      backward ? network_backward<Value>(block, args, block.memory)
               : network_forward<Value>(block, args, block.memory);
    };
    if (!threads) {
      run(0);
      continue;
    }
    std::vector<std::jthread> workers;
    for (int t = 0; t < kHostThreads; ++t) workers.emplace_back(run, t);
  }
}

void networks(const NetworkArgs& args, bool backward) {
  const bool threads = state.faults.threads;
  args.precision == NetworkPrecision::bf16 ? network<Bf16, LoopBlock>(args, backward, threads)
                                           : network<float, LoopBlock>(args, backward, threads);
}

void encode(const EncodeArgs& a, std::size_t items) {
  for (std::size_t i = 0; i < items; ++i) {
    const std::size_t most = items / std::size_t(a.grid.levels), n = i % most, l = i / most;
    if (n >= *a.count) continue;
#define LIKENESS_ENCODE(D, F) encode_sample<D, F>(a, n, int(l));
    LIKENESS_FOR_GRID(a.grid, LIKENESS_ENCODE)
#undef LIKENESS_ENCODE
  }
}

void encode_back(const EncodeBackwardArgs& a, std::size_t items) {
  for (std::size_t i = 0; i < items; ++i) {
    const std::size_t n = i % a.capacity, l = i / a.capacity;
    if (n >= *a.count) continue;
#define LIKENESS_ENCODE(D, F)         \
  if (a.d_point[0])                   \
    encode_sample_slopes<D, F>(a, n); \
  else                                \
    encode_sample_backward<D, F>(a, n, int(l), nullptr);
    LIKENESS_FOR_GRID(a.grid, LIKENESS_ENCODE)
#undef LIKENESS_ENCODE
  }
}

using Recording = std::vector<std::function<void()>>;

template <class Args>
const Args& as(const std::vector<unsigned char>& bytes) {
  static_assert(alignof(Args) <= alignof(std::max_align_t));
  LIKENESS_CHECK(bytes.size() == sizeof(Args), "arguments of %zu bytes for a kernel that takes %zu",
                 bytes.size(), sizeof(Args));
  return *reinterpret_cast<const Args*>(bytes.data());
}

// fn(args, item) for every item.
template <class Args, class F>
void each(const std::vector<unsigned char>& args, std::size_t items, const F& fn) {
  for (std::size_t i = 0; i < items; ++i) fn(as<Args>(args), i);
}

void run_picture_kernel(Kernel kernel, const std::vector<unsigned char>& args, std::size_t items) {
  switch (kernel) {
    case Kernel::neck_cells: {
      const FrameNumbers& frame = *as<NeckCellsArgs>(args).scene.frame;
      const std::size_t count = frame.neck.bends ? neck_cell_count(frame) : 0;
      return each<NeckCellsArgs>(args, std::min(items, count), fill_neck_cell);
    }
    case Kernel::march_strata:
      return each<MarchStrataArgs>(args, items, march_strata);
    case Kernel::march_rays:
      return each<MarchRaysArgs>(args, items, march_rays);
    case Kernel::ray_offsets:
      for (std::uint32_t b = 0; b * kScanRays < items; ++b) {
        std::vector<std::uint32_t> shared(7 * kScanRays, ~0u);
        Threads block{b, 0};
        ray_offsets(block, as<RayOffsetsArgs>(args), shared.data());
      }
      return;
    case Kernel::gather_samples:
      return each<GatherArgs>(args, items, gather_sample);
    case Kernel::refine_strata:
      return each<RefineArgs>(args, items, [](const RefineArgs& a, std::size_t i) { refine_strata(a, i); });
    case Kernel::pick_samples:
      return each<PickArgs>(args, items, pick_samples);
    case Kernel::composite_pixels:
      return each<CompositeArgs>(args, items, composite_pixel);
    default:
      return;
  }
}

void run_training_kernel(Kernel kernel, const std::vector<unsigned char>& args, std::size_t items) {
  switch (kernel) {
    case Kernel::choose_rays:
      return each<ChooseRaysArgs>(args, items, choose_ray_of_step);
    case Kernel::march_chosen:
      return each<MarchChosenArgs>(args, items, march_chosen);
    case Kernel::ordered_offsets:
      for (std::uint32_t b = 0; b * kScanRays < items; ++b) {
        std::vector<std::uint32_t> shared(8 * kScanRays, ~0u);
        Threads block{b, 0};
        ordered_offsets(block, as<OrderedOffsetsArgs>(args), shared.data());
      }
      return;
    case Kernel::gather_chosen:
      return each<GatherChosenArgs>(args, items, gather_chosen);
    case Kernel::look_up_cells:
      return each<LookUpArgs>(args, items, look_up_cell);
    case Kernel::decay_cells:
      return each<DecayArgs>(args, items, decay_cell);
    case Kernel::set_cell_bits:
      return each<CellBitsArgs>(args, items, set_cell_bits);
    case Kernel::mark_bricks:
      return each<BricksArgs>(args, items, mark_brick);
    case Kernel::bound_layers:
      return each<LayersArgs>(args, items, bound_layer);
    case Kernel::bound_necks:
      return each<NeckBoxArgs>(args, items, bound_neck_of_view);
    case Kernel::fill_necks:
      return each<FillNecksArgs>(args, items, [](const FillNecksArgs& a, std::size_t i) {
        fill_neck(a, i / a.views.neck_room, i % a.views.neck_room);
      });
    default:
      return run_picture_kernel(kernel, args, items);
  }
}

void run_kernel(Kernel kernel, const std::vector<unsigned char>& args, std::size_t items) {
  switch (kernel) {
    case Kernel::encode:
      return encode(as<EncodeArgs>(args), items);
    case Kernel::encode_backward:
      return encode_back(as<EncodeBackwardArgs>(args), items);
    case Kernel::network_forward:
      return networks(as<NetworkArgs>(args), false);
    case Kernel::network_backward:
      return networks(as<NetworkArgs>(args), true);
    case Kernel::adam_lines:
      for (std::size_t i = 0; i < items; ++i) adam_line(as<AdamLinesArgs>(args), i);
      return;
    case Kernel::adam_networks:
      for (std::size_t i = 0; i < items; ++i) adam_network(as<AdamNetworksArgs>(args), i);
      return;
    case Kernel::adam_codes: {
      Threads block{0, 1};
      return adam_codes(block, as<AdamCodesArgs>(args));
    }
    case Kernel::ray_loss: {
      const auto& a = as<RayLossArgs>(args);
      for (std::size_t r = 0; r < items && r < a.numbers->rays; ++r) a.sums->error += ray_loss(a, r);
      return;
    }
    default:
      return run_training_kernel(kernel, args, items);
  }
}

DeviceStatus answer() { return state.lost ? DeviceStatus::lost : DeviceStatus::ok; }

DeviceStatus queue(std::function<void()> work) {
  if (state.lost) return DeviceStatus::lost;
  if (state.recording) {
    state.recorded.push_back(std::move(work));
  } else {
    work();
  }
  return DeviceStatus::ok;
}

void count_launch() {
  ++state.counts.launches;
  if (state.faults.lost_after >= 0 && long(state.counts.launches) > state.faults.lost_after)
    state.lost = true;
}

DeviceStatus open(void** context, DeviceFacts* facts) {
  *facts = {};
  std::snprintf(facts->name, sizeof(facts->name), "emulated device");
  facts->major = 9, facts->driver = 12040, facts->toolkit = 13000, facts->multiprocessors = 1;
  facts->matrix_units = state.faults.matrix_units;
  facts->memory_bytes = facts->free_bytes = state.faults.memory_bytes;
  facts->shared_bytes = state.faults.shared_bytes;
  if (state.faults.open == DeviceStatus::ok) *context = &state;
  return state.faults.open;
}

DeviceStatus allocate(void*, std::size_t bytes, void** memory) {
  if (state.lost) return DeviceStatus::lost;  // after this there is nothing to release
  if (state.counts.bytes + bytes > state.faults.memory_bytes) return DeviceStatus::out_of_memory;
  *memory = ::operator new(bytes);
  std::memset(*memory, 0xff, bytes);  // NaN, so that unset memory is noticed
  state.memory[*memory] = bytes;
  state.counts.bytes += bytes;
  state.counts.max_bytes = std::max(state.counts.max_bytes, state.counts.bytes);
  return DeviceStatus::ok;
}

void release(void*, void* memory) {
  state.counts.bytes -= state.memory[memory];
  state.memory.erase(memory);
  ::operator delete(memory);
}

DeviceStatus copy(void*, void* to, const void* from, std::size_t bytes) {
  if (!state.lost) std::memcpy(to, from, bytes);
  return answer();
}

DeviceStatus launch(void*, std::int32_t kernel, const void* args, std::size_t bytes, std::size_t items) {
  const auto* first = static_cast<const unsigned char*>(args);
  return queue([kernel, copied = std::vector<unsigned char>(first, first + bytes), items] {
    count_launch();
    if (!state.lost) run_kernel(Kernel(kernel), copied, items);
  });
}

DeviceStatus end_record(void*, void** recording) {
  state.recording = false;
  Recording recorded = std::exchange(state.recorded, {});
  if (state.lost) return DeviceStatus::lost;
  *recording = new Recording(std::move(recorded));
  return DeviceStatus::ok;
}

DeviceStatus replay(void*, void* recording) {
  ++state.counts.replays;
  for (const auto& work : *static_cast<Recording*>(recording)) work();
  return DeviceStatus::ok;  // a device's errors are reported by wait
}

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

const DeviceApi kApi = {
    kDeviceApiVersion,
    open,
    [](void*) {},
    allocate,
    release,
    [](void* context, void* to, const void* from, std::size_t bytes) {
      state.counts.bytes_in += bytes;
      return copy(context, to, from, bytes);
    },
    copy,
    [](void*, void* memory, std::size_t bytes) { return queue([=] { std::memset(memory, 0, bytes); }); },
    launch,
    [](void*) { return state.recording = true, answer(); },
    end_record,
    replay,
    [](void*, void* recording) { delete static_cast<Recording*>(recording); },
    [](void*) {
      ++state.counts.waits;
      if (state.recording) ++state.counts.waits_while_recording;
      return answer();
    },
    [](void*, std::int32_t number) { return state.marks[number] = now(), answer(); },
    [](void*, std::int32_t first, std::int32_t second, double* seconds) {
      return *seconds = state.marks[second] - state.marks[first], answer();
    },
    [](void*) { return "emulated"; }};

}  // namespace

const DeviceApi& emulated_api(const EmulatedFaults& faults) {
  state = {};
  state.faults = faults;
  return kApi;
}

EmulatedCounts emulated_counts() { return state.counts; }

std::shared_ptr<Device> emulated_device(const EmulatedFaults& faults) {
  auto device = Device::open(emulated_api(faults));
  return device ? *device : nullptr;
}

}  // namespace likeness
