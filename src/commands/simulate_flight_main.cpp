// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/recording/bag/bag_flight_writer.h"
#include "kestrel_slam/recording/simulated_recording.h"
#include "kestrel_slam/recording/trajectory.h"
#include "kestrel_slam/simulation/flight_plan.h"
#include "kestrel_slam/simulation/flight_simulator.h"

namespace kestrel {
namespace {

struct Options {
  std::string world = "laboratory";
  std::string sensor = "utm30lx";
  std::string lidar;
  std::uint64_t seed = 1;
  double rate_hz = 0.0;   // 0: the rate of the sensor model
  double random_s = 0.0;  // 0: the standard flight of the world
  double jitter_s = 0.0;
  double loss = 0.0;
  bool level = false;
  bool raw_imu = false;
  std::string output;
  std::string truth;
  bool list = false;
};

void declareSensors(CLI::App& app, Options& options) {
  constexpr double kMinRate = 0.1, kMaxRate = 1000.0;  // Hz
  constexpr double kMaxJitter = 10.0;                  // s
  app.add_option("--sensor", options.sensor, "laser or lidar, see --list")->capture_default_str();
  app.add_option("--lidar", options.lidar, "additional 3D lidar, see --list");
  app.add_option("--rate", options.rate_hz, "scans per second (default: as the sensor)")
      ->check(CLI::Range(kMinRate, kMaxRate));
  app.add_flag("--raw-imu", options.raw_imu, "simulate an IMU without orientation");
  app.add_option("--jitter", options.jitter_s, "standard deviation of the error of the stamps, s")
      ->check(CLI::Range(0.0, kMaxJitter));
  app.add_option("--loss", options.loss, "probability that a message is lost")
      ->check(CLI::Range(0.0, 1.0));
}

void declareOptions(CLI::App& app, Options& options) {
  constexpr double kMinDuration = 1.0, kMaxDuration = 3600.0;  // s
  app.add_option("--world", options.world, "world of the flight, see --list")
      ->capture_default_str();
  declareSensors(app, options);
  app.add_option(
         "--random", options.random_s,
         "fly a random path for about this time instead of the standard path of the world, s")
      ->check(CLI::Range(kMinDuration, kMaxDuration));
  app.add_flag("--level", options.level, "same path with zero roll and pitch");
  app.add_option("--seed", options.seed,
                 "seed of wind, noise and random path; the same seed gives the same recording")
      ->capture_default_str();
  auto* output = app.add_option("--output", options.output, "bag to write");
  app.add_option("--truth", options.truth,
                 "also write the true poses at the stamps of the scans to this file (TUM format)");
  app.add_flag("--list", options.list, "print worlds and sensors and exit")->excludes(output);
}

template <typename T>
void printList(const char* title, const std::vector<T>& items) {
  std::printf("%s\n", title);
  for (const T& item : items)
    std::printf("  %-12s %s\n", item.name.c_str(), item.description.c_str());
}

VehicleModel vehicleOf(const Options& options) {
  VehicleModel vehicle = quadrotorWith(options.sensor);
  if (!options.lidar.empty()) {
    const VehicleModel other = quadrotorWith(options.lidar);
    if (!other.lidar) {
      throw std::invalid_argument("'" + options.lidar +
                                  "' is not a lidar; select it with --sensor");
    }
    vehicle.lidar = other.lidar;
  }
  if (options.rate_hz > 0.0 && vehicle.laser) vehicle.laser->rate_hz = options.rate_hz;
  if (options.rate_hz > 0.0 && !vehicle.laser) vehicle.lidar->rate_hz = options.rate_hz;
  vehicle.imu->gives_orientation = !options.raw_imu;
  vehicle.stamp_jitter_s = options.jitter_s;
  vehicle.loss_probability = options.loss;
  return vehicle;
}

double lengthOf(const Motion& motion) {
  constexpr double kStep = 0.01;  // s
  double length = 0.0;
  for (double t = 0.0; t < motion.duration(); t += kStep) {
    length += motion.at(t).velocity.norm() * kStep;
  }
  return length;
}

void fly(const Options& options) {
  Place chosen = place(options.world);
  chosen.quadrotor.level = options.level;
  if (options.random_s > 0.0) chosen.plan = randomPlan(chosen, options.random_s, options.seed);
  const VehicleModel vehicle = vehicleOf(options);
  const World world(chosen.parts);
  const auto motion = flyQuadrotor(chosen.plan, chosen.quadrotor, options.seed);
  FlightSimulator flight(world, *motion, vehicle, options.seed);
  const FlightBagSummary summary = writeFlightBag(options.output, flight, vehicle);
  if (!options.truth.empty()) {
    Trajectory truth;
    for (const double stamp : summary.scan_stamps) {
      truth.push_back({stamp, truePose(*motion, stamp)});
    }
    writeTum(options.truth, truth);
  }
  std::printf("%s: %zu scans, %zu messages, %.1f m in %.1f s\n", options.output.c_str(),
              summary.scan_stamps.size(), summary.messages, lengthOf(*motion), motion->duration());
}

void check(const Options& options) {
  if (!options.list && options.output.empty()) throw CLI::RequiredError("--output");
}

void run(const Options& options) {
  if (!options.list) return fly(options);
  printList("worlds:", places());
  printList("sensors, 2D lasers:", laserModels());
  printList("sensors, 3D lidars:", lidarModels());
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  Options options;
  CLI::App app("Simulates a flight of a quadrotor and writes the data of its sensors to a rosbag.");
  declareOptions(app, options);
  return runTool(
      "simulate_flight", app, argc, argv, [&] { run(options); }, [&] { check(options); });
}
