// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/filter/filter_types.h"
#include "kestrel_slam/filter/pose_filter_config.h"
#include "kestrel_slam/sensor/imu_sample.h"

namespace kestrel {

/// Why a measurement is invalid in any state; empty if it is valid.
std::string faultOf(const PoseMeasurement& measurement);
std::string faultOf(const PositionMeasurement& measurement);
std::string faultOf(const YawMeasurement& measurement);
/// `only_positive`: the value is a distance to the ground, up to `max_m`.
std::string faultOf(const HeightSample& sample, bool only_positive, double max_m);

/// Whether a matrix is finite, symmetric and positive definite.
bool isCovariance(const Eigen::Matrix3d& matrix);

}  // namespace kestrel
