// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/submap_graph.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <queue>

#include "kestrel_slam/graph/optimizer.h"
#include "kestrel_slam/matching/fit.h"
#include "kestrel_slam/matching/thinned.h"

namespace kestrel {
namespace {
double env(const char* name, double value) {
  const char* text = std::getenv(name);
  return text ? std::atof(text) : value;
}
const bool kVerbose = env("KV", 0) > 0;

Eigen::Matrix3d informationOf(const Eigen::Matrix3d& covariance) { return covariance.inverse(); }
Eigen::Matrix3d floorOf(double m, double rad) {
  return Eigen::Vector3d(m * m, m * m, rad * rad).asDiagonal();
}
}  // namespace

SubmapGraph::SubmapGraph(const MapperConfig& mapper, const LoopConfig& config)
    : mapper_(mapper), config_(config) {
  config_.min_margin = env("MARGIN", config.min_margin);
  config_.min_fit = env("FIT", config.min_fit);
  config_.min_known = env("KNOWN", config.min_known);
  config_.min_constraint = env("CONSTRAINT", config.min_constraint);
  config_.min_agreement = env("AGREE", config.min_agreement);
  config_.query_keyframes = static_cast<int>(env("QUERY", config.query_keyframes));
}

void SubmapGraph::add(const PlanarScan& scan, const MapperResult& result) {
  if (!result.inserted) return;
  if (result.finished_window) addPlace(result);
  const Pose2 map_T_base = mapTLocal() * result.pose;
  keyframes_.push_back({scan.stamp, scan.time, result.submap, result.pose, scan,
                        thinned(hitsOf(scan), 400), result.new_view});
  graph_.vertices.push_back({map_T_base, keyframes_.size() == 1});
  if (keyframes_.size() > 1) addOdometry(result);
  if (!config_.enabled) return;
  if (keyframes_.size() >= searched_ + static_cast<std::size_t>(config_.query_keyframes)) search();
}

void SubmapGraph::addOdometry(const MapperResult& result) {
  const std::size_t to = keyframes_.size() - 1;
  const Pose2 motion = keyframes_[to - 1].local_T_base.between(keyframes_[to].local_T_base);
  const Eigen::Matrix3d covariance =
      tangentCovariance(result.keyframe_covariance, motion) * env("ODOCOV", 1.0) +
      floorOf(0.003, 0.001);
  graph_.edges.push_back({to - 1, to, motion, informationOf(covariance), EdgeKind::kOdometry});
}

void SubmapGraph::addPlace(const MapperResult& result) {
  Place place;
  place.map = result.finished_window;
  place.last_submap = result.submap - 1;
  place.last = keyframes_.size();
  place.first = place.last;
  while (place.first > 0 && keyframes_[place.first - 1].submap >= place.last_submap) --place.first;
  places_.push_back(place);
}

Pose2 SubmapGraph::mapTLocal(std::size_t keyframe) const {
  return graph_.vertices[keyframe].pose * keyframes_[keyframe].local_T_base.inverse();
}
Pose2 SubmapGraph::mapTLocal() const {
  return keyframes_.empty() ? Pose2() : mapTLocal(keyframes_.size() - 1);
}

/// Dijkstra: the variance of the position (without the lever arm of the yaw) and of the yaw of all
/// keyframes relative to `from`.
std::vector<double> SubmapGraph::variances(std::size_t from, std::vector<double>& yaw) const {
  std::vector<std::vector<std::size_t>> edges(keyframes_.size());
  for (std::size_t i = 0; i < graph_.edges.size(); ++i) {
    edges[graph_.edges[i].from].push_back(i);
    edges[graph_.edges[i].to].push_back(i);
  }
  std::vector<double> result(keyframes_.size(), 1e9);
  yaw.assign(keyframes_.size(), 1e9);
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  result[from] = yaw[from] = 0.0;
  open.emplace(0.0, from);
  while (!open.empty()) {
    const auto [variance, at] = open.top();
    open.pop();
    if (variance > result[at]) continue;
    for (const std::size_t i : edges[at]) {
      const PoseEdge& edge = graph_.edges[i];
      const std::size_t to = edge.from == at ? edge.to : edge.from;
      const Eigen::Matrix3d covariance = edge.information.inverse();
      const double next = variance + covariance.topLeftCorner<2, 2>().trace();
      if (next >= result[to]) continue;
      result[to] = next;
      yaw[to] = yaw[at] + covariance(2, 2);
      open.emplace(next, to);
    }
  }
  return result;
}

std::vector<SubmapGraph::Candidate> SubmapGraph::candidates(std::size_t query,
                                                            double least_radius) const {
  std::vector<double> yaw;
  const std::vector<double> position = variances(query, yaw);
  const Pose2& pose = graph_.vertices[query].pose;
  std::vector<Candidate> result;
  for (const Place& place : places_) {
    if (place.last_submap + static_cast<std::uint32_t>(env("GAP", 2)) > keyframes_.back().submap)
      continue;
    Candidate best{&place, 0, 1e9, 0, 0};
    for (std::size_t i = place.first; i < place.last; ++i) {
      const double distance = (graph_.vertices[i].pose.translation() - pose.translation()).norm();
      if (distance < best.distance_m) best.distance_m = distance, best.anchor = i;
    }
    const double lever = yaw[best.anchor] * best.distance_m * best.distance_m;
    best.sigma_m = std::sqrt(position[best.anchor] + lever);
    best.sigma_rad = std::sqrt(yaw[best.anchor]);
    if (best.distance_m > std::max(least_radius, config_.sigmas * best.sigma_m) + 2.0) continue;
    result.push_back(best);
  }
  std::sort(result.begin(), result.end(),
            [](const Candidate& a, const Candidate& b) { return a.distance_m < b.distance_m; });
  return result;
}

Points SubmapGraph::queryPoints(std::size_t first, std::size_t last, std::size_t frame) const {
  const Pose2 frame_T_local = keyframes_[frame].local_T_base.inverse();
  Points result;
  for (std::size_t i = first; i < last; ++i) {
    const Pose2 frame_T_base = frame_T_local * keyframes_[i].local_T_base;
    for (const Eigen::Vector2f& hit : keyframes_[i].hits)
      result.push_back((frame_T_base * hit.cast<double>()).cast<float>());
  }
  return result;
}

void SubmapGraph::search() {
  const std::size_t first = searched_, last = keyframes_.size();
  searched_ = last;
  ++searches_;
  const std::size_t query = (first + last) / 2;
  const bool wide = searches_ % 4 == 0;
  const double least = wide ? config_.wide_radius_m : config_.least_radius_m;
  const std::vector<Candidate> all = candidates(query, least);
  const std::size_t before = graph_.edges.size();
  std::size_t tried = 0;
  for (const Candidate& candidate : all) {
    if (tried++ >= static_cast<std::size_t>(env("TRIES", 3))) break;
    const double radius = std::max(least, config_.sigmas * candidate.sigma_m);
    tryLoop(candidate, first, last, std::min(radius, env("MAXR", 15.0)));
  }
  if (graph_.edges.size() > before) solve();
}

void SubmapGraph::tryLoop(const Candidate& candidate, std::size_t first, std::size_t last,
                          double radius) {
  const std::size_t query = (first + last) / 2;
  const Place& place = *candidate.place;
  const Points points = queryPoints(first, last, query);
  const Pose2& local_T_anchor = keyframes_[candidate.anchor].local_T_base;
  const Pose2 anchor_T_query =
      graph_.vertices[candidate.anchor].pose.between(graph_.vertices[query].pose);
  const Pose2 guess = local_T_anchor * anchor_T_query;
  const SearchWindow window{std::max(radius, config_.wide_radius_m),
                            std::max(0.35, config_.sigmas * candidate.sigma_rad)};
  const PlaceMatch found = matchPlace(*place.map, points, guess, window, mapper_.matcher,
                                      static_cast<std::int64_t>(env("WORK", 40e6)));
  Loop loop;
  loop.query = query;
  loop.anchor = candidate.anchor;
  loop.fit = found.match.score;
  loop.known = found.match.known;
  loop.constraint = found.match.constraint;
  loop.margin = found.score - found.second_score;
  loop.radius_m = radius;
  loop.correction_m = (guess.between(found.match.pose)).distance();
  // The anchor is the keyframe next to the query.
  double nearest = 1e9;
  for (std::size_t i = place.first; i < place.last; ++i) {
    const double distance = keyframes_[i].local_T_base.between(found.match.pose).distance();
    if (distance < nearest) nearest = distance, loop.anchor = i;
  }
  const Pose2 measured = keyframes_[loop.anchor].local_T_base.between(found.match.pose);
  const double scale = env("LOOPCOV", 4.0);
  loop.anchor_T_query = {measured,
                         tangentCovariance(found.match.covariance, found.match.pose) * scale +
                             floorOf(env("LOOPM", 0.015), env("LOOPR", 0.004))};
  if (loop.fit < config_.min_fit) {
    loop.refused = "fit";
  } else if (loop.known < config_.min_known) {
    loop.refused = "known";
  } else if (loop.constraint < config_.min_constraint) {
    loop.refused = "constraint";
  } else if (loop.margin < config_.min_margin) {
    loop.refused = "ambiguous";
  } else if (loop.correction_m > radius) {
    loop.refused = "far";
  } else {
    loop.agreement = agreementOf(place, found.match.pose, first, last, query, found.match);
    if (loop.agreement < config_.min_agreement) loop.refused = "agreement";
  }
  loops_.push_back(loop);
  if (*loop.refused == '\0') accept(loop);
}

double SubmapGraph::agreementOf(const Place& place, const Pose2& local_T_query, std::size_t first,
                                std::size_t last, std::size_t query,
                                const MatchResult& match) const {
  int agree = 0, all = 0;
  for (std::size_t i = first; i < last; ++i) {
    if (keyframes_[i].hits.size() < 10) continue;
    const Pose2 expected =
        local_T_query * keyframes_[query].local_T_base.between(keyframes_[i].local_T_base);
    const MatchResult single = matchNear(*place.map, keyframes_[i].hits, expected, mapper_.matcher);
    ++all;
    Eigen::Vector2d away = single.pose.translation() - expected.translation();
    if (single.degenerate)
      away -= single.degenerate_direction * single.degenerate_direction.dot(away);
    if (match.degenerate) away -= match.degenerate_direction * match.degenerate_direction.dot(away);
    if (single.score >= 0.6 && single.known >= 0.4 && away.norm() < 0.15 &&
        std::abs(normalizeAngle(single.pose.yaw - expected.yaw)) < 0.035)
      ++agree;
  }
  return all == 0 ? 0.0 : static_cast<double>(agree) / all;
}

void SubmapGraph::accept(const Loop& loop) {
  graph_.edges.push_back({loop.anchor, loop.query, loop.anchor_T_query.mean,
                          informationOf(loop.anchor_T_query.covariance), EdgeKind::kLoop});
}

void SubmapGraph::solve() {
  OptimizerOptions options;
  options.kernel_scale = env("KERNEL", options.kernel_scale);
  const OptimizerResult result = optimize(graph_, options);
  if (!result.ok()) std::fprintf(stderr, "optimize: %s\n", result.problem.c_str());
}

/// Matches one keyframe with all places that it overlaps where the graph says it is.
void SubmapGraph::refine(std::size_t keyframe) {
  std::vector<double> yaw;
  const Pose2& pose = graph_.vertices[keyframe].pose;
  int count = 0;
  for (const Place& place : places_) {
    if (keyframe + 5 >= place.first && keyframe < place.last + 5) continue;
    double nearest = 1e9;
    std::size_t anchor = 0;
    for (std::size_t i = place.first; i < place.last; ++i) {
      const double distance = (graph_.vertices[i].pose.translation() - pose.translation()).norm();
      if (distance < nearest) nearest = distance, anchor = i;
    }
    if (nearest > env("REFNEAR", 3.0)) continue;
    const Pose2 guess =
        keyframes_[anchor].local_T_base * graph_.vertices[anchor].pose.between(pose);
    const MatchResult match =
        matchNear(*place.map, keyframes_[keyframe].hits, guess, mapper_.matcher);
    if (match.score < env("REFFIT", 0.75) || match.known < 0.6 || match.constraint < 0.02) continue;
    if (guess.between(match.pose).distance() > 0.3) continue;
    if (std::abs(guess.between(match.pose).yaw) > 0.1) continue;
    const Pose2 measured = keyframes_[anchor].local_T_base.between(match.pose);
    const Eigen::Matrix3d covariance =
        tangentCovariance(match.covariance, match.pose) * env("LOOPCOV", 4.0) +
        floorOf(env("LOOPM", 0.015), env("LOOPR", 0.004));
    graph_.edges.push_back(
        {anchor, keyframe, measured, informationOf(covariance), EdgeKind::kLoop});
    if (++count >= 4) break;
  }
}

void SubmapGraph::finish() {
  if (!config_.enabled) return;
  if (graph_.edges.size() >= keyframes_.size()) solve();
  const int every = static_cast<int>(env("REFINE", 3));
  const std::size_t loops = graph_.edges.size() - keyframes_.size() + 1;
  if (every > 0 && loops > 0) {
    for (std::size_t i = 0; i < keyframes_.size(); i += static_cast<std::size_t>(every)) refine(i);
    solve();
  }
  if (!kVerbose) return;
  std::map<std::string, int> refused;
  for (const Loop& loop : loops_) {
    ++refused[loop.refused];
    if (kVerbose)
      std::fprintf(stderr,
                   "loop %.3f -> %.3f fit %.2f known %.2f constraint %.3f margin %.2f agree %.2f r "
                   "%.1f corr %.2f %s\n",
                   keyframes_[loop.anchor].stamp, keyframes_[loop.query].stamp, loop.fit,
                   loop.known, loop.constraint, loop.margin, loop.agreement, loop.radius_m,
                   loop.correction_m, loop.refused);
  }
  for (const auto& [reason, count] : refused)
    std::fprintf(stderr, "%s: %d\n", reason.empty() ? "accepted" : reason.c_str(), count);
  std::fprintf(stderr, "%zu keyframes, %zu places, %zu edges, %zu refined\n", keyframes_.size(),
               places_.size(), graph_.edges.size(),
               graph_.edges.size() - keyframes_.size() + 1 - loops);
}

}  // namespace kestrel
