// See person_network.h.
#include "core/matte/person_network.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/base/hash.h"
#include "core/network/installed_networks.h"
#include "core/network/onnx_network.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kNetworkSide = 256;           // px of the network's input and output
constexpr const char* kNoNetwork = "none";  // the choice of no network
constexpr int kNetworkCopies = 8;           // threads that it is run by at once; some megabytes each

// In sizes of the detector's box, which runs from the brows to the chin.
constexpr double kPersonSides = 7, kPersonAbove = 1.6;
constexpr double kWidening = 1.6;
constexpr int kWidenTries = 3;
constexpr int kReachPx = 2;                // px within which somebody reaches a side
constexpr std::uint8_t kMorePerson = 127;  // above it a pixel is more person than not

// Written so that what is not a number becomes 0.
std::uint8_t share_byte(float share) {
  return share > 0 ? std::uint8_t(std::lround(255 * std::min(share, 1.0f))) : std::uint8_t(0);
}

int placed_inside(double start, int length, int limit) {
  return int(std::lround(std::clamp(start, 0.0, double(limit - length))));
}

Image8 mirrored(const Image8& rgb) {
  Image8 result(rgb.width, rgb.height, rgb.channels);
  for (int y = 0; y < rgb.height; ++y)
    for (int x = 0; x < rgb.width; ++x)
      std::copy_n(rgb.at(x, y), rgb.channels, result.at(rgb.width - 1 - x, y));
  return result;
}

// Whether somebody reaches beyond the left, right or upper side of `part`, where the picture goes on.
bool reaches_on(const Image8& share, const PictureRect& part, int width) {
  for (int y = 0; y < share.height; ++y)
    for (int i = 0; i < std::min(kReachPx, share.width); ++i)
      if ((part.x > 0 && *share.at(i, y) > kMorePerson) ||
          (part.x + part.width<width&& * share.at(share.width - 1 - i, y)> kMorePerson))
        return true;
  for (int x = 0; x < share.width && part.y > 0; ++x)
    if (*share.at(x, 0) > kMorePerson) return true;
  return false;
}

}  // namespace

PictureRect person_rect(const FaceBox& face, int width, int height, double widen) {
  const double size = std::max(face.width, face.height), side = kPersonSides * widen * size;
  PictureRect rect;
  rect.width = std::clamp(int(std::lround(side)), 1, width);
  rect.height = std::clamp(int(std::lround(side)), 1, height);
  rect.x = placed_inside(face.x + 0.5 * face.width - 0.5 * rect.width, rect.width, width);
  rect.y = placed_inside(face.y - kPersonAbove * widen * size, rect.height, height);
  return rect;
}

struct PersonNetwork::Impl {
  OnnxNetwork network;

  // Of a picture of the network's own size: 0..1, row by row.
  Result<std::vector<float>> run(const Image8& rgb) const {
    auto output = network.run(picture_tensor(rgb, 1 / 255.0));
    if (!output) return output.error();
    if (output->values.size() != rgb.pixels())
      return Error{ErrorCode::bad_input,
                   fmt::format("The network's output has {} values; a map of {} x {} is expected.",
                               output->values.size(), kNetworkSide, kNetworkSide),
                   "Give the person network that comes with Likeness, or one like it: RGB of 256 x 256 px, 0 "
                   "to 1, to the share of person.",
                   network.origin().string()};
    return std::move(output->values);
  }
};

PersonNetwork::PersonNetwork(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PersonNetwork::~PersonNetwork() = default;
PersonNetwork::PersonNetwork(PersonNetwork&&) noexcept = default;
PersonNetwork& PersonNetwork::operator=(PersonNetwork&&) noexcept = default;

Result<PersonNetwork> PersonNetwork::load(const fs::path& onnx) {
  auto network = OnnxNetwork::load(onnx, kNetworkCopies);
  if (!network) return network.error();
  PersonNetwork person(std::make_unique<Impl>(Impl{std::move(*network)}));
  // What is no map of 256 x 256 is refused here, not in the middle of a clip.
  if (const auto tried = person.share(Image8(kNetworkSide, kNetworkSide, 3, 128)); !tried)
    return tried.error();
  return person;
}

Result<PersonNetwork> PersonNetwork::installed() {
  auto network = load_installed_network(InstalledNetwork::person, kNetworkCopies);
  if (!network) return network.error();
  return PersonNetwork(std::make_unique<Impl>(Impl{std::move(*network)}));
}

Result<Image8> PersonNetwork::share(const Image8& rgb, Looks looks) const {
  LIKENESS_CHECK(rgb.channels == 3 && !rgb.empty(), "a picture of %d channels", rgb.channels);
  const bool as_it_is = rgb.width == kNetworkSide && rgb.height == kNetworkSide;
  const Image8 seen = as_it_is ? rgb : resize(rgb, kNetworkSide, kNetworkSide);
  auto values = impl_->run(seen);
  if (!values) return values.error();
  if (looks == Looks::both_ways) {
    const auto other = impl_->run(mirrored(seen));
    if (!other) return other.error();
    for (std::size_t i = 0; i < values->size(); ++i) {
      const std::size_t x = i % kNetworkSide;
      (*values)[i] = 0.5f * ((*values)[i] + (*other)[i - x + kNetworkSide - 1 - x]);
    }
  }
  Image8 map(kNetworkSide, kNetworkSide, 1);
  std::ranges::transform(*values, map.data.begin(), share_byte);
  return as_it_is ? std::move(map) : resize(map, rgb.width, rgb.height);
}

Result<Image8> PersonNetwork::share_in(const Image8& rgb, const PictureRect& part, Looks looks) const {
  if (part == PictureRect{0, 0, rgb.width, rgb.height}) return share(rgb, looks);
  LIKENESS_CHECK(part.x >= 0 && part.y >= 0 && part.width > 0 && part.height > 0 &&
                     part.x + part.width <= rgb.width && part.y + part.height <= rgb.height,
                 "a part that is not inside the picture: %d px from %d", part.width, part.x);
  const auto seen = share(crop(rgb, part.x, part.y, part.width, part.height), looks);
  if (!seen) return seen.error();
  return crop(*seen, -part.x, -part.y, rgb.width, rgb.height);
}

Result<Image8> PersonNetwork::share_about(const Image8& rgb, const FaceBox& face, Looks looks) const {
  double widen = 1;
  for (int tries = 1;; ++tries, widen *= kWidening) {
    const PictureRect part = person_rect(face, rgb.width, rgb.height, widen);
    const auto seen = share(crop(rgb, part.x, part.y, part.width, part.height), looks);
    if (!seen) return seen.error();
    if (tries < kWidenTries && reaches_on(*seen, part, rgb.width)) continue;
    Image8 whole(rgb.width, rgb.height, 1);
    for (int y = 0; y < part.height; ++y)
      std::copy_n(seen->at(0, y), part.width, whole.at(part.x, part.y + y));
    return whole;
  }
}

Result<std::shared_ptr<const PersonNetwork>> chosen_person_network(const fs::path& choice) {
  std::shared_ptr<const PersonNetwork> chosen;
  if (choice == kNoNetwork || (choice.empty() && !find_installed_network(InstalledNetwork::person)))
    return chosen;
  auto network = choice.empty() ? PersonNetwork::installed() : PersonNetwork::load(choice);
  if (!network) return network.error();
  chosen = std::make_shared<const PersonNetwork>(std::move(*network));
  return chosen;
}

std::string person_network_hash(const fs::path& choice) {
  if (choice == kNoNetwork) return {};
  if (choice.empty())
    return find_installed_network(InstalledNetwork::person) ? installed_network_hash(InstalledNetwork::person)
                                                            : std::string();
  const auto hash = hash_file(choice);
  return hash ? *hash : "absent";
}

}  // namespace likeness
