// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/recording/trajectory.h"

namespace kestrel {

/// Statistics of absolute errors; all zero if there are no errors.
struct ErrorStatistics {
  std::size_t count = 0;
  double mean = 0.0;
  double std = 0.0;  ///< standard deviation of the population
  double median = 0.0;
  double max = 0.0;
  double rmse = 0.0;
};

ErrorStatistics statisticsOf(std::vector<double> errors);

/// Statistics of translation (m) and rotation (deg) errors of the same items.
struct PoseErrorStatistics {
  ErrorStatistics translation_m;
  ErrorStatistics rotation_deg;
};

/// The error of one item (a relation or a pose) and its stamp, s.
struct PoseError {
  double stamp = 0.0;
  double translation_m = 0.0;
  double rotation_deg = 0.0;
};

PoseErrorStatistics statisticsOf(const std::vector<PoseError>& errors);

/// A reference relation of the Freiburg benchmark: the pose of the vehicle at `stamp2` in its frame
/// at `stamp1` (s).
struct Relation {
  double stamp1 = 0.0;
  double stamp2 = 0.0;
  Pose2 pose;
};

/// Reads a file with lines `t1 t2 x y z roll pitch yaw`. Throws std::runtime_error with the name of
/// the file, the line and the error.
std::vector<Relation> readRelations(const std::string& path);

/// The metric of [Kümmerle 2009], without weights of loops: |relation⁻¹ · (pose1⁻¹ · pose2)|.
struct RelationEvaluation {
  std::vector<PoseError> errors;   ///< in the order of the relations; `stamp` is stamp1
  std::vector<double> end_stamps;  ///< the later stamp of the relation, for each of `errors`
  PoseErrorStatistics all;
  PoseErrorStatistics distant;        ///< relations over more than kDistantRelation
  std::vector<double> unmatched;      ///< stamps without a pose in the trajectory, ascending
  std::size_t skipped_relations = 0;  ///< relations with a stamp among `unmatched`
};

constexpr double kDistantRelation = 60.0;  ///< s
constexpr double kStampTolerance = 1e-5;   ///< s; largest difference of equal stamps in two files

/// Compares a trajectory with reference relations.
RelationEvaluation evaluateRelations(const Trajectory& trajectory,
                                     const std::vector<Relation>& relations);

/// The noise of the relations themselves. Trajectory, relations and odometry measure the same
/// motions, and their errors are independent: the three differences between them give the noise of
/// each ("three-cornered hat"). Medians over relations of at most kShortRelation in which the
/// vehicle moved; standard deviations along one axis, zero where the differences show none.
struct RelationNoise {
  std::size_t count = 0;
  double relations_m = 0.0, trajectory_m = 0.0, odometry_m = 0.0;
};

constexpr double kShortRelation = 3.0;  ///< s

RelationNoise noiseOf(const std::vector<Relation>& relations, const Trajectory& trajectory,
                      const Trajectory& odometry);

/// Comparison with a reference trajectory.
///
/// Each pose is compared with the reference at its stamp, interpolated between two poses that are
/// at most kMaxReferenceGap apart. ATE (absolute trajectory error): the error after the best rigid
/// alignment ([Umeyama 1991], without scale). RPE (relative pose error): the difference of the
/// motions over a fixed distance or time.
struct ReferenceEvaluation {
  std::size_t unmatched = 0;   ///< poses without a reference at their time
  Pose2 reference_T_map;       ///< the best alignment
  Trajectory aligned;          ///< the matched poses, in the frame of the reference
  Trajectory reference;        ///< the reference at the stamps of `aligned`
  std::vector<PoseError> ate;  ///< one for each of `aligned`
  PoseErrorStatistics ate_statistics;
  PoseErrorStatistics rpe_per_meter;   ///< over kRpeDistance along the reference
  PoseErrorStatistics rpe_per_second;  ///< over kRpeDuration
};

constexpr double kMaxReferenceGap = 0.5;  ///< s
constexpr double kRpeDistance = 1.0;      ///< m
constexpr double kRpeDuration = 1.0;      ///< s

/// Thrown if fewer than two poses have a reference.
class ReferenceMismatch : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Compares a trajectory with a reference. Throws ReferenceMismatch.
ReferenceEvaluation evaluateReference(const Trajectory& trajectory, const Trajectory& reference);

/// Length of the path, m.
double pathLength(const Trajectory& trajectory);

}  // namespace kestrel
