// Claims about memory limits: whatever version and however deep, the least one on the program's path counts.
#include "core/base/control_groups.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "core/base/files.h"
#include "core/base/temporary_folder.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMb = 1 << 20;
constexpr const char* kSecondVersion =
    "30 23 0:26 / /sys/fs/cgroup rw,nosuid shared:9 - cgroup2 cgroup2 rw,nsdelegate\n";

// A machine's files, made up.
class ControlGroups : public ::testing::Test {
 protected:
  ControlGroups() : folder_(TemporaryFolder::make("groups")) {}
  void put(const std::string& name, const std::string& text) const {
    ASSERT_TRUE(write_text(folder_->path() / name, text).ok());
  }
  std::optional<std::uint64_t> left() const { return group_memory_left(folder_->path()); }

  Result<TemporaryFolder> folder_;
};

TEST_F(ControlGroups, WithoutGroupsOrLimitsThereIsNone) {
  EXPECT_EQ(left(), std::nullopt);
  put("proc/self/mountinfo", kSecondVersion);
  put("proc/self/cgroup", "0::/a\n");
  put("sys/fs/cgroup/a/memory.max", "max\n");
  EXPECT_EQ(left(), std::nullopt);
}

TEST_F(ControlGroups, OfVersionTwoTheLeastOfAllParentsCounts) {
  put("proc/self/mountinfo", "22 1 8:1 / / rw - ext4 /dev/sda1 rw\n" + std::string(kSecondVersion));
  put("proc/self/cgroup", "0::/user.slice/app.scope\n");
  put("sys/fs/cgroup/user.slice/memory.max", std::to_string(500 * kMb));
  put("sys/fs/cgroup/user.slice/memory.stat", "anon " + std::to_string(450 * kMb) + "\nfile 7\n");
  put("sys/fs/cgroup/user.slice/app.scope/memory.max", std::to_string(200 * kMb));
  put("sys/fs/cgroup/user.slice/app.scope/memory.high", "max");
  put("sys/fs/cgroup/user.slice/app.scope/memory.stat", "anon " + std::to_string(50 * kMb) + "\n");
  EXPECT_EQ(left(), 50 * kMb);  // what others of user.slice hold counts there
  put("sys/fs/cgroup/user.slice/app.scope/memory.high", std::to_string(60 * kMb));
  EXPECT_EQ(left(), 10 * kMb);
  put("sys/fs/cgroup/user.slice/app.scope/memory.stat", "anon " + std::to_string(900 * kMb) + "\n");
  EXPECT_EQ(left(), 0u);
}

TEST_F(ControlGroups, OfVersionOneToo) {
  put("proc/self/mountinfo",
      "31 23 0:27 / /sys/fs/cgroup/cpu rw - cgroup cgroup rw,cpu,cpuacct\n"
      "32 23 0:28 / /sys/fs/cgroup/memory rw - cgroup cgroup rw,memory\n");
  put("proc/self/cgroup", "5:cpu,cpuacct:/else\n4:memory:/jobs/7\n");
  put("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712");
  put("sys/fs/cgroup/memory/jobs/memory.limit_in_bytes", std::to_string(300 * kMb));
  put("sys/fs/cgroup/memory/jobs/memory.stat", "rss 1\ntotal_rss " + std::to_string(100 * kMb) + "\n");
  put("sys/fs/cgroup/memory/jobs/7/memory.limit_in_bytes", "9223372036854771712");
  EXPECT_EQ(left(), 200 * kMb);
}

// A container's own group is mounted as the root, with the name that it has outside, or seen from within.
TEST_F(ControlGroups, AContainersOwnGroupIsFoundWhereItIsMounted) {
  put("proc/self/mountinfo", "32 23 0:28 /box/1 /sys/fs/cgroup/mem\\040ory rw - cgroup cgroup rw,memory\n");
  put("sys/fs/cgroup/mem ory/memory.limit_in_bytes", std::to_string(80 * kMb));
  put("sys/fs/cgroup/mem ory/inner/memory.limit_in_bytes", std::to_string(40 * kMb));
  for (const char* outside : {"4:memory:/box/1\n", "4:memory:/../2\n", ""}) {
    put("proc/self/cgroup", outside);
    EXPECT_EQ(left(), 80 * kMb) << outside;
  }
  put("proc/self/cgroup", "4:memory:/box/1/inner\n");
  EXPECT_EQ(left(), 40 * kMb);
}

}  // namespace
}  // namespace likeness
