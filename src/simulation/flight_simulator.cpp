// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/simulation/flight_simulator.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include "imu_simulator.h"
#include "infinity.h"
#include "kestrel_slam/geometry/random.h"

namespace kestrel {
namespace {

/// Numbers of the random streams. They must not change, because they determine the flights.
enum StreamId : std::uint64_t {
  kTruth,
  kWalkers,
  kImu,
  kRangeFinder,
  kBarometer,
  kLaser,
  kLidar,
  kSecondLaser
};

/// Independent seeds for the streams of one flight, by the hash function splitmix64.
std::uint64_t mix(std::uint64_t seed, std::uint64_t stream) {
  std::uint64_t z = seed + (stream + 1) * 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

void setStamp(LaserScan& scan, double stamp) { scan.stamp = stamp; }
void setStamp(PointCloud& cloud, double stamp) { cloud.stamp = stamp; }
void setStamp(ImuSample& sample, double stamp) { sample.stamp = stamp; }
void setStamp(HeightSample& sample, double stamp) { sample.stamp = stamp; }
void setStamp(Barometer& barometer, double stamp) { barometer.sample.stamp = stamp; }
void setStamp(TruePose&, double) {}
void setStamp(TrueWalkers&, double) {}

/// The message sequence of one sensor.
struct Stream {
  std::function<FlightMessage(double time)> measure;  ///< time after the start, s
  double rate_hz = 0.0;
  double phase = 0.0;    ///< time of the first message, in periods
  double delay_s = 0.0;  ///< from the stamp to the arrival
  double jitter_s = 0.0;
  double loss_probability = 0.0;
  bool second_laser = false;
  Random channel = Random(0);  ///< draws stamp errors and losses; independent of the sensor noise
  std::size_t count = 0;
  std::size_t index = 0;
  std::optional<FlightEvent> pending;

  /// Stores the next message that is not lost in `pending`, if there is one.
  void prepare() {
    while (!pending && index < count) {
      const double time = (phase + static_cast<double>(index++)) / rate_hz;
      const bool lost = channel.uniform() < loss_probability;
      const double error = jitter_s * channel.gaussian();
      FlightEvent event{kFlightStart + time + error, kFlightStart + time + delay_s, measure(time),
                        second_laser};
      std::visit([&](auto& message) { setStamp(message, event.stamp); }, event.message);
      if (!lost) pending = std::move(event);
    }
  }
};

/// A reading of a range finder that looks along the negative z axis of the base.
HeightSample measureHeight(const RangeFinderModel& model, const World& world, const Motion& motion,
                           double time, Random& random) {
  const Eigen::Isometry3d world_T_base = motion.at(time).world_T_base;
  const Eigen::Vector3d down = -world_T_base.linear().col(2);
  const RayHit hit = world.cast(world_T_base.translation(), down, time, model.range_max);
  const double range = hit.distance + model.sigma_m * random.gaussian();
  HeightSample sample;
  sample.height_m = range < model.range_min ? -kInfinity : range;
  if (!(range <= model.range_max) || hit.material == Material::kBlack) sample.height_m = kInfinity;
  return sample;
}

void block(const BlockedView& view, double time, LaserScan& scan) {
  if (time < view.from_s || time >= view.until_s) return;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const double angle = scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    if (angle < view.first_rad || angle > view.last_rad) continue;
    scan.ranges[i] = static_cast<float>(view.range_m);
  }
}

class BarometerSimulator {
 public:
  BarometerSimulator(const BarometerModel& model, std::uint64_t seed)
      : model_(model), random_(seed) {}

  Barometer next(const TrueState& truth) {
    Barometer barometer;
    barometer.sample.height_m =
        truth.world_T_base.translation().z() + drift_ + model_.sigma_m * random_.gaussian();
    drift_ += model_.drift_m_per_sqrt_s / std::sqrt(model_.rate_hz) * random_.gaussian();
    return barometer;
  }

 private:
  BarometerModel model_;
  Random random_;
  double drift_ = 0.0;  // m
};

}  // namespace

struct FlightSimulator::State {
  State(const World& the_world, const Motion& the_motion, const VehicleModel& model,
        std::uint64_t the_seed)
      : world(the_world), motion(the_motion), vehicle(model), seed(the_seed) {}

  void add(StreamId id, double rate_hz, double delay_s,
           std::function<FlightMessage(double)> measure);
  void addTruth();
  void addAttitudeSensors();
  void addHeightSensors();
  void addLaser(StreamId id, const LaserModel& laser, const Eigen::Isometry3d& base_T_laser);
  void addScanners();
  std::uint64_t seedOf(StreamId id) const { return mix(seed, 2 * id); }

  const World& world;
  const Motion& motion;
  const VehicleModel vehicle;
  const std::uint64_t seed;
  std::unique_ptr<ImuSimulator> imu;
  std::vector<Stream>
      streams;  ///< if messages arrive at the same time, the first stream goes first
};

void FlightSimulator::State::add(StreamId id, double rate_hz, double delay_s,
                                 std::function<FlightMessage(double)> measure) {
  if (!(rate_hz > 0.0 && std::isfinite(rate_hz))) {
    throw std::invalid_argument("the rate of a simulated sensor must be positive");
  }
  const bool is_truth = id == kTruth || id == kWalkers;
  Stream stream;
  stream.measure = std::move(measure);
  stream.rate_hz = rate_hz;
  stream.delay_s = delay_s;
  stream.jitter_s = is_truth ? 0.0 : vehicle.stamp_jitter_s;
  stream.loss_probability = is_truth ? 0.0 : vehicle.loss_probability;
  stream.channel = Random(mix(seed, 2 * id + 1));
  constexpr double kRounding =
      1e-9;  // in periods; keeps a last message that falls exactly on the end
  stream.count = static_cast<std::size_t>(motion.duration() * rate_hz + kRounding) + 1;
  // The last sweeps are omitted, so that attitudes are available until the end of every sweep.
  constexpr std::size_t kOmittedSweeps = 2;
  if (id == kLaser || id == kLidar || id == kSecondLaser) {
    stream.count -= std::min(stream.count, kOmittedSweeps);
  }
  if (id == kSecondLaser) {
    stream.phase = 0.5;
    stream.second_laser = true;
  }
  streams.push_back(std::move(stream));
}

void FlightSimulator::State::addTruth() {
  constexpr double kWalkersRate = 10.0;  // Hz
  if (vehicle.truth_rate_hz > 0.0) {
    add(kTruth, vehicle.truth_rate_hz, 0.0,
        [this](double time) { return TruePose{motion.at(time)}; });
  }
  if (world.parts().walkers.empty()) return;
  add(kWalkers, kWalkersRate, 0.0, [this](double time) {
    TrueWalkers walkers;
    for (std::size_t i = 0; i < world.parts().walkers.size(); ++i) {
      walkers.positions.push_back(world.walkerAt(i, time));
    }
    return walkers;
  });
}

void FlightSimulator::State::addAttitudeSensors() {
  if (!vehicle.imu) return;
  imu = std::make_unique<ImuSimulator>(*vehicle.imu, vehicle.base_R_imu, seedOf(kImu));
  add(kImu, vehicle.imu->rate_hz, vehicle.imu->latency_s,
      [this](double time) { return imu->next(motion.at(time)); });
}

void FlightSimulator::State::addHeightSensors() {
  if (vehicle.range_finder) {
    const RangeFinderModel& model = *vehicle.range_finder;
    add(kRangeFinder, model.rate_hz, model.latency_s,
        [this, &model, random = Random(seedOf(kRangeFinder))](double time) mutable {
          return measureHeight(model, world, motion, time, random);
        });
  }
  if (vehicle.barometer) {
    auto barometer = std::make_shared<BarometerSimulator>(*vehicle.barometer, seedOf(kBarometer));
    add(kBarometer, vehicle.barometer->rate_hz, vehicle.barometer->latency_s,
        [this, barometer](double time) { return barometer->next(motion.at(time)); });
  }
}

void FlightSimulator::State::addLaser(StreamId id, const LaserModel& laser,
                                      const Eigen::Isometry3d& base_T_laser) {
  const double sweep_s = laser.beams * laser.time_increment;
  add(id, laser.rate_hz, sweep_s + vehicle.scan_latency_s,
      [this, &laser, &base_T_laser, random = Random(seedOf(id))](double time) mutable {
        LaserScan scan = sweep(laser, world, motion, base_T_laser, time, random);
        for (const BlockedView& view : vehicle.blocked_views) block(view, time, scan);
        return scan;
      });
}

void FlightSimulator::State::addScanners() {
  if (vehicle.laser) addLaser(kLaser, *vehicle.laser, vehicle.base_T_laser);
  if (vehicle.second_laser) {
    addLaser(kSecondLaser, *vehicle.second_laser, vehicle.base_T_second_laser);
  }
  if (vehicle.lidar) {
    const LidarModel& lidar = *vehicle.lidar;
    add(kLidar, lidar.rate_hz, 1.0 / lidar.rate_hz + vehicle.scan_latency_s,
        [this, &lidar, random = Random(seedOf(kLidar))](double time) mutable {
          return sweep(lidar, world, motion, vehicle.base_T_lidar, time, random);
        });
  }
}

FlightSimulator::FlightSimulator(const World& world, const Motion& motion,
                                 const VehicleModel& vehicle, std::uint64_t seed)
    : state_(std::make_unique<State>(world, motion, vehicle, seed)) {
  state_->addTruth();
  state_->addAttitudeSensors();
  state_->addHeightSensors();
  state_->addScanners();
}

FlightSimulator::~FlightSimulator() = default;

TrueBiases FlightSimulator::imuBiases() const {
  if (!state_->imu) return {};
  return {state_->imu->gyroBias(), state_->imu->accelerometerBias()};
}

bool FlightSimulator::next(FlightEvent& event) {
  Stream* first = nullptr;
  for (Stream& stream : state_->streams) {
    stream.prepare();
    if (!stream.pending) continue;
    if (!first || stream.pending->arrival < first->pending->arrival) first = &stream;
  }
  if (!first) return false;
  event = std::move(*first->pending);
  first->pending.reset();
  return true;
}

}  // namespace kestrel
