// LIKENESS_CHECK: for programmer mistakes only (wrong shapes passed to a public function). Files and users
// get a Result instead.
#pragma once

#include <cstdio>
#include <cstdlib>

#define LIKENESS_CHECK(condition, ...)                                                   \
  do {                                                                                   \
    if (!(condition)) {                                                                  \
      std::fprintf(stderr, "%s:%d: check failed: %s: ", __FILE__, __LINE__, #condition); \
      std::fprintf(stderr, __VA_ARGS__);                                                 \
      std::fputc('\n', stderr);                                                          \
      std::abort();                                                                      \
    }                                                                                    \
  } while (false)
