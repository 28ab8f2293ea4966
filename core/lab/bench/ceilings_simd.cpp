// The ceilings' loops for every instruction set: see ceiling_kernels.h.
#include "core/lab/bench/ceiling_kernels.h"

#include <algorithm>

#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/lab/bench/ceilings_simd.cpp"
#include "hwy/foreach_target.h"
// After foreach_target.h, which includes this file again once per target:
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace likeness {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Df = hn::CappedTag<float, 16>;
using Du = hn::RebindToUnsigned<Df>;
using Pair = hn::FixedTag<float, 2>;
constexpr std::size_t kIndices = 64;  // computed at a time

double FmaBlock(std::size_t rounds, float& keep) {
  const Df d;
  constexpr int kChains = 12;  // latency times units is at most 10 on today's processors
  hn::Vec<Df> sum[kChains];
#pragma GCC unroll 12
  for (int k = 0; k < kChains; ++k) sum[k] = hn::Set(d, float(k));
  const auto scale = hn::Set(d, 0.999f), shift = hn::Set(d, 0.5f);
  for (std::size_t r = 0; r < rounds; ++r) {
#pragma GCC unroll 12
    for (int k = 0; k < kChains; ++k) sum[k] = hn::MulAdd(sum[k], scale, shift);
  }
#pragma GCC unroll 11
  for (int k = 1; k < kChains; ++k) sum[0] = hn::Add(sum[0], sum[k]);
  keep += hn::GetLane(sum[0]);
  return 2.0 * kChains * double(hn::Lanes(d)) * double(rounds);
}

// Random indices below a power of two: one linear congruence per lane, whose high bits are good enough here.
struct Indices {
  alignas(64) std::uint32_t at[kIndices];
  alignas(64) std::uint32_t state[kIndices];

  explicit Indices(std::uint32_t seed) {
    for (std::uint32_t& s : state) s = seed = seed * 747796405u + 2891336453u;
  }
  HWY_INLINE void next(std::uint32_t mask) {
    const Du d;
    for (std::size_t i = 0; i < kIndices; i += hn::Lanes(d)) {
      const auto s = hn::Add(hn::Mul(hn::Load(d, state + i), hn::Set(d, 1664525u)), hn::Set(d, 1013904223u));
      hn::Store(s, d, state + i);
      hn::Store(hn::And(hn::ShiftRight<8>(s), hn::Set(d, mask)), d, at + i);
    }
  }
};

double GatherBlock(const float* table, std::size_t entries, std::size_t reads, std::uint32_t seed,
                   float& keep) {
  const Pair d;
  Indices indices(seed);
  hn::Vec<Pair> sum[4] = {hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  std::size_t done = 0;
  for (; done < reads; done += kIndices) {
    indices.next(std::uint32_t(entries - 1));
    for (std::size_t i = 0; i < kIndices; i += 4) {
#pragma GCC unroll 4
      for (std::size_t k = 0; k < 4; ++k)
        sum[k] = hn::Add(sum[k], hn::LoadU(d, table + 2 * std::size_t(indices.at[i + k])));
    }
  }
  keep += hn::GetLane(hn::Add(hn::Add(sum[0], sum[1]), hn::Add(sum[2], sum[3])));
  return double(done);
}

double ReadModifyWriteBlock(float* table, std::size_t entries, std::size_t writes, std::uint32_t seed) {
  const Pair d;
  Indices indices(seed);
  const auto weight = hn::Set(d, 0.5f), gradient = hn::Set(d, 1e-6f);
  std::size_t done = 0;
  for (; done < writes; done += kIndices) {
    indices.next(std::uint32_t(entries - 1));
#pragma GCC unroll 4
    for (std::size_t i = 0; i < kIndices; ++i) {
      float* entry = table + 2 * std::size_t(indices.at[i]);
      hn::StoreU(hn::MulAdd(weight, gradient, hn::LoadU(d, entry)), d, entry);
    }
  }
  return double(done);
}

double StreamBlock(const float* data, std::size_t count, float& keep) {
  const Df d;
  const std::size_t lanes = hn::Lanes(d);
  hn::Vec<Df> sum[4] = {hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  std::size_t i = 0;
  for (; i + 4 * lanes <= count; i += 4 * lanes) {
#pragma GCC unroll 4
    for (std::size_t k = 0; k < 4; ++k) sum[k] = hn::Add(sum[k], hn::LoadU(d, data + i + k * lanes));
  }
  keep += hn::GetLane(hn::Add(hn::Add(sum[0], sum[1]), hn::Add(sum[2], sum[3])));
  return double(i * sizeof(float));
}

const char* InstructionSet() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace likeness
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace likeness {

HWY_EXPORT(FmaBlock);
HWY_EXPORT(GatherBlock);
HWY_EXPORT(ReadModifyWriteBlock);
HWY_EXPORT(StreamBlock);
HWY_EXPORT(InstructionSet);

double fma_block(std::size_t rounds, float& keep) { return HWY_DYNAMIC_DISPATCH(FmaBlock)(rounds, keep); }
double gather_block(const float* table, std::size_t entries, std::size_t reads, std::uint32_t seed,
                    float& keep) {
  return HWY_DYNAMIC_DISPATCH(GatherBlock)(table, entries, reads, seed, keep);
}
double read_modify_write_block(float* table, std::size_t entries, std::size_t writes, std::uint32_t seed) {
  return HWY_DYNAMIC_DISPATCH(ReadModifyWriteBlock)(table, entries, writes, seed);
}
double stream_block(const float* data, std::size_t count, float& keep) {
  return HWY_DYNAMIC_DISPATCH(StreamBlock)(data, count, keep);
}
const char* instruction_set() { return HWY_DYNAMIC_DISPATCH(InstructionSet)(); }

}  // namespace likeness
#endif  // HWY_ONCE
