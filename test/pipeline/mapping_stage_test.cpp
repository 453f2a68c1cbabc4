// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/pipeline/mapping_stage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "kestrel_slam/sensor/scan_projector.h"
#include "room_log.h"

namespace kestrel {
namespace {

constexpr double kSpeed = 0.5;   // m/s
constexpr double kStart = 1e9;   // s
constexpr double kFlight = 4.0;  // s

/// A scan of a laser on a vehicle that flies at a constant speed.
struct Sweep {
  double stamp, arrival;
  std::string source;
};

PlanarScan scanOf(const Sweep& sweep) {
  LaserScan scan = RoomFlight::scan(0);
  scan.stamp = sweep.stamp;
  scan.frame = sweep.source;
  const double x = kSpeed * (sweep.stamp - kStart);
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const double angle = scan.angle_min + scan.angle_increment * static_cast<double>(i);
    scan.ranges[i] = static_cast<float>(RoomFlight::range(x, angle));
  }
  return ScanProjector(ProjectorConfig()).project(scan, Eigen::Isometry3d::Identity()).scan;
}

/// A laser at 40 Hz, and one at `rate_hz` whose scans arrive `delay_s` after their stamps.
std::vector<Sweep> twoLasers(double rate_hz, double delay_s, double offset_s) {
  std::vector<Sweep> sweeps;
  for (double t = 0.0; t < kFlight; t += 0.025) {
    sweeps.push_back({kStart + t, kStart + t, "front"});
  }
  for (double t = offset_s; t < kFlight - delay_s; t += 1.0 / rate_hz) {
    sweeps.push_back({kStart + t, kStart + t + delay_s, "back"});
  }
  std::stable_sort(sweeps.begin(), sweeps.end(),
                   [](const Sweep& a, const Sweep& b) { return a.arrival < b.arrival; });
  return sweeps;
}

void expectRightMotion(const std::vector<Sweep>& sweeps) {
  MappingStage stage{MapperConfig()};
  for (const Sweep& sweep : sweeps) {
    PlanarScan scan = scanOf(sweep);
    const MapperResult result = stage.process(scan, std::nullopt);
    EXPECT_EQ(scan.time, sweep.stamp) << sweep.source;
    const double flown = sweep.stamp - kStart;
    EXPECT_NEAR(result.pose.x, kSpeed * flown, 0.02) << sweep.source << " " << flown;
    if (flown > 1.0) {
      EXPECT_NEAR(result.velocity.x(), kSpeed, 0.15) << sweep.source << " " << flown;
    }
  }
}

TEST(MappingStage, LasersWithEqualStamps) { expectRightMotion(twoLasers(40.0, 0.0, 0.0)); }

TEST(MappingStage, AFastAndASlowLaser) { expectRightMotion(twoLasers(10.0, 0.0, 0.01)); }

TEST(MappingStage, ASlowLaserWhoseScansArriveLate) {
  expectRightMotion(twoLasers(10.0, 0.1, 0.003));
}

TEST(MappingStage, OneLaserThatRepeatsItsStamps) {
  MappingStage stage{MapperConfig()};
  double last = 0.0;
  for (int i = 0; i < 100; ++i) {
    PlanarScan scan = scanOf({kStart + 0.1 * i, 0.0, "front"});
    scan.stamp = kStart + 0.1 * (i / 2 * 2);
    stage.process(scan, std::nullopt);
    EXPECT_GT(scan.time, last);
    last = scan.time;
  }
  EXPECT_NEAR(last, kStart + 9.9, 0.3);
}

}  // namespace
}  // namespace kestrel
