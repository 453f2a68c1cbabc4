#include "kestrel_slam/tools/filter_measurement.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/sensor/attitude_buffer.h"
#include "kestrel_slam/tools/simulated_recording.h"

namespace kestrel_slam {
namespace {

using Error = Eigen::Matrix<double, kFilterDim, 1>;

/// The rotation vector that turns `estimate` into `truth`.
Eigen::Vector3d turnBetween(const Eigen::Matrix3d& estimate, const Eigen::Matrix3d& truth) {
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(truth * estimate.transpose()));
  return normalizeAngle(turn.angle()) * turn.axis();
}

class Judge {
 public:
  explicit Judge(const Motion& motion) : motion_(motion) {}

  void hear(const PlanarScan& scan, const MapperResult& result) {
    const Pose2 truth = truePose(motion_, scan.stamp);
    if (!placed_) map_T_world_ = result.pose * truth.inverse();
    placed_ = true;
    ++m_.scans;
    m_.searched += result.searched ? 1U : 0U;
    m_.lost += result.state == MatchState::kLost ? 1U : 0U;
    iterations_ += result.match.iterations;
    if (result.state == MatchState::kLost) return;
    const Pose2 expected = map_T_world_ * truth;
    mapper_squares_ += (result.pose.translation() - expected.translation()).squaredNorm();
  }

  void hear(const FilterOutput& output, const TrueBiases& biases) {
    if (!placed_) return;
    const Error error = errorOf(output, biases);
    smoothness(output);
    ++count_;
    squares_ += error.cwiseAbs2();
    m_.xy_max_m = std::max(m_.xy_max_m, error.segment<2>(kPosition).norm());
    if (output.stamp - judged_ < 1.0) return;
    judged_ = output.stamp;
    m_.errors.push_back(error);
    m_.nees.push_back(error.dot(output.covariance.ldlt().solve(error)));
    Eigen::Vector<double, 5> blocks;
    for (int i = 0; i < 5; ++i) {
      const Eigen::Matrix3d p = output.covariance.block<3, 3>(3 * i, 3 * i);
      const Eigen::Vector3d e = error.segment<3>(3 * i);
      blocks(i) = e.dot(p.ldlt().solve(e));
    }
    m_.block_nees.push_back(blocks);
  }

  FilterMeasurement result() {
    const double n = std::max(1.0, static_cast<double>(count_));
    const Error mean = squares_ / n;
    m_.xy_rmse_m = std::sqrt(mean.segment<2>(kPosition).sum());
    m_.z_rmse_m = std::sqrt(mean(kPosition + 2));
    m_.velocity_rmse = std::sqrt(mean.segment<3>(kVelocity).sum());
    m_.tilt_rmse_deg = radToDeg(std::sqrt(0.5 * mean.segment<2>(kOrientation).sum()));
    m_.yaw_rmse_deg = radToDeg(std::sqrt(mean(kOrientation + 2)));
    const double scans = std::max(1.0, static_cast<double>(m_.scans));
    m_.iterations = iterations_ / scans;
    m_.mapper_rmse_m =
        std::sqrt(mapper_squares_ / std::max(1.0, static_cast<double>(m_.scans - m_.lost)));
    return m_;
  }

 private:
  Error errorOf(const FilterOutput& output, const TrueBiases& biases) const {
    const TrueState truth = motion_.at(output.stamp - kFlightStart);
    const Eigen::Matrix3d map_R_world =
        Eigen::AngleAxisd(map_T_world_.theta, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    Eigen::Vector3d position = map_R_world * truth.world_T_base.translation();
    position.head<2>() += map_T_world_.translation();
    Error error;
    error.segment<3>(kOrientation) =
        turnBetween(output.map_T_base.linear(), map_R_world * truth.world_T_base.linear());
    error.segment<3>(kPosition) = position - output.map_T_base.translation();
    error.segment<3>(kVelocity) = map_R_world * truth.velocity - output.velocity;
    error.segment<3>(kGyroBias) = biases.gyro - output.gyro_bias;
    error.segment<3>(kAccelerometerBias) = biases.accelerometer - output.accelerometer_bias;
    return error;
  }

  void smoothness(const FilterOutput& output) {
    constexpr double kResolution = 1e-3;  // m
    if (last_) {
      const TrueState truth = motion_.at(output.stamp - kFlightStart);
      const TrueState before = motion_.at(last_->stamp - kFlightStart);
      const double step =
          (output.odom_T_base.translation() - last_->odom_T_base.translation()).norm();
      const double explained =
          (truth.world_T_base.translation() - before.world_T_base.translation()).norm();
      m_.largest_step_m = std::max(m_.largest_step_m, step);
      m_.worst_step = std::max(m_.worst_step, step / (kResolution + explained));
    }
    last_ = output;
  }

  const Motion& motion_;
  FilterMeasurement m_;
  bool placed_ = false;
  Pose2 map_T_world_;
  double iterations_ = 0.0, mapper_squares_ = 0.0;
  std::size_t count_ = 0;
  Error squares_ = Error::Zero();
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
  FilteredMapping mapping(flight.config, trial.filter, trial.coupling);
  Judge judge(*motion);
  mapping.on_scan = [&](const PlanarScan& scan, const MapperResult& result) {
    judge.hear(scan, result);
  };
  mapping.on_output = [&](const FilterOutput& out) { judge.hear(out, simulator.imuBiases()); };
  FlightEvent event;
  while (simulator.next(event)) {
    const double time = event.stamp - kFlightStart;
    if (const auto* sample = std::get_if<ImuSample>(&event.message)) {
      mapping.addImu(*sample, flight.vehicle.base_R_imu, event.arrival);
    } else if (const auto* range = std::get_if<HeightSample>(&event.message)) {
      mapping.addRange(*range);
    } else if (const auto* barometer = std::get_if<Barometer>(&event.message)) {
      mapping.addBarometer(barometer->sample);
    } else if (const auto* scan = std::get_if<LaserScan>(&event.message)) {
      if (time >= trial.blind_from_s && time < trial.blind_until_s) continue;
      mapping.addScan(*scan, flight.vehicle.base_T_laser);
    }
  }
  FilterMeasurement result = judge.result();
  result.status = mapping.filter().status(event.stamp);
  return result;
}

}  // namespace kestrel_slam
