// OpenCV's dnn behind one function: see matting_network.h.
#include "core/matte/matting_network.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>
#include <nlohmann/json.hpp>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/json_text.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

fs::path format_path(const fs::path& onnx) { return fs::path(onnx).replace_extension(".json"); }

Error bad_network(const fs::path& path, std::string what) {
  return {ErrorCode::bad_input, std::move(what),
          "Give a network in ONNX (opset 9 to 13) that turns one RGB picture into a map of the person, and "
          "describe what it expects in a .json file of the same name (core/matte/matting_network.h).",
          path.string()};
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

// The channels' values at one pixel, turned into the share of person.
float person_share(const MattingNetworkFormat& format, const cv::Mat& output, int y, int x) {
  const int channels = output.size[1];
  const auto value = [&](int c) { return output.ptr<float>(0, c)[y * output.size[3] + x]; };
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
  fs::path path;
  MattingNetworkFormat format;
  cv::dnn::Net net;
  std::mutex mutex;

  Result<cv::Mat> run(const Image8& rgb) {
    const cv::Mat picture(rgb.height, rgb.width, CV_8UC3, const_cast<std::uint8_t*>(rgb.data.data()));
    cv::Mat small;
    const cv::Size size(format.size_px, format.size_px);
    cv::resize(picture, small, size, 0, 0, rgb.width > size.width ? cv::INTER_AREA : cv::INTER_LINEAR);
    const cv::Mat blob = cv::dnn::blobFromImage(
        small, format.scale, {}, {format.mean[0], format.mean[1], format.mean[2]}, false, false, CV_32F);
    cv::Mat output;
    {
      const std::lock_guard lock(mutex);
      net.setInput(blob);
      output = (format.output.empty() ? net.forward() : net.forward(format.output)).clone();
    }
    if (output.dims != 4 || output.size[0] != 1 || output.type() != CV_32F || output.size[2] < 8 ||
        output.size[3] < 8)
      return bad_network(
          path,
          "The network's output is not a map: one picture, its channels, rows and columns are expected.");
    const int most = *std::ranges::max_element(format.person_channels);
    if (most >= output.size[1] || *std::ranges::min_element(format.person_channels) < 0)
      return bad_network(
          path, fmt::format("The network's output has {} channels; the person is said to be in channel {}.",
                            output.size[1], most));
    return output;
  }
};

Result<MattingNetwork> MattingNetwork::load(const fs::path& onnx) {
  auto impl = std::make_unique<Impl>();
  impl->path = onnx;
  std::error_code ignored;
  if (!fs::is_regular_file(onnx, ignored))
    return Error{ErrorCode::not_found, fmt::format("There is no network \"{}\".", onnx.string()),
                 "Check the name and the folder.", onnx.string()};
  auto format = read_format(onnx);
  if (!format) return format.error();
  impl->format = std::move(*format);
  try {
    impl->net = cv::dnn::readNetFromONNX(onnx.string());
    if (impl->net.empty()) return bad_network(onnx, "The file holds no network.");
    impl->net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    impl->net.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
  } catch (const cv::Exception& fault) {
    return bad_network(onnx, fmt::format("The network cannot be read: {}.", fault.err));
  } catch (const std::exception& fault) {  // thrown by the standard library for sizes that the file claims
    return bad_network(onnx, fmt::format("The network cannot be read: {}.", fault.what()));
  }
  MattingNetwork network(std::move(impl));
  const auto tried = network.alpha(Image8(64, 64, 3, 128));
  if (!tried) return tried.error();
  return network;
}

MattingNetwork::MattingNetwork(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MattingNetwork::~MattingNetwork() = default;
MattingNetwork::MattingNetwork(MattingNetwork&&) noexcept = default;
MattingNetwork& MattingNetwork::operator=(MattingNetwork&&) noexcept = default;

Result<Image8> MattingNetwork::alpha(const Image8& rgb) const {
  try {
    const auto output = impl_->run(rgb);
    if (!output) return output.error();
    const int rows = output->size[2], columns = output->size[3];
    cv::Mat share(rows, columns, CV_32F), whole, bytes;
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < columns; ++x) share.at<float>(y, x) = person_share(impl_->format, *output, y, x);
    cv::resize(share, whole, {rgb.width, rgb.height}, 0, 0,
               rgb.width < columns ? cv::INTER_AREA : cv::INTER_LINEAR);
    whole.convertTo(bytes, CV_8U, 255);
    Image8 alpha(rgb.width, rgb.height, 1);
    std::memcpy(alpha.data.data(), bytes.data, alpha.data.size());
    return alpha;
  } catch (const cv::Exception& fault) {
    return bad_network(impl_->path, fmt::format("The network cannot be run: {}.", fault.err));
  } catch (const std::exception& fault) {
    return bad_network(impl_->path, fmt::format("The network cannot be run: {}.", fault.what()));
  }
}

std::string matting_network_hash(const fs::path& onnx) {
  const auto network = hash_file(onnx), format = hash_file(format_path(onnx));
  return (network ? *network : "absent") + (format ? *format : "");
}

}  // namespace likeness
