// SPDX-License-Identifier: BSD-3-Clause
// The functions of PhdFilter that deal with labels and targets; a part of phd_filter_impl.h.
#pragma once

#include <algorithm>
#include <utility>

#include "kestrel_slam/tracking/mixture_reduction.h"
#include "kestrel_slam/tracking/phd_filter.h"

namespace kestrel {
namespace phd {

constexpr double kTargetWeight = 0.5;  ///< from here on, there is a target [Vo 2006, table III]

}  // namespace phd

template <int N, int M>
void PhdFilter<N, M>::noteLabels() {
  labels_.clear();
  for (const Component& prior : components_) labels_.push_back(prior.label);
  std::sort(labels_.begin(), labels_.end());
  labels_.erase(std::unique(labels_.begin(), labels_.end()), labels_.end());
  label_of_.clear();
  for (const Component& prior : components_) {
    const auto found = std::lower_bound(labels_.begin(), labels_.end(), prior.label);
    label_of_.push_back(static_cast<std::size_t>(found - labels_.begin()));
  }
}

/// A label is one target, which is either detected or missed: what it was detected with leaves no
/// weight for its missed part, and all its weights together are at most 1. Otherwise the weight of
/// a target that is seen again and again with a low P_D would grow in its missed part.
template <int N, int M>
void PhdFilter<N, M>::limitLabels() {
  std::vector<LabelWeight> weights(labels_.size());
  for (std::size_t i = 0; i < updated_.size(); ++i) {
    LabelWeight& label = weights[origins_[i].label];
    (origins_[i].observation < 0 ? label.missed : label.detected) += updated_[i].weight;
  }
  for (LabelWeight& label : weights) {  // becomes the factors
    const double left = std::max(0.0, 1.0 - label.detected);
    label.missed = label.missed > left ? left / label.missed : 1.0;
    label.detected = 1.0 / std::max(1.0, label.detected);
  }
  for (std::size_t i = 0; i < updated_.size(); ++i) {
    const LabelWeight& label = weights[origins_[i].label];
    updated_[i].weight *= origins_[i].observation < 0 ? label.missed : label.detected;
  }
}

/// The heaviest pair of label and observation is a target, then the heaviest of the others, ... The
/// label gets the whole weight of the observation: it is one target, though others may explain it.
template <int N, int M>
void PhdFilter<N, M>::findTargets() {
  targets_.clear();
  std::vector<bool> used(explained_.size(), false), found(labels_.size(), false);
  for (const Share& share : sortedShares()) {
    if (found[share.label]) continue;
    double weight = share.weight;
    if (share.observation >= 0) {
      const auto observation = static_cast<std::size_t>(share.observation);
      if (used[observation]) continue;
      weight = explained_[observation];
      if (weight >= phd::kTargetWeight) used[observation] = true;
    }
    if (weight < phd::kTargetWeight) continue;
    found[share.label] = true;
    targets_.push_back(targetOf(share, weight));
  }
}

template <int N, int M>
std::vector<typename PhdFilter<N, M>::Share> PhdFilter<N, M>::sortedShares() const {
  std::vector<Share> shares;
  for (std::size_t first = 0, end = 0; first < updated_.size(); first = end) {
    const int observation = origins_[first].observation;
    std::vector<double> weights(labels_.size(), 0.0);
    for (; end < updated_.size() && origins_[end].observation == observation; ++end) {
      weights[origins_[end].label] += updated_[end].weight;
    }
    for (std::size_t label = 0; label < weights.size(); ++label) {
      if (!(weights[label] > 0.0)) continue;
      shares.push_back({label, observation, weights[label], first, end});
    }
  }
  std::stable_sort(shares.begin(), shares.end(),
                   [](const Share& a, const Share& b) { return a.weight > b.weight; });
  return shares;
}

template <int N, int M>
LabeledTarget<N> PhdFilter<N, M>::targetOf(const Share& share, double weight) const {
  std::vector<const Component*> parts;
  for (std::size_t i = share.first; i < share.end; ++i) {
    if (origins_[i].label == share.label) parts.push_back(&updated_[i]);
  }
  LabeledTarget<N> target;
  target.label = labels_[share.label];
  target.weight = weight;
  target.observation = share.observation;
  const Component merged = mergedOf(parts);
  target.mean = merged.mean;
  target.covariance = merged.covariance;
  target.modes.assign(model_.motions.size(), 0.0);
  for (const Component* part : parts) {
    target.modes[static_cast<std::size_t>(part->mode)] += part->weight / share.weight;
  }
  return target;
}

template <int N, int M>
bool PhdFilter<N, M>::wasReported(TargetLabel label) const {
  return std::binary_search(reported_.begin(), reported_.end(), label);
}

template <int N, int M>
void PhdFilter<N, M>::noteReported() {
  std::vector<TargetLabel> alive;
  for (const TargetLabel label : labels_) {
    const bool is_target = std::any_of(targets_.begin(), targets_.end(),
                                       [label](const auto& t) { return t.label == label; });
    if (is_target || wasReported(label)) alive.push_back(label);
  }
  reported_ = std::move(alive);
}

}  // namespace kestrel
