// The ICT-FaceKit head for tests that want an anatomical model; absent on most machines.
#pragma once

#include <filesystem>

#include "core/head/load_head_model.h"

namespace likeness {

inline std::filesystem::path ict_head_path() {
  return std::filesystem::path(LIKENESS_SHARED) / "head_models" / "ict_head_flame_schema.npz";
}

}  // namespace likeness

#define LIKENESS_NEED_ICT_HEAD(model)                                                                   \
  if (!std::filesystem::exists(likeness::ict_head_path()))                                              \
    GTEST_SKIP() << "needs " << likeness::ict_head_path().string() << ", which is not on this machine"; \
  const likeness::Result<likeness::HeadModel> model##_result =                                          \
      likeness::load_head_model(likeness::ict_head_path());                                             \
  ASSERT_TRUE(model##_result.ok()) << model##_result.error().what;                                      \
  const likeness::HeadModel& model = *model##_result
