// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "kestrel_slam/simulation/world.h"
#include "walker.h"

namespace kestrel {

/// People step aside from their path by less than this, m.
constexpr double kMostAside = 0.45;

/// Moves people who see each other in small steps. In each, everyone in turn chooses the velocity
/// that is near the wanted one and does not soon lead to a collision, taking half of the
/// responsibility for it [van den Berg 2008].
class CrowdSteps {
 public:
  struct Person {
    WalkerPath::Step step;
    Eigen::Vector2d velocity;  ///< m/s
    double along;              ///< place on the path, m
    double to_solids;          ///< distance that it keeps from solids there, m
    double waited = 0.0;       ///< s
    double side = -1.0;        ///< to which it steps aside next: -1 is right
    bool steps_aside = false;
  };

  explicit CrowdSteps(const World::Parts& parts) : parts_(parts) {}

  /// Adds a person at the start of the path; returns its index.
  std::size_t add(const WalkerPath& path);
  void advance(double seconds);
  const std::vector<Person>& people() const { return people_; }

 private:
  void follow(std::size_t i);
  static void noteWaiting(Person& person, double seconds);
  Eigen::Vector2d wantedVelocity(std::size_t i) const;
  Eigen::Vector2d bestVelocity(std::size_t i) const;
  double costOf(std::size_t i, const Eigen::Vector2d& velocity,
                const Eigen::Vector2d& wanted) const;
  bool mayStand(std::size_t i, const Eigen::Vector2d& position) const;
  bool keepsDistance(std::size_t i, const Eigen::Vector2d& position) const;
  double distanceToSolids(const Eigen::Vector2d& point) const;

  World::Parts parts_;
  std::vector<WalkerPath> paths_;
  std::vector<Person> people_;
};

}  // namespace kestrel
