// The walk through the file: see predictor_file.h. The order of its parts is that of dlib's
// serialize(shape_predictor): version, mean shape, forests of regression trees, then for each forest the
// landmarks to which its pixels are anchored and the pixels' offsets from them.
#include "core/face/predictor_file.h"

#include <dlib/serialize.h>
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "core/head/head_model.h"

namespace likeness {
namespace {

constexpr long kCoordinates = 2 * kLandmarkCount;
// Of shapes and their changes, in sides of the face's box: far beyond any face, well within the range of a
// pixel coordinate.
constexpr float kLargest = 1000;

struct Fault {
  std::string what;
};

class Walk {
 public:
  Walk(std::istream& in, std::uint64_t bytes) : in_(in), bytes_(bytes) {}

  template <class T>
  T next() {
    T value{};
    dlib::deserialize(value, in_);
    return value;
  }
  // Every counted element takes at least a byte.
  std::uint64_t count() {
    const auto n = next<unsigned long>();
    if (n > bytes_) throw Fault{fmt::format("it claims {} parts in a file of {} bytes", n, bytes_)};
    return n;
  }
  void number() {
    if (!(std::abs(next<float>()) <= kLargest))
      throw Fault{"one of its numbers is not an offset within a face"};
  }
  // dlib writes both dimensions negated; older versions did not.
  void shape() {
    const auto rows = next<long>(), columns = next<long>();
    const bool fits = (rows == kCoordinates && columns == 1) || (rows == -kCoordinates && columns == -1);
    if (!fits)
      throw Fault{fmt::format("one of its shapes has {} x {} numbers instead of {} x 1", rows, columns,
                              kCoordinates)};
    for (long i = 0; i < kCoordinates; ++i) number();
  }
  // The least number of pixels that a forest compares.
  std::uint64_t forest() {
    std::uint64_t pixels = 0;
    for (std::uint64_t trees = count(); trees > 0; --trees) {
      const std::uint64_t splits = count();
      for (std::uint64_t s = 0; s < splits; ++s) {
        const auto first = next<unsigned long>(), second = next<unsigned long>();
        if (std::max(first, second) > bytes_) throw Fault{"a tree compares pixels that do not exist"};
        pixels = std::max<std::uint64_t>(pixels, std::max(first, second) + 1);
        static_cast<void>(next<float>());
      }
      const std::uint64_t leaves = count();
      if (leaves != splits + 1 || !std::has_single_bit(leaves))
        throw Fault{fmt::format("a tree has {} splits and {} leaves", splits, leaves)};
      for (std::uint64_t l = 0; l < leaves; ++l) shape();
    }
    return pixels;
  }

 private:
  std::istream& in_;
  std::uint64_t bytes_;
};

void walk(Walk& file) {
  if (const int version = file.next<int>(); version != 1)
    throw Fault{fmt::format("its format has version {} instead of 1", version)};
  file.shape();
  std::vector<std::uint64_t> compared;
  for (std::uint64_t forests = file.count(); forests > 0; --forests) compared.push_back(file.forest());
  const auto for_each_forest = [&](const auto& read) {
    if (file.count() != compared.size()) throw Fault{"its forests and their pixels differ in number"};
    std::vector<std::uint64_t> pixels;
    for (std::size_t f = 0; f < compared.size(); ++f) {
      pixels.push_back(file.count());
      for (std::uint64_t i = 0; i < pixels[f]; ++i) read();
    }
    return pixels;
  };
  const auto anchored = for_each_forest([&] {
    if (file.next<unsigned long>() >= kLandmarkCount) throw Fault{"a pixel is anchored to no landmark"};
  });
  const auto placed = for_each_forest([&] { file.number(), file.number(); });
  if (anchored != placed) throw Fault{"its pixels and their places differ in number"};
  for (std::size_t f = 0; f < compared.size(); ++f)
    if (compared[f] > placed[f]) throw Fault{"a tree compares pixels that do not exist"};
}

}  // namespace

Result<void> check_predictor(std::istream& in, std::uint64_t bytes) {
  const auto refused = [](const std::string& what) { return Error{ErrorCode::bad_input, what, "", ""}; };
  try {
    Walk file(in, bytes);
    walk(file);
    return {};
  } catch (const Fault& fault) {
    return refused(fault.what);
  } catch (const dlib::error& e) {
    return refused(e.what());
  }
}

}  // namespace likeness
