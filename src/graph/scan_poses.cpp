// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/scan_poses.h"

#include <algorithm>
#include <cstdint>

#include "kestrel_slam/graph/submap_graph.h"
#include "kestrel_slam/mapping/odometry_sign.h"

namespace kestrel {
namespace {

/// The odometry of scans, with its delay.
class ScanOdometry {
 public:
  ScanOdometry(const std::vector<TrackedScan>& scans, const OdometryTrack& track)
      : scans_(scans), track_(track) {
    SignedOdometry odometry;
    for (const TrackedScan& scan : scans)
      odometry_.push_back(odometry.next(scan.odom_T_base, scan.reversed));
  }

  std::optional<Pose2> at(std::size_t scan) const {
    const auto number = static_cast<std::ptrdiff_t>(scan) + track_.delayScans();
    if (number < 0 || number >= static_cast<std::ptrdiff_t>(odometry_.size())) return std::nullopt;
    return odometry_[static_cast<std::size_t>(number)];
  }

  /// Corrected, of the scans from `first` to `last`; less if it ends or is missing.
  std::vector<OdometryPoint> between(std::size_t first, std::size_t last) const {
    std::vector<OdometryPoint> result;
    for (std::size_t i = first; i <= last && at(i); ++i)
      result.push_back({scans_[i].keyframes, scans_[i].local_T_base, *at(i)});
    correct(track_.worth(), result);
    return result;
  }

 private:
  const std::vector<TrackedScan>& scans_;
  const OdometryTrack& track_;
  std::vector<std::optional<Pose2>> odometry_;  ///< of the scans
};

/// A keyframe that the graph has placed by odometry.
struct Anchor {
  std::size_t scan = 0, keyframe = 0;
  Pose2 map_T_base;
};

std::vector<Anchor> anchorsOf(const std::vector<TrackedScan>& scans, const OdometryTrack& track) {
  std::vector<Anchor> result;
  auto placed = track.placed().begin();
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (!scans[i].inserted || scans[i].keyframes == 0) continue;
    while (placed != track.placed().end() && placed->keyframe + 1 < scans[i].keyframes) ++placed;
    if (placed != track.placed().end() && placed->keyframe + 1 == scans[i].keyframes)
      result.push_back({i, placed->keyframe, placed->map_T_base});
  }
  return result;
}

/// Replaces the poses of scans by those of the odometry.
class Placement {
 public:
  Placement(const std::vector<TrackedScan>& scans, const OdometryTrack& track,
            std::vector<Pose2>& poses)
      : scans_(scans), track_(track), odometry_(scans, track), poses_(poses) {}

  /// Places the scans between two anchors by both of them, in proportion to the way.
  void placeBetween(const Anchor& first, const Anchor& last) {
    const std::vector<OdometryPoint> points = odometry_.between(first.scan, last.scan);
    if (points.size() <= last.scan - first.scan) return;
    std::vector<double> way(points.size(), 0.0);
    for (std::size_t i = 1; i < points.size(); ++i)
      way[i] = way[i - 1] + lengthOf(points[i - 1].measured.between(points[i].measured));
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
      const Pose2 moved = points.front().measured.between(points[i].measured);
      const Pose2 by_last = last.map_T_base * points.back().measured.between(points[i].measured);
      const double share = way.back() > 0.0 ? way[i] / way.back() : 0.5;
      place(first.scan + i, moved, interpolate(first.map_T_base * moved, by_last, share));
    }
  }

  void placeAfter(const Anchor& anchor) {
    const std::vector<OdometryPoint> points = odometry_.between(anchor.scan, scans_.size() - 1);
    for (std::size_t i = 1; i < points.size(); ++i) {
      const Pose2 moved = points.front().measured.between(points[i].measured);
      place(anchor.scan + i, moved, anchor.map_T_base * moved);
    }
  }

 private:
  /// `moved`: from an anchor.
  void place(std::size_t scan, const Pose2& moved, const Pose2& map_T_base) {
    if (scans_[scan].inserted) return;
    const Pose2 error = map_T_base.between(poses_[scan]);
    const Eigen::Matrix3d expected = varianceOf(track_.worth(), moved).asDiagonal();
    const bool is_refuted = track_.delayScans() != 0 && scans_[scan].doubtful &&
                            !isExpected(error, expected) &&
                            track_.singleContradictions().refutes(lengthOf(error));
    if (scans_[scan].carried || is_refuted) poses_[scan] = map_T_base;
  }

  const std::vector<TrackedScan>& scans_;
  const OdometryTrack& track_;
  const ScanOdometry odometry_;
  std::vector<Pose2>& poses_;
};

}  // namespace

TrackedScan trackedScan(const MapperResult& result, std::size_t keyframes) {
  return {result.pose,     result.odom_T_base,  keyframes,
          result.inserted, !result.isMatched(), result.state != MatchState::kOk,
          result.reversed};
}

std::vector<Pose2> scanPoses(const std::vector<TrackedScan>& scans, const SubmapGraph& graph) {
  std::vector<Pose2> result;
  for (const TrackedScan& scan : scans) {
    // Poses before the first keyframe of this run, which may go on from an older graph.
    const std::size_t count = std::max(scan.keyframes, graph.loadedCount() + 1);
    result.push_back(graph.keyframes().empty()
                         ? scan.local_T_base
                         : graph.mapTLocal(std::min(count, graph.keyframes().size()) - 1) *
                               scan.local_T_base);
  }
  const std::vector<Anchor> anchors = anchorsOf(scans, graph.odometry());
  Placement placement(scans, graph.odometry(), result);
  for (std::size_t i = 0; i + 1 < anchors.size(); ++i)
    if (graph.isJoined(anchors[i].keyframe) == graph.isJoined(anchors[i + 1].keyframe))
      placement.placeBetween(anchors[i], anchors[i + 1]);
  if (!anchors.empty()) placement.placeAfter(anchors.back());
  return result;
}

}  // namespace kestrel
