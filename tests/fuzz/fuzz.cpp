// The damage, the watch over memory and time, and the loop: see fuzz.h.
#include "tests/fuzz/fuzz.h"

#include <gtest/gtest.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <new>
#include <random>

#include "core/base/hash.h"
#include "tests/support/trials.h"

namespace {

std::atomic<std::size_t> g_alive{0}, g_peak{0};
char g_place[256] = "no input\n";  // what is being read, for the message after a crash

void* take(std::size_t size) {
  void* memory = std::malloc(size);
  if (!memory) throw std::bad_alloc();
  const std::size_t alive = g_alive += malloc_usable_size(memory);
  for (std::size_t peak = g_peak; alive > peak && !g_peak.compare_exchange_weak(peak, alive);) {
  }
  return memory;
}

void give(void* memory) noexcept {
  if (memory) g_alive -= malloc_usable_size(memory);
  std::free(memory);
}

void last_words(int signal) {
  const auto ignored = ::write(2, g_place, std::strlen(g_place));
  static_cast<void>(ignored);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

void* operator new(std::size_t size) { return take(size); }
void* operator new[](std::size_t size) { return take(size); }
void operator delete(void* memory) noexcept { give(memory); }
void operator delete[](void* memory) noexcept { give(memory); }
void operator delete(void* memory, std::size_t) noexcept { give(memory); }
void operator delete[](void* memory, std::size_t) noexcept { give(memory); }

// Called by the sanitizers where they are built in.
extern "C" void __asan_on_error() {
  const auto ignored = ::write(2, g_place, std::strlen(g_place));
  static_cast<void>(ignored);
}
extern "C" const char* __ubsan_default_options() { return "halt_on_error=1:print_stacktrace=1"; }
extern "C" const char* __asan_default_options() {
  return "allocator_may_return_null=1:max_allocation_size_mb=2048";
}

namespace likeness {
namespace {

using Random = std::mt19937_64;

std::size_t below(Random& random, std::size_t limit) {
  return limit == 0 ? 0 : std::size_t(random() % limit);
}

// A range of the text; short ones are likelier.
std::pair<std::size_t, std::size_t> range_in(Random& random, const std::string& text) {
  const std::size_t begin = below(random, text.size() + 1);
  const std::size_t longest =
      random() % 4 == 0 ? text.size() - begin : std::min<std::size_t>(16, text.size() - begin);
  return {begin, below(random, longest + 1)};
}

void set_integer(Random& random, std::string& text) {
  constexpr std::uint64_t kValues[] = {0,
                                       1,
                                       2,
                                       0x7f,
                                       0x80,
                                       0xff,
                                       0x7fff,
                                       0xffff,
                                       0x10000,
                                       0x7fffffff,
                                       0x80000000,
                                       0xffffffff,
                                       0x100000000,
                                       0x0fffffffffffffff,
                                       0x7fffffffffffffff,
                                       0x8000000000000000,
                                       0xffffffffffffffff};
  const std::size_t bytes = std::size_t(1) << below(random, 4);
  if (text.size() < bytes) return;
  const std::size_t at = below(random, text.size() - bytes + 1);
  std::uint64_t value =
      random() % 3 == 0 ? text.size() + below(random, 9) - 4 : kValues[below(random, std::size(kValues))];
  if (random() % 4 == 0) {  // a step from what is there
    std::memcpy(&value, text.data() + at, bytes);
    value += below(random, 5) - 2;
  }
  std::memcpy(text.data() + at, &value, bytes);
}

// Another number, or another kind of value, in the place of a run of digits.
void set_number(Random& random, std::string& text) {
  constexpr const char* kNumbers[] = {
      "0",     "-1",     "1",      "4294967296", "2147483648", "99999999999999999999999",
      "1e999", "-1e308", "1e-320", "null",       "true",       "\"x\"",
      "[]",    "{}",     "NaN",    "0.5",        "-0"};
  const std::size_t from = below(random, text.size() + 1);
  const std::size_t begin = text.find_first_of("0123456789", from);
  if (begin == std::string::npos) return;
  const std::size_t end = std::min(text.find_first_not_of("0123456789.eE+-", begin), text.size());
  text.replace(begin, end - begin, kNumbers[below(random, std::size(kNumbers))]);
}

void damage_once(Random& random, const std::vector<std::string>& seeds, std::string& text) {
  const auto [begin, length] = range_in(random, text);
  switch (random() % 10) {
    case 0:
      for (std::size_t i = below(random, 8) + 1; i-- > 0 && !text.empty();)
        text[below(random, text.size())] ^= char(1 << below(random, 8));
      break;
    case 1:
      if (!text.empty()) text[below(random, text.size())] = char(random());
      break;
    case 2:
      text.resize(begin);
      break;
    case 3:
      text.erase(begin, length);
      break;
    case 4: {
      const std::string part = text.substr(begin, length);
      for (std::size_t times = 1 + (random() % 8 == 0 ? below(random, 64) : 0);
           times-- > 0 && text.size() < 65536;)
        text.insert(below(random, text.size() + 1), part);
      break;
    }
    case 5: {
      const std::string& other = seeds[below(random, seeds.size())];
      const auto [from, count] = range_in(random, other);
      text.replace(begin, random() % 2 ? length : 0, other, from, count);
      break;
    }
    case 6:
    case 7:
      set_integer(random, text);
      break;
    case 8:
      set_number(random, text);
      break;
    default:
      for (std::size_t i = 0; i < length && begin + i < text.size(); ++i) text[begin + i] = char(random());
  }
}

// Leaves every length as it is, so that a reader gets past the outline of the file to its values.
void damage_in_place(Random& random, std::string& text) {
  if (text.size() < 8) return;
  const bool is_json = text.front() == '{' || text.front() == '[';
  switch (is_json ? 2 : random() % 4) {
    case 0:
      text[below(random, text.size())] ^= char(1 << below(random, 8));
      break;
    case 1:
      set_integer(random, text);
      break;
    case 2: {  // digits: of a text, or of a header
      const std::size_t begin = text.find_first_of("0123456789", below(random, text.size()));
      if (begin == std::string::npos) break;
      const std::size_t end = std::min(text.find_first_not_of("0123456789.", begin), text.size());
      const char sign = random() % 4 == 0 ? '-' : char('0' + below(random, 10));
      for (std::size_t i = begin; i < end; ++i)
        if (text[i] != '.') text[i] = i == begin ? sign : random() % 2 ? '9' : char('0' + below(random, 10));
      break;
    }
    default: {
      constexpr float kFloats[] = {0, -0.0f, 1, -1, 1e-38f, 1e30f, -1e30f, 1e4f, INFINITY, NAN};
      const float value = kFloats[below(random, std::size(kFloats))];
      std::memcpy(text.data() + 4 * below(random, text.size() / 4), &value, sizeof value);
    }
  }
}

double cpu_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

std::uint64_t environment_number(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

}  // namespace

std::string damaged(const std::vector<std::string>& seeds, std::uint64_t seed) {
  Random random(seed * 0x9e3779b97f4a7c15 + 1);
  std::string text = seeds[below(random, seeds.size())];
  if (seed % 4 == 1 || seed % 4 == 2) {  // of each kind one with its checksum put right
    for (std::size_t times = 1 + below(random, 3); times-- > 0;) damage_in_place(random, text);
    return text;
  }
  for (std::size_t times = 1 + below(random, 5); times-- > 0;) damage_once(random, seeds, text);
  return text;
}

FuzzFigures fuzz(const FuzzTarget& target) {
  for (const std::string& seed : target.seeds)
    EXPECT_TRUE(target.read(std::as_bytes(std::span(seed.data(), seed.size()))))
        << target.name << ": a seed is refused";
  for (const int signal : {SIGALRM, SIGABRT, SIGSEGV, SIGFPE}) std::signal(signal, last_words);
  using Clock = std::chrono::steady_clock;
  const auto start_of_all = Clock::now();
  const auto seconds_so_far = [&] {
    return std::chrono::duration<double>(Clock::now() - start_of_all).count();
  };
  const bool timed = std::getenv("LIKENESS_MINUTES") != nullptr;
  const auto only = test::only_trial();
  const std::uint64_t first = only ? *only : timed ? test::read_tally("fuzz " + target.name).trials : 0;
  const std::uint64_t inputs = only ? 1 : environment_number("LIKENESS_FUZZ_INPUTS", target.inputs);
  const auto goes_on = [&](std::uint64_t done) {
    return timed && !only ? done == 0 || seconds_so_far() < test::trial_seconds() : done < inputs;
  };
  FuzzFigures figures;
  std::size_t settled = 0;
  for (std::uint64_t n = first; goes_on(n - first); ++n) {
    const int complaints = test::complaints_so_far();
    std::string input = damaged(target.seeds, n);
    if (target.repair && n % 2 == 0) target.repair(input);
    std::snprintf(g_place, sizeof g_place, "fuzz: while %s read LIKENESS_TRIAL=%llu of %zu bytes\n",
                  target.name.c_str(), static_cast<unsigned long long>(n), input.size());
    ::alarm(600);  // wall time, since the computer may be busy
    const std::size_t before = g_alive;
    g_peak = before;
    const double start = cpu_seconds();
    const bool taken = target.read(std::as_bytes(std::span(input.data(), input.size())));
    const double seconds = cpu_seconds() - start;
    const std::size_t peak = g_peak - before;
    if (n == first + 100) settled = g_alive;  // caches and buffers of the libraries are made by then
    EXPECT_LE(peak, target.memory_floor + target.memory_times * input.size()) << g_place;
    EXPECT_LE(seconds, target.max_cpu_s) << g_place;
    figures.inputs += 1;
    figures.taken += taken;
    figures.slowest_s = std::max(figures.slowest_s, seconds);
    figures.peak_bytes = std::max(figures.peak_bytes, peak);
    figures.complaints += test::complaints_so_far() > complaints;
  }
  ::alarm(0);
  const std::size_t alive = g_alive;
  if (settled != 0 && alive > settled) figures.leaked_bytes = alive - settled;
  EXPECT_LE(figures.leaked_bytes, target.max_kept) << target.name;
  if (timed)
    test::add_to_tally("fuzz " + target.name, {figures.inputs, figures.complaints}, seconds_so_far());
  std::printf("%-22s %llu inputs, %llu taken, slowest %.0f ms, most memory %.1f MB, kept %zu bytes\n",
              target.name.c_str(), static_cast<unsigned long long>(figures.inputs),
              static_cast<unsigned long long>(figures.taken), 1000 * figures.slowest_s,
              double(figures.peak_bytes) / 1e6, figures.leaked_bytes);
  return figures;
}

void repair_checksum(std::string& text) {
  if (text.size() < 32) return;
  const std::size_t end = text.size() - 32;
  const std::string hash = hash_bytes(std::as_bytes(std::span(text.data(), end)));
  std::copy(hash.begin(), hash.end(), text.begin() + std::ptrdiff_t(end));
}

ScratchFolder::ScratchFolder() {
  std::error_code ignored;
  const std::filesystem::path memory("/dev/shm");
  path_ = (std::filesystem::is_directory(memory, ignored) ? memory : std::filesystem::temp_directory_path()) /
          std::string("likeness_fuzz_").append(std::to_string(::getpid()));
  std::filesystem::create_directories(path_);
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::filesystem::path ScratchFolder::put(const std::string& name, std::span<const std::byte> bytes) const {
  const std::filesystem::path file = path_ / name;
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
  return file;
}

std::string ScratchFolder::get(const std::string& name) const {
  std::ifstream file(path_ / name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace likeness
