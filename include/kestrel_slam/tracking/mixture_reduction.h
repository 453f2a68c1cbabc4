// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "kestrel_slam/tracking/phd_filter.h"

namespace kestrel {

/// One Gaussian with the weight, mean and covariance of a mixture; mode and label of the first.
template <int N>
PhdComponent<N> mergedOf(const std::vector<const PhdComponent<N>*>& parts) {
  PhdComponent<N> merged = *parts.front();
  if (parts.size() == 1) return merged;
  merged.weight = 0.0;
  merged.mean.setZero();
  merged.covariance.setZero();
  for (const PhdComponent<N>* part : parts) merged.weight += part->weight;
  for (const PhdComponent<N>* part : parts) {
    merged.mean += part->weight / merged.weight * part->mean;
  }
  for (const PhdComponent<N>* part : parts) {
    const Eigen::Matrix<double, N, 1> offset = part->mean - merged.mean;
    merged.covariance +=
        part->weight / merged.weight * (part->covariance + offset * offset.transpose());
  }
  return merged;
}

/// Squared Mahalanobis distances to Gaussians of one covariance C [Vo 2006, table II]. C may be
/// singular, as that of a target that stands, whose turn rate is exactly zero: in the directions
/// that it spans, the distance is that of its generalized inverse (the limit of C + e I for e ->
/// 0); beyond them, the target cannot be, and the distance is infinite.
///
/// Factors C = L D L' column by column. A column of a semidefinite C is zero where its entry of D
/// is, so that the equation of this row says whether the offset lies in the span.
template <int N>
class GaussianDistance {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;

  explicit GaussianDistance(const Eigen::Matrix<double, N, N>& covariance) {
    Eigen::Matrix<double, N, N> rest = covariance;
    for (int k = 0; k < N; ++k) {
      diagonal_(k) = rest(k, k) > kRounding * covariance(k, k) ? rest(k, k) : 0.0;
      if (diagonal_(k) > 0.0) {
        lower_.col(k) = rest.col(k) / diagonal_(k);
      } else {
        lower_.col(k).setZero();
      }
      for (int j = k + 1; j < N; ++j) rest.col(j) -= lower_.col(k) * lower_(j, k) * diagonal_(k);
    }
  }

  /// Between the places `a` and `b`.
  double squared(const Vector& a, const Vector& b) const {
    Vector rest = a - b, solved;
    double sum = 0.0;
    for (int k = 0; k < N; ++k) {
      solved(k) = rest(k);
      if (diagonal_(k) > 0.0) {
        sum += solved(k) * solved(k) / diagonal_(k);
      } else {
        double terms = std::abs(a(k)) + std::abs(b(k));
        for (int j = 0; j < k; ++j) terms += std::abs(lower_(k, j) * solved(j));
        if (std::abs(solved(k)) > kRounding * terms) return std::numeric_limits<double>::infinity();
      }
      rest -= lower_.col(k) * solved(k);
    }
    return sum;
  }

 private:
  /// Of what a difference of nearly equal numbers loses: a rest that is smaller is zero.
  static constexpr double kRounding = 1e-10;
  /// Only what is below the diagonal counts: whole columns are faster than their parts.
  Eigen::Matrix<double, N, N> lower_;
  Vector diagonal_;
};

/// A lower bound of the squared Mahalanobis distance to a Gaussian: the one of its first two
/// coordinates. It decides most pairs without the factors of the covariance.
template <int N>
struct PlaneBound {
  double x, y;
  double inverse_xx, slope, inverse_rest;

  explicit PlaneBound(const PhdComponent<N>& c) : x(c.mean(0)), y(c.mean(1)) {
    constexpr double kSingular = 1e-6;  // rounding would decide
    const double xx = c.covariance(0, 0), yx = c.covariance(1, 0), yy = c.covariance(1, 1);
    inverse_xx = xx > 0.0 ? 1.0 / xx : 0.0;
    slope = yx * inverse_xx;
    const double rest = yy - slope * yx;
    inverse_rest = rest > kSingular * yy ? 1.0 / rest : 0.0;
  }
  bool exceeds(double limit, const PlaneBound& other) const {
    const double dx = x - other.x;
    const double along = dx * dx * inverse_xx;
    if (along > limit) return true;
    const double across = y - other.y - slope * dx;
    return along + across * across * inverse_rest > limit;
  }
};

template <int N>
void sortByWeight(std::vector<const PhdComponent<N>*>& components) {
  std::stable_sort(components.begin(), components.end(),
                   [](const auto* a, const auto* b) { return a->weight > b->weight; });
}

/// Pruning, merging and the cap of [Vo 2006, table II], in the order of falling weight. A component
/// is merged into a heavier one of the same motion model if `may_merge(heavier, component)` allows
/// it.
template <int N, typename MayMerge>
std::vector<PhdComponent<N>> reduceMixture(const std::vector<PhdComponent<N>>& mixture,
                                           const PhdLimits& limits, MayMerge may_merge) {
  using Component = PhdComponent<N>;
  constexpr double kRounding = 1.0 + 1e-6;
  std::vector<const Component*> order;  // a component is too large to be moved by sorting
  for (const Component& c : mixture) {
    if (c.weight > limits.prune_weight) order.push_back(&c);
  }
  sortByWeight<N>(order);
  std::vector<PlaneBound<N>> bounds;
  bounds.reserve(order.size());
  for (const Component* component : order) bounds.emplace_back(*component);
  std::vector<std::optional<GaussianDistance<N>>> distances(order.size());
  // Chains of the components of one motion model that are not merged yet.
  std::vector<std::size_t> next(order.size()), first;
  for (std::size_t i = order.size(); i-- > 0;) {
    const auto mode = static_cast<std::size_t>(order[i]->mode);
    if (first.size() <= mode) first.resize(mode + 1, order.size());
    next[i] = std::exchange(first[mode], i);
  }
  std::vector<char> merged(order.size(), 0);
  const auto isNear = [&](std::size_t i, std::size_t j) {
    if (bounds[j].exceeds(kRounding * limits.merge_distance, bounds[i])) return false;
    if (!distances[j]) distances[j].emplace(order[j]->covariance);
    return distances[j]->squared(order[j]->mean, order[i]->mean) <= limits.merge_distance;
  };
  std::vector<Component> kept;
  kept.reserve(order.size());
  std::vector<const Component*> parts;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (merged[i] != 0) continue;
    parts.assign(1, order[i]);
    std::size_t last = i;
    for (std::size_t j = next[i]; j < order.size(); j = next[j]) {
      if (isNear(i, j) && may_merge(*order[i], *order[j])) {
        merged[j] = 1;
        parts.push_back(order[j]);
        next[last] = next[j];
      } else {
        last = j;
      }
    }
    kept.push_back(mergedOf(parts));
  }
  order.clear();
  for (const Component& component : kept) order.push_back(&component);
  sortByWeight<N>(order);
  if (order.size() > limits.max_components) order.resize(limits.max_components);
  std::vector<Component> result;
  result.reserve(order.size());
  for (const Component* component : order) result.push_back(*component);
  return result;
}

}  // namespace kestrel
