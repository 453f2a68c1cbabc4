// SPDX-License-Identifier: BSD-3-Clause
// Recordings of a standing laser with a walker, and of a robot that drives where nobody is.

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>

#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/recording/recording.h"
#include "kestrel_slam/tracking/continuous_pose.h"
#include "kestrel_slam/tracking/tracker.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

struct Shown {
  std::map<long, std::size_t> scans;  ///< of each track
  std::size_t longest() const {
    std::size_t most = 0;
    for (const auto& [id, count] : scans) most = std::max(most, count);
    return most;
  }
};

Shown shownIn(const std::string& path) {
  Shown shown;
  Tracker tracker;
  ContinuousPose continuous;
  RunOptions options;
  options.sweep_observer = [&](const MappedSweep& sweep) {
    const bool may_jump = sweep.result.searched || sweep.result.state == MatchState::kLost;
    const Pose2 pose = continuous.add(sweep.scan.time, sweep.result.pose, may_jump);
    for (const Track& track : tracker.process(sweep.scan, pose).tracks) {
      if (track.isShown()) ++shown.scans[track.id];
    }
  };
  runOffline(*openRecording(path), SlamConfig(), options);
  return shown;
}

TEST(Walkers, NobodyGivesNoTrack) {
  SKIP_WITHOUT_DATA(dataFolder());
  EXPECT_TRUE(shownIn(dataFolder() + "/legs/negative_2.bag").scans.empty());
}

// 400 scans. The walker goes away along a corridor that is longer than the range, and comes back.
TEST(Walkers, WalkerInACorridorKeepsItsIdentity) {
  SKIP_WITHOUT_DATA(dataFolder());
  EXPECT_GT(shownIn(dataFolder() + "/legs/positive_1.bag").longest(), 260U);
}

}  // namespace
}  // namespace kestrel
