// Another value for any choice of a project's, inside its range.
#pragma once

#include <filesystem>

#include "core/project/option_table.h"

namespace likeness::test {

// other: a path for choices that are one.
inline void choose_other(const OptionRow& row, ProjectOptions& options, const std::filesystem::path& other) {
  struct Change {
    const OptionRow& row;
    const std::filesystem::path& other;

    void operator()(std::filesystem::path& path) const { path = other; }
    void operator()(bool& on) const { on = !on; }
    void operator()(int& number) const { number *= 2; }
    void operator()(double& number) const {
      const double near_low = row.range.low + 0.5;
      number = number == near_low ? near_low + 1 : near_low;
    }
    void operator()(std::uint64_t& number) const { ++number; }
    void operator()(Split& split) const { split = split == Split::views ? Split::random30 : Split::views; }
    void operator()(std::optional<CameraKind>& kind) const {
      kind = kind == CameraKind::walking ? CameraKind::handheld : CameraKind::walking;
    }
    void operator()(std::optional<FieldMode>& mode) const {
      mode = mode == FieldMode::concat ? FieldMode::warp : FieldMode::concat;
    }
    void operator()(std::vector<int>& frames) const {
      frames.push_back(frames.empty() ? 3 : frames.back() + 1);
    }
    void operator()(std::vector<RefitSpan>& spans) const {
      const int first = spans.empty() ? 4 : spans.back().last + 10;
      spans.push_back({first, first + 2});
    }
  };
  with_option(row, options, Change{row, other});
}

}  // namespace likeness::test
