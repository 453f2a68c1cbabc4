#include <CLI/CLI.hpp>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "kestrel_slam/tools/bag_flight_writer.h"
#include "kestrel_slam/tools/simulator.h"
#include "kestrel_slam/tools/trajectory.h"

namespace kestrel_slam {
namespace {

constexpr int kBadInput = 1;
constexpr int kWrongUsage = 2;

struct Options {
  std::string world = "laboratory";
  std::string sensor = "utm30lx";
  std::uint64_t seed = 1;
  double rate_hz = 0.0;  // 0: the sensor's own
  std::string output;
  std::string truth;
  bool list = false;
};

void declareOptions(CLI::App& app, Options& options) {
  constexpr double kMinRate = 0.1, kMaxRate = 1000.0;  // Hz
  app.add_option("--world", options.world, "where to fly, see --list")->capture_default_str();
  app.add_option("--sensor", options.sensor, "the laser, see --list")->capture_default_str();
  app.add_option("--seed", options.seed, "of the noise; the same seed gives the same recording")
      ->capture_default_str();
  app.add_option("--rate", options.rate_hz, "scans per second instead of the sensor's own rate")
      ->check(CLI::Range(kMinRate, kMaxRate));
  auto* output = app.add_option("--output", options.output, "the bag to write");
  app.add_option("--truth", options.truth, "also write the true trajectory in TUM format");
  app.add_flag("--list", options.list, "show worlds and sensors, and stop")->excludes(output);
}

template <typename T>
void printList(const char* title, const std::vector<T>& items) {
  std::printf("%s\n", title);
  for (const T& item : items)
    std::printf("  %-12s %s\n", item.name.c_str(), item.description.c_str());
}

void run(const Options& options) {
  const SimulatedWorld& world = simulatedWorld(options.world);
  LaserModel laser = laserModel(options.sensor);
  if (options.rate_hz > 0.0) laser.rate_hz = options.rate_hz;
  const FlightPath path = world.flight();
  const std::vector<SimulatedScan> flight = simulate(world.walls, laser, path, options.seed);
  writeFlightBag(options.output, flight, laser.base_T_laser);
  if (!options.truth.empty()) {
    Trajectory truth;
    for (const SimulatedScan& step : flight) {
      truth.push_back({step.scan.stamp, step.world_T_base});
    }
    writeTum(options.truth, truth);
  }
  std::printf("%s: %zu scans, %.1f m in %.1f s\n", options.output.c_str(), flight.size(),
              path.length(), path.duration());
}

}  // namespace
}  // namespace kestrel_slam

int main(int argc, char** argv) {
  using namespace kestrel_slam;
  Options options;
  CLI::App app("Simulates a flight with a 2D laser and writes it as a rosbag.");
  declareOptions(app, options);
  try {
    app.parse(argc, argv);
    if (!options.list && options.output.empty()) throw CLI::RequiredError("--output");
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kWrongUsage;
  }
  if (options.list) {
    printList("worlds:", simulatedWorlds());
    printList("sensors:", laserModels());
    return 0;
  }
  try {
    run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "simulate_flight: %s\n", error.what());
    return kBadInput;
  }
  return 0;
}
