// SPDX-License-Identifier: BSD-3-Clause
// Maps scans of a simulated laser that moves through a room, without ROS.
#include <cstdio>

#include "kestrel_slam/pipeline/pipeline.h"
#include "kestrel_slam/simulation/motion.h"
#include "kestrel_slam/simulation/sensor_models.h"
#include "kestrel_slam/simulation/world.h"

using namespace kestrel;

namespace {

/// A straight line at 0.5 m/s for four seconds, 1 m above the floor.
class StraightLine : public Motion {
 public:
  double duration() const override { return 4.0; }
  TrueState at(double time) const override {
    TrueState state;
    state.world_T_base.translation() = Eigen::Vector3d(0.5 * time, 0.0, 1.0);
    return state;
  }
};

/// A room of 8 m x 6 m with a pillar.
World room() {
  World::Parts parts;
  for (const double side : {-1.0, 1.0}) {
    parts.boxes.push_back({{1.0, 3.0 * side, 1.5}, {8.0, 0.2, 3.0}});
    parts.boxes.push_back({{1.0 + 4.0 * side, 0.0, 1.5}, {0.2, 6.0, 3.0}});
  }
  parts.cylinders.push_back({{2.0, 1.5}, 0.3});
  return World(parts);
}

}  // namespace

int main() {
  const Eigen::Isometry3d base_T_laser = Eigen::Isometry3d::Identity();
  const LaserModel& laser = laserModel("utm30lx");
  const World world = room();
  const StraightLine motion;
  Random random(1);

  PipelineConfig config;
  config.level = true;  // there is no IMU
  Pipeline pipeline(config);
  pipeline.on_scan = [](const MappedSweep& sweep) {
    const Pose2& pose = sweep.result.pose;
    std::printf("%.1f s: %s, x %.3f m, y %.3f m, yaw %.3f rad\n", sweep.scan.stamp,
                toString(sweep.result.state), pose.x, pose.y, pose.yaw);
  };
  for (int i = 0; i <= 40; ++i) {
    const double time = 0.1 * i;
    PipelineScan scan;
    scan.data = sweep(laser, world, motion, base_T_laser, time, random);
    scan.base_T_laser = base_T_laser;
    pipeline.addScan(scan, time);
  }
  pipeline.finish();
  const Pose2 end(motion.at(motion.duration()).world_T_base.translation().x(), 0.0, 0.0);
  const double error_m = (end.inverse() * pipeline.mapper().pose()).distance();
  std::printf("error at the end: %.3f m\n", error_m);
  return error_m < 0.05 ? 0 : 1;
}
