// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/recording/simulated_recording.h"
#include "kestrel_slam/sensor/scan_projector.h"
#include "temporary_folder.h"

namespace kestrel {

/// Some scans of one laser, as the mapper gets them.
struct LaserScans {
  std::string name;
  std::size_t beams = 0;  ///< of one scan
  std::vector<PlanarScan> scans;
  std::vector<Pose2> poses;  ///< true poses of the base in flights; empty for recordings
};

constexpr std::size_t kScansPerLaser = 20;

/// The scan that starts at `time` (s since the start), projected with the true attitude, height and
/// velocity.
inline PlanarScan flownScan(const LaserModel& laser, const SimulatedRecording& flight,
                            const Eigen::Isometry3d& base_T_laser, double time, Random& random) {
  constexpr double kStepS = 0.005, kMarginS = 0.3;
  const Motion& motion = flight.motion();
  AttitudeBuffer attitude;
  for (double t = time - kMarginS; t < time + kMarginS; t += kStepS) {
    const TrueState state = motion.at(t);
    attitude.add(t, Eigen::Quaterniond(state.world_T_base.rotation()), state.angular_velocity);
  }
  const TrueState state = motion.at(time);
  const double yaw = truePose(motion, kFlightStart + time).yaw;
  VehicleState vehicle;
  vehicle.attitude = &attitude;
  vehicle.height_m = state.world_T_base.translation().z();
  vehicle.velocity = Pose2(0.0, 0.0, -yaw) * Eigen::Vector2d(state.velocity.head<2>());
  ScanProjector projector{ProjectorConfig()};
  const LaserScan scan = sweep(laser, flight.world(), motion, base_T_laser, time, random);
  return projector.project(scan, base_T_laser, vehicle).scan;
}

inline LaserScans flownScans(const std::string& place_name, const std::string& laser) {
  const VehicleModel vehicle = quadrotorWith(laser);
  const SimulatedRecording flight(place(place_name), vehicle, 1);
  LaserScans result{laser + " flown in " + place_name, 0, {}, {}};
  result.beams = static_cast<std::size_t>(vehicle.laser->beams);
  Random random(3);
  for (std::size_t i = 0; i < kScansPerLaser; ++i) {
    const double time = flight.motion().duration() * static_cast<double>(i) / kScansPerLaser;
    result.scans.push_back(flownScan(*vehicle.laser, flight, vehicle.base_T_laser, time, random));
    result.poses.push_back(truePose(flight.motion(), kFlightStart + time));
  }
  return result;
}

/// Each scan consists of two, the second one of a laser that is mounted elsewhere.
inline LaserScans joined(const LaserScans& scans) {
  LaserScans result{"two lasers, " + scans.name, 2 * scans.beams, scans.scans, {}};
  const Eigen::Vector2f behind(-0.4F, 0.1F);
  for (PlanarScan& scan : result.scans) {
    const std::size_t rays = scan.rays.size();
    for (std::size_t i = 0; i < rays; ++i) {
      PlanarRay ray = scan.rays[i];
      ray.origin = behind - ray.origin;
      ray.end = behind - ray.end;
      scan.rays.push_back(ray);
    }
  }
  return result;
}

inline LaserScans recordedScans(const std::string& name, const std::string& path) {
  LaserScans result{name, 0, {}, {}};
  const std::unique_ptr<Recording> recording = openRecording(path);
  ScanProjector projector{ProjectorConfig()};
  const std::size_t step = recording->scanCount() / kScansPerLaser;
  RecordedScan recorded;
  for (std::size_t i = 0; recording->next(recorded); ++i) {
    if (i % step != 0) continue;
    result.beams = recorded.scan.ranges.size();
    result.scans.push_back(projector.project(recorded.scan, recorded.base_T_laser).scan);
  }
  return result;
}

/// Tilted and level, indoors and outdoors, moving and at rest, one laser and two. Recordings only
/// where they are.
inline const std::vector<LaserScans>& scansOfLasers() {
  static const std::vector<LaserScans> all = [] {
    std::vector<LaserScans> scans;
    for (const char* place : {"laboratory", "hall", "ring", "town"}) {
      scans.push_back(flownScans(place, "utm30lx"));
    }
    scans.push_back(joined(scans.front()));
    scans.push_back(flownScans("laboratory", "urg04lx"));
    scans.push_back(flownScans("town", "sick180"));
    for (const char* log : {"intel", "fr079"}) {
      const std::string path = dataFolder() + "/freiburg/" + log + ".clf.bz2";
      if (std::filesystem::exists(path)) scans.push_back(recordedScans(log, path));
    }
    return scans;
  }();
  return all;
}

}  // namespace kestrel
