// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "kestrel_slam/geometry/nearest_points.h"
#include "kestrel_slam/lidar/surface_map.h"

namespace kestrel {

/// What the ICP minimizes.
enum class IcpMetric {
  kPoint,  ///< squared distances of the pairs [Siew 2018, eq. 8]
  kPlane   ///< squared distances from the planes [Siew 2018, eq. 9]
};

struct CloudIcpConfig {
  IcpMetric metric = IcpMetric::kPlane;
  double rejected_share = 0.1;  ///< of the pairs, the worst
  double reach_m = 1.0;         ///< longest pair
  int max_iterations = 20;
  std::size_t max_points = 4000;  ///< more points are thinned
  /// How well the initial guess is known. Weighs only where the surfaces say nothing.
  double guess_sigma_m = 0.1, guess_sigma_rad = 0.02;
  double pair_sigma_m = 0.05;  ///< of the distance of a pair
};

struct CloudIcpResult {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< map_T_lidar
  std::size_t pairs = 0;                                   ///< in the last iteration, used
  double rms = 0.0;                                        ///< of their distances, m
  int iterations = 0;
  bool converged = false;
  /// Share of the pairs whose distance is explained by noise, in the direction where it is
  /// smallest: beside the right place, the surfaces across the error disagree, however few they
  /// are.
  double agreement = 0.0;
  double possible_agreement = 0.0;  ///< the same, as large as so few pairs allow
  bool is_fixed = false;            ///< there are pairs in all directions
  bool has_pairs = false;           ///< enough of them in any direction
};

/// Iterative closest point in six degrees of freedom against the cells of a static map.
class CloudIcp {
 public:
  explicit CloudIcp(const std::vector<SurfaceCell>& cells,
                    const CloudIcpConfig& config = CloudIcpConfig());

  /// `points`: in the frame of the lidar.
  CloudIcpResult align(const std::vector<Eigen::Vector3d>& points,
                       const Eigen::Isometry3d& guess) const;

  /// As align(), where the guess may be wrong by up to `radius` (m) in the plane: the motion of a
  /// vehicle is not known at the start and after the pose was lost.
  CloudIcpResult search(const std::vector<Eigen::Vector3d>& points, const Eigen::Isometry3d& guess,
                        double radius) const;

 private:
  struct Pair;
  using Pairs = std::vector<Pair>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;

  std::vector<Eigen::Vector3d> balanced(const std::vector<Eigen::Vector3d>& points,
                                        const Eigen::Isometry3d& guess) const;
  void refine(const std::vector<Eigen::Vector3d>& points, CloudIcpResult& result) const;
  Pairs pairsOf(const std::vector<Eigen::Vector3d>& points, const Eigen::Isometry3d& pose) const;
  void judge(const Pairs& pairs, CloudIcpResult& result) const;
  void weigh(Pairs& pairs, double scale) const;
  double kernelOf(int iteration) const;
  double closenessOf(const Pairs& pairs) const;
  Vector6 step(const Pairs& pairs, const Vector6& from_guess, const Eigen::Vector3d& center) const;

  CloudIcpConfig config_;
  std::vector<SurfaceCell> cells_;
  NearestPoints<3> means_;  ///< of the cells
};

}  // namespace kestrel
