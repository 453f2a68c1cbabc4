// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/parameters/parameters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <stdexcept>

namespace kestrel {
namespace {

/// The message that `action` throws, or "accepted".
template <typename Action>
std::string errorOf(const Action& action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

std::string setError(const std::string& name, const std::string& text) {
  return errorOf([&] {
    SlamConfig config;
    setParameter(config, name, text);
  });
}

/// The text of one parameter's value in `config`.
std::string valueOf(SlamConfig config, const std::string& name) {
  for (const Parameter& parameter : parametersOf(config)) {
    if (parameter.name == name) return valueText(parameter);
  }
  return "no such parameter";
}

TEST(Parameters, SetsEachKindOfValue) {
  SlamConfig config;
  setParameter(config, "map_resolution", "0.1");
  setParameter(config, "laser_max_dist", "5");
  setParameter(config, "clear_range", "1e1");
  setParameter(config, "max_beams", "2000");
  setParameter(config, "matcher", "correlative");
  EXPECT_EQ(config.mapper.grid.resolution_m, 0.1);
  EXPECT_EQ(config.projector.beams.max_range_m, 5.0);
  EXPECT_EQ(config.projector.beams.clear_range_m, 10.0);
  EXPECT_EQ(config.projector.beams.max_beams, 2000);
  EXPECT_EQ(valueOf(config, "matcher"), "correlative");
}

TEST(Parameters, HectorNamesReachTheirFields) {
  SlamConfig config;
  setParameter(config, "update_factor_free", "0.3");
  setParameter(config, "update_factor_occupied", "0.8");
  setParameter(config, "map_update_distance_thresh", "0.4");
  setParameter(config, "map_update_angle_thresh", "0.9");
  setParameter(config, "laser_min_dist", "0.2");
  EXPECT_EQ(config.mapper.grid.miss_probability, 0.3);
  EXPECT_EQ(config.mapper.grid.hit_probability, 0.8);
  EXPECT_EQ(config.mapper.insert_distance_m, 0.4);
  EXPECT_EQ(config.mapper.insert_angle_rad, 0.9);
  EXPECT_EQ(config.projector.beams.min_range_m, 0.2);
}

TEST(Parameters, RefusesWhatIsOutOfRange) {
  EXPECT_EQ(setError("map_resolution", "0"), "map_resolution = 0: must be between 0.005 and 1 m");
  EXPECT_EQ(setError("map_resolution", "0.005"), "accepted");
  EXPECT_EQ(setError("map_resolution", "1"), "accepted");
  EXPECT_EQ(setError("map_resolution", "1.0000001"),
            "map_resolution = 1.0000001: must be between 0.005 and 1 m");
  EXPECT_EQ(setError("max_beams", "-5"), "max_beams = -5: must be between 1 and 10000000");
  EXPECT_EQ(setError("matcher", "icpp"),
            "matcher = icpp: must be one of gauss_newton, correlative, progressive, icp, hybrid");
}

TEST(Parameters, NumbersParseCompletely) {
  const std::string expected = ": must be a number between 0.005 and 1 m";
  for (const std::string text :
       {"0.1x", "0,1", "abc", "nan", "inf", "-inf", "1e999", " 0.1", "0.1 "}) {
    EXPECT_EQ(setError("map_resolution", text), "map_resolution = " + text + expected);
  }
  EXPECT_EQ(setError("map_resolution", ""), "map_resolution = ''" + expected);
  for (const std::string text : {"1.5", "1e3", "99999999999", "0x10", "true"}) {
    EXPECT_EQ(setError("max_beams", text),
              "max_beams = " + text + ": must be a whole number between 1 and 10000000");
  }
}

TEST(Parameters, ARefusedValueChangesNothing) {
  SlamConfig config;
  EXPECT_THROW(setParameter(config, "map_resolution", "7"), std::invalid_argument);
  EXPECT_THROW(setParameter(config, "matcher", "none"), std::invalid_argument);
  EXPECT_EQ(config.mapper.grid.resolution_m, OccupancyGridConfig().resolution_m);
  EXPECT_EQ(valueOf(config, "matcher"), valueOf(SlamConfig(), "matcher"));
}

TEST(Parameters, MessagesStayOnOneLine) {
  const std::string message = setError("map_resolution", "1\n2\t" + std::string(1000, 'x'));
  EXPECT_EQ(message.find('\n'), std::string::npos);
  EXPECT_LT(message.size(), 150U);
}

TEST(Parameters, NamesTheNearestParameter) {
  EXPECT_EQ(setError("map_resolutoin", "0.1"),
            "unknown parameter 'map_resolutoin'; did you mean 'map_resolution'?");
  EXPECT_EQ(setError("laser_max_distance", "1"),
            "unknown parameter 'laser_max_distance'; did you mean 'laser_max_dist'?");
  EXPECT_EQ(setError("Matcher", "1"), "unknown parameter 'Matcher'; did you mean 'matcher'?");
  EXPECT_EQ(setError("clear_rnge", "1"),
            "unknown parameter 'clear_rnge'; did you mean 'clear_range'?");
  EXPECT_EQ(setError("", "1").find("unknown parameter ''; did you mean '"), 0U);
}

TEST(Parameters, TextsOfValuesReadBackExactly) {
  SlamConfig config;
  config.mapper.grid.resolution_m = 0.1 + 0.2;  // not 0.3
  config.mapper.insert_distance_m = 1.0 / 3.0;
  SlamConfig copy;
  for (const Parameter& parameter : parametersOf(config)) {
    setParameter(copy, parameter.name, valueText(parameter));
  }
  EXPECT_EQ(copy.mapper.grid.resolution_m, 0.1 + 0.2);
  EXPECT_EQ(copy.mapper.insert_distance_m, 1.0 / 3.0);
}

TEST(Parameters, TextsOfValuesAreShort) {
  SlamConfig config;
  config.mapper.grid.resolution_m = 0.05;
  config.mapper.grid.memory_limit_mb = 1e6;
  config.projector.beams.max_beams = 100000;
  EXPECT_EQ(valueOf(config, "map_resolution"), "0.05");
  EXPECT_EQ(valueOf(config, "map_memory_limit_mb"), "1000000");
  EXPECT_EQ(valueOf(config, "max_beams"), "100000");
}

TEST(Parameters, TableIsComplete) {
  SlamConfig config;
  std::set<std::string> names;
  for (const Parameter& parameter : parametersOf(config)) {
    EXPECT_TRUE(names.insert(parameter.name).second) << parameter.name << " twice";
    EXPECT_FALSE(parameter.description.empty()) << parameter.name;
    const bool is_text = std::holds_alternative<std::string*>(parameter.value);
    EXPECT_EQ(parameter.min < parameter.max,
              !is_text && !std::holds_alternative<bool*>(parameter.value))
        << parameter.name;
  }
}

TEST(Parameters, DefaultsAreValid) { EXPECT_NO_THROW(validate(SlamConfig())); }

TEST(Parameters, ValidateChecksRelationsAndRanges) {
  SlamConfig config;
  config.projector.beams.min_range_m = 5.0;
  config.projector.beams.max_range_m = 4.0;
  EXPECT_EQ(errorOf([&] { validate(config); }),
            "laser_min_dist = 5: must be less than laser_max_dist = 4");
  config = SlamConfig();
  config.mapper.grid.resolution_m = std::nan("");
  EXPECT_EQ(errorOf([&] { validate(config); }),
            "map_resolution = nan: must be a number between 0.005 and 1 m");
  config = SlamConfig();
  config.projector.ignored_angles = "10 to 20";
  EXPECT_NE(errorOf([&] { validate(config); }).find("'10 to 20' is no list of angles"),
            std::string::npos);
  config = SlamConfig();
  config.mapper.grid.min_probability = 0.5;
  EXPECT_NE(errorOf([&] { validate(config); }), "accepted");
}

}  // namespace
}  // namespace kestrel
