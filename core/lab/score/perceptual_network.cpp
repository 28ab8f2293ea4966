// OpenCV's dnn behind one function: see perceptual_network.h.
#include "core/lab/score/perceptual_network.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/dnn.hpp>

#include "core/base/files.h"
#include "core/base/json_text.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

Error bad_network(const fs::path& path, std::string what) {
  return {
      ErrorCode::bad_input, std::move(what),
      "Give a network in ONNX (opset 9 to 13) that turns two RGB pictures into their distance, and name its "
      "inputs in a .json file of the same name (core/lab/score/perceptual_network.h).",
      path.string()};
}

Result<PerceptualFormat> read_format(const fs::path& onnx) {
  PerceptualFormat format;
  const fs::path path = fs::path(onnx).replace_extension(".json");
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return format;
  const auto text = read_text(path);
  if (!text) return text.error();
  try {
    const auto json = parse_json(*text);
    for (const std::size_t i : {0u, 1u})
      if (json.contains("inputs")) json.at("inputs").at(i).get_to(format.inputs[i]);
    format.size_px = json.value("size_px", format.size_px);
  } catch (const nlohmann::json::exception& fault) {
    return bad_network(path, fmt::format("Not the format of a network: {}.", fault.what()));
  }
  if (format.size_px != 0 && (format.size_px < 16 || format.size_px > 2048))
    return bad_network(
        path, fmt::format("Pictures of {} px are not pictures that can be compared.", format.size_px));
  return format;
}

}  // namespace

struct PerceptualNetwork::Impl {
  fs::path path;
  PerceptualFormat format;
  cv::dnn::Net net;

  Result<double> run(const Image8& a, const Image8& b) {
    try {
      const Image8* given[] = {&a, &b};
      for (const std::size_t i : {0u, 1u}) {
        const int side = format.size_px;
        const Image8 fitted = side == 0 ? *given[i] : resize(*given[i], side, side);
        const cv::Mat picture(fitted.height, fitted.width, CV_8UC3,
                              const_cast<std::uint8_t*>(fitted.data.data()));
        net.setInput(
            cv::dnn::blobFromImage(picture, 1 / 127.5, {}, cv::Scalar::all(127.5), false, false, CV_32F),
            format.inputs[i]);
      }
      const cv::Mat output = net.forward();
      if (output.type() != CV_32F || output.total() == 0)
        return bad_network(path, "The network's output is not a distance.");
      const auto* values = output.ptr<float>();
      double sum = 0;
      for (std::size_t i = 0; i < output.total(); ++i) sum += double(values[i]);
      return sum / double(output.total());
    } catch (const cv::Exception& fault) {
      return bad_network(path, fmt::format("The network cannot compare two pictures given as \"{}\" and "
                                           "\"{}\": {}.",
                                           format.inputs[0], format.inputs[1], fault.err));
    }
  }
};

Result<PerceptualNetwork> PerceptualNetwork::load(const fs::path& onnx) {
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
  } catch (const std::exception& fault) {  // the file claims sizes that the standard library refuses
    return bad_network(onnx, fmt::format("The network cannot be read: {}.", fault.what()));
  }
  PerceptualNetwork network(std::move(impl));
  const int side = 64;
  const Image8 grey(side, side, 3, 180);
  Image8 other = grey;
  for (std::size_t i = 0; i < other.data.size(); i += 5) other.data[i] = 60;
  const auto same = network.distance(grey, grey), apart = network.distance(grey, other);
  if (!same) return same.error();
  if (!apart) return apart.error();
  if (!(std::abs(*same) < 1e-3) || !(*apart > *same))
    return bad_network(
        onnx, fmt::format("The network gives no distance: a picture is {:.4g} from itself and {:.4g} "
                          "from another.",
                          *same, *apart));
  return network;
}

Result<double> PerceptualNetwork::distance(const Image8& a, const Image8& b) const {
  if (a.channels != 3 || a.width != b.width || a.height != b.height || b.channels != 3)
    return Error{ErrorCode::bad_input, "Pictures of different shapes have no distance.",
                 "Compare RGB pictures of one size.", impl_->path.string()};
  return impl_->run(a, b);
}

PerceptualNetwork::PerceptualNetwork(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PerceptualNetwork::~PerceptualNetwork() = default;
PerceptualNetwork::PerceptualNetwork(PerceptualNetwork&&) noexcept = default;
PerceptualNetwork& PerceptualNetwork::operator=(PerceptualNetwork&&) noexcept = default;

}  // namespace likeness
