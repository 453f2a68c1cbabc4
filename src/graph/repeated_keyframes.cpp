// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/repeated_keyframes.h"

#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "kestrel_slam/graph/optimizer.h"

namespace kestrel {
namespace {

constexpr std::size_t kNotKept = std::numeric_limits<std::size_t>::max();
/// A keyframe is new if more than this share of its rays shows something else than the map.
constexpr double kNewShare = 0.1;
/// Walls may be this far apart, in cells: the error of the poses, and of the scans.
constexpr int kSameCells = 2;
/// One of so many rays is looked at.
constexpr std::size_t kEvery = 3;

/// Whether a keyframe shows something that the old map does not have.
class Novelty {
 public:
  Novelty(const GraphRecord& record, std::size_t first, const OccupancyGridConfig& config)
      : record_(record), parts_(connectedParts(record.graph)), old_(config), new_(config) {
    std::vector<bool> has_new(parts_.size(), false);
    for (std::size_t i = first; i < parts_.size(); ++i) has_new[parts_[i]] = true;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      if (has_new[parts_[i]]) insert(i, i < first ? old_ : new_);
    }
    first_ = first;
  }

  bool isNew(std::size_t keyframe) const {
    if (parts_[keyframe] >= first_) return true;  // no old keyframe is joined
    const Pose2& pose = record_.graph.vertices[keyframe].pose;
    const std::vector<PlanarRay> rays = record_.keyframes[keyframe].keyframe->scan.rays();
    std::size_t count = 0, different = 0;
    for (std::size_t i = 0; i < rays.size(); i += kEvery) {
      const Eigen::Vector2d end = pose * rays[i].end.cast<double>().eval();
      const Eigen::Vector2d origin = pose * rays[i].origin.cast<double>().eval();
      ++count;
      if ((rays[i].hit && isNewWall(end.cast<float>())) || passesOldWall(origin, end)) ++different;
    }
    return static_cast<double>(different) > kNewShare * static_cast<double>(count);
  }

 private:
  void insert(std::size_t i, OccupancyGrid& grid) {
    const Keyframe& keyframe = *record_.keyframes[i].keyframe;
    grid.insert(keyframe.planarScan(), record_.graph.vertices[i].pose, keyframe.new_view);
  }

  bool isNewWall(const Eigen::Vector2f& point) const {
    const Cell cell = new_.cellAt(point);
    return new_.isOccupied(cell) && !hasWall(old_, cell);
  }

  /// Whether a wall of the old map, which the new one does not have, is in the way.
  bool passesOldWall(const Eigen::Vector2d& origin, const Eigen::Vector2d& end) const {
    const double resolution = old_.resolution();
    const auto steps = static_cast<int>((end - origin).norm() / resolution) - kSameCells;
    const Eigen::Vector2d step = (end - origin).normalized() * resolution;
    for (int i = 0; i < steps; ++i) {
      const Cell cell = old_.cellAt((origin + i * step).cast<float>());
      if (old_.isOccupied(cell) && !hasWall(new_, cell)) return true;
    }
    return false;
  }

  static bool hasWall(const OccupancyGrid& grid, const Cell& cell) {
    for (int y = -kSameCells; y <= kSameCells; ++y) {
      for (int x = -kSameCells; x <= kSameCells; ++x)
        if (grid.isOccupied({cell.x + x, cell.y + y})) return true;
    }
    return false;
  }

  const GraphRecord& record_;
  std::vector<std::size_t> parts_;
  std::size_t first_ = 0;
  OccupancyGrid old_, new_;
};

/// For every keyframe that is left out, the nearest one of its part that stays.
class Replacement {
 public:
  Replacement(const PoseGraph& graph, const std::vector<bool>& kept)
      : by_(kept.size(), kNotKept), by_T_old_(kept.size()), motion_(kept.size()) {
    for (const PoseEdge& edge : graph.edges) {
      if (edge.kind == EdgeKind::kOdometry && edge.from + 1 == edge.to)
        motion_[edge.to] = GaussianPose2{edge.measured, edge.information.inverse()};
    }
    std::vector<std::size_t> steps(kept.size(), kNotKept);
    for (std::size_t i = 0; i < kept.size(); ++i) take(i, kept[i], i, i - 1, motion_[i], steps);
    for (std::size_t i = kept.size(); i-- > 0;) {
      const bool joined = i + 1 < kept.size() && motion_[i + 1];
      take(i, kept[i], i + 1, i + 1,
           joined ? std::optional(inverse(*motion_[i + 1])) : std::nullopt, steps);
    }
  }

  std::size_t of(std::size_t keyframe) const { return by_[keyframe]; }
  const GaussianPose2& pose(std::size_t keyframe) const { return by_T_old_[keyframe]; }
  const std::optional<GaussianPose2>& motionTo(std::size_t keyframe) const {
    return motion_[keyframe];
  }

 private:
  /// Keyframe i takes what stands for its neighbor, if that is nearer.
  void take(std::size_t i, bool kept, std::size_t joint, std::size_t neighbor,
            const std::optional<GaussianPose2>& neighbor_T_i, std::vector<std::size_t>& steps) {
    if (kept) {
      by_[i] = i;
      steps[i] = 0;
    } else if (joint > 0 && neighbor_T_i && by_[neighbor] != kNotKept &&
               steps[neighbor] + 1 < steps[i]) {
      by_[i] = by_[neighbor];
      by_T_old_[i] = compose(by_T_old_[neighbor], *neighbor_T_i);
      steps[i] = steps[neighbor] + 1;
    }
  }

  std::vector<std::size_t> by_;
  std::vector<GaussianPose2> by_T_old_;
  std::vector<std::optional<GaussianPose2>> motion_;  ///< from the keyframe before
};

Eigen::Matrix3d symmetricPart(const Eigen::Matrix3d& matrix) {
  return 0.5 * (matrix + matrix.transpose());
}

/// Makes a record of the keyframes that are kept.
class Thinning {
 public:
  Thinning(GraphRecord record, const std::vector<bool>& kept)
      : old_(std::move(record)), kept_(kept), replaced_(old_.graph, kept) {
    new_index_.push_back(0);
    for (const bool keep : kept_) new_index_.push_back(new_index_.back() + (keep ? 1 : 0));
  }

  GraphRecord run() {
    addKeyframes();
    for (const KnownPlace& place : old_.places) {
      const KnownPlace moved{place.submap, new_index_[place.first], new_index_[place.last]};
      if (hasOwnKeyframe(moved, result_.keyframes)) result_.places.push_back(moved);
    }
    for (const PoseEdge& edge : old_.graph.edges) {
      if (edge.kind == EdgeKind::kLoop && kept_[edge.from] && kept_[edge.to])
        result_.graph.edges.push_back(moved(edge));
    }
    addLoops();
    for (TrackedKeyframe& keyframe : old_.odometry) {
      if (!kept_[keyframe.number]) continue;
      result_.odometry.push_back(std::move(keyframe));
      result_.odometry.back().number = new_index_[result_.odometry.back().number];
    }
    return std::move(result_);
  }

 private:
  PoseEdge moved(PoseEdge edge) const {
    edge.from = new_index_[edge.from];
    edge.to = new_index_[edge.to];
    return edge;
  }

  void addKeyframes() {
    std::optional<GaussianPose2> motion;  // since the last one that is kept
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      const std::optional<GaussianPose2>& step = replaced_.motionTo(i);
      const bool repeats = i > 0 && !kept_[i - 1];
      motion = step && motion ? std::optional(compose(*motion, *step)) : std::nullopt;
      if (!kept_[i]) continue;
      if (motion) addOdometry(*motion);
      addKeyframe(i, motion, repeats);
      motion = GaussianPose2();
    }
  }

  void addKeyframe(std::size_t i, const std::optional<GaussianPose2>& motion, bool repeats) {
    LocalKeyframe entry = old_.keyframes[i];
    if (repeats) {
      auto keyframe = std::make_shared<Keyframe>(*entry.keyframe);
      keyframe->motion_covariance =
          motion ? symmetricPart(motion->covariance) : Eigen::Matrix3d::Zero();
      entry.keyframe = std::move(keyframe);
    }
    result_.keyframes.push_back(std::move(entry));
    result_.graph.vertices.push_back(old_.graph.vertices[i]);
  }

  void addOdometry(const GaussianPose2& motion) {
    const std::size_t to = result_.keyframes.size();
    result_.graph.edges.push_back(
        {to - 1, to, motion.mean, symmetricPart(motion.covariance.inverse()), EdgeKind::kOdometry});
  }

  /// Of the loops of removed keyframes, the best one between two parts at each keyframe that stays.
  void addLoops() {
    std::map<std::pair<std::size_t, std::size_t>, Loop> best;
    const OdometryChain chain(old_.graph);
    for (const Loop& loop : old_.loops) {
      if (kept_[loop.anchor] && kept_[loop.query]) {
        result_.loops.push_back(renumbered(loop));
        continue;
      }
      const std::optional<Loop> other = replaced(loop);
      if (!other) continue;
      const auto key = std::pair(other->query, chain.partOf(loop.anchor));
      const auto [found, added] = best.emplace(key, *other);
      if (!added && spreadOf(*other) < spreadOf(found->second)) found->second = *other;
    }
    for (const auto& [key, loop] : best) {
      result_.loops.push_back(renumbered(loop));
      result_.graph.edges.push_back(graphEdgeOf(result_.loops.back()));
    }
  }

  static double spreadOf(const Loop& loop) { return loop.anchor_T_query.covariance.determinant(); }

  Loop renumbered(Loop loop) const {
    loop.anchor = new_index_[loop.anchor];
    loop.query = new_index_[loop.query];
    return loop;
  }

  /// The same loop between keyframes that stay.
  std::optional<Loop> replaced(const Loop& loop) const {
    Loop result = loop;
    result.anchor = replaced_.of(loop.anchor);
    result.query = replaced_.of(loop.query);
    if (loop.state != LoopState::kAccepted || result.anchor == kNotKept ||
        result.query == kNotKept || result.anchor == result.query)
      return std::nullopt;
    result.anchor_T_query = compose(compose(replaced_.pose(loop.anchor), loop.anchor_T_query),
                                    inverse(replaced_.pose(loop.query)));
    result.anchor_T_query.covariance = symmetricPart(result.anchor_T_query.covariance);
    return result;
  }

  GraphRecord old_, result_;
  std::vector<bool> kept_;
  Replacement replaced_;
  std::vector<std::size_t> new_index_;
};

}  // namespace

GraphRecord withoutRepeated(GraphRecord record, std::size_t first,
                            const OccupancyGridConfig& config) {
  if (first == 0 || first >= record.keyframes.size()) return record;
  const Novelty novelty(record, first, config);
  std::vector<bool> kept(record.keyframes.size(), true);
  for (std::size_t i = first; i < kept.size(); ++i) kept[i] = novelty.isNew(i);
  GraphRecord result = Thinning(std::move(record), kept).run();
  // The poses follow from the edges that are left. Otherwise old places would move with every
  // flight.
  if (result.keyframes.size() < kept.size()) optimize(result.graph);
  return result;
}

}  // namespace kestrel
