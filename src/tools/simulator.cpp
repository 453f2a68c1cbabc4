#include "kestrel_slam/tools/simulator.h"

#include <cmath>
#include <limits>
#include <random>

namespace kestrel_slam {
namespace {

/// Random numbers that are the same on every platform: the standard fixes the generator, but not
/// the distributions.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : random_(seed) {}

  /// Uniform in [0, 1).
  double uniform() {
    constexpr int kUnusedBits = 64 - std::numeric_limits<double>::digits;
    return std::ldexp(static_cast<double>(random_() >> kUnusedBits),
                      -std::numeric_limits<double>::digits);
  }

  /// Normal with mean 0 and variance 1, up to six standard deviations: the sum of twelve uniform
  /// numbers, which needs no function that is rounded differently elsewhere.
  double gaussian() {
    constexpr int kTerms = 12;  // their variances of 1/12 add up to 1
    double sum = -kTerms / 2.0;
    for (int i = 0; i < kTerms; ++i) sum += uniform();
    return sum;
  }

 private:
  std::mt19937_64 random_;
};

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// The reading of one beam whose wall is `distance` away, with REP-117's special values.
float measure(double distance, const LaserModel& laser, Noise& noise) {
  // Both numbers are drawn for every beam, so that a far wall does not change the next beam.
  const bool dropped = noise.uniform() < laser.dropout_probability;
  const double error = laser.sigma_m * noise.gaussian();
  if (dropped) return std::numeric_limits<float>::quiet_NaN();
  double range = distance + error;
  if (!(range < laser.range_max)) return std::numeric_limits<float>::infinity();
  if (range < laser.range_min) return -std::numeric_limits<float>::infinity();
  if (laser.resolution_m > 0.0) range = std::round(range / laser.resolution_m) * laser.resolution_m;
  return static_cast<float>(range);
}

LaserScan emptyScan(const LaserModel& laser) {
  LaserScan scan;
  scan.angle_min = laser.angle_min;
  scan.angle_increment = laser.angle_increment;
  scan.time_increment = laser.time_increment;
  scan.range_min = laser.range_min;
  scan.range_max = laser.range_max;
  scan.ranges.reserve(static_cast<std::size_t>(laser.beams));
  return scan;
}

LaserScan sweep(const std::vector<Wall>& walls, const LaserModel& laser, const FlightPath& flight,
                double time, Noise& noise) {
  LaserScan scan = emptyScan(laser);
  Pose2 world_T_laser = flight.at(time) * laser.base_T_laser;
  for (int i = 0; i < laser.beams; ++i) {
    if (laser.time_increment > 0.0) {
      world_T_laser = flight.at(time + i * laser.time_increment) * laser.base_T_laser;
    }
    const double angle = world_T_laser.theta + laser.angle_min + i * laser.angle_increment;
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    const double distance = castRay(walls, world_T_laser.translation(), direction);
    scan.ranges.push_back(measure(distance, laser, noise));
  }
  return scan;
}

}  // namespace

double castRay(const std::vector<Wall>& walls, const Eigen::Vector2d& origin,
               const Eigen::Vector2d& direction) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Wall& wall : walls) {
    const Eigen::Vector2d along = wall.to - wall.from;
    const Eigen::Vector2d to_wall = wall.from - origin;
    const double denominator = cross(direction, along);
    if (denominator == 0.0) continue;  // parallel: seen edge on
    const double distance = cross(to_wall, along) / denominator;
    const double fraction = cross(to_wall, direction) / denominator;
    if (distance >= 0.0 && distance < nearest && fraction >= 0.0 && fraction <= 1.0) {
      nearest = distance;
    }
  }
  return nearest;
}

std::vector<SimulatedScan> simulate(const std::vector<Wall>& walls, const LaserModel& laser,
                                    const FlightPath& flight, std::uint64_t seed) {
  Noise noise(seed);
  std::vector<SimulatedScan> scans;
  const auto count = static_cast<std::size_t>(std::floor(flight.duration() * laser.rate_hz)) + 1;
  scans.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double time = static_cast<double>(i) / laser.rate_hz;
    scans.push_back({sweep(walls, laser, flight, time, noise), flight.at(time)});
    scans.back().scan.stamp = kFlightStart + time;
  }
  return scans;
}

}  // namespace kestrel_slam
