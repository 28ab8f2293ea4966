// OpenCV's dnn behind one class: see onnx_network.h.
#include "core/network/onnx_network.h"

#include <fmt/format.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <new>
#include <opencv2/dnn.hpp>
#include <utility>

#include "core/base/check.h"
#include "core/base/files.h"
#include "core/base/lending_pool.h"
#include "core/network/check_onnx.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

Error bad_network(const fs::path& origin, std::string what) {
  return {ErrorCode::bad_input, std::move(what),
          "Give a network in ONNX (opset 9 to 13) of operators that OpenCV knows.", origin.string()};
}

// Lets at most so many run at once, in no order.
class Turns {
 public:
  explicit Turns(int max_concurrent) : free_(max_concurrent) {}
  void take() {
    std::unique_lock lock(mutex_);
    freed_.wait(lock, [this] { return free_ > 0; });
    --free_;
  }
  void give() {
    {
      const std::lock_guard lock(mutex_);
      ++free_;
    }
    freed_.notify_one();
  }

 private:
  std::mutex mutex_;
  std::condition_variable freed_;
  int free_;
};

// A turn, and the copy that it is taken with; an empty one where all others are at work.
class Lent {
 public:
  Lent(Turns& turns, LendingPool<cv::dnn::Net>& copies) : turns_(turns), copies_(copies) {
    turns_.take();
    net_ = copies_.take();
  }
  ~Lent() {
    copies_.give(std::move(net_));
    turns_.give();
  }
  Lent(const Lent&) = delete;
  Lent& operator=(const Lent&) = delete;
  cv::dnn::Net& net() { return *net_; }

 private:
  Turns& turns_;
  LendingPool<cv::dnn::Net>& copies_;
  std::unique_ptr<cv::dnn::Net> net_;
};

Tensor tensor_of(const cv::Mat& output) {
  cv::Mat single;
  output.convertTo(single, CV_32F);  // with one type of numbers less to know about
  if (!single.isContinuous()) single = single.clone();
  Tensor tensor;
  tensor.shape.assign(single.size.p, single.size.p + single.dims);
  tensor.values.assign(single.ptr<float>(), single.ptr<float>() + single.total());
  return tensor;
}

// A view: valid as long as the tensor is.
cv::Mat view_of(const Tensor& tensor) {
  std::size_t count = tensor.shape.empty() ? 0 : 1;
  for (const int length : tensor.shape) count *= std::size_t(std::max(length, 0));
  LIKENESS_CHECK(count > 0 && count == tensor.values.size(), "a shape of %zu numbers, and %zu of them", count,
                 tensor.values.size());
  return cv::Mat(int(tensor.shape.size()), tensor.shape.data(), CV_32F,
                 const_cast<float*>(tensor.values.data()));
}

}  // namespace

Tensor picture_tensor(const Image8& picture, double scale, const std::array<double, 3>& mean) {
  const cv::Mat pixels(picture.height, picture.width, CV_8UC(picture.channels),
                       const_cast<std::uint8_t*>(picture.data.data()));
  return tensor_of(
      cv::dnn::blobFromImage(pixels, scale, {}, {mean[0], mean[1], mean[2]}, false, false, CV_32F));
}

struct OnnxNetwork::Impl {
  fs::path origin;
  std::vector<std::byte> bytes;  // for further copies, if there may be any
  Turns turns;
  LendingPool<cv::dnn::Net> copies;

  Impl(fs::path from, int max_concurrent) : origin(std::move(from)), turns(max_concurrent) {}

  // These two throw what OpenCV throws.
  static void read_into(cv::dnn::Net& net, const std::vector<std::byte>& bytes) {
    net = cv::dnn::readNetFromONNX(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    net.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
  }
  std::vector<Tensor> run(std::span<const NetworkInput> inputs, std::span<const std::string> outputs) {
    Lent lent(turns, copies);
    cv::dnn::Net& net = lent.net();
    if (net.empty()) read_into(net, bytes);
    for (const NetworkInput& input : inputs) net.setInput(view_of(input.tensor), input.name);
    std::vector<Tensor> tensors;
    if (outputs.size() == 1 && outputs[0].empty()) {
      tensors.push_back(tensor_of(net.forward()));
    } else {
      std::vector<cv::Mat> computed;
      net.forward(computed, std::vector<cv::String>(outputs.begin(), outputs.end()));
      for (const cv::Mat& output : computed) tensors.push_back(tensor_of(output));
    }
    return tensors;
  }
};

Result<OnnxNetwork> OnnxNetwork::load(const fs::path& onnx, int max_concurrent) {
  std::error_code ignored;
  if (!fs::is_regular_file(onnx, ignored))
    return Error{ErrorCode::not_found, fmt::format("There is no network \"{}\".", onnx.string()),
                 "Check the name and the folder.", onnx.string()};
  auto bytes = read_file(onnx);
  if (!bytes) return bytes.error();
  return load(std::move(*bytes), onnx, max_concurrent);
}

Result<OnnxNetwork> OnnxNetwork::load(std::vector<std::byte> bytes, const fs::path& origin,
                                      int max_concurrent) {
  LIKENESS_CHECK(max_concurrent > 0, "%d at once", max_concurrent);
  if (const std::string fault = onnx_fault(bytes); !fault.empty())
    return bad_network(origin, fmt::format("The network is not given to the importer: {}.", fault));
  auto impl = std::make_unique<Impl>(origin, max_concurrent);
  try {
    auto first = std::make_unique<cv::dnn::Net>();
    Impl::read_into(*first, bytes);
    if (first->empty()) return bad_network(origin, "The file holds no network.");
    impl->copies.give(std::move(first));
    if (max_concurrent > 1) impl->bytes = std::move(bytes);
  } catch (const cv::Exception& fault) {
    if (fault.code == cv::Error::StsNoMem) throw std::bad_alloc();
    return bad_network(origin, fmt::format("The network cannot be read: {}.", fault.err));
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& fault) {  // thrown by the standard library for sizes that the file claims
    return bad_network(origin, fmt::format("The network cannot be read: {}.", fault.what()));
  }
  return OnnxNetwork(std::move(impl));
}

Result<std::vector<Tensor>> OnnxNetwork::run(std::span<const NetworkInput> inputs,
                                             std::span<const std::string> outputs) const {
  try {
    return impl_->run(inputs, outputs);
  } catch (const cv::Exception& fault) {
    if (fault.code == cv::Error::StsNoMem) throw std::bad_alloc();
    return bad_network(impl_->origin, fmt::format("The network cannot be run: {}.", fault.err));
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& fault) {
    return bad_network(impl_->origin, fmt::format("The network cannot be run: {}.", fault.what()));
  }
}

Result<Tensor> OnnxNetwork::run(const Tensor& input, const std::string& output) const {
  const NetworkInput named{"", input};
  auto outputs = run({&named, 1}, {&output, 1});
  if (!outputs) return outputs.error();
  return std::move(outputs->front());
}

const fs::path& OnnxNetwork::origin() const { return impl_->origin; }

OnnxNetwork::OnnxNetwork(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
OnnxNetwork::~OnnxNetwork() = default;
OnnxNetwork::OnnxNetwork(OnnxNetwork&&) noexcept = default;
OnnxNetwork& OnnxNetwork::operator=(OnnxNetwork&&) noexcept = default;

}  // namespace likeness
