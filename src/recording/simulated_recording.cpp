// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/simulated_recording.h"

#include <stdexcept>

#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/sensor/attitude_buffer.h"
#include "kestrel_slam/sensor/time_base.h"

namespace kestrel {
namespace {

/// The vehicle with only the scanner that is read. This does not change its messages, because they
/// do not depend on the other sensors.
VehicleModel scannerOnly(VehicleModel vehicle) {
  if (vehicle.laser) vehicle.lidar.reset();
  vehicle.imu.reset();
  vehicle.range_finder.reset();
  vehicle.barometer.reset();
  vehicle.truth_rate_hz = 0.0;
  return vehicle;
}

/// The vehicle with a scanner whose scans are empty, which avoids the expensive ray casting. Stamps
/// and all other messages are unchanged.
VehicleModel blindScanner(VehicleModel vehicle) {
  if (vehicle.laser) {
    vehicle.laser->beams = 0;
    if (vehicle.second_laser) vehicle.second_laser->beams = 0;
    vehicle.lidar.reset();
  }
  if (vehicle.lidar) vehicle.lidar->columns = 0;
  vehicle.barometer.reset();
  vehicle.truth_rate_hz = 0.0;
  return vehicle;
}

}  // namespace

Pose2 truePose(const Motion& motion, double stamp) {
  return toPose2(motion.at(stamp - kFlightStart).world_T_base);
}

struct SimulatedRecording::State {
  State(const Place& place, const VehicleModel& model, std::uint64_t seed)
      : name(place.name),
        world(place.parts),
        motion(flyQuadrotor(place.plan, place.quadrotor, seed)),
        vehicle(model),
        scans(world, *motion, scannerOnly(model), seed) {}

  std::string name;
  World world;
  std::unique_ptr<Motion> motion;
  VehicleModel vehicle;
  FlightSimulator scans;
  Trajectory truth;
  std::vector<TrueState> true_states;
  TimeBase time_base;
};

SimulatedRecording::SimulatedRecording(const Place& place, const VehicleModel& vehicle,
                                       std::uint64_t seed) {
  if (!vehicle.laser && !vehicle.lidar) {
    throw std::invalid_argument("a simulated recording needs a vehicle with a laser or a lidar");
  }
  state_ = std::make_unique<State>(place, vehicle, seed);
  imu_.base_T_imu = Eigen::Isometry3d(vehicle.base_R_imu);
  imu_.topic = vehicle.imu ? "simulated" : "";
  FlightSimulator first_pass(state_->world, *state_->motion, blindScanner(vehicle), seed);
  FlightEvent event;
  while (first_pass.next(event)) recordFirstPass(event);
}

SimulatedRecording::~SimulatedRecording() = default;

/// Stores the data that must be available before the first scan is read.
void SimulatedRecording::recordFirstPass(const FlightEvent& event) {
  if (const auto* sample = std::get_if<ImuSample>(&event.message)) {
    imu_.samples.push_back(*sample);
  } else if (const auto* height = std::get_if<HeightSample>(&event.message)) {
    heights_.push_back(*height);
  } else if (std::holds_alternative<LaserScan>(event.message) ||
             std::holds_alternative<PointCloud>(event.message)) {
    state_->true_states.push_back(state_->motion->at(event.stamp - kFlightStart));
    state_->truth.push_back({event.stamp, toPose2(state_->true_states.back().world_T_base)});
  }
}

bool SimulatedRecording::next(RecordedScan& scan) {
  FlightEvent event;
  while (state_->scans.next(event)) {
    if (readScan(event, scan)) return true;
  }
  return false;
}

bool SimulatedRecording::readScan(const FlightEvent& event, RecordedScan& scan) {
  scan = RecordedScan();
  if (const auto* sweep = std::get_if<LaserScan>(&event.message)) {
    scan.scan = *sweep;
    scan.scan.frame = event.second_laser ? "second_laser" : "laser";
    scan.base_T_laser =
        event.second_laser ? state_->vehicle.base_T_second_laser : state_->vehicle.base_T_laser;
  } else if (const auto* cloud = std::get_if<PointCloud>(&event.message)) {
    scan.cloud = *cloud;
    scan.scan.stamp = cloud->stamp;
    scan.base_T_laser = state_->vehicle.base_T_lidar;
  } else {
    return false;  // positions of people
  }
  scan.time = state_->time_base.repair(scan.scan.frame, event.stamp);
  return true;
}

std::size_t SimulatedRecording::scanCount() const { return state_->truth.size(); }

std::string SimulatedRecording::description() const {
  const VehicleModel& vehicle = state_->vehicle;
  return "simulated flight in " + state_->name + " with " +
         (vehicle.laser ? vehicle.laser->name : vehicle.lidar->name);
}

const Trajectory& SimulatedRecording::truth() const { return state_->truth; }
const std::vector<TrueState>& SimulatedRecording::trueStates() const { return state_->true_states; }
const World& SimulatedRecording::world() const { return state_->world; }
const Motion& SimulatedRecording::motion() const { return *state_->motion; }

}  // namespace kestrel
