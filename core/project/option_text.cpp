// See option_text.h.
#include "core/project/option_text.h"

#include <charconv>
#include <string>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace likeness {

namespace {

constexpr int kMaxFrames = 1'000'000;

// "12,40-60" -> 12 to 12 and 40 to 60; empty if the words are not such a list.
std::vector<RefitSpan> spans_in(std::string_view words) {
  std::vector<RefitSpan> spans;
  const char *at = words.data(), *end = at + words.size();
  const auto number = [&](int& value) {
    const auto [rest, failure] = std::from_chars(at, end, value);
    at = rest;
    return failure == std::errc{} && value >= 0 && value < kMaxFrames;
  };
  while (at != end) {
    RefitSpan span;
    if (!number(span.first)) return {};
    span.last = span.first;
    if (at != end && *at == '-' && (++at, !number(span.last) || span.last < span.first)) return {};
    spans.push_back(span);
    if (at != end && (*at++ != ',' || at == end)) return {};
  }
  return spans;
}

// Reads the words as a value of one kind; false: they are not one.
struct ReadWords {
  std::string_view words, none;

  bool operator()(std::filesystem::path& path) const {
    path = words == none ? std::filesystem::path() : std::filesystem::path(words);
    return true;
  }
  bool operator()(std::vector<int>& frames) const {
    const auto spans = spans_in(words);
    frames.clear();
    for (const RefitSpan& span : merged_spans(spans))
      for (int frame = span.first; frame <= span.last; ++frame) frames.push_back(frame);
    return words == none || !spans.empty();
  }
  bool operator()(std::vector<RefitSpan>& spans) const {
    if (words == none) {
      spans.clear();
      return true;
    }
    const auto more = spans_in(words);
    spans.insert(spans.end(), more.begin(), more.end());
    spans = merged_spans(std::move(spans));
    return !more.empty();
  }
  template <class Other>
  bool operator()(Other&) const {
    return false;
  }
};

}  // namespace

Result<void> read_option_words(const OptionRow& row, std::string_view words, ProjectOptions& options) {
  ProjectOptions changed = options;
  if (!with_option(row, changed, ReadWords{words, row.taken_back}))
    return Error{ErrorCode::bad_input, fmt::format("\"{}\" is not a list of frames.", words),
                 fmt::format("Write numbers and spans, e.g. {} 12,40-60, or {}.", row.flag, row.taken_back),
                 ""};
  copy_option(row, changed, options);
  return {};
}

}  // namespace likeness
