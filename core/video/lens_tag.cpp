// moov / trak / meta / { hdlr, keys, ilst }: see lens_tag.h.
#include "core/video/lens_tag.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "core/video/box_walk.h"
#include "core/video/mp4_boxes.h"

namespace likeness {
namespace {

constexpr std::uint64_t kMaxBytes = 1 << 20;  // of a list of keys or of values: usually a page
constexpr int kMaxBoxes = 10000;              // a film has a few hundred; a damaged one may claim millions
constexpr double kLeast_mm = 10, kMost_mm = 400;  // the widest phones have 13

struct Film {
  std::ifstream file;
  int boxes = 0;  // looked at so far

  void for_each_box(std::uint64_t begin, std::uint64_t end, const std::function<void(const Box&)>& visit) {
    while (++boxes < kMaxBoxes) {
      const auto box = read_box(file, begin, end);
      if (!box || box->end < box->begin || box->end > end) return;
      visit(*box);
      begin = box->end;
    }
  }

  std::string bytes_of(const Box& box) {
    std::string bytes(std::size_t(std::min(box.end - box.begin, kMaxBytes)), '\0');
    file.clear();
    file.seekg(std::streamoff(box.begin));
    file.read(bytes.data(), std::streamsize(bytes.size()));
    bytes.resize(std::size_t(std::max<std::streamsize>(0, file.gcount())));
    return bytes;
  }
};

// Number of the key in the list, from 1; 0 if absent.
std::uint64_t key_number(const std::string& keys) {
  std::uint64_t at = 8;  // after version, flags and their count
  for (std::uint64_t number = 1; at + 8 <= keys.size(); ++number) {
    const std::uint64_t size = big_endian(keys.data() + at, 4);
    if (size < 8 || size > keys.size() - at) return 0;
    if (std::string_view(keys).substr(at + 8, size - 8) == kFocalLengthTag) return number;
    at += size;
  }
  return 0;
}

// "26", "26.00mm".
double number_of_text(std::string_view text) {
  double value = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view behind = text.substr(std::size_t(end - text.data()));
  return fault == std::errc() && (behind.empty() || behind == "mm" || behind == " mm") ? value : 0;
}

// A value by its type (QuickTime File Format, Well-known types).
double number_of(std::uint64_t type, const std::string& bytes) {
  if (type == 1) return number_of_text(bytes);
  if (bytes.empty() || bytes.size() > 8) return 0;
  const int size = int(bytes.size());
  const std::uint64_t raw = big_endian(bytes.data(), size);
  switch (type) {
    case 21:  // integers with a sign, of one to eight bytes
    case 65:
    case 66:
    case 67:
    case 74:
      return double(std::int64_t(raw << (64 - 8 * size)) >> (64 - 8 * size));
    case 22:  // and without
    case 75:
    case 76:
    case 77:
    case 78:
      return double(raw);
    case 23:
      return size == 4 ? double(std::bit_cast<float>(std::uint32_t(raw))) : 0;
    case 24:
      return size == 8 ? std::bit_cast<double>(raw) : 0;
    default:
      return 0;
  }
}

// The value of a key's number in a list of them: item { data { type, locale, bytes } }.
double value_of(Film& film, const Box& list, std::uint64_t number) {
  double value = 0;
  film.for_each_box(list.begin, list.end, [&](const Box& item) {
    if (big_endian(item.type.data(), 4) != number) return;
    film.for_each_box(item.begin, item.end, [&](const Box& data) {
      const std::string bytes = data.type == "data" ? film.bytes_of(data) : "";
      if (bytes.size() > 8) value = number_of(big_endian(bytes.data(), 4), bytes.substr(8));
    });
  });
  return value;
}

double focal_of_meta(Film& film, const Box& meta) {
  // QuickTime's has its boxes at once, ISO's after version and flags; a handler comes first in both.
  const auto first = read_box(film.file, meta.begin, meta.end);
  const std::uint64_t begin = first && first->type == "hdlr" ? meta.begin : meta.begin + 4;
  std::uint64_t number = 0;
  std::optional<Box> list;
  film.for_each_box(begin, meta.end, [&](const Box& box) {
    if (box.type == "keys") number = key_number(film.bytes_of(box));
    if (box.type == "ilst") list = box;
  });
  const double value = number > 0 && list ? value_of(film, *list, number) : 0;
  return value >= kLeast_mm && value <= kMost_mm ? value : 0;  // NaN is neither
}

struct Focals {
  double of_film = 0, of_track = 0;
};

// Collects the tags in a box that holds others; editors put theirs below "udta".
void look_into(Film& film, const Box& whole, bool in_track, Focals& found) {
  film.for_each_box(whole.begin, whole.end, [&](const Box& box) {
    if (box.type == "meta") {
      double& focal = in_track ? found.of_track : found.of_film;
      if (focal == 0) focal = focal_of_meta(film, box);
    }
    if (box.type == "trak" && !in_track) look_into(film, box, true, found);
    if (box.type == "udta" && whole.type != "udta") look_into(film, box, in_track, found);
  });
}

}  // namespace

double read_focal_35mm(const std::filesystem::path& path) {
  std::error_code failure;
  const std::uint64_t file_size = std::filesystem::file_size(path, failure);
  Film film{std::ifstream(path, std::ios::binary)};
  if (failure || !film.file || !scan_mp4_boxes(path).is_mp4) return 0;
  Focals found;
  film.for_each_box(0, file_size, [&](const Box& box) {
    if (box.type == "moov") look_into(film, box, false, found);
  });
  return found.of_track > 0 ? found.of_track : found.of_film;
}

}  // namespace likeness
