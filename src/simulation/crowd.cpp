// SPDX-License-Identifier: BSD-3-Clause
#include "crowd.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "crowd_steps.h"

namespace kestrel {
namespace {

constexpr double kCrowdStep = 0.05;    ///< s
constexpr double kLastStep = 72000.0;  ///< one hour
constexpr double kPathSample = 0.1;    ///< m, between the places where two paths are compared
/// Paths that keep this distance are of people who cannot meet, m.
constexpr double kMeet = 2.0 * kMostAside + kBodyDistance;

bool canMeet(const Walker& a, const Walker& b) {
  const WalkerPath path(a);
  for (double along = 0.0; along < path.length() + kPathSample; along += kPathSample) {
    if (b.distanceToPath(path.alongPath(along).position) < kMeet) return true;
  }
  return false;
}

}  // namespace

double mostAside(const std::vector<Walker>& walkers, std::size_t person) {
  for (std::size_t i = 0; i < walkers.size(); ++i) {
    if (i != person && canMeet(walkers[i], walkers[person])) return kMostAside;
  }
  return 0.0;
}

struct Crowd::State {
  explicit State(const World::Parts& parts) : steps(parts) {
    for (std::size_t i = 0; i < parts.walkers.size(); ++i) {
      paths.emplace_back(parts.walkers[i]);
      place.push_back(mostAside(parts.walkers, i) > 0.0 ? static_cast<int>(steps.add(paths.back()))
                                                        : kAlone);
    }
    past.push_back(steps.people());
  }

  WalkerPath::Step at(std::size_t person, double time) {
    if (place[person] == kAlone) return paths[person].at(time);
    const auto member = static_cast<std::size_t>(place[person]);
    const double count = std::clamp(time / kCrowdStep, 0.0, kLastStep);
    const auto first = static_cast<std::size_t>(count);
    const std::lock_guard<std::mutex> lock(mutex);
    while (past.size() < first + 2) {
      steps.advance(kCrowdStep);
      past.push_back(steps.people());
    }
    const double share = count - static_cast<double>(first);
    const WalkerPath::Step &from = past[first][member].step, &to = past[first + 1][member].step;
    Eigen::Vector2d direction = from.direction + share * (to.direction - from.direction);
    if (!(direction.norm() > 0.0)) direction = to.direction;
    return {from.position + share * (to.position - from.position), direction.normalized(),
            from.traveled + share * (to.traveled - from.traveled)};
  }

  static constexpr int kAlone = -1;
  std::vector<WalkerPath> paths;
  std::vector<int> place;  ///< of each person in `steps`
  CrowdSteps steps;
  std::vector<std::vector<CrowdSteps::Person>> past;  ///< after each step
  std::mutex mutex;
};

Crowd::Crowd(const World::Parts& parts) : state_(std::make_unique<State>(parts)) {}
Crowd::~Crowd() = default;
Crowd::Crowd(Crowd&&) noexcept = default;
Crowd& Crowd::operator=(Crowd&&) noexcept = default;

WalkerPath::Step Crowd::at(std::size_t person, double time) const {
  return state_->at(person, time);
}

void Crowd::intersect(const Ray& ray, RayHit& nearest) const {
  for (std::size_t i = 0; i < state_->paths.size(); ++i) {
    intersectPerson(state_->at(i, ray.time), ray, nearest);
  }
}

}  // namespace kestrel
