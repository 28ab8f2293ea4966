// Claims about packaging/networks: it makes the pinned networks whole or not at all, and where it cannot it
// says why and everything else goes on. What it starts is stood in for, but in the suite that is really to
// fetch.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include "core/base/files.h"
#include "core/base/sha256.h"
#include "core/network/installed_networks.h"
#include "tests/support/run_program.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// Networks that packaging/networks made in the checkout, if it did.
const fs::path kMadeNetworks = LIKENESS_SOURCE "/build/networks";

// A checkout of the packaging scripts alone.
class NetworksScript : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "likeness_networks_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
    fs::create_directories(root_ / "packaging");
    fs::create_directories(root_ / "programs");
    for (const char* file : {"networks", "prepare.sh", "tflite_to_onnx.py"})
      fs::copy_file(fs::path(LIKENESS_SOURCE "/packaging") / file, root_ / "packaging" / file);
  }
  void TearDown() override { fs::remove_all(root_); }

  // A program found before the system's.
  void stand_in(const std::string& name, const std::string& script) {
    const fs::path file = root_ / "programs" / name;
    ASSERT_TRUE(write_text(file, "#!/bin/sh\n" + script + "\n").ok());
    fs::permissions(file, fs::perms::owner_all);
  }
  // Python whose environments hold a python that does `pip` for `-m pip ...`.
  void stand_in_python(const std::string& pip) {
    stand_in("python3",
             "[ \"$1\" = -m ] || exit 0\n"
             "mkdir -p \"$3/bin\"\n"
             "cat >\"$3/bin/python\" <<'END'\n"
             "#!/bin/sh\n"
             "[ \"$1\" = -m ] || exit 0\n" +
                 pip +
                 "\nEND\n"
                 "chmod +x \"$3/bin/python\"");
  }
  ProgramResult run(const std::string& what) const {
    return run_program({"/usr/bin/env", "-u", "LIKENESS_NETWORKS",
                        "PATH=" + (root_ / "programs").string() + ":/usr/bin:/bin", "/bin/bash", "-c",
                        "cd " + root_.string() + " && " + what});
  }
  bool made() const { return fs::exists(root_ / "build/networks"); }

  fs::path root_;
};

TEST_F(NetworksScript, WithoutPythonItSaysSo) {
  stand_in("python3", "exit 1");
  stand_in("dpkg-query", "exit 1");
  for (const char* name : {"apt-get", "sudo"}) stand_in(name, "exit 100");
  const ProgramResult result = run("packaging/networks");
  EXPECT_EQ(result.exit_code, 77) << result.out << result.err;
  EXPECT_THAT(result.err, HasSubstr("cannot be installed"));
  EXPECT_FALSE(made());
}

TEST_F(NetworksScript, WithoutAConnectionItSaysSoAndAllElseGoesOn) {
  stand_in_python("echo no way out >&2; exit 1");
  const ProgramResult result = run("packaging/networks");
  EXPECT_EQ(result.exit_code, 77) << result.out << result.err;
  EXPECT_THAT(result.err, testing::AllOf(HasSubstr("no way out"), HasSubstr("is there a connection?")));
  EXPECT_FALSE(made());
  const ProgramResult all =
      run("root=$PWD; set -euo pipefail; source packaging/prepare.sh; make_networks; echo went on");
  EXPECT_EQ(all.exit_code, 0) << all.err;
  EXPECT_THAT(all.out, HasSubstr("went on"));
  EXPECT_THAT(all.err, HasSubstr("is there a connection?"));
}

TEST_F(NetworksScript, AnythingButThePinnedFileIsThrownAway) {
  stand_in_python(
      "while [ $# -gt 0 ]; do\n"
      "  [ \"$1\" != -d ] || echo something else "
      ">\"$2/mediapipe-0.10.21-cp311-cp311-manylinux_2_28_x86_64.whl\"\n"
      "  shift\n"
      "done");
  const ProgramResult result = run("packaging/networks");
  EXPECT_EQ(result.exit_code, 77) << result.out << result.err;
  EXPECT_THAT(result.err, HasSubstr("not the file that was meant"));
  EXPECT_EQ(run("find build -name '*.whl'").out, "");
  EXPECT_FALSE(made());
}

TEST_F(NetworksScript, WhatIsThereIsNotMadeAgainUnlessItIsDamaged) {
  if (!fs::exists(kMadeNetworks)) GTEST_SKIP() << "packaging/networks has made no networks in this checkout";
  fs::create_directories(root_ / "build");
  fs::copy(kMadeNetworks, root_ / "build/networks", fs::copy_options::recursive);
  stand_in_python("echo asked >&2; exit 1");
  const ProgramResult again = run("packaging/networks");
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(again.out + again.err, "");
  ASSERT_TRUE(write_text(root_ / "build/networks/iris.onnx", "damaged").ok());
  const ProgramResult damaged = run("packaging/networks");
  EXPECT_EQ(damaged.exit_code, 77);
  EXPECT_THAT(damaged.err, HasSubstr("asked"));
}

TEST_F(NetworksScript, HelpSaysWhatItIsFor) {
  const ProgramResult help = run("packaging/networks --help");
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_THAT(help.out, testing::AllOf(HasSubstr("packaging/networks"), HasSubstr("77")));
  EXPECT_EQ(run("packaging/networks --unknown").exit_code, 2);
  EXPECT_FALSE(fs::exists(root_ / "build"));
}

// Fetches 80 MB.
class NetworksFetched : public NetworksScript {};

TEST_F(NetworksFetched, ThePinnedPackageBecomesThePinnedNetworks) {
  const ProgramResult result = run("packaging/networks");
  if (result.exit_code == 77 && result.err.find("is there a connection?") != std::string::npos)
    GTEST_SKIP() << result.err;
  ASSERT_EQ(result.exit_code, 0) << result.out << result.err;
  for (const InstalledNetworkFile& file : installed_network_files()) {
    const auto bytes = read_file(root_ / "build/networks" / file.file);
    ASSERT_TRUE(bytes.ok()) << bytes.error().what;
    EXPECT_EQ(sha256(*bytes), file.sha256) << file.file;
  }
  EXPECT_TRUE(fs::exists(root_ / "build/networks/ORIGIN"));
  EXPECT_FALSE(fs::exists(root_ / "build/networks-work"));
  EXPECT_EQ(run("packaging/networks").out, "");
}

}  // namespace
}  // namespace likeness::test
