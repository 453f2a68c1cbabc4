// SPDX-License-Identifier: BSD-3-Clause
// The functions of PhdFilter. It takes long to compile: a file for each size of the state includes
// it, in the library that needs this size.
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/tracking/mixture_reduction.h"
#include "kestrel_slam/tracking/phd_filter.h"

namespace kestrel {
namespace phd {

constexpr double kTargetWeight = 0.5;  ///< from here on, there is a target [Vo 2006, table III]
constexpr double kFar2 = 50.0;  ///< sigmas²; a target so far away did not cause an observation

}  // namespace phd

template <int N, int M>
ExpectedObservation<N, M> expectPosition(const Eigen::Matrix<double, N, 1>& state) {
  return {state.template head<M>(), Eigen::Matrix<double, M, N>::Identity()};
}

template <int N, int M>
PhdFilter<N, M>::PhdFilter(PhdModel<N, M> model, const PhdLimits& limits)
    : model_(std::move(model)), limits_(limits) {}

template <int N, int M>
void PhdFilter<N, M>::predict(double seconds, const std::vector<Component>& births) {
  std::vector<Component> predicted = births;
  for (Component& birth : predicted) birth.label = next_label_++;
  addSpawned(predicted);
  addSurvivors(seconds, predicted);
  components_ = std::move(predicted);
}

template <int N, int M>
void PhdFilter<N, M>::add(const std::vector<Component>& births) {
  for (const Component& birth : births) {
    components_.push_back(birth);
    if (birth.label == 0) components_.back().label = next_label_++;
  }
}

/// [Siew 2018, eq. 23].
template <int N, int M>
void PhdFilter<N, M>::addSpawned(std::vector<Component>& predicted) {
  for (const SpawnModel<N>& spawn : model_.spawns) {
    for (const Component& parent : components_) {
      const double weight = spawn.weight * parent.weight;
      if (weight <= limits_.prune_weight) continue;
      Component& child = predicted.emplace_back(parent);
      child.weight = weight;
      child.mean = spawn.transition * parent.mean + spawn.offset;
      child.covariance =
          spawn.transition * parent.covariance * spawn.transition.transpose() + spawn.noise;
      child.label = next_label_++;
    }
  }
}

/// [Siew 2018, eq. 22], for every motion model to which the target may change.
template <int N, int M>
void PhdFilter<N, M>::addSurvivors(double seconds, std::vector<Component>& predicted) const {
  const int modes = static_cast<int>(model_.motions.size());
  for (const Component& parent : components_) {
    const double weight = model_.survival(parent.mean) * parent.weight;
    for (int mode = 0; mode < modes; ++mode) {
      const double share = model_.mode_transition.size() > 0
                               ? model_.mode_transition(parent.mode, mode)
                               : (mode == parent.mode ? 1.0 : 0.0);
      if (!(weight * share > limits_.prune_weight)) continue;
      const Transition<N> motion =
          model_.motions[static_cast<std::size_t>(mode)](parent.mean, seconds);
      Component& child = predicted.emplace_back(parent);
      child.weight = weight * share;
      child.mode = mode;
      child.mean = motion.mean;
      child.covariance =
          motion.jacobian * parent.covariance * motion.jacobian.transpose() + motion.noise;
    }
  }
}

template <int N, int M>
void PhdFilter<N, M>::update(const std::vector<Observation<M>>& observations) {
  std::vector<Prepared> prepared;
  prepared.reserve(components_.size());
  for (const Component& prior : components_) {
    const ExpectedObservation<N, M> expected = model_.expect(prior.mean);
    const auto& H = expected.jacobian;
    prepared.push_back({expected, model_.detection(prior), H * prior.covariance * H.transpose()});
  }
  updated_.clear();
  observation_of_.clear();
  explained_.assign(observations.size(), 0.0);
  addMissed(prepared);
  for (std::size_t i = 0; i < observations.size(); ++i) {
    addDetected(prepared, observations[i], static_cast<int>(i));
  }
  if (limits_.keep_identities) limitLabels();
  findTargets();
  noteReported();
  reduce();
}

/// The first term of [Siew 2018, eq. 25].
template <int N, int M>
void PhdFilter<N, M>::addMissed(const std::vector<Prepared>& prepared) {
  for (std::size_t j = 0; j < components_.size(); ++j) {
    append(components_[j], -1);
    const double p = prepared[j].detection;
    updated_.back().weight *= model_.missed ? model_.missed(p) : 1.0 - p;
  }
}

/// The sum of [Siew 2018, eq. 25-27] for one observation.
template <int N, int M>
void PhdFilter<N, M>::addDetected(const std::vector<Prepared>& prepared,
                                  const Observation<M>& observation, int index) {
  std::vector<Candidate> candidates;
  candidates.reserve(components_.size());
  double sum = 0.0;
  for (std::size_t j = 0; j < components_.size(); ++j) {
    Candidate candidate;
    candidate.prior = j;
    if (!likelihood(components_[j], prepared[j], observation, candidate)) continue;
    if (!mayCause(components_[j], index)) continue;
    sum += candidate.weight;
    candidates.push_back(candidate);
  }
  if (!(sum > 0.0)) return;
  const double total = sum + model_.clutter(observation.value);
  explained_[static_cast<std::size_t>(index)] = sum / total;
  for (Candidate& candidate : candidates) {
    candidate.weight /= total;
    if (candidate.weight <= limits_.prune_weight) continue;
    append(corrected(prepared[candidate.prior], observation, candidate), index);
  }
}

template <int N, int M>
bool PhdFilter<N, M>::mayCause(const Component& prior, int index) const {
  return !model_.may_cause || model_.may_cause(prior, static_cast<std::size_t>(index));
}

/// P_D w q of [Siew 2018, eq. 27, 28]; false if it is nothing.
template <int N, int M>
bool PhdFilter<N, M>::likelihood(const Component& prior, const Prepared& prepared,
                                 const Observation<M>& observation, Candidate& candidate) const {
  const double weight = model_.detection_where_seen.value_or(prepared.detection) * prior.weight;
  if (!(weight > 0.0)) return false;
  const Eigen::Matrix<double, M, M> S = prepared.covariance + observation.noise;
  candidate.innovation = model_.difference
                             ? model_.difference(observation.value, prepared.expected.value)
                             : (observation.value - prepared.expected.value).eval();
  if (!(candidate.innovation.squaredNorm() < phd::kFar2 * S.trace())) return false;
  const double determinant = S.determinant();
  if (!(determinant > 0.0)) return false;
  candidate.inverse_covariance = S.inverse();
  const double distance2 =
      candidate.innovation.dot(candidate.inverse_covariance * candidate.innovation);
  static const double kNorm = std::pow(2.0 * kPi, M / 2.0);
  const double scale = kNorm * std::sqrt(determinant);
  candidate.weight = weight * std::exp(-0.5 * distance2) / scale;
  return candidate.weight > 0.0;
}

/// The update of the Kalman filter [Siew 2018, eq. 29-31]. The covariance is in Joseph's form,
/// which stays symmetric.
template <int N, int M>
PhdComponent<N> PhdFilter<N, M>::corrected(const Prepared& prepared,
                                           const Observation<M>& observation,
                                           const Candidate& candidate) const {
  Component result = components_[candidate.prior];
  const Eigen::Matrix<double, M, N>& H = prepared.expected.jacobian;
  const Eigen::Matrix<double, N, M> PH = result.covariance * H.transpose();
  const Eigen::Matrix<double, N, M> K = PH * candidate.inverse_covariance;
  result.weight = candidate.weight;
  result.mean += K * candidate.innovation;
  result.covariance -= K * PH.transpose();  // (I - K H) P
  const Eigen::Matrix<double, N, M> rest = result.covariance * H.transpose();
  result.covariance += (K * observation.noise - rest) * K.transpose();
  return result;
}

template <int N, int M>
void PhdFilter<N, M>::append(const Component& component, int observation) {
  updated_.push_back(component);
  observation_of_.push_back(observation);
}

/// A label is one target, which is either detected or missed: what it was detected with leaves no
/// weight for its missed part, and all its weights together are at most 1. Otherwise the weight of
/// a target that is seen again and again with a low P_D would grow in its missed part.
template <int N, int M>
void PhdFilter<N, M>::limitLabels() {
  std::vector<TargetLabel> labels;
  for (const Component& component : components_) labels.push_back(component.label);
  std::sort(labels.begin(), labels.end());
  std::vector<std::size_t> place(updated_.size());
  std::vector<LabelWeight> weights(labels.size());
  for (std::size_t i = 0; i < updated_.size(); ++i) {
    const auto found = std::lower_bound(labels.begin(), labels.end(), updated_[i].label);
    place[i] = static_cast<std::size_t>(found - labels.begin());
    LabelWeight& label = weights[place[i]];
    (observation_of_[i] < 0 ? label.missed : label.detected) += updated_[i].weight;
  }
  for (std::size_t i = 0; i < updated_.size(); ++i) {
    const LabelWeight& label = weights[place[i]];
    const double left = std::max(0.0, 1.0 - label.detected);
    const double missed_scale = label.missed > left ? left / label.missed : 1.0;
    updated_[i].weight *=
        observation_of_[i] < 0 ? missed_scale : 1.0 / std::max(1.0, label.detected);
  }
}

/// The heaviest pair of label and observation is a target, then the heaviest of the others, ... The
/// label gets the whole weight of the observation: it is one target, though others may explain it.
template <int N, int M>
void PhdFilter<N, M>::findTargets() {
  targets_.clear();
  std::vector<bool> used(explained_.size(), false);
  std::vector<TargetLabel> found;
  for (const Share& share : sortedShares()) {
    if (std::find(found.begin(), found.end(), share.label) != found.end()) continue;
    double weight = share.weight;
    if (share.observation >= 0) {
      const auto observation = static_cast<std::size_t>(share.observation);
      if (used[observation]) continue;
      weight = explained_[observation];
      if (weight >= phd::kTargetWeight) used[observation] = true;
    }
    if (weight < phd::kTargetWeight) continue;
    found.push_back(share.label);
    targets_.push_back(targetOf(share, weight));
  }
}

template <int N, int M>
std::vector<typename PhdFilter<N, M>::Share> PhdFilter<N, M>::sortedShares() {
  order_.clear();
  for (std::size_t i = 0; i < updated_.size(); ++i) {
    order_.push_back({observation_of_[i], updated_[i].label, i});
  }
  std::sort(order_.begin(), order_.end());
  std::vector<Share> shares;
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const auto [observation, label, i] = order_[k];
    if (shares.empty() || shares.back().label != label ||
        shares.back().observation != observation) {
      shares.push_back({label, observation, 0.0, k, k});
    }
    shares.back().weight += updated_[i].weight;
    ++shares.back().end;
  }
  std::stable_sort(shares.begin(), shares.end(),
                   [](const Share& a, const Share& b) { return a.weight > b.weight; });
  return shares;
}

template <int N, int M>
LabeledTarget<N> PhdFilter<N, M>::targetOf(const Share& share, double weight) const {
  std::vector<const Component*> parts;
  for (std::size_t k = share.first; k < share.end; ++k) {
    parts.push_back(&updated_[std::get<2>(order_[k])]);
  }
  LabeledTarget<N> target;
  target.label = share.label;
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
void PhdFilter<N, M>::reduce() {
  components_ = reduceMixture(updated_, limits_,
                              [this](const auto& a, const auto& b) { return mayMerge(a, b); });
  updated_.clear();
}

template <int N, int M>
bool PhdFilter<N, M>::mayMerge(const Component& heavy, const Component& other) const {
  if (!limits_.keep_identities || heavy.label == other.label) return true;
  return !(wasReported(heavy.label) && wasReported(other.label));
}

template <int N, int M>
bool PhdFilter<N, M>::wasReported(TargetLabel label) const {
  return std::binary_search(reported_.begin(), reported_.end(), label);
}

template <int N, int M>
void PhdFilter<N, M>::noteReported() {
  std::vector<TargetLabel> alive;
  for (const Component& component : components_) {
    if (wasReported(component.label)) alive.push_back(component.label);
  }
  for (const LabeledTarget<N>& target : targets_) alive.push_back(target.label);
  std::sort(alive.begin(), alive.end());
  alive.erase(std::unique(alive.begin(), alive.end()), alive.end());
  reported_ = std::move(alive);
}

template <int N, int M>
double PhdFilter<N, M>::expectedCount() const {
  double sum = 0.0;
  for (const Component& component : components_) sum += component.weight;
  return sum;
}

template <int N, int M>
std::vector<PhdComponent<N>> PhdFilter<N, M>::estimates() const {
  std::vector<Component> result;
  for (const Component& component : components_) {
    if (component.weight <= phd::kTargetWeight) continue;
    result.insert(result.end(), static_cast<std::size_t>(std::lround(component.weight)), component);
  }
  return result;
}

template <int N, int M>
std::optional<PhdComponent<N>> PhdFilter<N, M>::find(TargetLabel label) const {
  std::vector<const Component*> parts;
  for (const Component& component : components_) {
    if (component.label == label) parts.push_back(&component);
  }
  return parts.empty() ? std::nullopt : std::optional<Component>(mergedOf(parts));
}

template <int N, int M>
void PhdFilter<N, M>::forget(TargetLabel label) {
  components_.erase(std::remove_if(components_.begin(), components_.end(),
                                   [label](const Component& c) { return c.label == label; }),
                    components_.end());
}

}  // namespace kestrel
