// SPDX-License-Identifier: BSD-3-Clause
// One recorded flight through the three nodes in one process and through the offline run: the same
// trajectory, bit for bit, where the messages arrive in the same order.

#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/Range.h>
#include <tf2_msgs/TFMessage.h>

#include <functional>
#include <map>
#include <memory>

#include "kestrel_slam/MapperState.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/offline/arrival_order.h"
#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/recording/bag/bag_flight_writer.h"
#include "kestrel_slam/ros/filter/pose_filter_node.h"
#include "kestrel_slam/ros/mapper/mapper_node.h"
#include "kestrel_slam/ros/projector/scan_projector_node.h"
#include "kestrel_slam/simulation/flight_plan.h"
#include "kestrel_slam/simulation/flight_simulator.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

constexpr double kFlown = 8.0;     // s of the flight
constexpr double kPatience = 5.0;  // s
constexpr std::uint32_t kQueue = 1000;

/// The messages of a bag by their stamp.
template <typename Message>
class Messages {
 public:
  Messages(const rosbag::Bag& bag, const std::string& topic) {
    rosbag::View view(bag, rosbag::TopicQuery(topic));
    for (const rosbag::MessageInstance& instance : view) {
      const auto message = instance.instantiate<Message>();
      if (message) by_stamp_[toSeconds(message->header.stamp)] = message;
    }
  }
  const boost::shared_ptr<Message>& at(double stamp) const { return by_stamp_.at(stamp); }

 private:
  std::map<double, boost::shared_ptr<Message>> by_stamp_;
};

/// Projector, mapper and pose filter with the parameters of mav.launch, in this process.
class Nodes {
 public:
  explicit Nodes(ros::NodeHandle nh)
      : projector_(nh, ros::NodeHandle("projector")),
        mapper_(nh, ros::NodeHandle("mapper")),
        filter_(nh, ros::NodeHandle("pose_filter")) {}

 private:
  ScanProjectorNode projector_;
  MapperNode mapper_;
  PoseFilterNode filter_;
};

class PipelineParity : public ::testing::Test {
 protected:
  PipelineParity() {
    Place laboratory = place("laboratory");
    laboratory.plan = randomPlan(laboratory, kFlown, 1);
    const auto motion = flyQuadrotor(laboratory.plan, laboratory.quadrotor, 1);
    const World world(laboratory.parts);
    VehicleModel vehicle = quadrotorWith("utm30lx");
    vehicle.laser->rate_hz = 10.0;
    FlightSimulator flight(world, *motion, vehicle, 1);
    writeFlightBag(path_, flight, vehicle);
  }

  OfflineRun runRecorded() const {
    const auto recording = openRecording(path_);
    RunOptions options;
    options.use_filter = true;
    return runOffline(*recording, SlamConfig(), options);
  }

  /// Spins until `done`; false where it takes too long.
  static bool spinUntil(const std::function<bool()>& done) {
    const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(kPatience);
    while (!done()) {
      ros::spinOnce();
      if (ros::WallTime::now() > end) return false;
      ros::WallDuration(1e-4).sleep();
    }
    return true;
  }

  /// Gives the messages one by one to the nodes, each after the one before has had its effect.
  Trajectory runLive() {
    rosbag::Bag bag(path_);
    const Messages<sensor_msgs::LaserScan> scans(bag, "/scan");
    const Messages<sensor_msgs::Imu> imu(bag, "/imu/data");
    const Messages<sensor_msgs::Range> heights(bag, "/height");
    connect(bag);
    const auto recording = openRecording(path_);
    ArrivalOrder order(*recording, true);
    ArrivingMessage next;
    while (order.next(next) && !HasFailure()) {
      if (const auto* scan = std::get_if<RecordedScan>(&next.message)) {
        scan_publisher_.publish(scans.at(scan->scan.stamp));
        settle();
      } else if (const auto* sample = std::get_if<ImuSample>(&next.message)) {
        imu_publisher_.publish(imu.at(sample->stamp));
        settle();
      } else {
        height_publisher_.publish(heights.at(std::get<HeightSample>(next.message).stamp));
        settle();
      }
    }
    return trajectory_;
  }

  void connect(const rosbag::Bag& bag) {
    scan_publisher_ = nh_.advertise<sensor_msgs::LaserScan>("scan", kQueue);
    imu_publisher_ = nh_.advertise<sensor_msgs::Imu>("imu/data", kQueue);
    height_publisher_ = nh_.advertise<sensor_msgs::Range>("height", kQueue);
    tf_publisher_ = nh_.advertise<tf2_msgs::TFMessage>("/tf_static", 1, true);
    rosbag::View view(bag, rosbag::TopicQuery("/tf_static"));
    for (const auto& instance : view) {
      tf_publisher_.publish(instance.instantiate<tf2_msgs::TFMessage>());
    }
    nodes_ = std::make_unique<Nodes>(nh_);
    const boost::function<void(const kestrel_slam::MapperState&)> on_state =
        [this](const kestrel_slam::MapperState& state) {
          trajectory_.push_back(
              {toSeconds(state.header.stamp), Pose2(state.x, state.y, state.yaw)});
        };
    state_subscriber_ = nh_.subscribe<kestrel_slam::MapperState>("mapper_state", kQueue, on_state);
    ASSERT_TRUE(spinUntil([&] {
      return scan_publisher_.getNumSubscribers() > 0 && imu_publisher_.getNumSubscribers() > 1 &&
             height_publisher_.getNumSubscribers() > 1 && state_subscriber_.getNumPublishers() > 0;
    }));
    settle();
    settle();
  }

  /// Until nothing has happened for a while: the mapper matches on a thread of its own.
  void settle() {
    constexpr int kQuiet = 12;
    const double kStep = 5e-4;  // s
    std::size_t poses = trajectory_.size();
    for (int quiet = 0; quiet < kQuiet; ++quiet) {
      ros::spinOnce();
      if (trajectory_.size() != poses) quiet = 0;
      poses = trajectory_.size();
      ros::WallDuration(kStep).sleep();
    }
  }

  TemporaryFolder folder_;
  std::string path_ = folder_.file("flight.bag");
  ros::NodeHandle nh_;
  ros::Publisher scan_publisher_, imu_publisher_, height_publisher_, tf_publisher_;
  ros::Subscriber state_subscriber_;
  std::unique_ptr<Nodes> nodes_;
  Trajectory trajectory_;
};

TEST_F(PipelineParity, NodesAndOfflineRunGiveTheSameTrajectory) {
  const OfflineRun offline = runRecorded();
  ASSERT_GT(offline.trajectory.size(), 60U);
  ASSERT_TRUE(offline.filter);
  EXPECT_GT(offline.filter->of(FilterSensor::kPose).accepted, 40U) << "the filter takes part";
  const Trajectory live = runLive();
  ASSERT_EQ(live.size(), offline.trajectory.size());
  for (std::size_t i = 0; i < live.size(); ++i) {
    EXPECT_EQ(live[i].stamp, offline.trajectory[i].stamp) << i;
    EXPECT_EQ(live[i].pose, offline.trajectory[i].pose)
        << i << ": " << (live[i].pose.inverse() * offline.trajectory[i].pose).distance() << " m";
  }
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "pipeline_parity_test");
  return RUN_ALL_TESTS();
}
