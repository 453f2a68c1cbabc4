// SPDX-License-Identifier: BSD-3-Clause
// The functions of PhdFilter. It takes long to compile: a file for each size of the state includes
// it, in the library that needs this size.
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/tracking/mixture_reduction.h"
#include "kestrel_slam/tracking/phd_filter.h"
#include "kestrel_slam/tracking/phd_targets_impl.h"

namespace kestrel {
namespace phd {

constexpr double kFar2 = 50.0;  ///< sigmas²; a target so far away did not cause an observation

}  // namespace phd

template <int N, int M>
ExpectedObservation<N, M> expectPosition(const Eigen::Matrix<double, N, 1>& state) {
  return {state.template head<M>()};
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
  predicted.reserve(predicted.size() + model_.motions.size() * components_.size());
  for (const Component& parent : components_) {
    const double weight = model_.survival(parent.mean) * parent.weight;
    for (int mode = 0; mode < modes; ++mode) {
      const double share = model_.mode_transition.size() > 0
                               ? model_.mode_transition(parent.mode, mode)
                               : (mode == parent.mode ? 1.0 : 0.0);
      if (!(weight * share > limits_.prune_weight)) continue;
      Component& child = predicted.emplace_back(parent);
      child.weight = weight * share;
      child.mode = mode;
      model_.motions[static_cast<std::size_t>(mode)](seconds, child.mean, child.covariance);
    }
  }
}

template <int N, int M>
void PhdFilter<N, M>::update(const std::vector<Observation<M>>& observations) {
  std::vector<Prepared> prepared;
  prepared.reserve(components_.size());
  for (const Component& prior : components_) prepared.push_back(prepare(prior));
  noteLabels();
  updated_.clear();
  origins_.clear();
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

template <int N, int M>
typename PhdFilter<N, M>::Prepared PhdFilter<N, M>::prepare(const Component& prior) const {
  Prepared result;
  result.expected = model_.expect(prior.mean);
  result.detection = model_.detection(prior);
  result.detected_weight = model_.detection_where_seen.value_or(result.detection) * prior.weight;
  result.cross = result.expected.crossOf(prior.covariance);
  result.covariance = result.expected.covarianceOf(result.cross);
  return result;
}

/// The first term of [Siew 2018, eq. 25].
template <int N, int M>
void PhdFilter<N, M>::addMissed(const std::vector<Prepared>& prepared) {
  for (std::size_t j = 0; j < components_.size(); ++j) {
    append(components_[j], j, -1);
    const double p = prepared[j].detection;
    updated_.back().weight *= model_.missed ? model_.missed(p) : 1.0 - p;
  }
}

/// The sum of [Siew 2018, eq. 25-27] for one observation.
template <int N, int M>
void PhdFilter<N, M>::addDetected(const std::vector<Prepared>& prepared,
                                  const Observation<M>& observation, int index) {
  candidates_.clear();
  double sum = 0.0;
  for (std::size_t j = 0; j < prepared.size(); ++j) {
    Candidate candidate;
    if (!isNear(prepared[j], observation, candidate)) continue;
    if (!likelihood(prepared[j], observation, candidate)) continue;
    if (!mayCause(components_[j], index)) continue;
    candidate.prior = j;
    sum += candidate.weight;
    candidates_.push_back(candidate);
  }
  if (!(sum > 0.0)) return;
  const double total = sum + model_.clutter(observation.value);
  explained_[static_cast<std::size_t>(index)] = sum / total;
  for (Candidate& candidate : candidates_) {
    candidate.weight /= total;
    if (candidate.weight <= limits_.prune_weight) continue;
    append(corrected(prepared[candidate.prior], observation, candidate), candidate.prior, index);
  }
}

template <int N, int M>
bool PhdFilter<N, M>::mayCause(const Component& prior, int index) const {
  return !model_.may_cause || model_.may_cause(prior, static_cast<std::size_t>(index));
}

/// False for most pairs, which need no more than their distance and the size of the covariance.
template <int N, int M>
bool PhdFilter<N, M>::isNear(const Prepared& prepared, const Observation<M>& observation,
                             Candidate& candidate) const {
  candidate.innovation = observation.value - prepared.expected.value;
  if (model_.difference) {
    candidate.innovation = model_.difference(observation.value, prepared.expected.value);
  }
  const double variances = (prepared.covariance.diagonal() + observation.noise.diagonal()).sum();
  return candidate.innovation.squaredNorm() < phd::kFar2 * variances;
}

/// P_D w q of [Siew 2018, eq. 27, 28]; false if it is nothing.
template <int N, int M>
bool PhdFilter<N, M>::likelihood(const Prepared& prepared, const Observation<M>& observation,
                                 Candidate& candidate) const {
  if (!(prepared.detected_weight > 0.0)) return false;
  const Eigen::Matrix<double, M, M> S = prepared.covariance + observation.noise;
  const double determinant = S.determinant();
  if (!(determinant > 0.0)) return false;
  candidate.inverse_covariance = S.inverse();
  const double distance2 =
      candidate.innovation.dot(candidate.inverse_covariance * candidate.innovation);
  static const double kNorm = std::pow(2.0 * kPi, M / 2.0);
  const double scale = kNorm * std::sqrt(determinant);
  candidate.weight = prepared.detected_weight * std::exp(-0.5 * distance2) / scale;
  return candidate.weight > 0.0;
}

/// The update of the Kalman filter [Siew 2018, eq. 29-31]. The covariance is in Joseph's form,
/// which stays symmetric.
template <int N, int M>
PhdComponent<N> PhdFilter<N, M>::corrected(const Prepared& prepared,
                                           const Observation<M>& observation,
                                           const Candidate& candidate) const {
  Component result = components_[candidate.prior];
  const Eigen::Matrix<double, N, M> K = prepared.cross * candidate.inverse_covariance;
  result.weight = candidate.weight;
  result.mean += K * candidate.innovation;
  result.covariance -= K * prepared.cross.transpose();  // (I - K H) P
  const Eigen::Matrix<double, N, M> rest = prepared.expected.crossOf(result.covariance);
  result.covariance += (K * observation.noise - rest) * K.transpose();
  return result;
}

template <int N, int M>
void PhdFilter<N, M>::append(const Component& component, std::size_t prior, int observation) {
  updated_.push_back(component);
  origins_.push_back({label_of_[prior], observation});
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
