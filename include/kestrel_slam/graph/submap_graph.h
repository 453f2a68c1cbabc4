// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose_covariance.h"
#include "kestrel_slam/graph/pose_graph.h"
#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/matching/place_match.h"

namespace kestrel {

/// Limits of the loop search.
struct LoopConfig {
  bool enabled = true;
  int query_keyframes = 10;     ///< keyframes that are searched for together
  double least_radius_m = 1.5;  ///< half size of the search window, if the graph is certain
  double wide_radius_m = 6.0;   ///< the same, now and then
  double sigmas = 3.0;          ///< the window covers so many standard deviations of the graph
  double min_fit = 0.65;
  double min_known = 0.6;
  double min_constraint = 0.04;
  double min_margin = 0.08;    ///< of the score to the second explanation
  double min_agreement = 0.7;  ///< share of the single scans that fit at the same place
};

/// A keyframe of the graph.
struct GraphKeyframe {
  double stamp = 0.0, time = 0.0;
  std::uint32_t submap = 0;
  Pose2 local_T_base;
  PlanarScan scan;
  Points hits;  ///< base frame, m
  bool new_view = false;
};

/// A loop that was tried.
struct Loop {
  std::size_t query = 0, anchor = 0;  ///< keyframes
  GaussianPose2 anchor_T_query;
  double fit = 0.0, known = 0.0, constraint = 0.0, margin = 0.0, agreement = 0.0;
  double radius_m = 0.0;
  double correction_m = 0.0;
  const char* refused = "";  ///< reason, "" if it is accepted
};

/// Keyframes, submaps and the pose graph between them.
class SubmapGraph {
 public:
  SubmapGraph(const MapperConfig& mapper, const LoopConfig& config);

  /// Adds the scan if it was inserted.
  void add(const PlanarScan& scan, const MapperResult& result);

  /// Optimizes with everything found so far.
  void finish();

  /// Correction of the local frame at the last keyframe.
  Pose2 mapTLocal() const;
  Pose2 mapTLocal(std::size_t keyframe) const;

  const std::vector<GraphKeyframe>& keyframes() const { return keyframes_; }
  const PoseGraph& graph() const { return graph_; }
  const std::vector<Loop>& loops() const { return loops_; }

 private:
  /// The scans of two submaps in one grid in the local frame, as scans were matched to it.
  struct Place {
    std::uint32_t last_submap = 0;
    std::shared_ptr<const Submap> map;
    std::size_t first = 0, last = 0;  ///< keyframes [first, last)
  };
  struct Candidate {
    const Place* place;
    std::size_t anchor;
    double distance_m, sigma_m, sigma_rad;
  };

  void addOdometry(const MapperResult& result);
  void addPlace(const MapperResult& result);
  void search();
  void refine(std::size_t keyframe);
  std::vector<double> variances(std::size_t from, std::vector<double>& yaw) const;
  std::vector<Candidate> candidates(std::size_t query, double least_radius) const;
  Points queryPoints(std::size_t first, std::size_t last, std::size_t frame) const;
  void tryLoop(const Candidate& candidate, std::size_t first, std::size_t last, double radius);
  double agreementOf(const Place& place, const Pose2& local_T_query, std::size_t first,
                     std::size_t last, std::size_t query, const MatchResult& match) const;
  void accept(const Loop& loop);
  void solve();

  MapperConfig mapper_;
  LoopConfig config_;
  std::vector<GraphKeyframe> keyframes_;
  std::vector<Place> places_;
  PoseGraph graph_;
  std::vector<Loop> loops_;
  std::size_t searched_ = 0;  ///< keyframes before this one were searched for
  std::size_t searches_ = 0;
};

}  // namespace kestrel
