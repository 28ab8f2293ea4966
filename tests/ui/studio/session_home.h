// What a session of the studio needs around it, for tests of one without the others: a tiny project, the
// background, and what is said to the user.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <thread>

#include "tests/core/export/tiny_project.h"
#include "ui/studio/session_context.h"

namespace likeness::ui::test {

struct SessionHome {
  likeness::test::TinyProject project;
  StudioOptions options{.settings = project.root / "studio.json", .projects = project.root};
  std::function<void()> wake = [] {};
  Settings settings;
  Notices notices;
  OpenProject open;
  ShownStep shown;
  std::uint64_t pictures = 0;
  Background background{[](const std::string& what) { ADD_FAILURE() << what; }, [] {}};
  SessionContext context{options, wake,  background, settings,        notices,
                         open,    shown, pictures,   options.projects};

  // As if the project session had read it.
  void open_project() {
    const auto contents = read_contents(project.folder(), nullptr);
    ASSERT_TRUE(contents.ok());
    open.folder = project.folder();
    open.contents = *contents;
  }

  // False where it does not come to be so in time. tick: of the session.
  bool until(const std::function<void()>& tick, const std::function<bool()>& so) {
    for (int i = 0; i < 4000; ++i) {
      background.deliver();
      tick();
      if (so()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }
};

}  // namespace likeness::ui::test
