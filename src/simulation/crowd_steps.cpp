// SPDX-License-Identifier: BSD-3-Clause
#include "crowd_steps.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr double kLookAhead = 0.5;     ///< m; people walk to the place of their path so far ahead
constexpr double kNearGoal = 0.25;     ///< m; where a path turns back, they turn this much before
constexpr double kPathReach = 0.8;     ///< m of the path in which the place of a person is sought
constexpr double kPathSearch = 0.02;   ///< m
constexpr double kStrongest = 3.0;     ///< m/s², of an adult who starts or stops
constexpr double kToSolids = 0.25;     ///< m, of the middle of a person
constexpr double kBesidePath = 0.05;   ///< m nearer to solids than the path, if that is near
constexpr double kTallest = 1.75;      ///< m; what is above is in nobody's way
constexpr double kPersonal = 0.65;     ///< m, the distance that people want to keep
constexpr double kForesight = 2.5;     ///< s, in which they see a collision coming
constexpr double kBlockedAfter = 0.4;  ///< s, after which a velocity must not lead into a solid
constexpr double kSlowest = 0.1;       ///< m/s; slower people do not turn
constexpr double kWaiting = 0.15;      ///< m/s; slower people wait
constexpr double kPatience = 1.0;      ///< s
constexpr double kStepAside = 80.0;    ///< degrees from the way
constexpr double kBlockedCost = 10.0, kSoonest = 0.1;

const std::array<double, 9> kTurns = {0.0, 20.0, -20.0, 40.0, -40.0, 60.0, -60.0, 90.0, -90.0};
const std::array<double, 4> kShares = {1.0, 0.75, 0.5, 0.25};

double distanceTo(const Box& box, const Eigen::Vector2d& point) {
  const Eigen::Vector2d offset =
      Eigen::Rotation2Dd(-box.yaw) * (point - box.center.head<2>()).eval();
  return (offset.cwiseAbs() - 0.5 * box.size.head<2>()).cwiseMax(0.0).norm();
}

/// Time until `offset`, which changes by -`velocity`, is shorter than kPersonal, s.
double timeToMeet(const Eigen::Vector2d& offset, const Eigen::Vector2d& velocity) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double closing = offset.dot(velocity), speed2 = velocity.squaredNorm();
  if (closing <= 0.0) return kNever;
  const double outside2 = offset.squaredNorm() - kPersonal * kPersonal;
  if (outside2 <= 0.0) return 0.0;
  const double root = closing * closing - speed2 * outside2;
  return root < 0.0 ? kNever : (closing - std::sqrt(root)) / speed2;
}

}  // namespace

std::size_t CrowdSteps::add(const WalkerPath& path) {
  const WalkerPath::Step start = path.at(0.0);
  people_.push_back(
      {start, path.speed() * start.direction, start.traveled, kToSolids, 0.0, -1.0, false});
  paths_.push_back(path);
  return people_.size() - 1;
}

void CrowdSteps::advance(double seconds) {
  for (std::size_t i = 0; i < people_.size(); ++i) {
    Person& person = people_[i];
    follow(i);
    noteWaiting(person, seconds);
    const Eigen::Vector2d change = bestVelocity(i) - person.velocity;
    const double most = kStrongest * seconds;
    person.velocity += change * std::min(1.0, most / std::max(change.norm(), most));
    const Eigen::Vector2d next = person.step.position + seconds * person.velocity;
    if (!keepsDistance(i, next) || !mayStand(i, next)) {
      person.velocity.setZero();
      continue;
    }
    person.step.position = next;
    const double speed = person.velocity.norm();
    person.step.traveled += seconds * speed;
    if (speed > kSlowest) person.step.direction = person.velocity / speed;
  }
}

/// Two who wait for each other step aside after some time, first to the right, then to the left.
void CrowdSteps::noteWaiting(Person& person, double seconds) {
  const bool waits = person.velocity.norm() < kWaiting;
  person.waited = std::max(0.0, person.waited + (waits ? seconds : -seconds));
  if (person.waited > kPatience) {
    person.side = person.steps_aside ? -person.side : person.side;
    person.steps_aside = true;
    person.waited = 0.5 * kPatience;
  } else if (person.waited == 0.0 && person.steps_aside) {
    person.steps_aside = false;
    person.side = -1.0;
  }
}

/// Moves the place on the path on to the nearest one to the person.
void CrowdSteps::follow(std::size_t i) {
  Person& person = people_[i];
  double best = std::numeric_limits<double>::infinity(), place = person.along;
  for (double ahead = 0.0; ahead < kPathReach; ahead += kPathSearch) {
    const Eigen::Vector2d on_path = paths_[i].alongPath(person.along + ahead).position;
    const double distance = (on_path - person.step.position).norm();
    if (distance >= best) continue;
    best = distance;
    place = person.along + ahead;
  }
  person.along = place;
  person.to_solids =
      std::min(kToSolids, distanceToSolids(paths_[i].alongPath(place).position) - kBesidePath);
}

Eigen::Vector2d CrowdSteps::wantedVelocity(std::size_t i) const {
  const auto wayTo = [&](double ahead) -> Eigen::Vector2d {
    return paths_[i].alongPath(people_[i].along + ahead).position - people_[i].step.position;
  };
  double ahead = kLookAhead;
  while (wayTo(ahead).norm() < kNearGoal && ahead < paths_[i].length()) ahead += kPathSearch;
  const Eigen::Vector2d wanted = paths_[i].speed() * wayTo(ahead).normalized();
  if (!people_[i].steps_aside) return wanted;
  return Eigen::Rotation2Dd(degToRad(people_[i].side * kStepAside)) * wanted;
}

Eigen::Vector2d CrowdSteps::bestVelocity(std::size_t i) const {
  const Eigen::Vector2d wanted = wantedVelocity(i);
  Eigen::Vector2d best = Eigen::Vector2d::Zero();
  double least = costOf(i, best, wanted);
  for (const double share : kShares) {
    for (const double turn : kTurns) {
      const Eigen::Vector2d velocity = share * (Eigen::Rotation2Dd(degToRad(turn)) * wanted);
      const double cost = costOf(i, velocity, wanted);
      if (cost >= least) continue;
      least = cost;
      best = velocity;
    }
  }
  return best;
}

double CrowdSteps::costOf(std::size_t i, const Eigen::Vector2d& velocity,
                          const Eigen::Vector2d& wanted) const {
  const Person& person = people_[i];
  double soonest = kForesight;
  for (std::size_t j = 0; j < people_.size(); ++j) {
    if (j == i) continue;
    const Eigen::Vector2d relative = 2.0 * velocity - person.velocity - people_[j].velocity;
    soonest =
        std::min(soonest, timeToMeet(people_[j].step.position - person.step.position, relative));
  }
  double cost = (velocity - wanted).norm();
  if (soonest < kForesight) cost += 1.0 / std::max(soonest, kSoonest);
  if (!mayStand(i, person.step.position + kBlockedAfter * velocity)) cost += kBlockedCost;
  return cost;
}

/// Not too far from its path, and not into solids.
bool CrowdSteps::mayStand(std::size_t i, const Eigen::Vector2d& position) const {
  return paths_[i].distanceTo(position) < kMostAside &&
         distanceToSolids(position) > people_[i].to_solids;
}

/// Those who are too close from the start may go apart.
bool CrowdSteps::keepsDistance(std::size_t i, const Eigen::Vector2d& position) const {
  for (std::size_t j = 0; j < people_.size(); ++j) {
    if (j == i) continue;
    const Eigen::Vector2d& other = people_[j].step.position;
    const double distance = (other - position).norm();
    if (distance < kBodyDistance && distance <= (other - people_[i].step.position).norm()) {
      return false;
    }
  }
  return true;
}

double CrowdSteps::distanceToSolids(const Eigen::Vector2d& point) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Box& box : parts_.boxes) {
    if (box.center.z() - 0.5 * box.size.z() > kTallest) continue;
    nearest = std::min(nearest, distanceTo(box, point));
  }
  for (const Cylinder& cylinder : parts_.cylinders) {
    nearest = std::min(nearest, (point - cylinder.center).norm() - cylinder.radius);
  }
  return nearest;
}

}  // namespace kestrel
