// SPDX-License-Identifier: BSD-3-Clause
#include <ceres/ceres.h>
#include <ceres/normal_prior.h>
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "filter_flight.h"
#include "kestrel_slam/geometry/gravity.h"
#include "kestrel_slam/sensor/attitude_estimator.h"

namespace kestrel {
namespace {

constexpr double kImuHz = 100.0;
constexpr double kDuration = 10.0;  // s
constexpr double kRest = 1.5;       // s
constexpr int kPerNode = 5;         // IMU samples between two nodes of the batch
constexpr double kFixSigma = 0.02;  // of a position measurement, m

/// Rotation vector, position, velocity, gyro bias and accelerometer bias at one time.
using Node = std::array<double, 15>;

template <typename T>
using Vector = Eigen::Matrix<T, 3, 1>;

template <typename T>
Eigen::Quaternion<T> rotationOf(const T* vector) {
  const Vector<T> v(vector[0], vector[1], vector[2]);
  const T angle_squared = v.squaredNorm();
  if (angle_squared < T(1e-16)) {
    return Eigen::Quaternion<T>(T(1.0), T(0.5) * v.x(), T(0.5) * v.y(), T(0.5) * v.z())
        .normalized();
  }
  using std::cos;
  using std::sin;
  using std::sqrt;
  const T angle = sqrt(angle_squared), s = sin(T(0.5) * angle) / angle;
  return Eigen::Quaternion<T>(cos(T(0.5) * angle), s * v.x(), s * v.y(), s * v.z());
}

/// The rotation vector of a small rotation.
template <typename T>
Vector<T> twiceVector(const Eigen::Quaternion<T>& q) {
  return T(2.0) * q.vec() * (q.w() < T(0.0) ? T(-1.0) : T(1.0));
}

/// The motion between two nodes from the IMU, trapezoidal. Independent of the code of the filter.
struct ImuFactor {
  std::vector<ImuSample> samples;  ///< from the first node to the second, including both
  ImuNoiseConfig noise;

  template <typename T>
  bool operator()(const T* a, const T* b, T* residual) const {
    Eigen::Quaternion<T> rotation = rotationOf(a);
    Vector<T> position(a[3], a[4], a[5]), velocity(a[6], a[7], a[8]);
    const Vector<T> gyro_bias(a[9], a[10], a[11]), force_bias(a[12], a[13], a[14]);
    for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
      const double dt = samples[i + 1].stamp - samples[i].stamp;
      const Eigen::Vector3d rate =
          0.5 * (*samples[i].angular_velocity + *samples[i + 1].angular_velocity);
      const Eigen::Vector3d force =
          0.5 * (*samples[i].linear_acceleration + *samples[i + 1].linear_acceleration);
      const Vector<T> turn = (rate.cast<T>() - gyro_bias) * T(dt);
      const Vector<T> half = turn * T(0.5);
      const Vector<T> acceleration =
          rotation * (rotationOf(half.data()) * (force.cast<T>() - force_bias)) -
          Vector<T>(T(0.0), T(0.0), T(kGravity));
      position += velocity * T(dt) + acceleration * T(0.5 * dt * dt);
      velocity += acceleration * T(dt);
      rotation = rotation * rotationOf(turn.data());
    }
    const double time = samples.back().stamp - samples.front().stamp, root = std::sqrt(time);
    const Vector<T> turned =
        twiceVector(Eigen::Quaternion<T>(rotationOf(b) * rotation.conjugate()));
    // The part of the position noise that is not explained by the velocity noise.
    const double velocity_sigma = noise.accelerometer_noise * root;
    const double rest_sigma = velocity_sigma * time / std::sqrt(12.0);
    for (int i = 0; i < 3; ++i) {
      const T gained = T(b[6 + i]) - velocity(i);
      residual[i] = turned(i) / T(noise.gyro_noise * root);
      residual[3 + i] = (T(b[3 + i]) - position(i) - gained * T(0.5 * time)) / T(rest_sigma);
      residual[6 + i] = gained / T(velocity_sigma);
      residual[9 + i] = (b[9 + i] - a[9 + i]) / T(noise.gyro_bias_walk * root);
      residual[12 + i] = (b[12 + i] - a[12 + i]) / T(noise.accelerometer_bias_walk * root);
    }
    return true;
  }
};

struct FixFactor {
  Eigen::Vector3d position;
  template <typename T>
  bool operator()(const T* a, T* residual) const {
    for (int i = 0; i < 3; ++i) residual[i] = (a[3 + i] - T(position(i))) / T(kFixSigma);
    return true;
  }
};

/// The flight for filter and batch: at rest, then moving, with a position every 50 ms.
struct BatchFlight {
  FilterFlight flight;
  std::vector<ImuSample> samples;
  std::vector<PositionMeasurement> fixes;

  BatchFlight() {
    Random random(17);
    const double root = std::sqrt(kImuHz);
    const ImuNoiseConfig noise;
    for (int i = 0; i <= static_cast<int>(kDuration * kImuHz); ++i) {
      ImuSample sample = flight.imu(i / kImuHz);
      for (double& axis : *sample.angular_velocity) {
        axis += noise.gyro_noise * root * random.gaussian();
      }
      for (double& axis : *sample.linear_acceleration) {
        axis += noise.accelerometer_noise * root * random.gaussian();
      }
      samples.push_back(sample);
      if (i % kPerNode != 0 || i / kImuHz < kRest) continue;
      PositionMeasurement fix{sample.stamp, flight.position(i / kImuHz),
                              kFixSigma * kFixSigma * Eigen::Matrix3d::Identity()};
      for (double& axis : fix.position) axis += kFixSigma * random.gaussian();
      fixes.push_back(fix);
    }
  }
};

Node nodeOf(const FilterOutput& output) {
  const Eigen::AngleAxisd turn(output.map_T_base.linear());
  const Eigen::Vector3d vector = turn.angle() * turn.axis();
  const Eigen::Vector3d position = output.map_T_base.translation();
  Node node;
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    node[k] = vector(i);
    node[3 + k] = position(i);
    node[6 + k] = output.velocity(i);
    node[9 + k] = output.gyro_bias(i);
    node[12 + k] = output.accelerometer_bias(i);
  }
  return node;
}

struct FilterRun {
  FilterOutput start, end;
};

FilterRun runFilter(const BatchFlight& batch) {
  PoseFilterConfig config;
  config.motion.gravity_sigma = 0.0;
  config.motion.zero_velocity = false;
  config.noise.mounting_sigma_rad = 0.0;
  PoseFilter filter(config);
  FilterRun run;
  std::size_t next = 0;
  bool started = false;
  for (const ImuSample& sample : batch.samples) {
    if (filter.addImu(sample) && !started) {
      started = true;
      run.start = *filter.output();
    }
    for (; next < batch.fixes.size() && batch.fixes[next].stamp <= sample.stamp; ++next) {
      filter.addPosition(batch.fixes[next]);
    }
  }
  run.end = *filter.output();
  return run;
}

class BatchProblem {
 public:
  BatchProblem(const BatchFlight& batch, const FilterOutput& start) {
    const auto first =
        static_cast<std::size_t>(std::lround((start.stamp - batch.flight.start_stamp) * kImuHz));
    addPrior(start);
    std::size_t fix = 0;
    for (std::size_t i = first; i + kPerNode < batch.samples.size(); i += kPerNode) {
      addMotion(batch, i);
      const double stamp = batch.samples[i + kPerNode].stamp;
      while (fix < batch.fixes.size() && batch.fixes[fix].stamp < stamp - 1e-6) ++fix;
      if (fix < batch.fixes.size() && std::abs(batch.fixes[fix].stamp - stamp) < 1e-6) {
        addFix(batch.fixes[fix]);
      }
    }
  }

  Node solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 50;
    options.function_tolerance = 1e-12;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    EXPECT_TRUE(summary.IsSolutionUsable()) << summary.BriefReport();
    return nodes_.back();
  }

 private:
  void addPrior(const FilterOutput& start) {
    nodes_.reserve(1000);  // Ceres stores their addresses
    nodes_.push_back(nodeOf(start));
    // The full covariance of the initial state, because tilt and accelerometer bias are correlated.
    const FilterCovariance root = start.covariance.llt().matrixL();
    ceres::Matrix whitening = root.inverse();
    ceres::Vector mean = Eigen::Map<const ceres::Vector>(nodes_.back().data(), 15);
    problem_.AddResidualBlock(new ceres::NormalPrior(whitening, mean), nullptr,
                              nodes_.back().data());
  }

  void addMotion(const BatchFlight& batch, std::size_t from) {
    auto* factor = new ImuFactor();
    const auto begin = batch.samples.begin() + static_cast<std::ptrdiff_t>(from);
    factor->samples.assign(begin, begin + kPerNode + 1);
    nodes_.push_back(nodes_.back());
    const double time = factor->samples.back().stamp - batch.flight.start_stamp;
    // Only the initial guess of the solver.
    const FilterFlight::Truth truth = batch.flight.at(time);
    FilterOutput near;
    near.map_T_base.linear() = truth.map_R_base.toRotationMatrix();
    near.map_T_base.translation() = truth.position;
    near.velocity = truth.velocity;
    nodes_.back() = nodeOf(near);
    problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<ImuFactor, 15, 15, 15>(factor),
                              nullptr, nodes_[nodes_.size() - 2].data(), nodes_.back().data());
  }

  void addFix(const PositionMeasurement& fix) {
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<FixFactor, 3, 15>(new FixFactor{fix.position}), nullptr,
        nodes_.back().data());
  }

  ceres::Problem problem_;
  std::vector<Node> nodes_;
};

/// At the end of the flight the filter has used the same information as the batch. For a linear
/// system the results would be equal. The only difference are the linearization points; it must be
/// small compared with the uncertainty.
TEST(PoseFilterBatch, AgreesWithBatchLeastSquares) {
  const BatchFlight batch;
  const FilterRun run = runFilter(batch);
  const Node expected = BatchProblem(batch, run.start).solve();
  const Node found = nodeOf(run.end);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    EXPECT_NEAR(found[i], expected[i], 0.1 * std::sqrt(run.end.covariance(k, k))) << "state " << i;
  }
}

}  // namespace
}  // namespace kestrel
