// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/hard_flight.h"

#include <gtest/gtest.h>

#include <cctype>

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

TEST(HardFlight, MapperThatAcceptsEverythingMissesLostScans) {
  HardFlight flight = blockedFlight();
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
