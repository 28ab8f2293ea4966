// The built-in head, made once for all tests of a program.
#pragma once

#include "core/head/builtin_head.h"

namespace likeness {

inline const HeadModel& builtin() {
  static const HeadModel model = make_builtin_head();
  return model;
}

}  // namespace likeness
