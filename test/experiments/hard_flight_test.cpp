// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/hard_flight.h"

#include <gtest/gtest.h>

#include <cctype>
#include <stdexcept>
#include <string>
#include <vector>

namespace kestrel {
namespace {

class HardFlights : public testing::TestWithParam<std::size_t> {};

TEST_P(HardFlights, KeepTheirLimits) {
  const HardFlight flight = hardFlights()[GetParam()];
  const HardFlightMeasurement m = measureHardFlight(flight);
  EXPECT_GT(m.flight.run.scans.size(), 100U);
  EXPECT_EQ(m.failures(flight.limits), "") << flight.trial.name;
  EXPECT_EQ(m.lost > 0, flight.lost_expected) << flight.trial.name;
}

INSTANTIATE_TEST_SUITE_P(All, HardFlights, testing::Range<std::size_t>(0, hardFlights().size()),
                         [](const auto& test) {
                           std::string name = hardFlights()[test.param].trial.name;
                           for (char& c : name) {
                             if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
                           }
                           return name;
                         });

HardFlight blockedFlight() {
  for (const HardFlight& flight : hardFlights()) {
    if (flight.lost_expected && !flight.trial.vehicle.imu) return flight;
  }
  throw std::logic_error("no hard flight blocks the view");
}

HardFlight flightCalled(const std::string& name) {
  for (const HardFlight& flight : hardFlights()) {
    if (flight.trial.name == name) return flight;
  }
  throw std::logic_error("no hard flight has this name");
}

TEST(HardFlight, TwelvePeopleKeepApartAndAreNotInWalls) {
  const World world(flightCalled("twelve people").trial.place.parts);
  const std::vector<Walker>& walkers = world.parts().walkers;
  ASSERT_EQ(walkers.size(), 12U);
  constexpr double kEvery = 0.02, kEnd = 45.0;  // s
  std::vector<double> ways(walkers.size(), 0.0);
  for (double time = 0.0; time < kEnd; time += kEvery) {
    for (std::size_t i = 0; i < walkers.size(); ++i) {
      const Eigen::Vector2d place = world.walkerAt(i, time);
      const double step = (world.walkerAt(i, time + kEvery) - place).norm();
      ASSERT_LT(step, 1.001 * walkers[i].speed_m_s * kEvery) << i << " at " << time << " s";
      ways[i] += step;
      ASSERT_GT(distanceToUprightSurface(world.parts(), place), 0.2) << i << " at " << time << " s";
      for (std::size_t j = 0; j < i; ++j) {
        ASSERT_GT((world.walkerAt(j, time) - place).norm(), kBodyDistance - 0.01);
      }
    }
  }
  for (std::size_t i = 0; i < walkers.size(); ++i) {
    EXPECT_GT(ways[i], 0.6 * walkers[i].speed_m_s * kEnd) << i;
  }
}

TEST(HardFlight, MapperThatAcceptsEverythingMissesLostScans) {
  HardFlight flight = blockedFlight();
  flight.trial.config.mapper.matcher.method = "gauss_newton";
  flight.trial.config.mapper.lost_score = 0.0;
  flight.trial.config.mapper.min_known_share = 0.0;
  flight.trial.config.mapper.matcher.search_score = 0.0;
  flight.trial.config.mapper.evaluation.enabled = false;
  const HardFlightMeasurement m = measureHardFlight(flight);
  EXPECT_GT(m.missed, 100U);
  EXPECT_GT(m.double_cells + m.ghost_cells, 100U);
  EXPECT_NE(m.failures(flight.limits).find("missed over 0"), std::string::npos);
}

TEST(HardFlight, MapperThatRejectsEverythingGivesFalseAlarms) {
  HardFlight flight = blockedFlight();
  flight.trial.config.mapper.lost_score = 1.0;
  const HardFlightMeasurement m = measureHardFlight(flight);
  EXPECT_GT(m.false_alarms, 100U);
  EXPECT_NE(m.failures(flight.limits).find("false alarms over 0"), std::string::npos);
}

TEST(HardFlight, FailuresListTheExceededLimits) {
  HardFlightMeasurement m;
  EXPECT_EQ(m.failures(HardLimits()), "");
  m.ate_m = 0.03;
  m.recovery_s = 0.6;
  EXPECT_EQ(m.failures(HardLimits()), "ATE over 0.02, recovery over 0.5");
}

}  // namespace
}  // namespace kestrel
