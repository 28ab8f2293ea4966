// Claims about the window's own thread.
#include "ui/run_window.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <new>
#include <stdexcept>

namespace likeness::ui {
namespace {

using testing::HasSubstr;

TEST(GuardWindow, WhatBreaksAFrameEndsInWords) {
  EXPECT_TRUE(guard_window([] {}).ok());
  const auto memory = guard_window([] { throw std::bad_alloc(); });
  ASSERT_FALSE(memory.ok());
  EXPECT_THAT(memory.error().what, HasSubstr("not enough memory"));
  EXPECT_THAT(memory.error().fix, HasSubstr("kept"));
  const auto other = guard_window([] { throw std::runtime_error("a broken font"); });
  ASSERT_FALSE(other.ok());
  EXPECT_THAT(other.error().what, HasSubstr("a broken font"));
}

}  // namespace
}  // namespace likeness::ui
