// Claims about dense networks: products agree with plain sums, gradients with finite differences.
#include "core/papers/dense_network.h"

#include <gtest/gtest.h>

#include <array>

#include "core/papers/dense_product.h"

namespace likeness {
namespace {

TEST(DenseProducts, EqualPlainSumsInTheChosenInstructions) {
  constexpr int kOutputs = 37, kInputs = 53, kCount = 71;  // no multiple of any register
  const Eigen::MatrixXf w = Eigen::MatrixXf::Random(kOutputs, kInputs),
                        x = Eigen::MatrixXf::Random(kInputs, kCount),
                        y = Eigen::MatrixXf::Random(kOutputs, kCount);
  Eigen::MatrixXf forward = y, backward = x, weights = w;
  const DenseProducts<float>& products = dense_products<float>();
  products.add_forward(w.data(), kOutputs, kInputs, x.data(), kCount, forward.data());
  products.add_backward(w.data(), kOutputs, kInputs, y.data(), kCount, backward.data());
  products.add_weights(y.data(), kOutputs, kInputs, x.data(), kCount, weights.data());
  const Eigen::MatrixXd wd = w.cast<double>(), xd = x.cast<double>(), yd = y.cast<double>();
  EXPECT_LT((forward.cast<double>() - (yd + wd * xd)).cwiseAbs().maxCoeff(), 2e-5);
  EXPECT_LT((backward.cast<double>() - (xd + wd.transpose() * yd)).cwiseAbs().maxCoeff(), 2e-5);
  EXPECT_LT((weights.cast<double>() - (wd + yd * xd.transpose())).cwiseAbs().maxCoeff(), 2e-5);
}

// A layer that reads two inputs, one that skips, and an output of two nodes.
const DenseNetworkSpec kSpec{{3, 2},
                             {{{0, 1}, 7, Activation::relu},
                              {{2}, 6, Activation::relu},
                              {{3, 0}, 5, Activation::none},
                              {{4, 2}, 2, Activation::none}}};

TEST(DenseNetwork, CountsItsWeightsAndBiases) {
  EXPECT_EQ(parameter_count(kSpec), std::size_t(7 * 5 + 7 + 6 * 7 + 6 + 5 * 9 + 5 + 2 * 12 + 2));
}

TEST(DenseNetwork, GradientsAgreeWithFiniteDifferences) {
  std::vector<float> drawn(parameter_count(kSpec));
  initialise(kSpec, 4, drawn);
  std::vector<double> parameters(drawn.begin(), drawn.end());
  for (std::size_t i = 0; i < parameters.size(); ++i) parameters[i] += 0.01 * double(1 + i % 7);
  DenseNodes<double> given{Eigen::MatrixXd::Random(3, 9), Eigen::MatrixXd::Random(2, 9)};
  const Eigen::MatrixXd pull = Eigen::MatrixXd::Random(2, 9);  // loss = <pull, output>
  const auto loss = [&] {
    DenseNodes<double> nodes = given;
    network_forward(kSpec, parameters.data(), nodes);
    return nodes.back().cwiseProduct(pull).sum();
  };
  DenseNodes<double> nodes = given, slopes;
  network_forward(kSpec, parameters.data(), nodes);
  slopes.resize(nodes.size());
  slopes.back() = pull;
  std::vector<double> gradients(parameters.size());
  const std::array wanted{0, 1};
  network_backward(kSpec, parameters.data(), nodes, wanted, slopes, gradients.data());

  constexpr double kStep = 1e-6;
  const auto difference = [&](double& value) {
    const double kept = value;
    value = kept + kStep;
    const double above = loss();
    value = kept - kStep;
    const double below = loss();
    value = kept;
    return (above - below) / (2 * kStep);
  };
  for (std::size_t i = 0; i < parameters.size(); ++i)
    EXPECT_NEAR(gradients[i], difference(parameters[i]), 1e-6) << i;
  for (std::size_t n = 0; n < given.size(); ++n)
    for (Eigen::Index i = 0; i < given[n].size(); ++i)
      EXPECT_NEAR(slopes[n].data()[i], difference(given[n].data()[i]), 1e-6) << n << " " << i;
}

}  // namespace
}  // namespace likeness
