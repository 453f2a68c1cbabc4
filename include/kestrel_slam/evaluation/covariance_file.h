// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "kestrel_slam/evaluation/evaluation.h"
#include "kestrel_slam/mapping/pose_uncertainty.h"

namespace kestrel {

/// The estimated pose of one scan with its covariance.
struct ScanCovariance {
  double stamp = 0.0;  ///< s
  UncertainPose pose;
};

/// Write and read covariances.txt, which has one line per scan: stamp (s), x, y (m) and yaw (rad)
/// of the pose, then the elements xx xy xt yy yt tt (t: yaw) of the map covariance and of the match
/// covariance (see UncertainPose). Both throw std::runtime_error with the name of the file, the
/// line and the error.
void writeCovariances(const std::string& path, const std::vector<ScanCovariance>& covariances);
/// What writeCovariances writes.
std::string covariancesText(const std::vector<ScanCovariance>& covariances);
std::vector<ScanCovariance> readCovariances(const std::string& path);

/// Errors of relations, compared with their covariances (see relativeCovariance()).
struct CovarianceEvaluation {
  ErrorStatistics translation;  ///< error divided by its standard deviation
  ErrorStatistics rotation;     ///< error divided by its standard deviation
  ErrorStatistics nees;         ///< the mean is 3 if the covariances are correct
};

/// Relations between scans without covariance are omitted.
CovarianceEvaluation evaluateCovariances(const std::vector<ScanCovariance>& covariances,
                                         const std::vector<Relation>& relations);

}  // namespace kestrel
