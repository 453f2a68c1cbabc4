// SPDX-License-Identifier: BSD-3-Clause
// Frames, mountings and clocks of a bag.
#include "bag_maker.h"

namespace kestrel {
namespace {

using BagFrames = BagTest;

/// A vehicle that drives along x in a bag with the frames `names`: world, vehicle, laser.
void recordDrive(rosbag::Bag& bag, const std::vector<std::string>& names) {
  record(bag, "/tf_static", kBagStart, transform(names[1], names[2], kBagStart, 0.25));
  for (int i = 0; i < 12; ++i) {
    const double time = kBagStart + 0.1 * i;
    record(bag, "/tf", time, transform(names[0], names[1], time, 0.05 * i, 0.02 * i));
  }
  recordTurns(bag, 10, names[2]);
}

TEST_F(BagFrames, TheVehicleEndsWhereTheTransformsMove) {
  const std::vector<std::vector<std::string>> frames = {
      {"odom", "base_link", "laser"},
      {"iris_0/odom", "iris_0/base_link", "iris_0/laser"},
      {"uav1/local_origin", "uav1/fcu", "uav1/rplidar"},
      {"mocap_world", "drone", "lidar"},
      {"t265_odom_frame", "t265_pose_frame", "hokuyo"}};
  for (const auto& names : frames) {
    const auto recording = open([&](rosbag::Bag& bag) { recordDrive(bag, names); });
    EXPECT_CONTAINS(recording->description(), "laser " + names[2] + " on " + names[1]);
    const std::vector<RecordedScan> scans = readAll(*recording);
    ASSERT_EQ(scans.size(), 10U);
    for (const RecordedScan& scan : scans) {
      EXPECT_NEAR(scan.base_T_laser.translation().x(), 0.25, 1e-9);
      EXPECT_NEAR(scan.base_T_laser.linear()(0, 0), 1.0, 1e-9);
    }
  }
}

TEST_F(BagFrames, ATreeThatNeverMovesStillGivesOneMounting) {
  const auto recording = open([](rosbag::Bag& bag) {
    record(bag, "/tf_static", kBagStart, transform("world", "mast", kBagStart, 1.0));
    record(bag, "/tf_static", kBagStart, transform("mast", "laser", kBagStart, 0.5));
    recordTurns(bag, 3);
  });
  for (const RecordedScan& scan : readAll(*recording)) {
    EXPECT_NEAR(scan.base_T_laser.translation().x(), 1.5, 1e-9);
  }
}

TEST_F(BagFrames, AnotherRobotsBaseLinkIsNotTheVehicle) {
  const auto recording = open([](rosbag::Bag& bag) {
    record(bag, "/tf_static", kBagStart, transform("base_link", "camera", kBagStart, 1.0));
    recordDrive(bag, {"uav/odom", "uav/body", "uav/laser"});
  });
  EXPECT_CONTAINS(recording->description(), "laser uav/laser on uav/body");
}

TEST_F(BagFrames, ALaserOnAMovingJointBelongsToBaseLink) {
  const auto recording = open([](rosbag::Bag& bag) {
    for (int i = 0; i < 5; ++i) {
      const double time = kBagStart + 0.1 * i;
      record(bag, "/tf", time, transform("base_link", "laser", time, 0.1, 0.1 * i));
    }
    recordTurns(bag, 3);
  });
  EXPECT_CONTAINS(recording->description(), "laser laser on base_link");
}

TEST_F(BagFrames, ARigidMountingNeedsNoTime) {
  // tf in unix time, the laser's clock since boot.
  const auto recording = open([](rosbag::Bag& bag) {
    for (int i = 0; i < 5; ++i) {
      const double time = kBagStart + 0.1 * i;
      record(bag, "/tf", time, transform("base_link", "laser", time, 0.3));
      auto scan = turnPart(0, 360);
      scan.header.stamp = ros::Time(91.0 + 0.1 * i);
      record(bag, "/scan", time, scan);
      record(bag, "/imu", time, imuReading(time, "base_link"));
    }
  });
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 5U);
  EXPECT_NEAR(scans[0].base_T_laser.translation().x(), 0.3, 1e-9);
  EXPECT_CONTAINS(warningsOf(*recording),
                  "the stamps of laser and IMU come from different clocks: they differ by "
                  "1699999909 s");
}

TEST_F(BagFrames, DifferentClocksAreSaidWhereAMovingMountingCannotBeFound) {
  const auto recording = open([](rosbag::Bag& bag) {
    for (int i = 0; i < 5; ++i) {
      const double time = kBagStart + 0.1 * i;
      record(bag, "/tf", time, transform("base_link", "laser", time, 0.3, 0.1 * i));
      auto scan = turnPart(0, 360);
      scan.header.stamp = ros::Time(91.0 + 0.1 * i);
      record(bag, "/scan", time, scan);
    }
  });
  EXPECT_TRUE(readAll(*recording).empty());
  EXPECT_EQ(recording->skipped().at("transform not recorded at this time"), 5U);
  EXPECT_CONTAINS(recording->warningOf("transform not recorded at this time"), "different clocks");
}

TEST_F(BagFrames, AGivenMountingIsNotAskedFor) {
  const auto fill = [](rosbag::Bag& bag) {
    record(bag, "/tf_static", kBagStart, transform("base_link", "base_link_frd", kBagStart, 0.0));
    recordTurns(bag, 3);
  };
  const auto without = open(fill);
  EXPECT_TRUE(readAll(*without).empty());
  EXPECT_CONTAINS(without->warningOf("missing transform"),
                  "the bag has no tf base_link -> laser; give the mounting with --laser-pose");
  RecordingOptions options;
  options.base_T_laser = Eigen::Isometry3d(Eigen::Translation3d(0.1, 0.0, 0.0));
  const auto with = open(fill, options);
  const std::vector<RecordedScan> scans = readAll(*with);
  ASSERT_EQ(scans.size(), 3U);
  EXPECT_EQ(scans[0].base_T_laser.translation().x(), 0.1);
  EXPECT_EQ(warningsOf(*with), "");
}

TEST_F(BagFrames, AnUnknownBaseFrameIsNamedWithTheFramesOfTf) {
  RecordingOptions options;
  options.base_frame = "foo";
  const auto fill = [](rosbag::Bag& bag) { recordDrive(bag, {"odom", "base_link", "laser"}); };
  EXPECT_CONTAINS(messageOf([&] { open(fill, options); }),
                  "tf has no frame foo (--base-frame); its frames: base_link, laser, odom");
}

TEST_F(BagFrames, AForeignMapToOdomIsNamed) {
  const auto recording = open([](rosbag::Bag& bag) {
    record(bag, "/tf", kBagStart, transform("map", "odom", kBagStart, 1.6));
    recordDrive(bag, {"odom", "base_link", "laser"});
  });
  EXPECT_CONTAINS(warningsOf(*recording), "the bag has tf map -> odom of another localization");
  EXPECT_EQ(readAll(*recording).size(), 10U);
}

}  // namespace
}  // namespace kestrel
