// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/parameters/parameters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <stdexcept>

#include "kestrel_slam/parameters/filter_parameters.h"
#include "kestrel_slam/parameters/parameters_text.h"
#include "kestrel_slam/parameters/parameters_yaml.h"

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

/// Each name once; a sentence as description; limits where there are numbers.
void expectComplete(const std::vector<Parameter>& table) {
  std::set<std::string> names;
  for (const Parameter& parameter : table) {
    EXPECT_TRUE(names.insert(parameter.name).second) << parameter.name << " twice";
    for (const std::string& name : parameter.old_names) {
      EXPECT_TRUE(names.insert(name).second) << name << " twice";
    }
    EXPECT_FALSE(parameter.group.empty()) << parameter.name;
    ASSERT_FALSE(parameter.description.empty()) << parameter.name;
    EXPECT_EQ(parameter.description.back(), '.') << parameter.name;
    const bool is_text = std::holds_alternative<std::string*>(parameter.value);
    EXPECT_EQ(parameter.min < parameter.max,
              !is_text && !std::holds_alternative<bool*>(parameter.value))
        << parameter.name;
  }
}

TEST(Parameters, TablesAreComplete) {
  SlamConfig config;
  expectComplete(parametersOf(config));
  PoseFilterConfig filter;
  expectComplete(parametersOf(filter));
}

TEST(Parameters, LimitsAreReadable) {
  SlamConfig config;
  for (const Parameter& parameter : parametersOf(config)) {
    const std::string limits = limitsText(parameter);
    EXPECT_EQ(limits.find("inf"), std::string::npos) << parameter.name;
    if (parameter.name == "map_resolution") {
      EXPECT_EQ(limits, "0.005 to 1");
    }
    if (parameter.name == "progressive_seed") {
      EXPECT_EQ(limits, "0 or more");
    }
    if (parameter.name == "covariance") {
      EXPECT_EQ(limits, "hessian, sampled");
    }
    if (parameter.name == "mirror_angles") {
      EXPECT_EQ(limits, "");
    }
  }
}

TEST(Parameters, SomeHaveNoUpperLimit) {
  EXPECT_EQ(setError("map_update_distance_thresh", "1000000"), "accepted");
  EXPECT_EQ(setError("map_update_distance_thresh", "-1"),
            "map_update_distance_thresh = -1: must be 0 m or more");
  EXPECT_EQ(setError("map_update_distance_thresh", "far"),
            "map_update_distance_thresh = far: must be a number, 0 m or more");
  EXPECT_EQ(setError("map_update_distance_thresh", "inf"),
            "map_update_distance_thresh = inf: must be a number, 0 m or more");
}

TEST(Parameters, OldNamesAreAcceptedWithOneWarning) {
  PoseFilterConfig filter;
  std::vector<std::string> warnings;
  applySettings({"heading_sigma=0.2", "anchor_after=3", "max_anchors=7", "coast_after=0.7"},
                parametersOf(filter),
                [&](const std::string& warning) { warnings.push_back(warning); });
  EXPECT_EQ(filter.yaw_sigma_rad, 0.2);
  EXPECT_EQ(filter.gate.reinitialize_after_s, 3.0);
  EXPECT_EQ(filter.gate.max_reinitializations, 7);
  EXPECT_EQ(filter.gate.coast_after_s, 0.7);
  ASSERT_EQ(warnings.size(), 3U);
  EXPECT_EQ(warnings.front(),
            "the parameter heading_sigma is deprecated; its new name is yaw_sigma");
}

TEST(Parameters, MessagesForOldNamesShowTheNewOne) {
  PoseFilterConfig filter;
  EXPECT_EQ(errorOf([&] {
              setParameter(parametersOf(filter), "heading_sigma", "-1", [](const std::string&) {});
            }),
            "yaw_sigma = -1: must be between 0.0001 and 10 rad");
}

/// YAML 1.1, which rosparam reads, takes 2e-05 for a text.
TEST(Parameters, SmallNumbersHaveNoExponent) {
  PoseFilterConfig filter;
  filter.noise.gyro_bias_walk = 2.5e-5;
  for (const Parameter& parameter : parametersOf(filter)) {
    if (parameter.name == "gyro_bias_walk") {
      EXPECT_EQ(valueText(parameter), "0.000025");
    }
  }
  EXPECT_EQ(defaultFilterParametersYaml().find("e-"), std::string::npos);
}

/// A table with one parameter of each kind.
struct Example {
  double speed = 0.5;
  std::string frame, mode = "fast";
  std::vector<Parameter> table() {
    return {{"max_speed", "m/s", "Speed limit.", &speed, 0.0, 10.0, {}, "Motion", {"vmax"}},
            {"mode", "", "How it moves.", &mode, 0.0, 0.0, {"fast", "slow"}, "Motion", {}},
            {"frame", "", "Frame a|b.", &frame, 0.0, 0.0, {}, "Frames", {}}};
  }
};

TEST(Parameters, MarkdownHasATableForEachGroup) {
  EXPECT_EQ(parametersMarkdown(Example().table()),
            "**Motion**\n\n"
            "| name | default | unit | limits | effect |\n|---|---|---|---|---|\n"
            "| `max_speed` | `0.5` | m/s | 0 to 10 | Speed limit. (Old name: `vmax`.) |\n"
            "| `mode` | `fast` |  | fast, slow | How it moves. |\n"
            "\n**Frames**\n\n"
            "| name | default | unit | limits | effect |\n|---|---|---|---|---|\n"
            "| `frame` | empty |  |  | Frame a\\|b. |\n");
}

TEST(Parameters, HelpShowsDefaultLimitsAndEffect) {
  EXPECT_EQ(parametersHelp(Example().table()),
            "Motion\n"
            "  max_speed: 0.5 m/s (0 to 10 m/s)\n      Speed limit. (Old name: vmax.)\n"
            "  mode: fast (fast, slow)\n      How it moves.\n"
            "\nFrames\n"
            "  frame: ''\n      Frame a|b.\n");
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
