// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/parameters/parameters_yaml.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <set>

#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/parameters/filter_parameters.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

const char* const kShippedFile = KESTREL_SOURCE_DIR "/config/kestrel_slam.yaml";

/// What loading a file with `content` throws, without the path before it.
std::string fileError(const std::string& content) {
  const TemporaryFolder folder;
  const std::string path = folder.write("p.yaml", content);
  SlamConfig config;
  const std::string message = messageOf([&] { loadParameters(path, config); });
  return message.rfind(path, 0) == 0 ? message.substr(path.size()) : message;
}

TEST(ParametersYamlTest, TheShippedFileHoldsExactlyTheDefaults) {
  const YAML::Node shipped = YAML::LoadFile(kShippedFile);
  SlamConfig defaults;
  const auto parameters = parametersOf(defaults);
  EXPECT_EQ(shipped.size(), parameters.size());
  for (const Parameter& parameter : parameters) {
    ASSERT_TRUE(shipped[parameter.name]) << parameter.name << " is missing";
    EXPECT_EQ(shipped[parameter.name].Scalar(), valueText(parameter)) << parameter.name;
  }
}

TEST(ParametersYamlTest, TheFiltersFileHoldsExactlyItsDefaults) {
  const std::string path = KESTREL_SOURCE_DIR "/config/pose_filter.yaml";
  EXPECT_EQ(readFile(path), defaultFilterParametersYaml());
  const YAML::Node shipped = YAML::LoadFile(path);
  PoseFilterConfig defaults;
  std::set<std::string> names;
  for (const Parameter& parameter : parametersOf(defaults)) {
    EXPECT_TRUE(names.insert(parameter.name).second) << parameter.name << " twice";
    EXPECT_FALSE(parameter.description.empty()) << parameter.name;
    setValue(parameter, shipped[parameter.name].Scalar());  // within its limits
  }
  EXPECT_EQ(shipped.size(), names.size());
  validate(defaults);
}

TEST(ParametersYamlTest, TheShippedFileIsWhatTheToolPrints) {
  EXPECT_EQ(readFile(kShippedFile), defaultParametersYaml());
}

TEST(ParametersYamlTest, WhatIsThereIsSetAndTheRestIsKept) {
  const TemporaryFolder folder;
  SlamConfig config;
  config.projector.beams.max_range_m = 12.0;
  loadParameters(folder.write("p.yaml", "# mine\nmap_resolution: 0.1\nmatcher: \"correlative\"\n"),
                 config);
  EXPECT_EQ(config.mapper.grid.resolution_m, 0.1);
  for (const Parameter& parameter : parametersOf(config)) {
    if (parameter.name == "matcher") {
      EXPECT_EQ(valueText(parameter), "correlative");
    }
  }
  EXPECT_EQ(config.projector.beams.max_range_m, 12.0);
}

TEST(ParametersYamlTest, AnEmptyFileChangesNothing) {
  EXPECT_EQ(fileError(""), "nothing thrown");
  EXPECT_EQ(fileError("# nothing\n"), "nothing thrown");
}

TEST(ParametersYamlTest, ErrorsNameLineAndParameter) {
  EXPECT_EQ(fileError("\nmap_resolutoin: 0.1\n"),
            ", line 2: unknown parameter 'map_resolutoin'; did you mean 'map_resolution'?");
  EXPECT_EQ(fileError("map_resolution: 7\n"),
            ", line 1: map_resolution = 7: must be between 0.005 and 1 m");
  EXPECT_EQ(fileError("a:\n  map_resolution: 0.1\n"),
            ", line 1: 'a' is not a single value; one 'name: value' a line is expected");
  EXPECT_EQ(fileError("just text\n"), ": one 'name: value' a line is expected");
  EXPECT_CONTAINS(fileError("map_resolution: [0.1\n"), "no valid YAML");
}

TEST(ParametersYamlTest, OldNamesAreAcceptedWithAWarning) {
  const TemporaryFolder folder;
  PoseFilterConfig filter;
  std::vector<std::string> warnings;
  loadParameters(folder.write("p.yaml", "max_anchors: 5\nheading_sigma: 0.2\n"),
                 parametersOf(filter),
                 [&](const std::string& warning) { warnings.push_back(warning); });
  EXPECT_EQ(filter.gate.max_reinitializations, 5);
  EXPECT_EQ(filter.yaw_sigma_rad, 0.2);
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_CONTAINS(warnings.front(), "max_reinitializations");
}

/// rosparam cannot send a value that is missing.
TEST(ParametersYamlTest, TheServerCanTakeEveryValue) {
  for (const std::string& yaml : {defaultParametersYaml(), defaultFilterParametersYaml()}) {
    for (const auto& entry : YAML::Load(yaml)) {
      EXPECT_FALSE(entry.second.IsNull()) << entry.first.Scalar();
    }
  }
}

TEST(ParametersYamlTest, AMissingFileIsNamed) {
  SlamConfig config;
  EXPECT_EQ(messageOf([&] { loadParameters("/nowhere/p.yaml", config); }),
            "cannot read /nowhere/p.yaml: No such file or directory");
}

}  // namespace
}  // namespace kestrel
