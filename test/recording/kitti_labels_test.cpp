// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/kitti_labels.h"

#include <gtest/gtest.h>

#include "temporary_folder.h"

namespace kestrel {
namespace {

TEST(KittiLabelsTest, ReadsWhatItWrites) {
  const TemporaryFolder folder;
  KittiLabel label;
  label.frame = 3;
  label.id = 7;
  label.type = "Car";
  label.center << 12.0, -3.0, -0.9;
  label.size << 4.2, 1.8, 1.5;
  label.yaw = 0.4;
  const Eigen::Isometry3d camera = plainKittiCamera();
  const std::string path = folder.write(
      "labels.txt", "0 -1 DontCare -1 -1 -10 1 2 3 4 -1 -1 -1 -1000 -1000 -1000 -10\n" +
                        kittiLine(label, camera));
  const std::vector<KittiLabel> labels = readKittiLabels(path, camera);
  ASSERT_EQ(labels.size(), 1U);
  EXPECT_EQ(labels[0].frame, 3);
  EXPECT_EQ(labels[0].id, 7);
  EXPECT_LT((labels[0].center - label.center).norm(), 1e-3);
  EXPECT_LT((labels[0].size - label.size).norm(), 1e-3);
  EXPECT_NEAR(labels[0].yaw, label.yaw, 1e-3);
}

TEST(KittiLabelsTest, ErrorsNameTheFileAndTheLine) {
  const TemporaryFolder folder;
  const std::string path = folder.write("bad.txt", "0 1 Car 0 0\n");
  try {
    readKittiLabels(path, plainKittiCamera());
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("bad.txt:1"), std::string::npos);
  }
  EXPECT_THROW(readKittiCalibration(path), std::runtime_error);
}

}  // namespace
}  // namespace kestrel
