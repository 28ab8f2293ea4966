// Two pictures given to a network, and its numbers' mean: see perceptual_network.h.
#include "core/lab/score/perceptual_network.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/json_text.h"
#include "core/network/onnx_network.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

const char* const kPerceptualFix =
    "Give a network in ONNX (opset 9 to 13) that turns two RGB pictures into their distance, and name its "
    "inputs in a .json file of the same name (core/lab/score/perceptual_network.h).";

Error bad_network(const fs::path& path, std::string what) {
  return {ErrorCode::bad_input, std::move(what), kPerceptualFix, path.string()};
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
  PerceptualFormat format;
  OnnxNetwork network;

  Result<double> run(const Image8& a, const Image8& b) const {
    const int side = format.size_px;
    const auto input = [&](const std::string& name, const Image8& picture) {
      return NetworkInput{name, picture_tensor(side == 0 ? picture : resize(picture, side, side), 1 / 127.5,
                                               {127.5, 127.5, 127.5})};
    };
    const NetworkInput inputs[] = {input(format.inputs[0], a), input(format.inputs[1], b)};
    const std::string last_output;
    const auto outputs = network.run(inputs, {&last_output, 1});
    if (!outputs)
      return bad_network(network.origin(),
                         fmt::format("The network cannot compare two pictures given as \"{}\" and \"{}\". {}",
                                     format.inputs[0], format.inputs[1], outputs.error().what));
    const std::vector<float>& values = outputs->front().values;
    if (values.empty()) return bad_network(network.origin(), "The network's output is not a distance.");
    double sum = 0;
    for (const float value : values) sum += double(value);
    return sum / double(values.size());
  }
};

Result<PerceptualNetwork> PerceptualNetwork::load(const fs::path& onnx) {
  std::error_code ignored;
  auto format = fs::is_regular_file(onnx, ignored) ? read_format(onnx) : PerceptualFormat{};
  if (!format) return format.error();
  auto read = OnnxNetwork::load(onnx);
  if (!read) {
    Error error = read.error();
    if (error.code == ErrorCode::bad_input) error.fix = kPerceptualFix;
    return error;
  }
  PerceptualNetwork network(std::make_unique<Impl>(Impl{std::move(*format), std::move(*read)}));
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
                 "Compare RGB pictures of one size.", impl_->network.origin().string()};
  return impl_->run(a, b);
}

PerceptualNetwork::PerceptualNetwork(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PerceptualNetwork::~PerceptualNetwork() = default;
PerceptualNetwork::PerceptualNetwork(PerceptualNetwork&&) noexcept = default;
PerceptualNetwork& PerceptualNetwork::operator=(PerceptualNetwork&&) noexcept = default;

}  // namespace likeness
