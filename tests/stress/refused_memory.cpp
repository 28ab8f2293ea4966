// Preloaded into a program: refuses memory to its own code - what its file asks for, templates of libraries
// compiled into it among them - once.
//   LIKENESS_MEMORY_REPORT=file: written at the end: how many requests there were, then the places that ask
//   LIKENESS_MEMORY_REFUSE=n: refuses the n-th request
//   LIKENESS_MEMORY_PLACE=p: refuses the first request of that place
#include <fcntl.h>
#include <link.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <new>

extern "C" {
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);
}

namespace {

constexpr std::size_t kPlaces = 1 << 16;  // a table of places, open addressing
std::atomic<std::uintptr_t> g_places[kPlaces];
std::atomic<std::uint64_t> g_requests{0};
std::atomic<bool> g_watching{false}, g_refused{false};
std::uint64_t g_refuse_at = 0;
std::uintptr_t g_refuse_place = 0, g_base = 0, g_end = 0;
char g_report[4096];

// Whether this request, made from the code at `caller`, is the one to refuse.
bool refuses(const void* caller) {
  const auto at = reinterpret_cast<std::uintptr_t>(caller);
  if (!g_watching.load(std::memory_order_relaxed) || at < g_base || at >= g_end) return false;
  const std::uintptr_t place = at - g_base;
  const std::uint64_t request = ++g_requests;
  if (g_report[0]) {
    for (std::size_t i = place * 0x9e3779b97f4a7c15u >> 48;; i = (i + 1) % kPlaces) {
      std::uintptr_t there = 0;
      if (g_places[i].compare_exchange_strong(there, place) || there == place) break;
    }
  }
  if ((g_refuse_at == 0 || request != g_refuse_at) && (g_refuse_place == 0 || place != g_refuse_place))
    return false;
  return !g_refused.exchange(true);
}

int find_program(dl_phdr_info* info, std::size_t, void*) {  // the program itself comes first
  for (int i = 0; i < info->dlpi_phnum; ++i) {
    const auto& part = info->dlpi_phdr[i];
    if (part.p_type != PT_LOAD || !(part.p_flags & PF_X)) continue;
    g_base = info->dlpi_addr + part.p_vaddr;
    g_end = g_base + part.p_memsz;
  }
  return 1;
}

__attribute__((constructor)) void begin_watch() {
  const char* report = ::getenv("LIKENESS_MEMORY_REPORT");
  const char* at = ::getenv("LIKENESS_MEMORY_REFUSE");
  const char* place = ::getenv("LIKENESS_MEMORY_PLACE");
  if (strcmp(::program_invocation_short_name, "env") == 0) return;
  if (report) ::snprintf(g_report, sizeof g_report, "%s", report);
  if (at) g_refuse_at = ::strtoull(at, nullptr, 10);
  if (place) g_refuse_place = ::strtoull(place, nullptr, 10);
  ::dl_iterate_phdr(find_program, nullptr);
  ::unsetenv("LD_PRELOAD");
  g_watching = true;
}

__attribute__((destructor)) void end_watch() {
  g_watching = false;
  if (!g_report[0]) return;
  std::FILE* file = std::fopen(g_report, "w");
  if (!file) return;
  std::fprintf(file, "%llu\n", static_cast<unsigned long long>(g_requests.load()));
  for (const auto& place : g_places)
    if (place != 0) std::fprintf(file, "%llu\n", static_cast<unsigned long long>(place.load()));
  std::fclose(file);
}

void* take_or_throw(std::size_t size, std::size_t alignment, const void* caller) {
  void* memory = refuses(caller)  ? nullptr
                 : alignment == 0 ? __libc_malloc(size == 0 ? 1 : size)
                                  : __libc_memalign(alignment, size == 0 ? 1 : size);
  if (!memory) throw std::bad_alloc();
  return memory;
}

}  // namespace

#define LIKENESS_CALLER __builtin_return_address(0)

void* operator new(std::size_t size) { return take_or_throw(size, 0, LIKENESS_CALLER); }
void* operator new[](std::size_t size) { return take_or_throw(size, 0, LIKENESS_CALLER); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return take_or_throw(size, std::size_t(alignment), LIKENESS_CALLER);
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return take_or_throw(size, std::size_t(alignment), LIKENESS_CALLER);
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return refuses(LIKENESS_CALLER) ? nullptr : __libc_malloc(size == 0 ? 1 : size);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  return refuses(LIKENESS_CALLER) ? nullptr : __libc_malloc(size == 0 ? 1 : size);
}

extern "C" {

void* malloc(std::size_t size) noexcept { return refuses(LIKENESS_CALLER) ? nullptr : __libc_malloc(size); }
void* calloc(std::size_t count, std::size_t size) noexcept {
  return refuses(LIKENESS_CALLER) ? nullptr : __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) noexcept {
  return refuses(LIKENESS_CALLER) ? nullptr : __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  return refuses(LIKENESS_CALLER) ? nullptr : __libc_memalign(alignment, size);
}

}  // extern "C"
