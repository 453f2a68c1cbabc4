// SPDX-License-Identifier: BSD-3-Clause
#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/ConfigDescription.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <gtest/gtest.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "mapper_client.h"
#include "run_command.h"

namespace kestrel {
namespace {

using dynamic_reconfigure::Config;
using dynamic_reconfigure::ConfigDescription;
using dynamic_reconfigure::Reconfigure;

/// The value of a number in a Config; NaN if it is missing.
double valueOf(const Config& config, const std::string& name) {
  for (const auto& entry : config.doubles) {
    if (entry.name == name) return entry.value;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

Reconfigure request(const std::string& name, double value) {
  Reconfigure service;
  auto& entry = service.request.config.doubles.emplace_back();
  entry.name = name;
  entry.value = value;
  return service;
}

bool set(const std::string& name, double value) {
  Reconfigure service = request(name, value);
  return ros::service::call("/mapper/set_parameters", service);
}

/// Keeps the last message of a latched topic.
template <typename Message>
struct Last {
  explicit Last(const std::string& topic) {
    const boost::function<void(const Message&)> keep = [this](const Message& m) { message = m; };
    subscriber = ros::NodeHandle().subscribe<Message>(topic, 10, keep);
  }
  std::optional<Message> message;
  ros::Subscriber subscriber;
};

class LiveParametersTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    client_ = new MapperClient;
    flight_ = new TestFlight(laboratoryFlight(60));
    ASSERT_TRUE(client_->connect());
    ASSERT_TRUE(ros::service::waitForService("/mapper/set_parameters", 10000));
    ASSERT_TRUE(ros::service::waitForService("/scan_projector/set_parameters", 10000));
  }
  static void TearDownTestSuite() {
    delete client_;
    delete flight_;
  }
  static void fly(int scans) {
    for (int i = 0; i < scans; ++i)
      ASSERT_TRUE(client_->match(messageOf(flight_->scans[next_++].scan, "base_link")));
  }
  /// Distance of the farthest point of the last matched scan from the vehicle, m.
  static double reach() {
    const Pose2 pose = poseOf(client_->pose.pose);
    double farthest = 0.0;
    sensor_msgs::PointCloud2ConstIterator<float> x(client_->cloud, "x"), y(client_->cloud, "y");
    for (; x != x.end(); ++x, ++y)
      farthest = std::max(farthest, std::hypot(double{*x} - pose.x, double{*y} - pose.y));
    return farthest;
  }

  inline static MapperClient* client_ = nullptr;
  inline static TestFlight* flight_ = nullptr;
  inline static std::size_t next_ = 0;
};

TEST_F(LiveParametersTest, TheDescriptionHasLimitsAndOnlyWhatMayChange) {
  Last<ConfigDescription> last("/mapper/parameter_descriptions");
  ASSERT_TRUE(client_->waitFor([&] { return last.message.has_value(); }));
  ASSERT_EQ(last.message->groups.size(), 1U);
  std::map<std::string, std::string> types;
  for (const auto& row : last.message->groups[0].parameters) types[row.name] = row.type;
  EXPECT_EQ(types["laser_max_dist"], "double");
  EXPECT_EQ(types["close_loops"], "bool");
  EXPECT_EQ(types["ignored_angles"], "str");
  EXPECT_EQ(types.count("map_resolution"), 0U);
  EXPECT_EQ(valueOf(last.message->max, "laser_max_dist"), 1000.0);
  EXPECT_EQ(valueOf(last.message->min, "lost_score"), 0.0);
  EXPECT_EQ(valueOf(last.message->dflt, "lost_score"), 0.3) << "what the node started with";
}

TEST_F(LiveParametersTest, TheNextScanUsesTheNewRange) {
  fly(5);
  EXPECT_GT(reach(), 3.0);
  ASSERT_TRUE(set("laser_max_dist", 2.5));
  fly(2);
  client_->waitFor([] { return reach() < 2.6; });
  EXPECT_LT(reach(), 2.6);
  EXPECT_GT(reach(), 0.5);
  ASSERT_TRUE(set("laser_max_dist", 80.0));
  double on_server = 0.0;
  EXPECT_TRUE(ros::param::get("/mapper/laser_max_dist", on_server));
  EXPECT_EQ(on_server, 80.0);
}

TEST_F(LiveParametersTest, TheNextScanUsesTheNewScore) {
  fly(12);
  EXPECT_NE(client_->diagnosis("Match", "state"), "lost");
  ASSERT_TRUE(set("lost_score", 1.0));
  client_->publish(messageOf(flight_->scans[next_++].scan, "base_link"));
  EXPECT_TRUE(client_->waitFor([] {
    return client_->diagnosis("Match", "reason") == "no fit" ||
           client_->diagnosis("Match", "reason") == "carried: no fit";
  }));
  ASSERT_TRUE(set("lost_score", 0.35));
}

TEST_F(LiveParametersTest, WhatIsNotAllowedChangesNothing) {
  Last<Config> updates("/mapper/parameter_updates");
  EXPECT_FALSE(set("laser_min_dist", -1.0)) << "outside of its limits";
  EXPECT_FALSE(set("laser_min_dist", 90.0)) << "above laser_max_dist";
  EXPECT_FALSE(set("map_resolution", 0.1)) << "only before the start";
  Reconfigure both = request("good_score", 0.7);
  both.request.config.doubles.push_back(request("no_such_name", 1.0).request.config.doubles[0]);
  EXPECT_FALSE(ros::service::call("/mapper/set_parameters", both));
  Reconfigure nothing;
  ASSERT_TRUE(ros::service::call("/mapper/set_parameters", nothing));
  EXPECT_EQ(valueOf(nothing.response.config, "laser_min_dist"), 0.1);
  EXPECT_NE(valueOf(nothing.response.config, "good_score"), 0.7);
  EXPECT_TRUE(client_->waitFor([&] { return updates.message.has_value(); }));
}

/// Debian's command line client.
TEST_F(LiveParametersTest, DynparamSetsGetsAndSaysTheReason) {
  const std::string dynparam = "/usr/bin/python3 /usr/lib/dynamic_reconfigure/dynparam ";
  if (!std::filesystem::exists("/usr/lib/dynamic_reconfigure/dynparam"))
    GTEST_SKIP() << "python3-dynamic-reconfigure is not installed";
  for (const std::string node : {"/mapper", "/scan_projector"}) {
    const Outcome done = runCommand(dynparam + "set " + node + " laser_z_max_value 0.7");
    EXPECT_EQ(done.code, 0) << done.output;
    const Outcome all = runCommand(dynparam + "get " + node);
    EXPECT_NE(all.output.find("'laser_z_max_value': 0.7"), std::string::npos) << all.output;
  }
  for (const std::string name : {"close_loops", "tracker"}) {
    for (const std::string value : {"False", "True", "False"}) {
      const Outcome done = runCommand(dynparam + "set /mapper " + name + " " + value);
      EXPECT_EQ(done.code, 0) << done.output;
      const Outcome all = runCommand(dynparam + "get /mapper");
      EXPECT_NE(all.output.find("'" + name + "': " + value), std::string::npos) << all.output;
    }
  }
  const Outcome refused = runCommand(dynparam + "set /mapper laser_min_dist 90.0");
  EXPECT_NE(refused.output.find("laser_min_dist"), std::string::npos) << refused.output;
  EXPECT_NE(refused.output.find("laser_max_dist"), std::string::npos) << refused.output;
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_parameters_test");
  const ros::NodeHandle keeps_the_node_alive;
  return RUN_ALL_TESTS();
}
