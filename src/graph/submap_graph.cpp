// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/submap_graph.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "kestrel_slam/graph/optimizer.h"

namespace kestrel {
namespace {

/// The search window covers this many standard deviations of the graph, and at least this yaw.
constexpr double kSigmas = 3.0, kLeastRad = 0.35;
/// Every fourth search is wide.
constexpr std::size_t kWideEvery = 4;
/// Within this distance a descent finds the pose without a search.
constexpr double kBasinM = 0.3;
/// A place is looked at if the query is at most this far outside of the search window: it shows
/// what is around it.
constexpr double kAroundM = 2.0;
/// Loops are of one place if the path between their keyframes is at most this long.
constexpr double kSamePlaceM = 15.0;
/// Smallest errors of the motion from one keyframe to the next.
constexpr double kMotionM = 0.003, kMotionRad = 0.001;
/// So many loops must confirm a loop for each one that contradicts it.
constexpr std::size_t kMajority = 2;
/// Expected loops do not change the poses much, so they wait for the next optimization.
constexpr double kMuchChi2 = 7.815;  // 95 % of three degrees of freedom
constexpr std::size_t kMostUnsolved = 20;
/// Keyframes before and after a place that are its neighbors.
constexpr std::size_t kNeighbors = 30;

/// Not a loop.
constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

Eigen::Matrix3d symmetric(const Eigen::Matrix3d& matrix) {
  return 0.5 * (matrix + matrix.transpose());
}

}  // namespace

SubmapGraph::SubmapGraph(const MapperConfig& mapper, const LoopConfig& config)
    : mapper_(mapper), config_(config), matcher_(mapper.matcher, config), places_(mapper) {}

void SubmapGraph::add(const PlanarScan& scan, const MapperResult& result) {
  track_.add(result.odom_T_base, result.reversed);
  if (!result.inserted) return;
  shown_.reset();
  const std::size_t places = places_.all().size();
  addKeyframe(scan, result);
  if (places_.all().size() > places && !track_.empty()) solve();
  if (!isQuery({searched_, keyframes_.size()})) return;
  const LoopQuery query{searched_, keyframes_.size()};
  searched_ = keyframes_.size();
  if (config_.enabled) search(query);
}

/// Whether these keyframes are enough to search for.
bool SubmapGraph::isQuery(const LoopQuery& query) const {
  const auto most = static_cast<std::size_t>(config_.query_keyframes);
  const std::size_t count = query.last - query.first;
  if (count >= most || count * 2 < most) return count >= most;
  return pathBetween(query.first, query.last - 1) >= config_.query_path_m;
}

void SubmapGraph::addKeyframe(const PlanarScan& scan, const MapperResult& result) {
  const std::size_t number = keyframes_.size();
  auto keyframe = std::make_shared<Keyframe>();
  const bool first = number == part_begin_;
  const std::uint32_t submap = submap_offset_ + result.submap;
  const Pose2 motion = first ? Pose2() : keyframes_.back().local_T_base.between(result.pose);
  keyframe->id = number == 0 ? 0 : keyframes_.back().keyframe->id + 1;
  keyframe->stamp = scan.stamp;
  keyframe->time = scan.time;
  keyframe->submap_T_base = result.pose;
  keyframe->covariance = symmetric(result.covariance);
  if (!first)
    keyframe->motion_covariance = symmetric(tangentCovariance(result.keyframe_covariance, motion));
  errors_.push_back({first ? tangentCovariance(result.uncertain.map_covariance, result.pose)
                           : tangentCovariance(result.lasting_covariance, motion),
                     tangentCovariance(result.uncertain.match_covariance, result.pose)});
  keyframe->new_view = result.new_view;
  if (scan.height.isKnown()) keyframe->height = scan.height;
  keyframe->scan = CompactScan(scan.rays);
  if (!first && keyframes_.back().submap != submap) addPlace();
  graph_.vertices.push_back({mapTLocal() * result.pose, number == 0});
  keyframes_.push_back({std::move(keyframe), submap, result.pose});
  end_ = result.uncertain;
  path_.push_back((number == 0 ? 0.0 : path_.back()) + motion.distance());
  joined_.push_back(first ? number : joined_.back());
  doubtful_.push_back(result.state != MatchState::kOk);
  if (first) {
    if (start_) guess(number);
  } else {
    addOdometry();
  }
  odometry_.vertices.emplace_back();
  chain_.grow(odometry_);
  track_.addKeyframe(number, result.pose);
  lookForPart(scan);
}

void SubmapGraph::addOdometry() {
  const std::size_t to = keyframes_.size() - 1;
  const Pose2 motion = keyframes_[to - 1].local_T_base.between(keyframes_[to].local_T_base);
  Eigen::Matrix3d tangent = keyframes_[to].keyframe->motion_covariance;
  tangent.diagonal() += Eigen::Vector3d(kMotionM, kMotionM, kMotionRad).cwiseAbs2();
  const PoseEdge edge{to - 1, to, motion, tangent.inverse(), EdgeKind::kOdometry};
  odometry_.edges.push_back(edge);
  graph_.edges.push_back(edge);
  loop_of_edge_.push_back(kNone);
}

/// Length of the path between two keyframes of one part, m.
double SubmapGraph::pathBetween(std::size_t a, std::size_t b) const {
  return std::abs(path_[a] - path_[b]);
}

bool SubmapGraph::areNear(std::size_t a, std::size_t b) const {
  return chain_.partOf(a) == chain_.partOf(b) && pathBetween(a, b) <= kSamePlaceM;
}

/// Neighbors of a place are not matched with it: they were inserted relative to it.
bool SubmapGraph::isNeighbor(const KnownPlace& place, std::size_t keyframe) const {
  return chain_.partOf(place.first) == chain_.partOf(keyframe) &&
         keyframe + kNeighbors >= place.first && keyframe < place.last + kNeighbors;
}

Pose2 SubmapGraph::mapTLocal(std::size_t keyframe) const {
  const Pose2& local = keyframes_[keyframe].local_T_base;
  return poseOf(keyframe) == local ? Pose2() : poseOf(keyframe) * local.inverse();  // exact
}

Pose2 SubmapGraph::mapTLocal() const {
  return keyframes_.size() == part_begin_ ? Pose2() : mapTLocal(keyframes_.size() - 1);
}

/// A place with its keyframe that is nearest to the query.
SubmapGraph::Candidate SubmapGraph::candidateAt(std::size_t place, std::size_t query) const {
  const Eigen::Vector2d position = poseOf(query).translation();
  Candidate candidate{place, 0, std::numeric_limits<double>::infinity(), 0.0, 0.0};
  for (std::size_t i = places_.all()[place].first; i < places_.all()[place].last; ++i) {
    const double distance = (poseOf(i).translation() - position).norm();
    if (distance < candidate.distance_m) candidate.distance_m = distance, candidate.anchor = i;
  }
  return candidate;
}

/// Finished submaps in which the query may be, nearest first.
std::vector<SubmapGraph::Candidate> SubmapGraph::candidatesFor(std::size_t query) const {
  const std::vector<RelativeUncertainty> uncertain = uncertainties(query);
  std::vector<Candidate> result;
  for (std::size_t p = 0; p < places_.all().size(); ++p) {
    const KnownPlace& place = places_.all()[p];
    if (isNeighbor(place, query)) continue;
    Candidate candidate = candidateAt(p, query);
    const RelativeUncertainty& error = uncertain[candidate.anchor];
    if (!error.isKnown()) continue;
    candidate.sigma_m = error.sigmaAt(candidate.distance_m);
    candidate.sigma_rad = std::sqrt(error.yaw_rad2);
    const double radius = std::max(config_.wide_radius_m, kSigmas * candidate.sigma_m);
    if (candidate.distance_m <= radius + kAroundM) result.push_back(candidate);
  }
  std::sort(result.begin(), result.end(), [](const Candidate& a, const Candidate& b) {
    return std::pair(a.distance_m, a.place) < std::pair(b.distance_m, b.place);
  });
  return result;
}

/// Where the graph is certain, one match shows whether it is right. Where it is not, or where this
/// match fails now and then, the place is searched for.
void SubmapGraph::search(const LoopQuery& query) {
  const bool wide = ++searches_ % kWideEvery == 0;
  bool confirmed = false;
  for (const Candidate& candidate : candidatesFor(query.middle())) {
    const double radius = std::max(config_.least_radius_m, kSigmas * candidate.sigma_m);
    const bool near = candidate.distance_m <= radius + kAroundM;
    if (near && kSigmas * candidate.sigma_m <= kBasinM) {
      confirmed = confirmed || confirm(candidate, query.middle());
      if (confirmed || !wide) continue;
    } else if (!near && (!wide || confirmed)) {
      continue;
    }
    searchAt(candidate, query, wide ? std::max(radius, config_.wide_radius_m) : radius);
    break;
  }
}

Pose2 SubmapGraph::expectedAt(const Candidate& candidate, std::size_t query) const {
  return keyframes_[candidate.anchor].local_T_base *
         poseOf(candidate.anchor).between(poseOf(query));
}

bool SubmapGraph::confirm(const Candidate& candidate, std::size_t query) {
  const Submap& map = places_.mapOf(candidate.place, keyframes_);
  const Loop loop = matcher_.matchExpected(map, places_.all()[candidate.place], keyframes_, query,
                                           expectedAt(candidate, query), kBasinM);
  if (loop.state != LoopState::kAccepted) return false;
  loops_.push_back(loop);
  accept(loops_.size() - 1);
  return true;
}

void SubmapGraph::searchAt(const Candidate& candidate, const LoopQuery& query, double radius_m) {
  const Submap& map = places_.mapOf(candidate.place, keyframes_);
  const Loop loop = matcher_.search(map, places_.all()[candidate.place], keyframes_, query,
                                    expectedAt(candidate, query.middle()),
                                    std::min(radius_m, config_.most_radius_m),
                                    std::max(kLeastRad, kSigmas * candidate.sigma_rad));
  loops_.push_back(loop);
  if (loop.state == LoopState::kPending) judge(loop);
}

/// Decides on the last loop, which fits: by what other loops of the same place say.
void SubmapGraph::judge(const Loop& found) {
  const std::size_t number = loops_.size() - 1;
  const std::size_t own = consistency_.add(graphEdgeOf(found), chain_);
  verified_.push_back(number);
  std::vector<std::size_t> confirming;
  std::size_t contradicting = 0;
  for (std::size_t i = 0; i < own; ++i) {
    const Loop& other = loops_[verified_[i]];
    if (other.state != LoopState::kAccepted && other.state != LoopState::kPending) continue;
    if (!areNear(other.query, found.query) || !areNear(other.anchor, found.anchor)) continue;
    if (consistency_.areConsistent(own, i)) {
      confirming.push_back(verified_[i]);
    } else {
      ++contradicting;
    }
  }
  Loop& loop = loops_[number];
  const bool certain = loop.radius_m <= config_.least_radius_m;
  if (contradicting > 0 && confirming.size() < kMajority * contradicting) {
    loop.reason = "another loop contradicts it";
  } else if (!certain && confirming.empty()) {
    loop.reason = "no other loop confirms it yet";
  } else {
    for (const std::size_t other : confirming) {
      if (loops_[other].state == LoopState::kPending) accept(other);
    }
    accept(number);
  }
}

void SubmapGraph::accept(std::size_t number) {
  Loop& loop = loops_[number];
  loop.state = LoopState::kAccepted;
  loop.reason = "";
  graph_.edges.push_back(graphEdgeOf(loop));
  loop_of_edge_.push_back(number);
  if (joined_[loop.anchor] != joined_[loop.query]) join(loop);
  optimizeIfNeeded(loop);
}

/// Loops that only confirm the graph wait until there are some of them.
void SubmapGraph::optimizeIfNeeded(const Loop& loop) {
  ++unsolved_;
  const double chi2 = chi2Of(graph_.edges.back(), graph_);
  if (loop.radius_m > 0.0 || chi2 > kMuchChi2 || unsolved_ >= kMostUnsolved) solve();
}

/// The finished submap of a keyframe.
std::size_t SubmapGraph::placeOf(std::size_t keyframe) const {
  const auto found = std::find_if(
      places_.all().begin(), places_.all().end(),
      [&](const KnownPlace& place) { return place.submap == keyframes_[keyframe].submap; });
  return static_cast<std::size_t>(found - places_.all().begin());
}

/// Looks for loops that confirm the pending ones, with the keyframes before and after each query:
/// with others, because a query agrees with itself.
void SubmapGraph::searchAround() {
  const auto length = static_cast<std::size_t>(config_.query_keyframes);
  const std::vector<Loop> found = loops_;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (loops_[i].state != LoopState::kPending || found[i].query < loaded_) continue;
    const std::size_t begin = found[i].query - std::min(found[i].query, length / 2);
    for (const std::size_t first : {begin - std::min(begin, length), begin + length}) {
      const LoopQuery query{first, std::min(first + length, keyframes_.size())};
      if (query.last < query.first + length / 2 || query.first == begin) continue;
      if (chain_.partOf(query.first) != chain_.partOf(query.last - 1)) continue;
      searchAt(candidateAt(placeOf(found[i].anchor), query.middle()), query, found[i].radius_m);
    }
  }
}

void SubmapGraph::finish() {
  searchAround();
  refine();
  shown_ = largestPart(joined_, loaded_);
}

}  // namespace kestrel
