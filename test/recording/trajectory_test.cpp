// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/trajectory.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "temporary_folder.h"

namespace kestrel {
namespace {

TEST(Trajectory, WritesTheTumFormat) {
  const TemporaryFolder folder;
  const std::string path = folder.file("a.tum");
  writeTum(path, {{976052857.337530, Pose2(1.25, -2.0, 0.0)}, {0.5, Pose2(0.0, 0.0, kPi)}});
  std::ostringstream content;
  content << std::ifstream(path).rdbuf();
  EXPECT_EQ(content.str(),
            "976052857.337530 1.250000 -2.000000 0 0 0 0.000000000 1.000000000\n"
            "0.500000 0.000000 0.000000 0 0 0 1.000000000 0.000000000\n");
}

TEST(Trajectory, RoundTripKeepsStampsExactlyAndPosesToAMicrometer) {
  const TemporaryFolder folder;
  const std::string path = folder.file("a.tum");
  const Trajectory written = {{1.0 / 3.0, Pose2(0.1, 0.2, 3.1)},
                              {976052905.167303, Pose2(-7.5, 1e-6, -3.1)},
                              {976052904.9, Pose2(0.0, 0.0, 0.3)},
                              {1700000000.123456789, Pose2()}};
  writeTum(path, written);
  const Trajectory read = readTum(path);
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_NEAR(read[i].stamp, written[i].stamp, i == 0 ? 1e-12 : 0.0) << i;
    EXPECT_NEAR(read[i].pose.x, written[i].pose.x, 1e-6) << i;
    EXPECT_NEAR(read[i].pose.y, written[i].pose.y, 1e-6) << i;
    EXPECT_NEAR(read[i].pose.yaw, written[i].pose.yaw, 1e-7) << i;
  }
}

TEST(Trajectory, ReadsCommentsAndNegatedQuaternions) {
  const TemporaryFolder folder;
  const std::string path = folder.write(
      "a.tum", "# stamp tx ty tz qx qy qz qw\n\n 1 2 3 4 0 0 -0.7071068 -0.7071068\r\n");
  const Trajectory read = readTum(path);
  ASSERT_EQ(read.size(), 1U);
  EXPECT_NEAR(read[0].pose.yaw, kPi / 2.0, 1e-7);
}

TEST(Trajectory, ErrorsDescribeTheProblem) {
  const TemporaryFolder folder;
  const auto problem = [&](const std::string& content) {
    const std::string path = folder.write("a.tum", content);
    return messageOf([&] { readTum(path); });
  };
  const std::string good = "1 0 0 0 0 0 0 1\n";
  EXPECT_CONTAINS(problem(good + "2 0 0 0 0 0 1\n"), "a.tum, line 2: expected 8 fields");
  EXPECT_CONTAINS(problem(good + good + "3 0 x 0 0 0 0 1\n"), "line 3: 'x' is not a finite number");
  EXPECT_CONTAINS(problem("1 0 nan 0 0 0 0 1\n"), "'nan' is not a finite number");
  EXPECT_CONTAINS(problem("1 0 0 0 0 0 0 0\n"), "quaternion");
  EXPECT_CONTAINS(problem("# nothing\n"), "has no poses");
  EXPECT_CONTAINS(messageOf([&] { readTum(folder.file("b.tum")); }),
                  "b.tum: the file does not exist");
  EXPECT_CONTAINS(messageOf([&] { writeTum(folder.file("no/b.tum"), {}); }),
                  "no/b.tum: No such file");
}

}  // namespace
}  // namespace kestrel
