// SPDX-License-Identifier: BSD-3-Clause
// A vehicle localizes in the merged map of others while that map grows.
#include <gtest/gtest.h>

#include "kestrel_slam/merging/merged_session.h"
#include "kestrel_slam/session/session_file.h"
#include "mapper_client.h"
#include "merging/building.h"
#include "ros/mapper/mapper_process.h"
#include "ros/mapper/ring_scan.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

/// The merged map of vehicles that fly these ways.
void saveMerged(const std::string& file, const std::vector<std::vector<Pose2>>& ways) {
  MapMerger merger{MapperConfig(), LoopConfig()};
  for (std::size_t i = 0; i < ways.size(); ++i)
    merger.update(building::mapOf("uav" + std::to_string(i), {}, ways[i]));
  const MergeResult merged = merger.merge();
  ASSERT_EQ(merged.largestGroup(), ways.size());
  saveSession(file, mergedSession(merger.vehicles(), merged, 0));
}

class FollowMerged : public testing::Test {
 protected:
  std::vector<std::string> parameters() const {
    return {"_mode:=localization", "_session:=" + file_, "_follow_session:=true",
            "_map_frame:=world"};
  }

  /// Flies on and returns the largest error of the poses in `world`, m.
  double fly(const std::vector<Pose2>& way, std::size_t first, std::size_t last) {
    double largest = 0.0;
    for (std::size_t i = first; i < last; ++i) {
      stamp_ += ros::Duration(0.2);
      const auto pose = client_.match(messageAt(way[i], stamp_, building::walls()), 1.0);
      if (!pose) continue;
      ++poses_;
      const Pose2 truth = building::tour(0, 1).front().between(way[i]);
      largest = std::max(largest, truth.between(*pose).distance());
    }
    return largest;
  }

  bool mapHas(std::size_t cells) {
    return client_.waitFor([&] { return client_.map.data.size() > cells; });
  }

  TemporaryFolder folder_;
  const std::string file_ = folder_.file("merged.session");
  MapperClient client_;
  ros::Time stamp_ = ros::Time::now();
  std::size_t poses_ = 0;
};

TEST_F(FollowMerged, AVehicleFliesOnIntoWhatOnlyOthersHaveSeen) {
  const std::vector<Pose2> way = building::tour(0, 2);
  MapperProcess node(parameters());
  ASSERT_TRUE(client_.connect());
  fly(way, 0, 3);
  EXPECT_EQ(poses_, 0U) << "there is no map yet, and nothing is published on a guess";
  saveMerged(file_, {building::tour(0, 1)});
  ASSERT_TRUE(mapHas(1000));
  EXPECT_LT(fly(way, 3, way.size() / 2), 0.15);
  EXPECT_GT(poses_, way.size() / 4) << "it was found";
  const std::size_t cells = client_.map.data.size();
  saveMerged(file_, {building::tour(0, 1), building::tour(2, 0)});
  ASSERT_TRUE(mapHas(cells + 1000));
  poses_ = 0;
  EXPECT_LT(fly(way, way.size() / 2, way.size()), 0.15) << "in the rooms that only uav1 has seen";
  EXPECT_GT(poses_, way.size() * 4 / 10);
  EXPECT_EQ(client_.map.header.frame_id, "world");
}

TEST_F(FollowMerged, AnotherFileIsNotUsed) {
  folder_.write("merged.session", "half a session");
  MapperProcess node(parameters());
  ASSERT_TRUE(client_.connect());
  fly(building::tour(0, 0), 0, 3);
  EXPECT_EQ(poses_, 0U);
  saveMerged(file_, {building::tour(0, 1)});
  ASSERT_TRUE(mapHas(1000));
  fly(building::tour(0, 0), 3, 30);
  EXPECT_GT(poses_, 0U);
}

TEST_F(FollowMerged, NeedsASessionToLocalizeIn) {
  EXPECT_NE(MapperProcess({"_follow_session:=true"}).wait(), 0);
  EXPECT_NE(MapperProcess({"_follow_session:=true", "_session:=" + file_}).wait(), 0);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "follow_merged_test");
  const ros::NodeHandle started;  // the fixtures use the time of ROS
  return RUN_ALL_TESTS();
}
