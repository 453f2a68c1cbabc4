// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/filter_measurement.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "kestrel_slam/evaluation/consistency.h"
#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/recording/simulated_recording.h"
#include "kestrel_slam/sensor/attitude_buffer.h"

namespace kestrel {
namespace {

constexpr double kInterval_s = 1.0;  // between two samples of the NEES

/// The rotation vector that turns `estimate` into `truth`.
Eigen::Vector3d turnBetween(const Eigen::Matrix3d& estimate, const Eigen::Matrix3d& truth) {
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(truth * estimate.transpose()));
  return normalizeAngle(turn.angle()) * turn.axis();
}

/// Compares the output of the filter and the mapper with the truth.
class Judge {
 public:
  Judge(const Motion& motion, double return_stamp) : motion_(motion), return_stamp_(return_stamp) {}

  void hear(const PlanarScan& scan, const MapperResult& result) {
    const Pose2 truth = truePose(motion_, scan.stamp);
    if (!placed_) map_T_world_ = result.pose * truth.inverse();
    placed_ = true;
    ++m_.scans;
    m_.searched += result.searched ? 1U : 0U;
    m_.fallbacks += result.match.fallbacks > 0 ? 1U : 0U;
    iterations_ += result.match.iterations;
    if (result.state == MatchState::kLost) {
      ++m_.lost;
      return;
    }
    const Pose2 expected = map_T_world_ * truth;
    mapper_squares_ += (result.pose.translation() - expected.translation()).squaredNorm();
  }

  void hear(const FilterOutput& output, const TrueBiases& biases) {
    if (!placed_) return;
    const FilterError error = errorOf(output, biases);
    hearStep(output);
    const double away = error.segment<2>(kPosition).norm();
    if (output.stamp <= return_stamp_) m_.return_error_m = away;
    ++count_;
    squares_ += error.cwiseAbs2();
    m_.xy_max_m = std::max(m_.xy_max_m, away);
    m_.z_end_m = std::abs(error(kPosition + 2));
    if (output.stamp - judged_ < kInterval_s) return;
    judged_ = output.stamp;
    m_.nees.push_back(error.dot(output.covariance.ldlt().solve(error)));
    m_.block_nees.push_back(blockNees(error, output.covariance));
  }

  FilterMeasurement result() {
    const FilterError mean = squares_ / std::max(1.0, static_cast<double>(count_));
    m_.xy_rmse_m = std::sqrt(mean.segment<2>(kPosition).sum());
    m_.z_rmse_m = std::sqrt(mean(kPosition + 2));
    m_.velocity_rmse = std::sqrt(mean.segment<3>(kVelocity).sum());
    m_.tilt_rmse_deg = radToDeg(std::sqrt(0.5 * mean.segment<2>(kOrientation).sum()));
    m_.yaw_rmse_deg = radToDeg(std::sqrt(mean(kOrientation + 2)));
    m_.iterations = iterations_ / std::max(1.0, static_cast<double>(m_.scans));
    const double found = std::max(1.0, static_cast<double>(m_.scans - m_.lost));
    m_.mapper_rmse_m = std::sqrt(mapper_squares_ / found);
    return m_;
  }

 private:
  static std::array<double, 5> blockNees(const FilterError& error, const FilterCovariance& p) {
    std::array<double, 5> result{};
    for (int i = 0; i < 5; ++i) {
      result[static_cast<std::size_t>(i)] =
          neesOf(error.segment<3>(3 * i), p.block<3, 3>(3 * i, 3 * i));
    }
    return result;
  }

  FilterError errorOf(const FilterOutput& output, const TrueBiases& biases) const {
    const TrueState truth = motion_.at(output.stamp - kFlightStart);
    const Eigen::Matrix3d map_R_world =
        Eigen::AngleAxisd(map_T_world_.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    Eigen::Vector3d position = map_R_world * truth.world_T_base.translation();
    position.head<2>() += map_T_world_.translation();
    FilterError error;
    error.segment<3>(kOrientation) =
        turnBetween(output.map_T_base.linear(), map_R_world * truth.world_T_base.linear());
    error.segment<3>(kPosition) = position - output.map_T_base.translation();
    error.segment<3>(kVelocity) = map_R_world * truth.velocity - output.velocity;
    error.segment<3>(kGyroBias) = biases.gyro - output.gyro_bias;
    error.segment<3>(kAccelerometerBias) = biases.accelerometer - output.accelerometer_bias;
    return error;
  }

  void hearStep(const FilterOutput& output) {
    constexpr double kResolution = 1e-3;  // m
    if (last_) {
      const TrueState truth = motion_.at(output.stamp - kFlightStart);
      const TrueState before = motion_.at(last_->stamp - kFlightStart);
      const double step =
          (output.odom_T_base.translation() - last_->odom_T_base.translation()).norm();
      const double explained =
          (truth.world_T_base.translation() - before.world_T_base.translation()).norm();
      m_.largest_step_m = std::max(m_.largest_step_m, step);
      m_.worst_step = std::max(m_.worst_step, (kResolution + step) / (kResolution + explained));
    }
    last_ = output;
  }

  const Motion& motion_;
  double return_stamp_;  ///< end of the interval without scans, s
  FilterMeasurement m_;
  bool placed_ = false;
  Pose2 map_T_world_;
  double iterations_ = 0.0, mapper_squares_ = 0.0;
  std::size_t count_ = 0;
  FilterError squares_ = FilterError::Zero();
  double judged_ = 0.0;
  std::optional<FilterOutput> last_;
};

}  // namespace

FilterMeasurement measureFilter(const FilterTrial& trial) {
  const FlightTrial& flight = trial.flight;
  const World world(flight.place.parts);
  const std::unique_ptr<Motion> motion =
      flyQuadrotor(flight.place.plan, flight.place.quadrotor, flight.seed);
  FlightSimulator simulator(world, *motion, flight.vehicle, flight.seed);
  PipelineConfig config;
  config.slam = flight.config;
  config.filter = trial.filter;
  config.coupling = trial.coupling;
  Pipeline pipeline(config);
  Judge judge(*motion, kFlightStart + trial.blind_until_s);
  pipeline.on_scan = [&](const MappedSweep& sweep) { judge.hear(sweep.scan, sweep.result); };
  pipeline.on_filter = [&](const FilterOutput& out) { judge.hear(out, simulator.imuBiases()); };
  FlightEvent event;
  while (simulator.next(event)) {
    const double time = event.stamp - kFlightStart;
    if (const auto* sample = std::get_if<ImuSample>(&event.message)) {
      pipeline.addImu(*sample, Eigen::Isometry3d(flight.vehicle.base_R_imu), event.arrival);
    } else if (const auto* range = std::get_if<HeightSample>(&event.message)) {
      pipeline.addRange(*range, event.arrival);
    } else if (const auto* barometer = std::get_if<Barometer>(&event.message)) {
      pipeline.addBarometer(barometer->sample, event.arrival);
    } else if (const auto* scan = std::get_if<LaserScan>(&event.message)) {
      if (time >= trial.blind_from_s && time < trial.blind_until_s) continue;
      PipelineScan input;
      input.data = *scan;
      input.base_T_laser = flight.vehicle.base_T_laser;
      pipeline.addScan(std::move(input), event.arrival);
    }
  }
  FilterMeasurement result = judge.result();
  result.status = pipeline.filter().status(event.stamp);
  return result;
}

double measureImuCost(double duration_s) {
  constexpr double kRate = 400.0, kLate = 0.02;
  constexpr int kPerPose = 10, kPerRange = 20, kPerBarometer = 40;  // IMU samples
  constexpr double kMicroseconds = 1e6;
  PoseFilter filter;
  Random random(1);
  const Eigen::Matrix3d covariance = 3e-5 * Eigen::Matrix3d::Identity();
  const auto noise = [&](double sigma) { return sigma * random.gaussian(); };
  const int samples = static_cast<int>(duration_s * kRate);
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < samples; ++i) {
    ImuSample sample;
    sample.stamp = i / kRate;
    sample.angular_velocity = Eigen::Vector3d(noise(0.01), noise(0.01), noise(0.01));
    sample.linear_acceleration = Eigen::Vector3d(noise(0.05), noise(0.05), 9.81 + noise(0.05));
    filter.addImu(sample);
    const double late = sample.stamp - kLate;
    if (i % kPerPose == 0)
      filter.addPose({late, Pose2(noise(0.003), noise(0.003), 0.0), covariance});
    if (i % kPerRange == 0) filter.addRange({late, 1.0 + noise(0.01)});
    if (i % kPerBarometer == 0) filter.addBarometer({late, 100.0 + noise(0.1)});
  }
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
  return kMicroseconds * spent.count() / samples;
}

}  // namespace kestrel
