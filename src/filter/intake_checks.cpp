// SPDX-License-Identifier: BSD-3-Clause
#include "intake_checks.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "kestrel_slam/sensor/imu_validation.h"

namespace kestrel {
namespace {

constexpr double kAsymmetry = 1e-6;   // relative to the largest element; smaller is rounding
constexpr double kMaxPosition = 1e6;  // m; larger positions are invalid
constexpr double kMaxVariance = 1e6;  // m² or rad²; a larger variance contains no information

const char* const kNotFinite = "not finite";
const char* const kBadStamp = "bad stamp";
const char* const kBadCovariance = "covariance not positive definite";

}  // namespace

bool isCovariance(const Eigen::Matrix3d& matrix) {
  if (!matrix.allFinite() || !(matrix.diagonal().minCoeff() > 0.0)) return false;
  const double largest = matrix.cwiseAbs().maxCoeff();
  if ((matrix - matrix.transpose()).cwiseAbs().maxCoeff() > kAsymmetry * largest) return false;
  if (largest > kMaxVariance) return false;
  // Scaled to a unit diagonal, so that the units do not matter.
  const Eigen::Vector3d scale = matrix.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Eigen::Matrix3d> factor(scale.asDiagonal() * matrix * scale.asDiagonal());
  return factor.info() == Eigen::Success &&
         Eigen::Matrix3d(factor.matrixL()).diagonal().minCoeff() > kAsymmetry;
}

std::string faultOf(const PoseMeasurement& measurement) {
  if (faultOfStamp(measurement.stamp)) return kBadStamp;
  if (!measurement.pose.isFinite() || !measurement.unobservable.allFinite()) return kNotFinite;
  if (measurement.pose.distance() > kMaxPosition) return "too far";
  return isCovariance(measurement.covariance) ? "" : kBadCovariance;
}

std::string faultOf(const PositionMeasurement& measurement) {
  if (faultOfStamp(measurement.stamp)) return kBadStamp;
  if (!measurement.position.allFinite()) return kNotFinite;
  if (measurement.position.cwiseAbs().maxCoeff() > kMaxPosition) return "too far";
  return isCovariance(measurement.covariance) ? "" : kBadCovariance;
}

std::string faultOf(const YawMeasurement& measurement) {
  if (faultOfStamp(measurement.stamp)) return kBadStamp;
  const bool finite = std::isfinite(measurement.yaw) && std::isfinite(measurement.sigma);
  return finite ? "" : kNotFinite;
}

std::string faultOf(const HeightSample& sample, bool only_positive, double max_m) {
  if (faultOfStamp(sample.stamp)) return kBadStamp;
  if (std::isnan(sample.height_m)) return kNotFinite;
  if (std::isinf(sample.height_m)) return sample.height_m > 0.0 ? "infinite" : "too close";
  if (only_positive && sample.height_m <= 0.0) return "not positive";
  return std::abs(sample.height_m) > max_m ? "too far" : "";
}

}  // namespace kestrel
