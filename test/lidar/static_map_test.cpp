// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/lidar/static_map.h"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <sstream>

#include "kestrel_slam/recording/cloud_file.h"
#include "kestrel_slam/simulation/traffic.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

TEST(StaticMapTest, PcdAndOctoMapCanBeReadBack) {
  TrafficScene scene = crossingScene();
  scene.lidar.columns = 360;
  const TrafficSimulator simulator(scene);
  CloudTracker tracker;
  StaticMap map(0.5);
  for (int frame = 0; frame < 3; ++frame) tracker.process({simulator.sweep(frame).cloud, {}});
  map.add(tracker);
  const std::size_t count = map.points().size();
  ASSERT_GT(count, 1000U);
  const TemporaryFolder folder;
  EXPECT_EQ(readCloudFile(folder.write("map.pcd", map.pcd())).points.size(), count);
  std::istringstream file(map.octomap());
  octomap::OcTree tree(0.1);
  ASSERT_TRUE(tree.readBinary(file));
  EXPECT_DOUBLE_EQ(tree.getResolution(), 0.5);
  for (const Eigen::Vector3f& point : map.points()) {
    const octomap::OcTreeNode* node = tree.search(point.x(), point.y(), point.z());
    ASSERT_NE(node, nullptr);
    EXPECT_TRUE(tree.isNodeOccupied(node));
  }
  // Above the road, between the lidar and what it sees, nothing stands.
  const octomap::OcTreeNode* free = tree.search(3.0, 0.0, -1.0);
  ASSERT_NE(free, nullptr);
  EXPECT_FALSE(tree.isNodeOccupied(free));
}

}  // namespace
}  // namespace kestrel
