// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/recording/trajectory.h"

namespace kestrel {

/// Statistics of absolute errors; all zero where there are none.
struct ErrorStatistics {
  std::size_t count = 0;
  double mean = 0.0;
  double std = 0.0;  ///< of the population
  double median = 0.0;
  double max = 0.0;
  double rmse = 0.0;
};

ErrorStatistics statisticsOf(std::vector<double> errors);

/// Translation (m) and rotation (deg) errors of the same items.
struct PoseErrorStatistics {
  ErrorStatistics translation_m;
  ErrorStatistics rotation_deg;
};

/// The error of one item (a relation, a pose), with the stamp that it belongs to.
struct PoseError {
  double stamp = 0.0;
  double translation_m = 0.0;
  double rotation_deg = 0.0;
};

PoseErrorStatistics statisticsOf(const std::vector<PoseError>& errors);

/// A reference relation of the Freiburg benchmark: the vehicle's pose at stamp 2 in its frame at
/// stamp 1.
struct Relation {
  double stamp1 = 0.0;
  double stamp2 = 0.0;
  Pose2 pose;
};

/// Reads `t1 t2 x y z roll pitch yaw` a line. Throws std::runtime_error that names file and line.
std::vector<Relation> readRelations(const std::string& path);

/// The metric of Kümmerle et al. 2009, without its loop weights: |relation⁻¹ · (pose1⁻¹ · pose2)|.
struct RelationEvaluation {
  std::vector<PoseError> errors;   ///< in the order of the relations; stamp is stamp 1
  std::vector<double> end_stamps;  ///< for each of `errors`, the later stamp of its relation
  PoseErrorStatistics all;
  PoseErrorStatistics distant;        ///< of those whose ends are over kDistantRelation apart
  std::vector<double> unmatched;      ///< stamps that the trajectory does not have, ascending
  std::size_t skipped_relations = 0;  ///< those with an end among `unmatched`
};

constexpr double kDistantRelation = 60.0;  ///< s
constexpr double kStampTolerance = 1e-5;   ///< s; a recorded stamp and its copy in another file

RelationEvaluation evaluateRelations(const Trajectory& trajectory,
                                     const std::vector<Relation>& relations);

/// Comparison with a reference trajectory.
///
/// A pose is compared with the reference at its stamp, interpolated between two poses at most
/// kMaxReferenceGap apart. ATE: what remains after the best rigid alignment (Umeyama, no scale).
/// RPE: difference of the relative motions over a fixed distance or time.
struct ReferenceEvaluation {
  std::size_t unmatched = 0;   ///< poses without a reference at their time
  Pose2 reference_T_map;       ///< the alignment
  Trajectory aligned;          ///< the matched poses, in the reference's frame
  Trajectory reference;        ///< the reference at the stamps of `aligned`
  std::vector<PoseError> ate;  ///< one for each of `aligned`
  PoseErrorStatistics ate_statistics;
  PoseErrorStatistics rpe_per_meter;   ///< over kRpeDistance along the reference
  PoseErrorStatistics rpe_per_second;  ///< over kRpeDuration
};

constexpr double kMaxReferenceGap = 0.5;  ///< s
constexpr double kRpeDistance = 1.0;      ///< m
constexpr double kRpeDuration = 1.0;      ///< s

/// Thrown where fewer than two poses find a reference.
class ReferenceMismatch : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws ReferenceMismatch.
ReferenceEvaluation evaluateReference(const Trajectory& trajectory, const Trajectory& reference);

/// Length of the path, m.
double pathLength(const Trajectory& trajectory);

}  // namespace kestrel
