// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
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

/// Pruning, merging and the cap of [Vo 2006, table II], in the order of falling weight. A component
/// is merged into a heavier one if `may_merge(heavier, component)` allows it.
template <int N, typename MayMerge>
std::vector<PhdComponent<N>> reduceMixture(std::vector<PhdComponent<N>> mixture,
                                           const PhdLimits& limits, MayMerge may_merge) {
  using Component = PhdComponent<N>;
  mixture.erase(
      std::remove_if(mixture.begin(), mixture.end(),
                     [&](const Component& c) { return !(c.weight > limits.prune_weight); }),
      mixture.end());
  std::stable_sort(mixture.begin(), mixture.end(),
                   [](const Component& a, const Component& b) { return a.weight > b.weight; });
  std::vector<Eigen::LLT<Eigen::Matrix<double, N, N>>> inverses;
  inverses.reserve(mixture.size());
  for (const Component& component : mixture) inverses.emplace_back(component.covariance);
  std::vector<bool> merged(mixture.size(), false);
  std::vector<Component> result;
  for (std::size_t i = 0; i < mixture.size(); ++i) {
    if (merged[i]) continue;
    std::vector<const Component*> parts{&mixture[i]};
    for (std::size_t j = i + 1; j < mixture.size(); ++j) {
      if (merged[j] || !may_merge(mixture[i], mixture[j])) continue;
      const Eigen::Matrix<double, N, 1> offset = mixture[j].mean - mixture[i].mean;
      if (inverses[j].matrixL().solve(offset).squaredNorm() > limits.merge_distance) continue;
      merged[j] = true;
      parts.push_back(&mixture[j]);
    }
    result.push_back(mergedOf(parts));
  }
  std::stable_sort(result.begin(), result.end(),
                   [](const Component& a, const Component& b) { return a.weight > b.weight; });
  if (result.size() > limits.max_components) result.resize(limits.max_components);
  return result;
}

}  // namespace kestrel
