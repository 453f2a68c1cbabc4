// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/gravity.h"
#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/recording/simulated_recording.h"

namespace kestrel {
namespace {

/// A simulated flight whose IMU or laser has a fault.
class FaultyFlight : public Recording {
 public:
  using ImuFaultOf = std::function<void(ImuSample&)>;
  using ScanFaultOf = std::function<void(RecordedScan&)>;

  explicit FaultyFlight(const ImuFaultOf& imu_fault, ScanFaultOf scan_fault = nullptr)
      : flight_(place("laboratory"), quadrotorWith("utm30lx"), 1),
        scan_fault_(std::move(scan_fault)) {
    imu_ = flight_.imu();
    heights_ = flight_.heights();
    for (ImuSample& sample : imu_.samples) imu_fault(sample);
  }

  bool next(RecordedScan& scan) override {
    if (!flight_.next(scan)) return false;
    if (scan_fault_) scan_fault_(scan);
    return true;
  }
  std::size_t scanCount() const override { return flight_.scanCount(); }
  std::string description() const override { return flight_.description(); }
  bool hasOdometry() const override { return false; }
  const Trajectory& truth() const { return flight_.truth(); }

 private:
  SimulatedRecording flight_;
  ScanFaultOf scan_fault_;
};

OfflineRun map(FaultyFlight& flight) {
  RunOptions options;
  options.max_scans = 800;  // 20 s
  options.use_filter = true;
  return runOffline(flight, SlamConfig(), options);
}

std::string warningsOf(const OfflineRun& run) {
  std::string text;
  for (const std::string& warning : run.warnings) text += warning + "\n";
  return text;
}

double endError(const OfflineRun& run, const FaultyFlight& flight) {
  const std::size_t last = run.trajectory.size() - 1;
  const Pose2 truth = flight.truth()[0].pose.inverse() * flight.truth()[last].pose;
  return (run.trajectory[last].pose.inverse() * truth).distance();
}

struct Case {
  const char* name;
  FaultyFlight::ImuFaultOf fault;
  const char* expected;  ///< part of a warning
};

void scaleForce(ImuSample& sample, double factor) { *sample.linear_acceleration *= factor; }

std::vector<Case> cases() {
  return {
      {"degrees", [](ImuSample& s) { *s.angular_velocity *= radToDeg(1.0); }, "degrees per second"},
      {"g", [](ImuSample& s) { scaleForce(s, 1.0 / kGravity); }, "it seems to be in g"},
      {"no accelerometer", [](ImuSample& s) { scaleForce(s, 0.0); }, "the IMU's accelerometer"},
      {"no gyro", [](ImuSample& s) { s.angular_velocity->setZero(); }, "gyro reads zero"},
      {"without gravity",
       [](ImuSample& s) {
         *s.linear_acceleration -= s.world_R_imu->conjugate() * Eigen::Vector3d(0.0, 0.0, kGravity);
       },
       "without gravity"},
      {"orientation not filled",
       [](ImuSample& s) { s.world_R_imu = Eigen::Quaterniond::Identity(); },
       "orientation stands still"},
      {"forward-right-down",
       [](ImuSample& s) {
         const Eigen::Quaterniond flip(0.0, 1.0, 0.0, 0.0);
         s.world_R_imu = flip * *s.world_R_imu * flip.conjugate();
         s.angular_velocity = flip * *s.angular_velocity;
         s.linear_acceleration = flip * *s.linear_acceleration;
       },
       "forward-right-down"},
      {"late", [](ImuSample& s) { s.stamp += 0.25; }, "0.25 s later"},
      {"early", [](ImuSample& s) { s.stamp -= 0.25; }, "0.25 s earlier"},
  };
}

TEST(ImuFaults, AreSaidOffline) {
  for (const Case& fault : cases()) {
    FaultyFlight flight(fault.fault);
    const OfflineRun run = map(flight);
    EXPECT_NE(warningsOf(run).find(fault.expected), std::string::npos)
        << fault.name << ": " << warningsOf(run);
    RecordProperty(fault.name, std::to_string(endError(run, flight)));
  }
}

TEST(ImuFaults, AGoodFlightHasNoWarning) {
  FaultyFlight flight([](ImuSample&) {});
  const OfflineRun run = map(flight);
  EXPECT_EQ(warningsOf(run), "");
  EXPECT_LT(endError(run, flight), 0.05);
}

TEST(ImuFaults, TheMapIsRightWhereTheFaultCanBeRepaired) {
  for (const Case& fault : cases()) {
    const std::string name = fault.name;
    if (name != "degrees" && name != "no gyro" && name != "orientation not filled") continue;
    FaultyFlight flight(fault.fault);
    EXPECT_LT(endError(map(flight), flight), 0.1) << name;
  }
}

TEST(ImuFaults, ARawGyroInDegreesIsFoundByTheScans) {
  FaultyFlight flight([](ImuSample& s) {
    s.world_R_imu.reset();
    *s.angular_velocity *= radToDeg(1.0);
  });
  EXPECT_NE(warningsOf(map(flight)).find("degrees per second"), std::string::npos);
}

TEST(ImuFaults, ALaserThatIsUpsideDownUnlikeInTfIsFound) {
  FaultyFlight flight(
      [](ImuSample&) {},
      [](RecordedScan& scan) { std::reverse(scan.scan.ranges.begin(), scan.scan.ranges.end()); });
  EXPECT_NE(warningsOf(map(flight)).find("opposite directions"), std::string::npos);
}

TEST(OdometryFaults, AnOppositeTurnIsFound) {
  FaultyFlight flight([](ImuSample&) {});
  std::size_t i = 0;
  FaultyFlight mirrored([](ImuSample&) {},
                        [&](RecordedScan& scan) {
                          scan.odom_T_base = flight.truth()[i++].pose;
                          scan.odom_T_base->yaw *= -1.0;
                        });
  RunOptions options;
  options.max_scans = 800;
  options.use_imu = false;
  options.use_odometry = true;
  const OfflineRun run = runOffline(mirrored, SlamConfig(), options);
  EXPECT_NE(warningsOf(run).find("odometry and scan turn in opposite"), std::string::npos)
      << warningsOf(run);
}

}  // namespace
}  // namespace kestrel
