// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/evaluation/tracking_metrics.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/evaluation/assignment.h"

namespace kestrel {
namespace {

/// Distances to the power `order`, at most `cutoff`.
Eigen::MatrixXd costsOf(const PointSet& rows, const PointSet& columns, double cutoff,
                        double order) {
  Eigen::MatrixXd costs(rows.size(), columns.size());
  for (Eigen::Index i = 0; i < costs.rows(); ++i) {
    for (Eigen::Index j = 0; j < costs.cols(); ++j) {
      const double distance =
          (rows[static_cast<std::size_t>(i)] - columns[static_cast<std::size_t>(j)]).norm();
      costs(i, j) = std::pow(std::min(distance, cutoff), order);
    }
  }
  return costs;
}

/// The best assignment; pairs at the cutoff do not count as assigned.
struct Pairs {
  double cost = 0.0;
  std::size_t count = 0;
};

Pairs bestPairs(const PointSet& truth, const PointSet& estimate, double cutoff, double order) {
  Pairs pairs;
  if (truth.empty() || estimate.empty()) return pairs;
  const Eigen::MatrixXd costs = costsOf(truth, estimate, cutoff, order);
  const std::vector<int> column_of = cheapestAssignment(costs);
  const double limit = std::pow(cutoff, order);
  for (std::size_t i = 0; i < column_of.size(); ++i) {
    if (column_of[i] < 0) continue;
    const double cost = costs(static_cast<Eigen::Index>(i), column_of[i]);
    if (cost >= limit) continue;
    pairs.cost += cost;
    ++pairs.count;
  }
  return pairs;
}

}  // namespace

SetDistance ospa(const PointSet& truth, const PointSet& estimate, double cutoff, double order) {
  SetDistance result;
  const std::size_t larger = std::max(truth.size(), estimate.size());
  if (larger == 0) return result;
  const Pairs pairs = bestPairs(truth, estimate, cutoff, order);
  result.missed = truth.size() - pairs.count;
  result.extra = estimate.size() - pairs.count;
  // Pairs at the cutoff are a part of the localization in the definition.
  const std::size_t smaller = std::min(truth.size(), estimate.size());
  const double limit = std::pow(cutoff, order), n = static_cast<double>(larger);
  const double near = pairs.cost + static_cast<double>(smaller - pairs.count) * limit;
  const double unpaired = static_cast<double>(larger - smaller) * limit;
  result.localization = std::pow(near / n, 1.0 / order);
  result.cardinality = std::pow(unpaired / n, 1.0 / order);
  result.total = std::pow((near + unpaired) / n, 1.0 / order);
  return result;
}

SetDistance gospa(const PointSet& truth, const PointSet& estimate, double cutoff, double order) {
  const Pairs pairs = bestPairs(truth, estimate, cutoff, order);
  SetDistance result;
  result.missed = truth.size() - pairs.count;
  result.extra = estimate.size() - pairs.count;
  const double unpaired =
      static_cast<double>(result.missed + result.extra) * std::pow(cutoff, order) / 2.0;
  result.localization = std::pow(pairs.cost, 1.0 / order);
  result.cardinality = std::pow(unpaired, 1.0 / order);
  result.total = std::pow(pairs.cost + unpaired, 1.0 / order);
  return result;
}

double ClearMot::mota() const {
  const auto errors = static_cast<double>(misses + false_tracks + switches);
  return truths > 0 ? 1.0 - errors / static_cast<double>(truths) : 0.0;
}

double ClearMot::motp() const {
  return matches > 0 ? distance_sum / static_cast<double>(matches) : 0.0;
}

void ClearMotCounter::add(const TrackedFrame& frame) {
  ++result_.frames;
  const std::vector<int> track_of = match(frame);
  std::vector<bool> used(frame.tracks.size(), false);
  for (std::size_t i = 0; i < frame.truth.size(); ++i) {
    const bool found = track_of[i] >= 0;
    const auto track = static_cast<std::size_t>(std::max(track_of[i], 0));
    if (found) used[track] = true;
    count(frame.truth[i], found ? &frame.tracks[track] : nullptr);
  }
  result_.false_tracks += static_cast<std::size_t>(std::count(used.begin(), used.end(), false));
}

std::vector<int> ClearMotCounter::match(const TrackedFrame& frame) const {
  std::vector<int> track_of(frame.truth.size(), -1);
  for (std::size_t i = 0; i < frame.truth.size(); ++i) {
    const auto seen = objects_.find(frame.truth[i].id);
    if (seen == objects_.end() || !seen->second.found) continue;
    for (std::size_t j = 0; j < frame.tracks.size(); ++j) {
      if (frame.tracks[j].id == seen->second.track &&
          (frame.tracks[j].position - frame.truth[i].position).norm() <= max_distance_) {
        track_of[i] = static_cast<int>(j);
      }
    }
  }
  assignRest(frame, track_of);
  return track_of;
}

void ClearMotCounter::assignRest(const TrackedFrame& frame, std::vector<int>& track_of) const {
  std::vector<std::size_t> rows, columns;
  for (std::size_t i = 0; i < frame.truth.size(); ++i) {
    if (track_of[i] < 0) rows.push_back(i);
  }
  for (std::size_t j = 0; j < frame.tracks.size(); ++j) {
    if (std::find(track_of.begin(), track_of.end(), static_cast<int>(j)) == track_of.end()) {
      columns.push_back(j);
    }
  }
  if (rows.empty() || columns.empty()) return;
  // A pair that is too far costs so much that as many pairs as possible are made first.
  const double too_far =
      (max_distance_ + 1.0) * static_cast<double>(std::max(rows.size(), columns.size()) + 1);
  Eigen::MatrixXd costs(rows.size(), columns.size());
  for (Eigen::Index i = 0; i < costs.rows(); ++i) {
    for (Eigen::Index j = 0; j < costs.cols(); ++j) {
      const double distance = (frame.truth[rows[static_cast<std::size_t>(i)]].position -
                               frame.tracks[columns[static_cast<std::size_t>(j)]].position)
                                  .norm();
      costs(i, j) = distance <= max_distance_ ? distance : too_far;
    }
  }
  const std::vector<int> column_of = cheapestAssignment(costs);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (column_of[i] < 0 || costs(static_cast<Eigen::Index>(i), column_of[i]) >= too_far) continue;
    track_of[rows[i]] = static_cast<int>(columns[static_cast<std::size_t>(column_of[i])]);
  }
}

void ClearMotCounter::count(const TrackedObject& object, const TrackedObject* track) {
  Seen& seen = objects_[object.id];
  const bool found_before = seen.found;
  seen.found = track != nullptr;
  if (track != nullptr) seen.track = track->id;
  if (!object.counts) return;
  ++result_.truths;
  ++seen.frames;
  if (track == nullptr) {
    ++result_.misses;
    return;
  }
  ++result_.matches;
  ++seen.by_track[track->id];
  result_.distance_sum += (track->position - object.position).norm();
  // What it was while it did not count does not hide a switch.
  const bool known = seen.counted >= 0;
  if (known && seen.counted != track->id) ++result_.switches;
  if (known && !found_before) ++result_.fragments;
  seen.counted = track->id;
}

std::map<long, double> ClearMotCounter::identityShares() const {
  std::map<long, double> shares;
  for (const auto& [id, seen] : objects_) {
    std::size_t longest = 0;
    for (const auto& [track, frames] : seen.by_track) longest = std::max(longest, frames);
    if (seen.frames > 0) {
      shares[id] = static_cast<double>(longest) / static_cast<double>(seen.frames);
    }
  }
  return shares;
}

}  // namespace kestrel
