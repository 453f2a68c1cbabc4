// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <set>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/simulation/flight_plan.h"
#include "kestrel_slam/simulation/sensor_models.h"

namespace kestrel {
namespace {

using Points = std::vector<Eigen::Vector3d>;

/// The straight lines through the waypoints of a plan, in small steps.
Points alongPlan(const FlightPlan& plan) {
  constexpr double kStep = 0.1;  // m
  Points points;
  for (std::size_t i = 1; i < plan.waypoints.size(); ++i) {
    const Eigen::Vector3d from = plan.waypoints[i - 1].position;
    const Eigen::Vector3d line = plan.waypoints[i].position - from;
    const double steps = std::ceil(line.norm() / kStep);
    for (double step = 0.0; step < steps; ++step) points.push_back(from + step / steps * line);
  }
  points.push_back(plan.waypoints.back().position);
  return points;
}

/// The distance to the nearest obstacle in any direction.
double clearance(const World& world, const Eigen::Vector3d& point, double time) {
  constexpr int kAzimuths = 72;
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kAzimuths; ++i) {
    const double azimuth = 2.0 * kPi * i / kAzimuths;
    for (int elevation = -90; elevation <= 90; elevation += 15) {
      const double up = degToRad(elevation);
      const Eigen::Vector3d direction(std::cos(up) * std::cos(azimuth),
                                      std::cos(up) * std::sin(azimuth), std::sin(up));
      nearest = std::min(nearest, world.cast(point, direction, time, 5.0).distance);
    }
  }
  return nearest;
}

/// Share of the beams of an ideal laser that get a return within `max_range`.
double seenShare(const World& world, const Eigen::Vector3d& point, double max_range) {
  constexpr int kBeams = 360;
  int seen = 0;
  for (int i = 0; i < kBeams; ++i) {
    const double angle = 2.0 * kPi * i / kBeams;
    const RayHit hit = world.cast(point, {std::cos(angle), std::sin(angle), 0.0}, 0.0, max_range);
    seen += std::isfinite(hit.distance) && hit.material != Material::kBlack;
  }
  return static_cast<double>(seen) / kBeams;
}

double lengthOf(const Points& points) {
  double length = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).norm();
  return length;
}

Points flown(const Place& place) {
  constexpr double kStep = 0.1;  // s
  const std::unique_ptr<Motion> motion = flyQuadrotor(place.plan, place.quadrotor, 1);
  Points points;
  for (double time = 0.0; time < motion->duration(); time += kStep) {
    points.push_back(motion->at(time).world_T_base.translation());
  }
  return points;
}

double yawSpread(const Place& place) {
  const std::unique_ptr<Motion> motion = flyQuadrotor(place.plan, place.quadrotor, 1);
  std::set<int> quadrants;
  for (double time = 0.0; time < motion->duration(); time += 0.5) {
    const Eigen::Vector3d nose = motion->at(time).world_T_base.linear().col(0);
    quadrants.insert((nose.x() > 0.0 ? 1 : 0) + (nose.y() > 0.0 ? 2 : 0));
  }
  return static_cast<double>(quadrants.size());
}

class EveryPlace : public testing::TestWithParam<std::string> {};

TEST_P(EveryPlace, PlanKeepsItsDistance) {
  const Place& place = kestrel::place(GetParam());
  const World world(place.parts);
  const Points points = alongPlan(place.plan);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double time = 0.1 * static_cast<double>(i) / place.plan.speed_m_s;
    const double needed = points[i].z() < 0.61 ? 0.4 : 0.6;  // slow near the floor
    ASSERT_GE(clearance(world, points[i], time), needed) << "at " << points[i].transpose();
  }
}

TEST_P(EveryPlace, FlightKeepsItsDistanceInGusts) {
  const Place& place = kestrel::place(GetParam());
  const World world(place.parts);
  double time = 0.0;
  for (const Eigen::Vector3d& point : flown(place)) {
    ASSERT_GE(clearance(world, point, time), 0.4)
        << "at " << point.transpose() << ", " << time << " s";
    time += 0.1;
  }
}

TEST_P(EveryPlace, IsClosed) {
  // From every point of the plan, every horizontal beam hits something.
  const Place& place = kestrel::place(GetParam());
  const World world(place.parts);
  for (const Eigen::Vector3d& point : alongPlan(place.plan)) {
    for (int i = 0; i < 360; ++i) {
      const double angle = degToRad(i + 0.37);
      const RayHit hit = world.cast(point, {std::cos(angle), std::sin(angle), 0.0}, 0.0, 500.0);
      ASSERT_TRUE(std::isfinite(hit.distance))
          << "from " << point.transpose() << " towards " << i << " deg";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Places, EveryPlace,
                         testing::Values("laboratory", "ring", "corridor", "hall", "cluttered",
                                         "glass", "people", "doors"),
                         [](const auto& test) { return test.param; });

TEST(Places, AreFoundByName) {
  std::set<std::string> names;
  for (const Place& place : places()) {
    names.insert(place.name);
    EXPECT_FALSE(place.description.empty());
    EXPECT_EQ(&kestrel::place(place.name), &place);
    EXPECT_GT(place.quadrotor.gust_m_s2, 0.0);
  }
  EXPECT_EQ(names.size(), 12u);
  try {
    place("moon");
    FAIL() << "found the moon";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(),
                 "unknown world 'moon'; known: laboratory, ring, corridor, hall, cluttered, "
                 "glass, people, doors, town, large_town, sparse_town, twins");
  }
}

TEST(Places, LaboratoryHasTheSizeOfThePaper) {
  const Place& lab = place("laboratory");
  EXPECT_EQ(lab.plan.speed_m_s, 0.5);
  QuadrotorConfig calm = lab.quadrotor;
  calm.gust_m_s2 = 0.0;
  const Points path = flown({lab.name, "", lab.parts, lab.plan, calm});
  EXPECT_NEAR(lengthOf(path), 25.0, 0.5);
  EXPECT_LT((path.back() - path.front()).norm(), 0.05);
  // 8 m by 8 m between the walls, measured above the furniture.
  const World world(lab.parts);
  EXPECT_NEAR(world.cast({0, 0, 2.9}, {1, 0, 0}, 0.0, 100.0).distance, 4.0, 1e-9);
  EXPECT_NEAR(world.cast({0, 0, 2.9}, {-1, 0, 0}, 0.0, 100.0).distance, 4.0, 1e-9);
  EXPECT_NEAR(world.cast({3, 0.6, 2.9}, {0, 1, 0}, 0.0, 100.0).distance, 3.4, 1e-9);
  EXPECT_NEAR(world.cast({3, -0.6, 2.9}, {0, -1, 0}, 0.0, 100.0).distance, 3.4, 1e-9);
  EXPECT_EQ(yawSpread(lab), 4.0);
}

TEST(Places, RingFlightIsOneLoopAndEightMeters) {
  const Place& ring = place("ring");
  EXPECT_EQ(ring.plan.speed_m_s, 1.0);
  const Points points = alongPlan(ring.plan);
  EXPECT_NEAR(lengthOf(points), 190.0 + 8.0, 0.1);
  EXPECT_EQ(yawSpread(ring), 4.0);
}

TEST(Places, RingHasAFeatureEveryFewMeters) {
  // Ranges of an ideal laser to the right, along one side of the ring.
  const Place& ring = place("ring");
  const World world(ring.parts);
  double bare = 0.0, longest = 0.0;
  for (double x = -20.0; x < 20.0; x += 0.02) {
    const double right = world.cast({x, -23.75, 1.0}, {0, -1, 0}, 0.0, 10.0).distance;
    bare = std::abs(right - 1.25) < 1e-9 ? bare + 0.02 : 0.0;
    longest = std::max(longest, bare);
  }
  EXPECT_LT(longest, 4.5);
  EXPECT_GT(longest, 0.5);
}

TEST(Places, CorridorIsLongAndHasFewFeatures) {
  const World world(place("corridor").parts);
  EXPECT_NEAR(world.cast({0.1, 0, 1}, {1, 0, 0}, 0.0, 100.0).distance, 59.9, 1e-9);
  int edges = 0;
  for (const double side : {-1.0, 1.0}) {
    double before = 1.25;
    for (double x = 0.01; x < 60.0; x += 0.01) {
      const double seen = world.cast({x, 0, 1}, {0, side, 0}, 0.0, 10.0).distance;
      edges += std::abs(seen - before) > 0.05;
      before = seen;
    }
  }
  EXPECT_EQ(edges, 8);  // two per door
}

TEST(Places, HallIsLargerThanTheLaserRange) {
  const Place& hall = place("hall");
  const World world(hall.parts);
  double smallest = 1.0;
  for (const Eigen::Vector3d& point : alongPlan(hall.plan)) {
    smallest = std::min(smallest, seenShare(world, point, 30.0));
  }
  EXPECT_LT(smallest, 0.3);
  EXPECT_GT(smallest, 0.01);  // but never nothing
}

TEST(Places, ClutteredRoomDiffersWithHeight) {
  const Place& room = place("cluttered");
  const World world(room.parts);
  const auto ranges = [&](double height) {
    std::vector<double> result;
    for (int i = 0; i < 360; ++i) {
      const double angle = degToRad(i);
      result.push_back(
          world.cast({-3.3, -2.2, height}, {std::cos(angle), std::sin(angle), 0.0}, 0.0, 100.0)
              .distance);
    }
    return result;
  };
  const auto different = [&](double low, double high) {
    const std::vector<double> a = ranges(low), b = ranges(high);
    int count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) count += std::abs(a[i] - b[i]) > 0.1;
    return count;
  };
  EXPECT_GT(different(0.5, 1.25), 30);
  EXPECT_GT(different(1.25, 2.05), 30);
  double lowest = 10.0, highest = 0.0;
  for (const auto& waypoint : room.plan.waypoints) {
    lowest = std::min(lowest, waypoint.position.z());
    highest = std::max(highest, waypoint.position.z());
  }
  EXPECT_EQ(lowest, 0.5);
  EXPECT_EQ(highest, 2.0);
}

TEST(Places, OfficeHasBeamsWithoutReturn) {
  const Place& office = place("glass");
  const World world(office.parts);
  double least = 1.0;
  for (const Eigen::Vector3d& point : alongPlan(office.plan)) {
    least = std::min(least, seenShare(world, point, 30.0));
  }
  EXPECT_LT(least, 0.8);
  EXPECT_GT(least, 0.4);
}

TEST(Places, OnlyPeopleHasWalkers) {
  EXPECT_EQ(place("people").parts.walkers.size(), 4u);
  for (const Place& other : places()) {
    EXPECT_EQ(other.parts.walkers.empty(), other.name != "people") << other.name;
  }
}

}  // namespace
}  // namespace kestrel
