// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "kestrel_slam/graph/graph_correction.h"
#include "kestrel_slam/graph/graph_uncertainty.h"
#include "kestrel_slam/graph/keyframe_errors.h"
#include "kestrel_slam/graph/loop.h"
#include "kestrel_slam/graph/loop_matcher.h"
#include "kestrel_slam/graph/odometry_chain.h"
#include "kestrel_slam/graph/odometry_track.h"
#include "kestrel_slam/graph/pairwise_consistency.h"
#include "kestrel_slam/graph/part_finder.h"
#include "kestrel_slam/graph/places.h"
#include "kestrel_slam/graph/pose_graph.h"
#include "kestrel_slam/mapping/mapper.h"

namespace kestrel {

/// What a graph consists of. All of it is saved, and a graph that is made of it goes on from there.
struct GraphRecord {
  std::vector<LocalKeyframe> keyframes;
  std::vector<KnownPlace> places;
  PoseGraph graph;                        ///< its vertices are the keyframes
  std::vector<Loop> loops;                ///< of the accepted ones, `graph` has edges
  std::vector<TrackedKeyframe> odometry;  ///< of the wheels, if there was any
};

/// The keyframes of the map: those of the largest part of the graph, see connectedParts(). Where
/// the other parts lie in it, nobody knows.
std::vector<PlacedKeyframe> mapKeyframes(const GraphRecord& record);

/// Keyframes, finished submaps and the pose graph between the keyframes. Finds loops, verifies them
/// and corrects the poses of all keyframes. Deterministic: no clock, no thread.
///
/// A loop is accepted if the query fits in one place only and its single scans agree. Where the
/// graph is uncertain, a second loop must confirm it [Mangelson 2018], and none may contradict it.
/// After each optimization, a loop that contradicts the others is taken back.
///
/// The flights of several days are parts of one graph: no odometry leads from one to the next. Only
/// loops join them. Until then, poses of different parts say nothing about each other.
class SubmapGraph {
 public:
  SubmapGraph(const MapperConfig& mapper, const LoopConfig& config);
  /// Goes on from a record. Its indices must exist.
  SubmapGraph(const MapperConfig& mapper, const LoopConfig& config, GraphRecord record);

  /// Adds the scan if the mapper inserted it. `result.pose` is in the local frame.
  void add(const PlanarScan& scan, const MapperResult& result);

  /// Uses these parameters from the next search on.
  void configure(const LoopConfig& config) {
    config_ = config;
    matcher_.configure(config);
  }

  /// The next keyframe begins a new part: nobody measured how the vehicle got there. The frame of
  /// the mapper must be map, as far as it is known. `map_T_base`: where the vehicle may be. It only
  /// says where to search; without it, the whole map is searched.
  void beginPart(const std::optional<GaussianPose2>& map_T_base);

  /// Takes a loop that was found by other means and fits, for example by a search in the whole map.
  /// It is judged as the others are. Returns whether it was accepted.
  bool addLoop(const Loop& loop);

  /// Matches all keyframes with the places that they overlap, and optimizes once more. For the end
  /// of a recording. What was already in a record is not matched with itself again.
  void finish();

  /// Corrected pose of a keyframe in map, and the correction of the local frame there.
  const Pose2& poseOf(std::size_t keyframe) const { return graph_.vertices[keyframe].pose; }
  Pose2 mapTLocal(std::size_t keyframe) const;
  /// The correction at the last keyframe.
  Pose2 mapTLocal() const;

  /// The last keyframe relative to the first one, with the marginal covariance of the graph (see
  /// KeyframeMarginals: without the error of its own match, which is not in the poses after it).
  /// Only after a loop: nothing before, and where no edges lead from one to the other.
  std::optional<GraphCorrection::Known> knownEnd() const;
  /// Changes when the graph is optimized.
  std::size_t solutionCount() const { return solutions_; }

  const std::vector<LocalKeyframe>& keyframes() const { return keyframes_; }
  /// Of every keyframe. A record only has those of the motions as a whole.
  const std::vector<KeyframeErrors>& errors() const { return errors_; }
  const PoseGraph& graph() const { return graph_; }
  std::size_t submapCount() const { return places_.all().size(); }
  const Places& places() const { return places_; }
  const OdometryTrack& odometry() const { return track_; }
  GraphRecord record() const {
    return {keyframes_, places_.all(), graph_, loops_, track_.keyframes()};
  }
  /// Keyframes before this one were in the record.
  std::size_t loadedCount() const { return loaded_; }
  /// Whether edges join the keyframe with the newest one; after finish(), with the largest part of
  /// the new keyframes. Only such keyframes belong to one map.
  bool isJoined(std::size_t keyframe) const {
    return joined_[keyframe] == shown_.value_or(joined_.back());
  }
  /// false: the newest part began at an unknown place, no loop has joined it yet, and it is not the
  /// largest part: that one is the map.
  bool isLocated() const {
    return start_is_given_ || finder_ == nullptr || joined_.back() == largestPart(joined_);
  }
  /// Number of parts of the new keyframes that no loop has joined.
  std::size_t partCount() const;
  /// All loops of a search, accepted or not, and the accepted ones of other matches.
  const std::vector<Loop>& loops() const { return loops_; }
  std::size_t memoryBytes() const;

 private:
  /// A place where the query may be.
  struct Candidate {
    std::size_t place, anchor;
    double distance_m, sigma_m, sigma_rad;
  };

  void addKeyframe(const PlanarScan& scan, const MapperResult& result);
  bool isQuery(const LoopQuery& query) const;
  void addPlace();
  double pathBetween(std::size_t a, std::size_t b) const;
  bool areNear(std::size_t a, std::size_t b) const;
  bool isNeighbor(const KnownPlace& place, std::size_t keyframe) const;
  std::vector<PlacedKeyframe> keyframesOf(std::size_t part) const;
  void guess(std::size_t keyframe);
  void lookForPart(const PlanarScan& scan);
  void verifyFound(const Pose2& map_T_local);
  void moveNewestPart(const Pose2& map_T_local);
  void guessFound();
  std::vector<RelativeUncertainty> uncertainties(std::size_t from) const;
  void addOdometry();
  void search(const LoopQuery& query);
  std::size_t placeOf(std::size_t keyframe) const;
  void searchAround();
  Candidate candidateAt(std::size_t place, std::size_t query) const;
  std::vector<Candidate> candidatesFor(std::size_t query) const;
  bool confirm(const Candidate& candidate, std::size_t query);
  void searchAt(const Candidate& candidate, const LoopQuery& query, double radius_m);
  void judge(const Loop& loop);
  void accept(std::size_t loop);
  void join(const Loop& loop);
  void restore(const std::vector<Loop>& loops);
  Pose2 expectedAt(const Candidate& candidate, std::size_t query) const;
  void optimizeIfNeeded(const Loop& loop);
  void solve();
  PoseGraph withOdometry() const;
  bool takeBack(const std::vector<double>& weights);
  void refine();
  void refineAt(std::size_t place, std::vector<int>& matched);

  MapperConfig mapper_;
  LoopConfig config_;
  LoopMatcher matcher_;
  std::vector<LocalKeyframe> keyframes_;
  std::vector<KeyframeErrors> errors_;
  std::vector<double> path_;  ///< from the first keyframe to each, m
  Places places_;
  PoseGraph odometry_;  ///< only that, for `chain_`
  PoseGraph graph_;     ///< the odometry and the accepted loops
  OdometryChain chain_;
  OdometryTrack track_;         ///< the wheel odometry
  std::vector<bool> doubtful_;  ///< keyframes whose match may be wrong
  ConsistentLoops consistency_;
  std::vector<Loop> loops_;
  std::vector<std::size_t> loop_of_edge_;  ///< for every edge of `graph_`, the loop
  std::vector<std::size_t> verified_;      ///< numbers in `loops_` of those in `consistency_`
  std::vector<std::size_t> joined_;        ///< see connectedParts()
  std::vector<double> weights_;            ///< of the edges in the last optimization
  std::size_t solutions_ = 0;              ///< number of optimizations
  UncertainPose end_;                      ///< the last keyframe in the local frame
  std::optional<std::size_t> shown_;       ///< the part that is the map, after finish()
  std::size_t loaded_ = 0;                 ///< keyframes of the record
  std::size_t part_begin_ = 0;             ///< first keyframe of the newest part
  std::uint32_t submap_offset_ = 0;        ///< the mapper numbers the submaps of a part from 0
  std::optional<GaussianPose2> start_;     ///< where the newest part may be
  bool start_is_given_ = false;            ///< by a person, or the end of the last flight
  std::optional<PoseEdge> guess_;          ///< the same, from the nearest keyframe of other parts
  std::unique_ptr<PartFinder> finder_;     ///< while it is searched for in the whole map
  std::size_t searched_ = 0;               ///< keyframes before this one were searched for
  std::size_t searches_ = 0;
  std::size_t unsolved_ = 0;  ///< accepted loops since the last optimization
};

}  // namespace kestrel
