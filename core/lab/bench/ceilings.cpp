// Measuring the ceilings: see ceilings.h.
#include "core/lab/bench/ceilings.h"

#include <algorithm>
#include <atomic>
#include <barrier>
#include <cmath>
#include <functional>
#include <thread>

#include "core/base/check.h"
#include "core/lab/bench/ceiling_kernels.h"
#include "core/lab/bench/stopwatch.h"

namespace likeness {
namespace {

constexpr std::size_t kTableBytes[] = {std::size_t{1} << 15, std::size_t{1} << 17, std::size_t{1} << 19,
                                       std::size_t{1} << 21};
constexpr std::size_t kEntryBytes = 8;
constexpr std::size_t kStreamFloats = std::size_t{1} << 25;  // 128 MB per thread: beyond every cache
constexpr std::size_t kBlock = 1 << 15;                      // operations between two looks at the clock

// A thread's own data and results.
struct Worker {
  std::vector<float> data;
  float keep = 0;
  double rate = 0;
};

// Operations per second of all workers together. `block` does some operations and returns how many.
double together(std::vector<Worker>& workers, double seconds,
                const std::function<double(Worker&, std::uint32_t)>& block) {
  const int threads = int(workers.size());
  std::barrier start(threads);
  const auto work = [&](Worker& worker) {
    block(worker, 1);  // brings its data into the caches
    start.arrive_and_wait();
    const Stopwatch watch(threads);
    double operations = 0, passed = 0;
    for (std::uint32_t seed = 2; passed < seconds; ++seed) {
      operations += block(worker, seed);
      passed = watch.seconds();
    }
    worker.rate = operations / passed;
  };
  std::vector<std::jthread> others;
  for (int t = 1; t < threads; ++t) others.emplace_back(work, std::ref(workers[std::size_t(t)]));
  work(workers[0]);
  others.clear();
  double rate = 0;
  for (const Worker& worker : workers) rate += worker.rate;
  return rate;
}

double interpolated(const std::vector<TableRate>& tables, std::size_t bytes, double TableRate::*rate) {
  LIKENESS_CHECK(!tables.empty(), "no measured tables for %zu bytes", bytes);
  const auto seconds = [&](const TableRate& t) { return 1e-6 / (t.*rate); };
  if (bytes <= tables.front().bytes) return seconds(tables.front());
  for (std::size_t i = 1; i < tables.size(); ++i) {
    const TableRate &low = tables[i - 1], &high = tables[i];
    if (bytes > high.bytes) continue;
    const double share =
        std::log(double(bytes) / double(low.bytes)) / std::log(double(high.bytes) / double(low.bytes));
    return std::lerp(seconds(low), seconds(high), share);
  }
  return seconds(tables.back());
}

}  // namespace

Ceilings measure_ceilings(int threads, double seconds) {
  Ceilings ceilings;
  ceilings.threads = threads;
  std::vector<Worker> workers(std::size_t(std::max(1, threads)));
  ceilings.fma_gflops = 1e-9 * together(workers, seconds, [](Worker& w, std::uint32_t) {
                          return fma_block(kBlock / 8, w.keep);
                        });
  if (bf16_block(1, workers[0].keep) > 0)
    ceilings.bf16_gflops = 1e-9 * together(workers, seconds, [](Worker& w, std::uint32_t) {
                             return bf16_block(kBlock / 8, w.keep);
                           });
  for (const std::size_t bytes : kTableBytes) {
    for (Worker& worker : workers) worker.data.assign(bytes / sizeof(float), 0.25f);
    const std::size_t entries = bytes / kEntryBytes;
    TableRate rate{bytes, 0, 0};
    rate.gather_mps = 1e-6 * together(workers, seconds, [&](Worker& w, std::uint32_t seed) {
                        return gather_block(w.data.data(), entries, kBlock, seed, w.keep);
                      });
    rate.read_modify_write_mps = 1e-6 * together(workers, seconds, [&](Worker& w, std::uint32_t seed) {
                                   return read_modify_write_block(w.data.data(), entries, kBlock, seed);
                                 });
    ceilings.tables.push_back(rate);
  }
  for (Worker& worker : workers) worker.data.assign(kStreamFloats, 0.25f);
  ceilings.bandwidth_gbs = 1e-9 * together(workers, seconds, [](Worker& w, std::uint32_t) {
                             return stream_block(w.data.data(), kStreamFloats, w.keep);
                           });
  // Written where the compiler cannot prove that nobody reads, so that the loops are not removed.
  static std::atomic<float> seen;
  for (const Worker& worker : workers) seen = seen + worker.keep;
  return ceilings;
}

Ceilings best_of(const Ceilings& a, const Ceilings& b) {
  LIKENESS_CHECK(a.threads == b.threads && a.tables.size() == b.tables.size(),
                 "ceilings of %d and of %d threads", a.threads, b.threads);
  Ceilings best = a;
  best.fma_gflops = std::max(a.fma_gflops, b.fma_gflops);
  best.bf16_gflops = std::max(a.bf16_gflops, b.bf16_gflops);
  best.bandwidth_gbs = std::max(a.bandwidth_gbs, b.bandwidth_gbs);
  for (std::size_t i = 0; i < best.tables.size(); ++i) {
    TableRate& t = best.tables[i];
    t.gather_mps = std::max(t.gather_mps, b.tables[i].gather_mps);
    t.read_modify_write_mps = std::max(t.read_modify_write_mps, b.tables[i].read_modify_write_mps);
  }
  return best;
}

double gather_seconds(const Ceilings& ceilings, std::size_t bytes) {
  return interpolated(ceilings.tables, bytes, &TableRate::gather_mps);
}

double read_modify_write_seconds(const Ceilings& ceilings, std::size_t bytes) {
  return interpolated(ceilings.tables, bytes, &TableRate::read_modify_write_mps);
}

}  // namespace likeness
