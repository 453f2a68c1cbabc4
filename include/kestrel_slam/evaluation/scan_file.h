// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/evaluation/evaluation.h"
#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/recording/trajectory.h"

namespace kestrel {

/// What is known about one scan after mapping: one line of scans.csv.
struct ScanRow {
  double stamp = 0.0;  ///< as recorded, s
  Pose2 pose;          ///< map_T_base
  MatchState state = MatchState::kLost;
  double score = 0.0;       ///< fit of the scan, 0 to 1
  double known = 0.0;       ///< share of the beams in known space, 0 to 1
  double constraint = 0.0;  ///< share of the points that constrain the weakest direction
  Eigen::Vector2d degenerate_direction =
      Eigen::Vector2d::Zero();                       ///< in map; zero if there is none
  Eigen::Vector3d sigmas = Eigen::Vector3d::Zero();  ///< of x, y (m) and yaw (rad)
  bool inserted = false, searched = false, carried = false, ambiguous = false;
  std::optional<Pose2> odom_T_base;  ///< the odometry, if it was used
  std::string reason;                ///< of the state (reasonOf); empty in files of old versions
};

/// Write and read scans.csv. The first line names the columns; a reader finds them by name, so that
/// columns may be added. Fields that do not apply are empty. readScans() throws std::runtime_error
/// with the name of the file, the line and the error.
std::string scansText(const std::vector<ScanRow>& scans);
std::vector<ScanRow> readScans(const std::string& path);

/// The states of the scans of a run, compared with a reference trajectory.
struct StateEvaluation {
  std::size_t ok = 0, degraded = 0, lost = 0;
  /// Scans in the state ok whose motion since the base pose differs from that of the reference by
  /// more than kWrongMotion. The base is the newest scan that is at least kMotionScans older and
  /// not lost.
  std::size_t wrong_and_ok = 0;
  PoseErrorStatistics ate;  ///< of all scans, after the best rigid alignment
  std::optional<PoseErrorStatistics> odometry_ate;  ///< of the odometry alone, if it was used
};

constexpr std::size_t kMotionScans = 10;
constexpr double kWrongMotion = 1.0;  ///< m

/// Throws ReferenceMismatch.
StateEvaluation evaluateStates(const std::vector<ScanRow>& scans, const Trajectory& reference);

}  // namespace kestrel
