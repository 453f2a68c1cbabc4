// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/simulation/flight_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

/// A room of 8 m x 6 m and 3 m height with a pillar, a pane of glass and a table.
Place room() {
  Place place;
  place.name = "room";
  place.parts.boxes = {{{4.0, 0.0, 1.5}, {0.2, 6.2, 3.0}},
                       {{-4.0, 0.0, 1.5}, {0.2, 6.2, 3.0}},
                       {{0.0, 3.0, 1.5}, {8.2, 0.2, 3.0}},
                       {{0.0, -3.0, 1.5}, {8.2, 0.2, 3.0}},
                       {{-1.5, 1.5, 1.5}, {1.0, 0.05, 3.0}, 0.5, Material::kGlass},
                       {{2.5, 1.5, 0.74}, {1.2, 0.8, 0.04}}};
  place.parts.cylinders = {{{1.0, -0.5}, 0.2, 0.0, 3.0}};
  place.plan.waypoints = {{{-2.5, -1.5, 1.0}, 0.3, 5.0}, {{2.5, -2.0, 1.0}, 0.0, 0.0}};
  return place;
}

/// Distance to the nearest solid, computed without ray casting.
double distanceToSolids(const Place& place, const Eigen::Vector3d& point) {
  double distance = std::min(point.z(), place.parts.ceiling_m - point.z());
  for (const Box& box : place.parts.boxes) {
    const Eigen::Vector3d local =
        Eigen::AngleAxisd(-box.yaw, Eigen::Vector3d::UnitZ()) * (point - box.center);
    const Eigen::Vector3d outside = (local.cwiseAbs() - box.size / 2.0).cwiseMax(0.0);
    distance = std::min(distance, outside.norm());
  }
  for (const Cylinder& cylinder : place.parts.cylinders) {
    const double aside = (point.head<2>() - cylinder.center).norm() - cylinder.radius;
    const double above = std::max(point.z() - cylinder.top, cylinder.bottom - point.z());
    distance = std::min(distance, std::hypot(std::max(aside, 0.0), std::max(above, 0.0)));
  }
  return distance;
}

double smallestDistance(const Place& place, const Motion& motion) {
  double smallest = std::numeric_limits<double>::infinity();
  for (double t = 0.0; t < motion.duration(); t += 0.02) {
    const Eigen::Vector3d position = motion.at(t).world_T_base.translation();
    smallest = std::min(smallest, distanceToSolids(place, position));
  }
  return smallest;
}

TEST(RandomPlan, FlightsKeepTheirDistanceFromSolidsAndGlass) {
  const Place place = room();
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const FlightPlan plan = randomPlan(place, 30.0, seed);
    const auto motion = flyQuadrotor(plan, place.quadrotor, seed);
    EXPECT_GT(smallestDistance(place, *motion), 0.25) << "seed " << seed;
  }
}

TEST(RandomPlan, ChangesYawAndHeightForAboutTheGivenTime) {
  double farthest = 0.0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const FlightPlan plan = randomPlan(room(), 30.0, seed);
    const auto motion = flyQuadrotor(plan, QuadrotorConfig(), seed);
    EXPECT_GT(motion->duration(), 25.0) << seed;
    EXPECT_LT(motion->duration(), 90.0) << seed;
    std::set<int> yaws, heights;
    for (const FlightPlan::Waypoint& waypoint : plan.waypoints) {
      yaws.insert(static_cast<int>(waypoint.yaw * 10.0));
      heights.insert(static_cast<int>(waypoint.position.z() * 20.0));
      farthest = std::max(farthest, (waypoint.position - plan.waypoints.front().position).norm());
    }
    EXPECT_GT(yaws.size(), 4U) << seed;
    EXPECT_GT(heights.size(), 2U) << seed;
  }
  EXPECT_GT(farthest, 4.0);
}

TEST(RandomPlan, BeginsAtTheFirstWaypointOfThePlacesPlan) {
  const FlightPlan plan = randomPlan(room(), 10.0, 1);
  EXPECT_EQ(plan.waypoints.front().position, room().plan.waypoints.front().position);
  EXPECT_EQ(plan.waypoints.front().yaw, 0.3);
}

TEST(RandomPlan, KeepsAwayFromThePathsOfPeople) {
  Place place = room();
  Walker walker;
  walker.corners = {{-3.0, 0.2}, {3.0, 0.2}};
  place.parts.walkers = {walker};
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    for (const FlightPlan::Waypoint& waypoint : randomPlan(place, 30.0, seed).waypoints) {
      EXPECT_LT(waypoint.position.y(), -0.7) << seed;  // the flight begins on this side
    }
  }
}

TEST(RandomPlan, SameSeedSamePlan) {
  const FlightPlan a = randomPlan(room(), 30.0, 5), b = randomPlan(room(), 30.0, 5);
  const FlightPlan other = randomPlan(room(), 30.0, 6);
  ASSERT_EQ(a.waypoints.size(), b.waypoints.size());
  EXPECT_EQ(a.speed_m_s, b.speed_m_s);
  EXPECT_EQ(a.waypoints.back().position, b.waypoints.back().position);
  EXPECT_NE(a.waypoints.back().position, other.waypoints.back().position);
}

TEST(RandomPlan, HoversIfNoWaypointCanBeReached) {
  Place place = room();
  place.parts.boxes.push_back({{-2.5, -1.5, 1.5}, {0.8, 0.8, 3.0}});  // encloses the vehicle
  const FlightPlan plan = randomPlan(place, 20.0, 1);
  EXPECT_EQ(plan.waypoints.size(), 1U);
  EXPECT_EQ(plan.waypoints[0].hover_s, 20.0);
}

TEST(RandomPlan, ClimbsFirstIfThePlanBeginsCloseToTheFloor) {
  Place place = room();
  place.plan.waypoints[0].position.z() = 0.3;
  const FlightPlan plan = randomPlan(place, 20.0, 1);
  ASSERT_GT(plan.waypoints.size(), 3U);
  EXPECT_EQ(plan.waypoints[0].position.z(), 0.3);
  EXPECT_EQ(plan.waypoints[1].position, Eigen::Vector3d(-2.5, -1.5, 0.7));
}

TEST(RandomPlan, RejectsAPlaceWithoutAPlanAndANonFiniteDuration) {
  Place place = room();
  EXPECT_THROW(randomPlan(place, std::numeric_limits<double>::infinity(), 1),
               std::invalid_argument);
  EXPECT_THROW(randomPlan(place, std::nan(""), 1), std::invalid_argument);
  place.plan.waypoints.clear();
  EXPECT_THROW(randomPlan(place, 10.0, 1), std::invalid_argument);
}

TEST(BuiltInPlaces, AllowRandomFlights) {
  for (const Place& place : places()) {
    const FlightPlan plan = randomPlan(place, 20.0, 1);
    const auto motion = flyQuadrotor(plan, place.quadrotor, 1);
    EXPECT_GT(plan.waypoints.size(), 5U) << place.name;
    EXPECT_GT(smallestDistance(place, *motion), 0.2) << place.name;
  }
}

TEST(BuiltInPlaces, FlightsFollowTheirPlans) {
  for (const Place& place : places()) {
    const auto motion = flyQuadrotor(place.plan, place.quadrotor, 1);
    const Eigen::Vector3d end = motion->at(motion->duration()).world_T_base.translation();
    EXPECT_LT((end - place.plan.waypoints.back().position).norm(), 1e-3) << place.name;
    double highest_speed = 0.0;
    for (double t = 0.0; t < motion->duration(); t += 0.01) {
      highest_speed = std::max(highest_speed, motion->at(t).velocity.norm());
    }
    EXPECT_GT(highest_speed, 0.8 * place.plan.speed_m_s) << place.name;
    EXPECT_LT(highest_speed, place.plan.speed_m_s + 0.6) << place.name;  // with gusts
    EXPECT_GT(smallestDistance(place, *motion), 0.2) << place.name;
  }
}

}  // namespace
}  // namespace kestrel
