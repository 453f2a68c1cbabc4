// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "kestrel_slam/tracking/motion_models.h"

namespace kestrel {

/// Identity of a target in the PHD filter. Birth and spawning give new labels.
using TargetLabel = std::uint64_t;

/// One Gaussian of the intensity [Siew 2018, eq. 22-26].
template <int N>
struct PhdComponent {
  double weight = 0.0;  ///< expected number of targets
  Eigen::Matrix<double, N, 1> mean = Eigen::Matrix<double, N, 1>::Zero();
  Eigen::Matrix<double, N, N> covariance = Eigen::Matrix<double, N, N>::Identity();
  int mode = 0;           ///< index of its motion model
  TargetLabel label = 0;  ///< 0: a new target, whose label the filter chooses
};

/// A measured position (or range and bearing, ...) with its noise R [Siew 2018, eq. 20].
template <int M>
struct Observation {
  Eigen::Matrix<double, M, 1> value;
  Eigen::Matrix<double, M, M> noise;
};

/// What the sensor should measure of a state: η and H of [Siew 2018, algorithm 1].
template <int N, int M>
struct ExpectedObservation {
  Eigen::Matrix<double, M, 1> value;
  /// Empty: that of a value that is the first part of the state.
  std::optional<Eigen::Matrix<double, M, N>> jacobian = std::nullopt;

  /// P H' of a covariance P.
  Eigen::Matrix<double, N, M> crossOf(const Eigen::Matrix<double, N, N>& covariance) const {
    if (!jacobian) return covariance.template leftCols<M>();
    return covariance * jacobian->transpose();
  }
  /// H P H', given P H'.
  Eigen::Matrix<double, M, M> covarianceOf(const Eigen::Matrix<double, N, M>& cross) const {
    if (!jacobian) return cross.template topRows<M>();
    return *jacobian * cross;
  }
};

/// Targets that leave a target [Siew 2018, eq. 23]: `weight` per step for each existing target.
template <int N>
struct SpawnModel {
  double weight = 0.0;
  Eigen::Matrix<double, N, N> transition = Eigen::Matrix<double, N, N>::Identity();
  Eigen::Matrix<double, N, 1> offset = Eigen::Matrix<double, N, 1>::Zero();
  Eigen::Matrix<double, N, N> noise = Eigen::Matrix<double, N, N>::Zero();
};

/// Model of targets and sensor.
template <int N, int M>
struct PhdModel {
  using State = Eigen::Matrix<double, N, 1>;
  using Value = Eigen::Matrix<double, M, 1>;

  /// One motion model, or several that a target changes between (a jump Markov system [Pasha
  /// 2009]). With one model, the prediction is [Siew 2018, eq. 22].
  std::vector<MotionModel<N>> motions;
  /// `mode_transition(i, j)`: probability that a target with model i has model j in the next step.
  /// Empty: the model never changes.
  Eigen::MatrixXd mode_transition;
  std::vector<SpawnModel<N>> spawns;

  std::function<double(const State&)> survival;  ///< P_S
  /// P_D, of a Gaussian, so that it can be the mean over all places where the target may be.
  std::function<double(const PhdComponent<N>&)> detection;
  /// P_D where something was detected: the sensor sees this place, although most of the places
  /// where a hidden target may be are hidden. Empty: that of the Gaussian.
  std::optional<double> detection_where_seen;
  /// Share of the weight that is left after a scan without detection, given P_D. Empty: 1 - P_D,
  /// which takes the scans as independent.
  std::function<double(double)> missed;
  std::function<double(const Value&)> clutter;  ///< false measurements per unit of the value
  std::function<ExpectedObservation<N, M>(const State&)> expect;
  /// False if what else is known of the observation (by its index) excludes this target. Empty: any
  /// target may have caused any observation.
  std::function<bool(const PhdComponent<N>&, std::size_t)> may_cause;
  /// measured - expected; set it if the value has angles. Empty: plain difference.
  std::function<Value(const Value&, const Value&)> difference;
};

/// Bounds on the number of Gaussians [Vo 2006, table II].
struct PhdLimits {
  double prune_weight = 1e-5;        ///< T: lighter components are removed
  double merge_distance = 4.0;       ///< U: squared Mahalanobis distance below which two are merged
  std::size_t max_components = 100;  ///< J_max
  /// Two labels that were both reported as targets are not merged, so that two targets that meet
  /// keep their identities. False: everything is merged as in the paper.
  bool keep_identities = true;
};

/// A target with its identity.
template <int N>
struct LabeledTarget {
  TargetLabel label = 0;
  double weight = 0.0;   ///< expected number of targets here
  int observation = -1;  ///< index of the observation that confirms it; -1: none in this step
  Eigen::Matrix<double, N, 1> mean;
  Eigen::Matrix<double, N, N> covariance;
  std::vector<double> modes;  ///< probability of each motion model
};

/// Linear position measurement of a state that begins with the position.
template <int N, int M>
ExpectedObservation<N, M> expectPosition(const Eigen::Matrix<double, N, 1>& state);

/// Gaussian-mixture probability hypothesis density filter [Siew 2018, eq. 15-31 and algorithm 1; Vo
/// 2006], in the extended form if motion or measurement are not linear.
///
/// A step is predict() and then update(). Deterministic. The work is proportional to components
/// times observations, and both are bounded by PhdLimits and the caller.
template <int N, int M>
class PhdFilter {
 public:
  using Component = PhdComponent<N>;
  using State = Eigen::Matrix<double, N, 1>;

  explicit PhdFilter(PhdModel<N, M> model, const PhdLimits& limits = PhdLimits());

  PhdModel<N, M>& model() { return model_; }

  /// Survival, spawning and birth [Siew 2018, eq. 21-24]. Every birth gets a new label.
  void predict(double seconds, const std::vector<Component>& births);
  /// Adds components to the current intensity, for targets that were born before the next
  /// prediction. One with a label is what this target may be, too.
  void add(const std::vector<Component>& births);
  /// Measurement update [Siew 2018, eq. 25-31], then pruning and merging.
  void update(const std::vector<Observation<M>>& observations);

  const std::vector<Component>& components() const { return components_; }
  /// Expected number of targets: the sum of the weights.
  double expectedCount() const;
  /// The components heavier than 0.5, repeated as often as their rounded weight [Vo 2006, table
  /// III].
  std::vector<Component> estimates() const;
  /// The targets of the last update, one for each label and at most one for each observation, by
  /// falling weight. Unlike estimates(), two targets at one place keep their labels, and a target
  /// that is hidden (low P_D) stays.
  const std::vector<LabeledTarget<N>>& targets() const { return targets_; }
  /// For each observation of the last update, the probability that it comes from a target: the
  /// rest is clutter, or a target that is not known yet.
  const std::vector<double>& explained() const { return explained_; }

  /// All components of a label as one Gaussian; nothing if it has none.
  std::optional<Component> find(TargetLabel label) const;
  /// Removes all components of a label.
  void forget(TargetLabel label);

 private:
  /// Weight of one label in one observation (-1: not detected).
  struct Share {
    std::size_t label;  ///< in `labels_`
    int observation;
    double weight;
    std::size_t first, end;  ///< of the observation in `updated_`
  };
  struct LabelWeight {
    double detected = 0.0, missed = 0.0;
  };
  struct Prepared {
    ExpectedObservation<N, M> expected;
    double detection;
    double detected_weight;                  ///< if it is where the sensor sees
    Eigen::Matrix<double, N, M> cross;       ///< P H': covariance of the state and the value
    Eigen::Matrix<double, M, M> covariance;  ///< of the expected value
  };
  struct Candidate {
    std::size_t prior;  ///< in `components_`
    double weight;
    Eigen::Matrix<double, M, 1> innovation;
    Eigen::Matrix<double, M, M> inverse_covariance;
  };
  /// Where a component after the update comes from.
  struct Origin {
    std::size_t label;  ///< in `labels_`
    int observation;    ///< -1: not detected
  };

  void addSurvivors(double seconds, std::vector<Component>& predicted) const;
  void addSpawned(std::vector<Component>& predicted);
  Prepared prepare(const Component& prior) const;
  void noteLabels();
  void addMissed(const std::vector<Prepared>& prepared);
  void addDetected(const std::vector<Prepared>& prepared, const Observation<M>& observation,
                   int index);
  bool mayCause(const Component& prior, int index) const;
  bool isNear(const Prepared& prepared, const Observation<M>& observation,
              Candidate& candidate) const;
  bool likelihood(const Prepared& prepared, const Observation<M>& observation,
                  Candidate& candidate) const;
  Component corrected(const Prepared& prepared, const Observation<M>& observation,
                      const Candidate& candidate) const;
  void append(const Component& component, std::size_t prior, int observation);

  void limitLabels();
  void findTargets();
  std::vector<Share> sortedShares() const;
  LabeledTarget<N> targetOf(const Share& share, double weight) const;

  void reduce();
  bool mayMerge(const Component& heavy, const Component& other) const;
  bool wasReported(TargetLabel label) const;
  void noteReported();

  PhdModel<N, M> model_;
  PhdLimits limits_;
  std::vector<Component> components_;
  std::vector<double> explained_;
  std::vector<LabeledTarget<N>> targets_;
  std::vector<TargetLabel> reported_;  ///< labels that were a target and still have a component
  TargetLabel next_label_ = 1;

  // During update():
  std::vector<TargetLabel> labels_;    ///< sorted
  std::vector<std::size_t> label_of_;  ///< in `labels_`, of each of `components_`
  std::vector<Candidate> candidates_;  ///< of one observation
  std::vector<Component> updated_;     ///< by rising observation
  std::vector<Origin> origins_;        ///< of each of `updated_`
};

}  // namespace kestrel
