// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "kestrel_slam/graph/odometry_chain.h"
#include "kestrel_slam/graph/pose_graph.h"

namespace kestrel {

/// How good an odometry is. Its pose has an error that does not grow (it was measured at another
/// time than the scan, or is rounded), and an error that grows with the distance.
struct OdometryWorth {
  double delay_s = 0.0;            ///< the pose was measured that long before its stamp
  double scale = 1.0;              ///< of the distance
  double yaw_per_m = 0.0;          ///< added to the yaw for each meter
  double yaw_per_rad = 0.0;        ///< added to the yaw for each rad that was measured
  double position_m2 = 0.0;        ///< variance of each pose along x and along y
  double yaw_rad2 = 0.0;           ///< variance of each yaw
  double position_growth_m = 0.0;  ///< variance along x and along y for each meter, m²/m
  double yaw_growth_rad2_m = 0.0;  ///< variance of the yaw for each meter
};

/// The wheel odometry along the keyframes of a graph, and what it is worth. Matches are more
/// accurate over a few meters; the errors of a good odometry are smaller over a long way. So both
/// are in the graph: the odometry is a second chain of vertices, and each keyframe hangs on one of
/// them.
///
/// The odometry is compared with the matches over distances of all sizes. What the matches' own
/// covariance does not explain is the error of the odometry.
class OdometryTrack {
 public:
  /// The odometry at a scan, in the order of time.
  void add(double time, const std::optional<Pose2>& odom_T_base);
  /// The scan that was added last is keyframe number `keyframe`, at `local_T_base`.
  void addKeyframe(std::size_t keyframe, const Pose2& local_T_base);

  bool empty() const { return keyframes_.empty(); }

  /// Compares the odometry with the matches again. `chain`: the matches, a vertex per keyframe.
  void learn(const OdometryChain& chain);
  const OdometryWorth& worth() const { return worth_; }

  /// Adds a vertex per keyframe with odometry, and the edges, with robust kernels: wheels slip.
  void addTo(PoseGraph& graph, const OdometryChain& chain) const;

  /// Matches that may be wrong, and that contradict the odometry, lose their weight. `doubtful`:
  /// for each keyframe.
  void weaken(PoseGraph& graph, const OdometryChain& chain,
              const std::vector<bool>& doubtful) const;

  std::size_t memoryBytes() const { return keyframes_.capacity() * sizeof(TrackedKeyframe); }

 private:
  /// The odometry at some time before and after a keyframe.
  struct Sample {
    double time = 0.0;
    Pose2 odom_T_base;
  };
  static constexpr std::size_t kAround = 2;  ///< samples before, and after, a keyframe
  struct TrackedKeyframe {
    std::size_t number = 0;
    Pose2 local_T_base;
    std::vector<Sample> samples;
    std::size_t own = 0;  ///< the sample of the keyframe itself
  };
  /// An odometry pose that belongs to a keyframe.
  struct Point {
    std::size_t keyframe;
    Pose2 matched, measured;
    double path_m;  ///< from the first point
  };

  std::vector<Point> pointsAt(double delay_steps, const OdometryChain& chain) const;
  std::vector<Point> usable(const OdometryChain& chain) const;
  bool agree(const Point& a, const Point& b, const OdometryChain& chain, bool yaw) const;
  std::size_t nextUsable(const std::vector<Point>& points, const Point& last, std::size_t i,
                         const OdometryChain& chain) const;
  Eigen::Vector3d varianceBetween(const Point& a, const Point& b) const;
  void correct(std::vector<Point>& points) const;
  void learnDelay(const OdometryChain& chain);
  void learnGains(const OdometryChain& chain);
  void learnErrors(const OdometryChain& chain);

  std::vector<TrackedKeyframe> keyframes_;
  std::vector<Sample> recent_;
  double delay_steps_ = 0.0;  ///< delay in intervals between scans
  bool corrected_ = false;    ///< gains were learned from the matches
  OdometryWorth worth_;
};

}  // namespace kestrel
