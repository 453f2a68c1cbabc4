// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/offline/offline_run.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "kestrel_slam/sensor/projection.h"
#include "room_log.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

/// The room flight with optional errors for a test.
class RoomRecording : public Recording {
 public:
  explicit RoomRecording(int scans) : scans_(scans) {}

  bool next(RecordedScan& scan) override {
    if (i_ == breaks_at) throw std::runtime_error("the file is cut off");
    if (i_ == scans_) return false;
    scan = RecordedScan();
    scan.scan = RoomFlight::scan(i_);
    if (i_ == invalid_at) {
      scan.scan.ranges.assign(scan.scan.ranges.size(), std::numeric_limits<float>::quiet_NaN());
    }
    scan.scan.time_increment = time_increment;
    for (float& range : scan.scan.ranges) range *= static_cast<float>(range_factor);
    scan.time = scan.scan.stamp;
    if (i_ == late_stamp_at) scan.scan.stamp -= 0.9;
    if (i_ != no_odometry_at) scan.odom_T_base = Pose2(RoomFlight::x(i_), 0.0, 0.0);
    ++i_;
    return true;
  }
  std::size_t scanCount() const override { return static_cast<std::size_t>(scans_); }
  std::string description() const override { return "a room"; }
  bool hasOdometry() const override { return true; }

  void skip(const std::string& reason, std::size_t count) { skipped_[reason] = count; }
  void warn(const std::string& warning) { warnings_.push_back(warning); }

  double time_increment = 0.0, range_factor = 1.0;
  int breaks_at = -1, invalid_at = -1, late_stamp_at = -1, no_odometry_at = -1;

 private:
  int scans_;
  int i_ = 0;
};

TEST(OfflineRunTest, FollowsAFlightThroughARoom) {
  RoomRecording recording(41);
  const OfflineRun run = runOffline(recording, SlamConfig(), RunOptions());
  ASSERT_EQ(run.trajectory.size(), 41U);
  ASSERT_EQ(run.scans.size(), 41U);
  EXPECT_NEAR(run.trajectory.back().pose.x, 2.0, 0.03);
  EXPECT_NEAR(run.trajectory.back().pose.y, 0.0, 0.03);
  EXPECT_NEAR(run.distance_m, 2.0,
              0.15);  // sum of full steps; the last partial step is not counted
  EXPECT_NEAR(run.duration_s, 4.0, 1e-9);
  EXPECT_EQ(run.droppedCount(), 0U);
  EXPECT_TRUE(run.warnings.empty()) << run.warnings.front();
  EXPECT_TRUE(run.scans.front().inserted);
  EXPECT_FALSE(run.map.empty());
  EXPECT_GT(run.map_memory_bytes, 0U);
  EXPECT_GT(run.peak_memory_mb, 1.0);
  EXPECT_GT(run.speedFactor(), 1.0);
}

TEST(OfflineRunTest, TheTrajectoryKeepsTheRecordedStamps) {
  RoomRecording recording(5);
  recording.late_stamp_at = 3;
  const OfflineRun run = runOffline(recording, SlamConfig(), RunOptions());
  ASSERT_EQ(run.trajectory.size(), 5U);
  EXPECT_EQ(run.trajectory[2].stamp, RoomFlight::stamp(2));
  EXPECT_EQ(run.trajectory[3].stamp, RoomFlight::stamp(3) - 0.9);
  EXPECT_EQ(run.scans[3].time, RoomFlight::stamp(3));
}

TEST(OfflineRunTest, AScanWithoutValidBeamsIsDroppedAndCounted) {
  RoomRecording recording(10);
  recording.invalid_at = 4;
  const OfflineRun run = runOffline(recording, SlamConfig(), RunOptions());
  EXPECT_EQ(run.trajectory.size(), 9U);
  const std::map<std::string, std::size_t> expected = {{toString(ScanError::kNoValidBeam), 1}};
  EXPECT_EQ(run.dropped, expected);
  ASSERT_EQ(run.warnings.size(), 1U);
  EXPECT_CONTAINS(run.warnings[0],
                  "scans dropped (" + std::string(toString(ScanError::kNoValidBeam)));
  EXPECT_CONTAINS(run.warnings[0], "at 0.4 s (scan 5)");
}

TEST(OfflineRunTest, ScansSkippedByTheRecordingAreCountedToo) {
  RoomRecording recording(3);
  recording.skip("broken line", 2);
  recording.warn("line 7 is broken");
  const OfflineRun run = runOffline(recording, SlamConfig(), RunOptions());
  EXPECT_EQ(run.droppedCount(), 2U);
  EXPECT_EQ(run.dropped.at("broken line"), 2U);
  EXPECT_EQ(run.warnings, std::vector<std::string>{"line 7 is broken"});
}

TEST(OfflineRunTest, AReadErrorKeepsTheScansBeforeIt) {
  RoomRecording recording(10);
  recording.breaks_at = 6;
  const OfflineRun run = runOffline(recording, SlamConfig(), RunOptions());
  EXPECT_EQ(run.trajectory.size(), 6U);
  EXPECT_FALSE(run.map.empty());
  EXPECT_EQ(run.warnings,
            std::vector<std::string>{
                "the recording ends with an error after 6 scans: the file is cut off"});
}

TEST(OfflineRunTest, TheCallbackSeesEveryScanAndCanStop) {
  RoomRecording recording(10);
  std::vector<std::size_t> done;
  const OfflineRun run =
      runOffline(recording, SlamConfig(), RunOptions(), [&](const OfflineProgress& progress) {
        EXPECT_EQ(progress.total, 10U);
        done.push_back(progress.done);
        return progress.done < 4;
      });
  EXPECT_EQ(done, (std::vector<std::size_t>{1, 2, 3, 4}));
  EXPECT_EQ(run.trajectory.size(), 4U);
  EXPECT_EQ(run.warnings, std::vector<std::string>{"stopped early, after 4 of 10 scans"});
}

TEST(OfflineRunTest, MissingOdometryIsReportedOnlyWhereItIsUsed) {
  RoomRecording with(10), without(10);
  with.no_odometry_at = without.no_odometry_at = 5;
  RunOptions options;
  options.use_odometry = true;
  const OfflineRun used = runOffline(with, SlamConfig(), options);
  EXPECT_EQ(used.warnings,
            std::vector<std::string>{"1 of 10 scans had no odometry and were matched with the "
                                     "laser only, the first at 0.5 s (scan 6)"});
  EXPECT_TRUE(runOffline(without, SlamConfig(), RunOptions()).warnings.empty());
}

TEST(OfflineRunTest, APerturbedRunRemovesTheChosenScans) {
  RoomRecording recording(20);
  RunOptions options;
  options.perturbation.skip_scans = 3;
  options.perturbation.drop_every = 7;
  const OfflineRun run = runOffline(recording, SlamConfig(), options);
  ASSERT_EQ(run.trajectory.size(), 15U);
  EXPECT_EQ(run.left_out, 5U);  // scans 1 to 3, 7 and 14
  EXPECT_EQ(run.droppedCount(), 0U);
  EXPECT_EQ(run.trajectory.front().stamp, RoomFlight::stamp(3));
  EXPECT_EQ(run.trajectory.front().pose, Pose2());
  EXPECT_EQ(run.trajectory[3].stamp, RoomFlight::stamp(7));
  EXPECT_EQ(run.trajectory[9].stamp, RoomFlight::stamp(14));
}

TEST(OfflineRunTest, TheObserverSeesEveryProcessedScanUpToTheLimit) {
  RoomRecording recording(20);
  RunOptions options;
  options.max_scans = 6;
  options.perturbation.drop_every = 5;
  std::vector<double> seen, poses;
  options.observer = [&](const PlanarScan& scan, const MapperResult& result) {
    seen.push_back(scan.stamp);
    poses.push_back(result.pose.x);
  };
  const OfflineRun run = runOffline(recording, SlamConfig(), options);
  ASSERT_EQ(run.trajectory.size(), 5U);
  EXPECT_TRUE(run.warnings.empty());
  for (std::size_t i = 0; i < run.trajectory.size(); ++i) {
    EXPECT_EQ(seen.at(i), run.trajectory[i].stamp);
    EXPECT_EQ(poses.at(i), run.trajectory[i].pose.x);
  }
}

TEST(OfflineRunTest, AnEmptyRecordingGivesAnEmptyRun) {
  RoomRecording recording(0);
  const OfflineRun run = runOffline(recording, SlamConfig(), RunOptions());
  EXPECT_TRUE(run.trajectory.empty());
  EXPECT_TRUE(run.map.empty());
  EXPECT_EQ(run.duration_s, 0.0);
  EXPECT_EQ(run.distance_m, 0.0);
}

TEST(OfflineRunTest, ATimeIncrementInNanosecondsIsIgnoredWithAWarning) {
  RoomRecording recording(41);
  recording.time_increment = 277778.0;
  const OfflineRun run = runOffline(recording, SlamConfig(), RunOptions());
  EXPECT_NEAR(run.trajectory.back().pose.x, 2.0, 0.03);
  ASSERT_EQ(run.warnings.size(), 1U);
  EXPECT_CONTAINS(run.warnings[0],
                  "41 of 41 scans (time-increment), the first at 0.0 s (scan 1): time_increment "
                  "277778 s makes a sweep of 4.97223e+07 s: nanoseconds?");
}

TEST(OfflineRunTest, TheMostFrequentReasonIsTheMainProblem) {
  RoomRecording recording(41);
  recording.range_factor = 1000.0;
  recording.invalid_at = 0;
  recording.warn("the bag has no tf");
  const OfflineRun run = runOffline(recording, SlamConfig(), RunOptions());
  EXPECT_TRUE(run.scans.empty());
  EXPECT_CONTAINS(run.mainProblem(), "40 of 41 dropped (wrong-unit): ");
  EXPECT_CONTAINS(run.mainProblem(), "millimeters?");
}

TEST(OfflineRunTest, AReasonOfTheRecordingIsExplainedByItsWarning) {
  RoomRecording recording(0);
  recording.skip("no transform", 7);
  recording.warn("a line is broken");
  recording.warn("7 scans have no transform from laser to base_link");
  const OfflineRun run = runOffline(recording, SlamConfig(), RunOptions());
  EXPECT_EQ(run.mainProblem(),
            "7 of 7 dropped (no transform): 7 scans have no transform from laser to base_link");
}

}  // namespace
}  // namespace kestrel
