// Claims about the installed networks: they are found where they are said to lie, only the pinned files are
// accepted, and OpenCV computes what their own interpreter does.
#include "core/network/installed_networks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <numeric>
#include <optional>
#include <span>
#include <thread>

#include "core/base/files.h"
#include "core/base/sha256.h"
#include "tests/core/network/drawn_face.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kNetworksVariable = "LIKENESS_NETWORKS";

// Sets the variable, or unsets it, for as long as this lives.
class NetworksVariable {
 public:
  explicit NetworksVariable(const std::optional<std::string>& value) {
    if (const char* given = std::getenv(kNetworksVariable)) before_ = given;
    set(value);
  }
  ~NetworksVariable() { set(before_); }
  NetworksVariable(const NetworksVariable&) = delete;
  NetworksVariable& operator=(const NetworksVariable&) = delete;

 private:
  static void set(const std::optional<std::string>& value) {
    if (value)
      ::setenv(kNetworksVariable, value->c_str(), 1);
    else
      ::unsetenv(kNetworksVariable);
  }
  std::optional<std::string> before_;
};

class InstalledNetworks : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("likeness_networks_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST_F(InstalledNetworks, EachHasAFileAndAHash) {
  const auto files = installed_network_files();
  ASSERT_EQ(files.size(), 4u);
  for (std::size_t i = 0; i < files.size(); ++i) {
    EXPECT_EQ(std::size_t(files[i].network), i);
    EXPECT_EQ(&installed_network_file(files[i].network), &files[i]);
    EXPECT_THAT(files[i].sha256, testing::MatchesRegex("[0-9a-f]{64}"));
  }
}

TEST_F(InstalledNetworks, AnAbsentOneIsNamedWithWhereItWasLookedFor) {
  const NetworksVariable set((folder_ / "nowhere").string());
  const auto found = find_installed_network(InstalledNetwork::face468);
  ASSERT_FALSE(found.ok());
  EXPECT_EQ(found.error().code, ErrorCode::missing_dependency);
  EXPECT_EQ(found.error().what, "The network face468.onnx is not in " + (folder_ / "nowhere").string() + ".");
  EXPECT_THAT(found.error().fix, HasSubstr("packaging/networks"));
  const auto loaded = load_installed_network(InstalledNetwork::face468);
  ASSERT_FALSE(loaded.ok());
  EXPECT_EQ(loaded.error().what, found.error().what);
  EXPECT_EQ(installed_network_hash(InstalledNetwork::face468), "absent");
}

TEST_F(InstalledNetworks, WithoutTheVariableTheProgramsOwnFoldersAreLookedAt) {
  for (const auto& value : {std::optional<std::string>(), std::optional<std::string>("")}) {
    const NetworksVariable set(value);
    const auto found = find_installed_network(InstalledNetwork::person);
    const std::string said = found ? found->string() : found.error().what;
    EXPECT_THAT(said, testing::AnyOf(HasSubstr("share/likeness/networks"), HasSubstr("/networks")));
    if (!found) {
      EXPECT_THAT(said, HasSubstr("share/likeness/networks nor in "));
    }
  }
}

TEST_F(InstalledNetworks, AnotherFileThanThePinnedOneIsRefused) {
  ASSERT_TRUE(write_text(folder_ / "iris.onnx", "another network").ok());
  const NetworksVariable set(folder_.string());
  const auto found = find_installed_network(InstalledNetwork::iris);
  ASSERT_TRUE(found.ok()) << found.error().what;
  EXPECT_EQ(*found, folder_ / "iris.onnx");
  const auto loaded = load_installed_network(InstalledNetwork::iris);
  ASSERT_FALSE(loaded.ok());
  EXPECT_EQ(loaded.error().code, ErrorCode::bad_input);
  const std::string text = "another network";
  EXPECT_THAT(loaded.error().what,
              testing::AllOf(HasSubstr("iris.onnx"), HasSubstr("15 bytes"),
                             HasSubstr(sha256(std::as_bytes(std::span(text))).substr(0, 12))));
  EXPECT_THAT(loaded.error().fix, HasSubstr("packaging/networks"));
  const std::string before = installed_network_hash(InstalledNetwork::iris);
  EXPECT_NE(before, "absent");
  ASSERT_TRUE(write_text(folder_ / "iris.onnx", "yet another network").ok());
  EXPECT_NE(installed_network_hash(InstalledNetwork::iris), before);
}

// Of those that are really there; without LIKENESS_NETWORKS, those that packaging/networks made in the
// checkout.
class RealNetworks : public InstalledNetworks {
 protected:
  void SetUp() override {
    InstalledNetworks::SetUp();
    if (const char* given = std::getenv(kNetworksVariable); given == nullptr || *given == '\0')
      checkouts_.emplace(LIKENESS_SOURCE "/build/networks");
    for (const InstalledNetworkFile& file : installed_network_files())
      if (const auto found = find_installed_network(file.network); !found)
        GTEST_SKIP() << found.error().what << ' ' << found.error().fix;
  }
  std::optional<NetworksVariable> checkouts_;
};

TEST_F(RealNetworks, ADamagedOneIsRefused) {
  const auto good = read_file(*find_installed_network(InstalledNetwork::person));
  ASSERT_TRUE(good.ok());
  for (const std::size_t at : {std::size_t(0), good->size() / 2, good->size() - 1}) {
    auto damaged = *good;
    damaged[at] ^= std::byte{1};
    ASSERT_TRUE(write_file(folder_ / "person.onnx", damaged).ok());
    const NetworksVariable set(folder_.string());
    const auto loaded = load_installed_network(InstalledNetwork::person);
    ASSERT_FALSE(loaded.ok()) << at;
    EXPECT_THAT(loaded.error().what, HasSubstr("is not the network"));
  }
}

struct LiteRtOutput {
  InstalledNetwork network;
  std::string output;
  std::size_t count;
  double mean;  // of all values
  std::vector<std::size_t> chosen;
  std::vector<double> values;  // of the chosen
};

// What LiteRT 2.3.0 makes of drawn_face() in the .tflite files that these networks were converted from, by
// litert_outputs.py beside this.
const std::vector<LiteRtOutput>& litert_outputs() {
  using enum InstalledNetwork;
  static const std::vector<LiteRtOutput> outputs{
      {person,
       "activation_10",
       65536,
       0.4455557,
       {0, 9299, 10923, 21846, 32769, 36288, 43692, 50271, 54615, 57037, 64021, 64787},
       {1.546666e-34, 0.5056224, 1, 1, 0, 0.5011405, 1, 0.5055023, 1, 0.4969812, 0.5058519, 0.4973013}},
      {face468,
       "conv2d_21",
       1404,
       66.15032,
       {0, 234, 322, 468, 642, 684, 702, 741, 754, 889, 936, 1170},
       {96.30163, 81.11184, 66.68543, 58.05745, 66.10694, 66.41624, 52.64863, 66.26047, 66.27144, 66.17215,
        100.1476, 123.7195}},
      {face468, "conv2d_31", 1, 25.51217, {0}, {25.51217}},
      {iris,
       "output_eyes_contours_and_brows",
       213,
       20.48307,
       {0, 36, 72, 108, 130, 144, 162, 180, 189, 191, 192, 193},
       {25.25294, 32.82026, 46.0263, 33.28316, 18.26116, 19.39776, 17.49905, 42.45031, 17.41166, 18.28499,
        17.23981, 18.16423}},
      {iris,
       "output_iris",
       15,
       17.49643,
       {0, 1, 3, 4, 6, 7, 9, 10, 12, 13},
       {37.5907, 28.16828, 41.23215, 27.62176, 37.26244, 24.9807, 33.9318, 28.693, 37.99192, 31.21879}},
      {face_detector,
       "regressors",
       14336,
       7.247749,
       {0, 2390, 4780, 7170, 9362, 9363, 9560, 9938, 9939, 11490, 11491, 11950},
       {0.07274767, -0.8398769, -1.443289, 24.99059, 67.62702, 67.6196, -11.95886, 68.02677, 68.01842,
        68.35981, 68.34884, 18.10071}},
      {face_detector,
       "classificators",
       896,
       -15.1116,
       {0, 150, 300, 450, 541, 600, 750, 815, 847, 875, 888, 895},
       {-5.460857, -4.817408, -6.401244, -5.379507, -77.4017, -85.07051, -55.58127, -83.60915, -76.39296,
        -79.71859, -79.27236, -83.73492}},
  };
  return outputs;
}

TEST_F(RealNetworks, OpenCvComputesWhatLiteRtDoes) {
  for (const LiteRtOutput& expected : litert_outputs()) {
    const std::string name = installed_network_file(expected.network).file + (" " + expected.output);
    const auto network = load_installed_network(expected.network);
    ASSERT_TRUE(network.ok()) << network.error().what;
    const bool detector = expected.network == InstalledNetwork::face_detector;
    const int side = installed_network_file(expected.network).side;
    const Tensor picture = detector ? picture_tensor(drawn_face(side), 1 / 127.5, {127.5, 127.5, 127.5})
                                    : picture_tensor(drawn_face(side), 1 / 255.0);
    const auto computed = network->run(picture, expected.output);
    ASSERT_TRUE(computed.ok()) << name << ": " << computed.error().what;
    ASSERT_EQ(computed->values.size(), expected.count) << name;
    const double mean =
        std::accumulate(computed->values.begin(), computed->values.end(), 0.0) / double(expected.count);
    // Pixels, or shares of 1. Versions of OpenCV sum in different orders; 4.6 differs by less than a tenth of
    // this.
    const double tolerance = expected.network == InstalledNetwork::person ? 1e-4 : 1e-3;
    EXPECT_NEAR(mean, expected.mean, tolerance / 10) << name;
    for (std::size_t i = 0; i < expected.chosen.size(); ++i)
      EXPECT_NEAR(computed->values[expected.chosen[i]], expected.values[i], tolerance)
          << name << " at " << expected.chosen[i];
  }
}

// What the numbers mean, on a face whose parts are known.
TEST_F(RealNetworks, TheyFindTheDrawnFace) {
  const auto person = load_installed_network(InstalledNetwork::person);
  const auto face = load_installed_network(InstalledNetwork::face468);
  ASSERT_TRUE(person.ok() && face.ok());
  const auto share = person->run(picture_tensor(drawn_face(256), 1 / 255.0));
  ASSERT_TRUE(share.ok()) << share.error().what;
  EXPECT_GT(share->values[256 * 120 + 128], 0.99f);  // nose
  EXPECT_LT(share->values[256 * 20 + 20], 0.01f);    // a corner
  const NetworkInput picture{"", picture_tensor(drawn_face(192), 1 / 255.0)};
  const std::string outputs[] = {"conv2d_21", "conv2d_31"};
  const auto found = face->run({&picture, 1}, outputs);
  ASSERT_TRUE(found.ok()) << found.error().what;
  EXPECT_GT((*found)[1].values[0], 0);  // more likely a face than not
  const std::vector<float>& points = (*found)[0].values;
  const auto expect_at = [&](std::size_t point, double x, double y) {
    EXPECT_NEAR(points[3 * point] / 192, x, 0.03) << point;
    EXPECT_NEAR(points[3 * point + 1] / 192, y, 0.03) << point;
  };
  expect_at(13, 0.50, 0.65);   // upper lip, inside
  expect_at(33, 0.35, 0.42);   // outer corner of the person's right eye
  expect_at(263, 0.65, 0.42);  // and of the left
}

TEST_F(RealNetworks, CopiesComputeTheSameBits) {
  const auto network = load_installed_network(InstalledNetwork::face_detector, 3);
  ASSERT_TRUE(network.ok()) << network.error().what;
  const Tensor picture = picture_tensor(drawn_face(128), 1 / 127.5, {127.5, 127.5, 127.5});
  const auto once = network->run(picture, "regressors");
  ASSERT_TRUE(once.ok()) << once.error().what;
  std::atomic<int> same = 0;
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 3; ++t)
      threads.emplace_back([&] {
        for (int i = 0; i < 5; ++i) {
          const auto again = network->run(picture, "regressors");
          same += again.ok() && again->values == once->values;
        }
      });
  }
  EXPECT_EQ(same, 15);
}

}  // namespace
}  // namespace likeness
