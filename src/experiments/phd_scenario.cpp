// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/phd_scenario.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/evaluation/consistency.h"
#include "kestrel_slam/evaluation/tracking_metrics.h"
#include "kestrel_slam/geometry/random.h"

namespace kestrel {
namespace {

constexpr double kHalfSide = 1000.0;                   // of the region, m
constexpr double kArea = 4.0 * kHalfSide * kHalfSide;  // m²
constexpr double kCutoff = 100.0;                      // of the OSPA, m
constexpr double kAdaptiveBirths = 0.12;               // per scan, as the standard births
constexpr double kBirthSpeed = 15.0;                   // m/s, standard deviation

PhdComponent<4> birthAt(double x, double y, double weight, double sigma) {
  PhdComponent<4> birth;
  birth.weight = weight;
  birth.mean << x, y, 0.0, 0.0;
  birth.covariance = Eigen::Matrix4d::Identity() * sigma * sigma;
  return birth;
}

Eigen::Vector4d stateAt(const ScenarioTarget& target, int scan) {
  Eigen::Vector4d state = target.state;
  state.head<2>() += (scan - target.born + 1) * state.tail<2>();
  return state;
}

PointSet truthAt(const PhdScenario& scenario, int scan) {
  PointSet points;
  for (const ScenarioTarget& target : scenario.targets) {
    if (scan >= target.born && scan <= target.dies) {
      points.emplace_back(stateAt(target, scan).head<2>());
    }
  }
  return points;
}

/// Number of events of a Poisson process, by multiplying uniform numbers [Knuth].
int poisson(double mean, Random& random) {
  const double limit = std::exp(-mean);
  int count = 0;
  for (double product = random.uniform(); product > limit; product *= random.uniform()) ++count;
  return count;
}

std::vector<Observation<2>> measure(const PhdScenario& scenario, int scan, Random& random) {
  const Eigen::Matrix2d noise =
      Eigen::Matrix2d::Identity() * scenario.position_sigma * scenario.position_sigma;
  std::vector<Observation<2>> result;
  for (const Eigen::VectorXd& point : truthAt(scenario, scan)) {
    if (random.uniform() >= scenario.detection) continue;
    const Eigen::Vector2d error(random.gaussian(), random.gaussian());
    result.push_back({point + scenario.position_sigma * error, noise});
  }
  for (int i = poisson(scenario.clutter_per_scan, random); i > 0; --i) {
    const double x = random.uniform(-kHalfSide, kHalfSide);
    result.push_back({{x, random.uniform(-kHalfSide, kHalfSide)}, noise});
  }
  return result;
}

PhdFilter<4, 2> filterFor(const PhdScenario& scenario) {
  PhdModel<4, 2> model;
  model.motions = {constantVelocity<4, 2>(scenario.acceleration_sigma)};
  model.spawns = scenario.spawns;
  model.survival = [p = scenario.survival](const auto&) { return p; };
  model.detection = [p = scenario.detection](const auto&) { return p; };
  model.clutter = [density = scenario.clutter_per_scan / kArea](const auto&) { return density; };
  model.expect = expectPosition<4, 2>;
  PhdLimits limits;
  limits.keep_identities = scenario.labeled;
  return PhdFilter<4, 2>(std::move(model), limits);
}

/// Births at the observations of the last scan, by the share that the targets do not explain.
std::vector<PhdComponent<4>> birthsFrom(const std::vector<Observation<2>>& observations,
                                        const std::vector<double>& explained) {
  double sum = 0.0;
  for (const double share : explained) sum += 1.0 - share;
  std::vector<PhdComponent<4>> births;
  for (std::size_t i = 0; i < explained.size(); ++i) {
    const Eigen::Vector2d& at = observations[i].value;
    PhdComponent<4> birth =
        birthAt(at.x(), at.y(), kAdaptiveBirths * (1.0 - explained[i]) / sum, kBirthSpeed);
    birth.covariance.topLeftCorner<2, 2>() = observations[i].noise;
    births.push_back(birth);
  }
  return births;
}

PointSet estimateOf(const PhdScenario& scenario, const PhdFilter<4, 2>& filter) {
  PointSet points;
  if (scenario.labeled) {
    for (const auto& target : filter.targets()) points.emplace_back(target.mean.head<2>());
  } else {
    for (const auto& component : filter.estimates()) points.emplace_back(component.mean.head<2>());
  }
  return points;
}

/// Notes which targets were found in this scan for the first time.
void noteFound(const PhdScenario& scenario, int scan, const PointSet& estimate,
               std::vector<int>& found_after) {
  const auto distanceTo = [&](const ScenarioTarget& target, const Eigen::VectorXd& point) {
    return scan >= target.born && scan <= target.dies
               ? (stateAt(target, scan).head<2>() - point).norm()
               : kCutoff;
  };
  for (const Eigen::VectorXd& point : estimate) {
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < scenario.targets.size(); ++i) {
      if (distanceTo(scenario.targets[i], point) < distanceTo(scenario.targets[nearest], point)) {
        nearest = i;
      }
    }
    const ScenarioTarget& target = scenario.targets[nearest];
    if (found_after[nearest] < 0 && distanceTo(target, point) < kCutoff) {
      found_after[nearest] = scan - target.born;
    }
  }
}

void append(const PhdScenarioRun& run, PhdScenarioSummary& summary) {
  const double n = static_cast<double>(++summary.runs), mean = meanOf(run.ospa);
  const double step = mean - summary.ospa;
  summary.ospa += step / n;
  summary.sigma += step * (mean - summary.ospa);  // sum of squares until the end
  summary.localization += (meanOf(run.localization) - summary.localization) / n;
  summary.cardinality += (meanOf(run.cardinality) - summary.cardinality) / n;
  summary.count_bias += (run.count_bias - summary.count_bias) / n;
  summary.best = summary.runs == 1 ? mean : std::min(summary.best, mean);
  summary.worst = std::max(summary.worst, mean);
}

}  // namespace

PhdScenario standardScenario() {
  PhdScenario scenario;
  scenario.name = "standard";
  // x, vx, y, vy, born, dies: as in the reference.
  constexpr double kTargets[12][6] = {
      {0, 0, 0, -10, 1, 70},         {400, -10, -600, 5, 1, 101},    {-800, 20, -200, -5, 1, 70},
      {400, -7, -600, -4, 20, 101},  {400, -2.5, -600, 10, 20, 101}, {0, 7.5, 0, -5, 20, 101},
      {-800, 12, -200, 7, 40, 101},  {-200, 15, 800, -10, 40, 101},  {-800, 3, -200, 15, 60, 101},
      {-200, -3, 800, -15, 60, 101}, {0, -20, 0, -15, 80, 101},      {-200, 15, 800, -5, 80, 101}};
  for (const auto& t : kTargets) {
    scenario.targets.push_back(
        {{t[0], t[2], t[1], t[3]}, static_cast<int>(t[4]), static_cast<int>(t[5])});
  }
  for (const auto& [x, y] : {std::pair{0, 0}, {400, -600}, {-800, -200}, {-200, 800}}) {
    scenario.births.push_back(birthAt(x, y, 0.03, 10.0));
  }
  return scenario;
}

PhdScenario spawningScenario() {
  PhdScenario scenario;
  scenario.name = "spawning";
  // [Vo 2006, sec. III-F]: two targets that cross in scan 53; the third leaves the first.
  scenario.targets = {{{250.0, 250.0, 2.5, -11.5}, 1, 101}, {{-250.0, -250.0, 11.5, -2.5}, 1, 101}};
  Eigen::Vector4d parent = stateAt(scenario.targets[0], 66);
  parent.tail<2>() << -20.0, 4.0;
  scenario.targets.push_back({parent, 66, 101});
  for (const double at : {250.0, -250.0}) {
    PhdComponent<4> birth = birthAt(at, at, 0.1, 10.0);
    birth.covariance.diagonal() << 100.0, 100.0, 25.0, 25.0;
    scenario.births.push_back(birth);
  }
  SpawnModel<4> spawn;
  spawn.weight = 0.05;
  spawn.noise.diagonal() << 100.0, 100.0, 400.0, 400.0;
  scenario.spawns = {spawn};
  scenario.clutter_per_scan = 50.0;
  return scenario;
}

PhdScenarioRun runScenario(const PhdScenario& scenario, std::uint64_t seed) {
  Random random(seed);
  PhdFilter<4, 2> filter = filterFor(scenario);
  PhdScenarioRun run;
  run.found_after.assign(scenario.targets.size(), -1);
  std::vector<PhdComponent<4>> births = scenario.births;
  for (int scan = 1; scan <= kScenarioScans; ++scan) {
    const std::vector<Observation<2>> observations = measure(scenario, scan, random);
    filter.predict(1.0, births);
    filter.update(observations);
    if (scenario.adaptive_birth) births = birthsFrom(observations, filter.explained());
    const PointSet truth = truthAt(scenario, scan), estimate = estimateOf(scenario, filter);
    const SetDistance distance = ospa(truth, estimate, kCutoff);
    run.ospa.push_back(distance.total);
    run.localization.push_back(distance.localization);
    run.cardinality.push_back(distance.cardinality);
    run.count_bias +=
        (static_cast<double>(estimate.size()) - static_cast<double>(truth.size())) / kScenarioScans;
    noteFound(scenario, scan, estimate, run.found_after);
    run.most_components = std::max(run.most_components, filter.components().size());
  }
  return run;
}

double PhdScenarioSummary::foundAfter() const {
  std::vector<double> scans;
  for (const PhdScenarioRun& run : single) {
    for (const int after : run.found_after) {
      if (after >= 0) scans.push_back(after);
    }
  }
  return meanOf(scans);
}

PhdScenarioSummary summarizeScenario(const PhdScenario& scenario, std::size_t runs) {
  PhdScenarioSummary summary;
  for (std::size_t i = 1; i <= runs; ++i) {
    summary.single.push_back(runScenario(scenario, i));
    append(summary.single.back(), summary);
  }
  summary.sigma = runs > 1 ? std::sqrt(summary.sigma / static_cast<double>(runs - 1)) : 0.0;
  return summary;
}

}  // namespace kestrel
