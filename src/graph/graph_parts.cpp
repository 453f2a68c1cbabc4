// SPDX-License-Identifier: BSD-3-Clause
// The parts of a submap graph: flights that only loops can join, going on from a record, and what
// is known of the end.
#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "kestrel_slam/graph/keyframe_errors.h"
#include "kestrel_slam/graph/submap_graph.h"

namespace kestrel {
namespace {

constexpr std::size_t kNoPart = std::numeric_limits<std::size_t>::max();

/// The first loop that gave this edge and has no edge yet.
std::size_t loopOf(const PoseEdge& edge, const std::vector<Loop>& loops, std::vector<bool>& used) {
  for (std::size_t i = 0; i < loops.size(); ++i) {
    const Loop& loop = loops[i];
    if (used[i] || loop.state != LoopState::kAccepted || loop.anchor != edge.from ||
        loop.query != edge.to || !(loop.anchor_T_query.mean == edge.measured))
      continue;
    used[i] = true;
    return i;
  }
  return kNoPart;
}

double lengthOf(const PoseGraph& odometry, std::size_t to) {
  const PoseEdge& edge = odometry.edges.back();
  return !odometry.edges.empty() && edge.to == to ? edge.measured.distance() : 0.0;
}

}  // namespace

SubmapGraph::SubmapGraph(const MapperConfig& mapper, const LoopConfig& config, GraphRecord record)
    : SubmapGraph(mapper, config) {
  keyframes_ = std::move(record.keyframes);
  graph_ = std::move(record.graph);
  for (const KnownPlace& place : record.places) places_.add(place.submap, place.first, place.last);
  loaded_ = searched_ = keyframes_.size();
  joined_ = connectedParts(graph_);
  doubtful_.assign(keyframes_.size(), false);
  std::vector<const PoseEdge*> odometry(keyframes_.size(), nullptr);  // to each keyframe
  for (const PoseEdge& edge : graph_.edges) {
    if (edge.kind == EdgeKind::kOdometry && edge.from + 1 == edge.to) odometry[edge.to] = &edge;
  }
  for (std::size_t i = 0; i < keyframes_.size(); ++i) {
    errors_.emplace_back();
    if (odometry[i] != nullptr) {
      odometry_.edges.push_back(*odometry[i]);
      errors_.back().lasting = odometry[i]->information.inverse();
    }
    if (odometry[i] == nullptr) part_begin_ = i;
    path_.push_back((i == 0 ? 0.0 : path_.back()) + lengthOf(odometry_, i));
    odometry_.vertices.emplace_back();
  }
  chain_.grow(odometry_);
  track_ = OdometryTrack(std::move(record.odometry));
  restore(record.loops);
}

/// Takes the loops of a record, whose edges are in the graph.
void SubmapGraph::restore(const std::vector<Loop>& loops) {
  loops_ = loops;
  std::vector<bool> used(loops_.size(), false);
  for (const PoseEdge& edge : graph_.edges)
    loop_of_edge_.push_back(edge.kind == EdgeKind::kLoop ? loopOf(edge, loops_, used) : kNoPart);
  for (std::size_t i = 0; i < loops_.size(); ++i) {
    const bool counts =
        loops_[i].state == LoopState::kAccepted || loops_[i].state == LoopState::kPending;
    if (!counts || loops_[i].radius_m <= 0.0) continue;
    consistency_.add(graphEdgeOf(loops_[i]), chain_);
    verified_.push_back(i);
  }
}

/// The newest submap is finished.
void SubmapGraph::addPlace() {
  const std::size_t last = keyframes_.size();
  std::size_t first = last;
  while (first > part_begin_ && keyframes_[first - 1].submap == keyframes_.back().submap) --first;
  const auto overlap = static_cast<std::size_t>(mapper_.window.overlap_scans);
  places_.add(keyframes_.back().submap, first - std::min(first - part_begin_, overlap), last);
}

void SubmapGraph::beginPart(const std::optional<GaussianPose2>& map_T_base) {
  start_ = map_T_base;
  start_is_given_ = start_.has_value();
  guess_.reset();
  finder_.reset();
  if (keyframes_.empty()) return;
  if (!start_) finder_ = std::make_unique<PartFinder>(mapper_, keyframesOf(largestPart(joined_)));
  if (keyframes_.size() == part_begin_) return;
  const bool open =
      places_.all().empty() || places_.all().back().submap != keyframes_.back().submap;
  if (open) addPlace();
  submap_offset_ = keyframes_.back().submap + 1;
  part_begin_ = searched_ = keyframes_.size();
}

std::vector<PlacedKeyframe> mapKeyframes(const GraphRecord& record) {
  const std::vector<std::size_t> parts = connectedParts(record.graph);
  const std::size_t largest = largestPart(parts);
  std::vector<PlacedKeyframe> result;
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (parts[i] == largest)
      result.push_back({record.keyframes[i].keyframe, record.graph.vertices[i].pose});
  return result;
}

std::vector<PlacedKeyframe> SubmapGraph::keyframesOf(std::size_t part) const {
  std::vector<PlacedKeyframe> result;
  for (std::size_t i = 0; i < keyframes_.size(); ++i)
    if (joined_[i] == part) result.push_back({keyframes_[i].keyframe, poseOf(i)});
  return result;
}

std::size_t SubmapGraph::partCount() const {
  return std::set<std::size_t>(joined_.begin() + static_cast<std::ptrdiff_t>(loaded_),
                               joined_.end())
      .size();
}

/// `start_` says where this keyframe of the newest part may be.
void SubmapGraph::guess(std::size_t keyframe) {
  const auto distance = [&](std::size_t i) {
    return (poseOf(i).translation() - poseOf(keyframe).translation()).norm();
  };
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < part_begin_; ++i)
    if (distance(i) < distance(nearest)) nearest = i;
  if (part_begin_ == 0) return;
  guess_ = PoseEdge{nearest, keyframe, poseOf(nearest).between(poseOf(keyframe)),
                    start_->covariance.inverse(), EdgeKind::kOdometry};
}

/// Looks for the newest part in the whole map: if nobody knows where it began, or if no loop has
/// confirmed the given start over some meters. Where it is found, a loop has to verify it.
void SubmapGraph::lookForPart(const PlanarScan& scan) {
  constexpr double kTrustedStartM = 10.0;
  /// Work of the search with every keyframe, see WorkBudget. A flight whose start is given may be
  /// in new space for a long time.
  constexpr std::int64_t kWork = 20'000'000, kWorkBesideStart = 5'000'000;
  if (part_begin_ == 0 || (!finder_ && !start_is_given_)) return;
  if (joined_.back() < part_begin_) return finder_.reset();
  const double path = pathBetween(part_begin_, keyframes_.size() - 1);
  if (!finder_ && config_.enabled && path >= kTrustedStartM)
    finder_ = std::make_unique<PartFinder>(mapper_, keyframesOf(largestPart(joined_)));
  if (!finder_) return;
  const std::optional<Pose2> map_T_local = finder_->add(scan, keyframes_.back().local_T_base,
                                                        start_is_given_ ? kWorkBesideStart : kWork);
  if (!map_T_local) return;
  if (start_is_given_) {
    verifyFound(*map_T_local);
  } else {
    moveNewestPart(*map_T_local);
    guessFound();
  }
}

/// The given start is only given up for a place that a loop verifies.
void SubmapGraph::verifyFound(const Pose2& map_T_local) {
  const auto most = static_cast<std::size_t>(config_.query_keyframes);
  const std::size_t last = keyframes_.size();
  const Pose2 before = mapTLocal();
  const std::optional<GaussianPose2> start = start_;
  const std::optional<PoseEdge> guess = guess_;
  moveNewestPart(map_T_local);
  guessFound();
  search({std::max(part_begin_, last - std::min(most, last)), last});
  if (joined_.back() < part_begin_) return;
  moveNewestPart(before);
  start_ = start;
  guess_ = guess;
}

void SubmapGraph::moveNewestPart(const Pose2& map_T_local) {
  const Pose2 motion = map_T_local * mapTLocal().inverse();
  for (std::size_t i = part_begin_; i < keyframes_.size(); ++i)
    graph_.vertices[i].pose = motion * graph_.vertices[i].pose;
}

/// The last keyframe was found where it is.
void SubmapGraph::guessFound() {
  constexpr double kFoundM = 0.2, kFoundRad = 0.1;
  start_ = GaussianPose2{poseOf(keyframes_.size() - 1), Eigen::Matrix3d::Zero()};
  start_->covariance.diagonal() = Eigen::Vector3d(kFoundM, kFoundM, kFoundRad).cwiseAbs2();
  guess(keyframes_.size() - 1);
}

/// Uncertainty of all keyframes relative to one. Where no edges lead, the guess of the start does.
std::vector<RelativeUncertainty> SubmapGraph::uncertainties(std::size_t from) const {
  std::vector<RelativeUncertainty> result = uncertaintiesFrom(withOdometry(), from);
  if (!guess_ || !result[guess_->to].isKnown() || result[guess_->from].isKnown()) return result;
  const Eigen::Matrix3d covariance = guess_->information.inverse();
  RelativeUncertainty start = result[guess_->to];
  start.position_m2 += covariance(0, 0) + covariance(1, 1);
  start.yaw_rad2 += covariance(2, 2);
  const std::vector<RelativeUncertainty> beyond = uncertaintiesFrom(graph_, guess_->from);
  for (std::size_t i = 0; i < result.size(); ++i) {
    if (result[i].isKnown() || !beyond[i].isKnown()) continue;
    const double lever = poseOf(guess_->from).between(poseOf(i)).distance();
    result[i].position_m2 =
        start.position_m2 + start.yaw_rad2 * lever * lever + beyond[i].position_m2;
    result[i].yaw_rad2 = start.yaw_rad2 + beyond[i].yaw_rad2;
  }
  return result;
}

/// The loop joins two parts: the newer one moves as a whole, so that the loop fits.
void SubmapGraph::join(const Loop& loop) {
  const Pose2 map_T_query = poseOf(loop.anchor) * loop.anchor_T_query.mean;
  const Pose2 map_T_anchor = poseOf(loop.query) * loop.anchor_T_query.mean.inverse();
  const std::size_t stays = std::min(joined_[loop.anchor], joined_[loop.query]);
  const std::size_t moves = std::max(joined_[loop.anchor], joined_[loop.query]);
  const Pose2 motion = moves == joined_[loop.query] ? map_T_query * poseOf(loop.query).inverse()
                                                    : map_T_anchor * poseOf(loop.anchor).inverse();
  for (std::size_t i = 0; i < joined_.size(); ++i) {
    if (joined_[i] != moves) continue;
    joined_[i] = stays;
    graph_.vertices[i].pose = motion * graph_.vertices[i].pose;
  }
}

bool SubmapGraph::addLoop(const Loop& loop) {
  loops_.push_back(loop);
  loops_.back().state = LoopState::kPending;
  judge(loops_.back());
  if (shown_) shown_ = largestPart(joined_, loaded_);
  return loops_.size() > 0 && loops_.back().state == LoopState::kAccepted;
}

std::optional<GraphCorrection::Known> SubmapGraph::knownEnd() const {
  if (solutions_ == 0 || keyframes_.empty()) return std::nullopt;
  std::vector<double> weights = weights_;
  weights.resize(graph_.edges.size(), 1.0);  // edges since then
  const std::size_t end = keyframes_.size() - 1;
  const std::optional<GaussianPose2> first_T_end =
      KeyframeMarginals(graph_, errors_, weights).between(joined_[end], end);
  if (!first_T_end) return std::nullopt;
  UncertainPose local = end_;
  local.match_covariance.setZero();
  return GraphCorrection::Known{{poseOf(end), first_T_end->covariance}, local};
}

std::size_t SubmapGraph::memoryBytes() const {
  std::size_t bytes = places_.memoryBytes() + graph_.edges.capacity() * sizeof(PoseEdge) +
                      graph_.vertices.capacity() * sizeof(PoseVertex) +
                      loops_.capacity() * sizeof(Loop) +
                      errors_.capacity() * sizeof(KeyframeErrors);
  for (const LocalKeyframe& keyframe : keyframes_)
    bytes += sizeof keyframe + keyframe.keyframe->memoryBytes();
  return bytes + track_.memoryBytes() + (finder_ ? finder_->memoryBytes() : 0);
}

}  // namespace kestrel
