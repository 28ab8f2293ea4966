// A picture squared for the network, and its map back at the picture's size: see matting_network.h.
#include "core/matte/matting_network.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/json_text.h"
#include "core/network/onnx_network.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

fs::path format_path(const fs::path& onnx) { return fs::path(onnx).replace_extension(".json"); }

const char* const kFix =
    "Give a network in ONNX (opset 9 to 13) that turns one RGB picture into a map of the person, and "
    "describe what it expects in a .json file of the same name (core/matte/matting_network.h).";

Error bad_network(const fs::path& path, std::string what) {
  return {ErrorCode::bad_input, std::move(what), kFix, path.string()};
}

Result<MattingNetworkFormat> read_format(const fs::path& onnx) {
  MattingNetworkFormat format;
  const fs::path path = format_path(onnx);
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return format;
  const auto text = read_text(path);
  if (!text) return text.error();
  try {
    const auto json = parse_json(*text);
    format.size_px = json.value("size_px", format.size_px);
    if (json.contains("mean")) format.mean = json.at("mean").get<std::array<double, 3>>();
    format.scale = json.value("scale", format.scale);
    format.output = json.value("output", format.output);
    format.activation = json.value("activation", format.activation);
    format.person_channels = json.value("person_channels", format.person_channels);
  } catch (const nlohmann::json::exception& fault) {
    return bad_network(path, fmt::format("This does not describe a network's format: {}.", fault.what()));
  }
  const bool known =
      format.activation == "none" || format.activation == "sigmoid" || format.activation == "softmax";
  if (format.size_px < 16 || format.size_px > 2048 || !known || format.person_channels.empty() ||
      !std::isfinite(format.scale))
    return bad_network(path, fmt::format("A format with pictures of {} px, the activation \"{}\" and {} "
                                         "channels of the person cannot be used.",
                                         format.size_px, format.activation, format.person_channels.size()));
  return format;
}

// The channels' values at one pixel, turned into the share of person. map: (1, channels, rows, columns).
float person_share(const MattingNetworkFormat& format, const Tensor& map, std::size_t pixel) {
  const std::size_t pixels = std::size_t(map.shape[2]) * std::size_t(map.shape[3]);
  const int channels = map.shape[1];
  const auto value = [&](int c) { return map.values[std::size_t(c) * pixels + pixel]; };
  float sum = 0;
  if (format.activation == "softmax") {
    float highest = value(0), all = 0;
    for (int c = 1; c < channels; ++c) highest = std::max(highest, value(c));
    for (int c = 0; c < channels; ++c) all += std::exp(value(c) - highest);
    for (const int c : format.person_channels) sum += std::exp(value(c) - highest) / all;
    return sum;
  }
  for (const int c : format.person_channels)
    sum += format.activation == "sigmoid" ? 1 / (1 + std::exp(-value(c))) : value(c);
  return sum;
}

}  // namespace

struct MattingNetwork::Impl {
  MattingNetworkFormat format;
  OnnxNetwork network;

  // (1, channels, rows, columns)
  Result<Tensor> run(const Image8& rgb) const {
    Image8 square(format.size_px, format.size_px, 3);
    const cv::Mat picture(rgb.height, rgb.width, CV_8UC3, const_cast<std::uint8_t*>(rgb.data.data()));
    cv::Mat small(square.height, square.width, CV_8UC3, square.data.data());
    cv::resize(picture, small, small.size(), 0, 0,
               rgb.width > square.width ? cv::INTER_AREA : cv::INTER_LINEAR);
    auto map = network.run(picture_tensor(square, format.scale, format.mean), format.output);
    if (!map) return bad_network(network.origin(), map.error().what);
    if (map->shape.size() != 4 || map->shape[0] != 1 || map->shape[2] < 8 || map->shape[3] < 8)
      return bad_network(
          network.origin(),
          "The network's output is not a map: one picture, its channels, rows and columns are expected.");
    const int most = *std::ranges::max_element(format.person_channels);
    if (most >= map->shape[1] || *std::ranges::min_element(format.person_channels) < 0)
      return bad_network(
          network.origin(),
          fmt::format("The network's output has {} channels; the person is said to be in channel {}.",
                      map->shape[1], most));
    return map;
  }
};

Result<MattingNetwork> MattingNetwork::load(const fs::path& onnx) {
  std::error_code ignored;
  auto format = fs::is_regular_file(onnx, ignored) ? read_format(onnx) : MattingNetworkFormat{};
  if (!format) return format.error();
  auto network = OnnxNetwork::load(onnx);
  if (!network) {
    Error error = network.error();
    if (error.code == ErrorCode::bad_input) error.fix = kFix;
    return error;
  }
  MattingNetwork matting(std::make_unique<Impl>(Impl{std::move(*format), std::move(*network)}));
  const auto tried = matting.alpha(Image8(64, 64, 3, 128));
  if (!tried) return tried.error();
  return matting;
}

MattingNetwork::MattingNetwork(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MattingNetwork::~MattingNetwork() = default;
MattingNetwork::MattingNetwork(MattingNetwork&&) noexcept = default;
MattingNetwork& MattingNetwork::operator=(MattingNetwork&&) noexcept = default;

Result<Image8> MattingNetwork::alpha(const Image8& rgb) const {
  try {
    const auto map = impl_->run(rgb);
    if (!map) return map.error();
    const int rows = map->shape[2], columns = map->shape[3];
    cv::Mat share(rows, columns, CV_32F), whole, bytes;
    for (std::size_t pixel = 0; pixel < share.total(); ++pixel)
      share.ptr<float>()[pixel] = person_share(impl_->format, *map, pixel);
    cv::resize(share, whole, {rgb.width, rgb.height}, 0, 0,
               rgb.width < columns ? cv::INTER_AREA : cv::INTER_LINEAR);
    whole.convertTo(bytes, CV_8U, 255);
    Image8 alpha(rgb.width, rgb.height, 1);
    std::memcpy(alpha.data.data(), bytes.data, alpha.data.size());
    return alpha;
  } catch (const cv::Exception& fault) {
    if (fault.code == cv::Error::StsNoMem) throw std::bad_alloc();
    return bad_network(impl_->network.origin(), fmt::format("The picture cannot be scaled: {}.", fault.err));
  }
}

std::string matting_network_hash(const fs::path& onnx) {
  const auto network = hash_file(onnx), format = hash_file(format_path(onnx));
  return (network ? *network : "absent") + (format ? *format : "");
}

}  // namespace likeness
