// SPDX-License-Identifier: BSD-3-Clause
// Runs one recorded flight through the three nodes in one process and through the offline run. The
// trajectories must be bit-identical if the messages arrive in the same order.

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
#include <vector>

#include "kestrel_slam/MapperState.h"
#include "kestrel_slam/messages/pipeline_messages.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/offline/arrival_order.h"
#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/recording/bag/bag_flight_writer.h"
#include "kestrel_slam/ros/filter/pose_filter_node.h"
#include "kestrel_slam/ros/mapper/mapper_node.h"
#include "kestrel_slam/ros/projector/scan_projector_node.h"
#include "kestrel_slam/simulation/flight_plan.h"
#include "kestrel_slam/simulation/flight_simulator.h"
#include "patience.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

constexpr double kFlown = 8.0;  // duration of the flight, s
constexpr std::uint32_t kQueue = 1000;

/// The messages of a bag, by stamp.
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

  OfflineRun runRecorded(std::vector<FilteredMotion>& motions) const {
    const auto recording = openRecording(path_);
    RunOptions options;
    options.use_filter = true;
    options.filter_observer = [&](const FilterOutput& output) {
      motions.push_back(motionOf(output));
    };
    return runOffline(*recording, SlamConfig(), options);
  }

  /// Spins until `done` is true. Returns false after a timeout.
  static bool spinUntil(const std::function<bool()>& done) {
    Patience patience;
    while (!done()) {
      ros::spinOnce();
      if (patience.isOver()) return false;
      ros::WallDuration(1e-4).sleep();
    }
    return true;
  }

  /// Publishes the messages one by one. Each message is published after the nodes have processed
  /// the previous one.
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
    const boost::function<void(const kestrel_slam::FilteredMotion&)> on_motion =
        [this](const kestrel_slam::FilteredMotion& motion) {
          motions_.push_back(fromMessage(motion));
        };
    motion_subscriber_ =
        nh_.subscribe<kestrel_slam::FilteredMotion>("filtered_motion", kQueue, on_motion);
    const boost::function<void(const kestrel_slam::PlanarScanConstPtr&)> on_scan =
        [this](const kestrel_slam::PlanarScanConstPtr&) { ++planar_scans_; };
    const boost::function<void(const nav_msgs::OdometryConstPtr&)> on_odometry =
        [this](const nav_msgs::OdometryConstPtr&) { ++matched_; };
    odometry_subscriber_ = nh_.subscribe<nav_msgs::Odometry>("odom/slam", kQueue, on_odometry);
    scan_subscriber_ = nh_.subscribe<kestrel_slam::PlanarScan>("planar_scan", kQueue, on_scan);
    ASSERT_TRUE(spinUntil([&] {
      return scan_publisher_.getNumSubscribers() > 0 && imu_publisher_.getNumSubscribers() > 0 &&
             height_publisher_.getNumSubscribers() > 0 && state_subscriber_.getNumPublishers() > 0;
    }));
    Patience mounting(0.5);
    spinUntil([&] { return mounting.isOver(); });  // wait until tf reaches the nodes
  }

  /// Waits until the nodes have processed the previous message. The mapper matches on its own
  /// thread. So it waits until every planar scan has given an odometry message, which the mapper
  /// publishes last.
  void settle() {
    constexpr int kRounds = 4;  // planar scan -> mapper -> filter -> projector
    Patience patience;
    for (int round = 0; round < kRounds; ++round) {
      ros::spinOnce();
      if (planar_scans_ == matched_) continue;
      round = 0;
      ASSERT_FALSE(patience.isOver()) << "a planar scan was not matched";
      ros::WallDuration(1e-4).sleep();
    }
  }

  TemporaryFolder folder_;
  std::string path_ = folder_.file("flight.bag");
  ros::NodeHandle nh_;
  ros::Publisher scan_publisher_, imu_publisher_, height_publisher_, tf_publisher_;
  ros::Subscriber state_subscriber_, motion_subscriber_, scan_subscriber_, odometry_subscriber_;
  std::size_t planar_scans_ = 0, matched_ = 0;
  std::unique_ptr<Nodes> nodes_;
  Trajectory trajectory_;
  std::vector<FilteredMotion> motions_;
};

TEST_F(PipelineParity, NodesAndOfflineRunGiveTheSameTrajectory) {
  std::vector<FilteredMotion> motions;
  const OfflineRun offline = runRecorded(motions);
  ASSERT_GT(offline.trajectory.size(), 60U);
  ASSERT_TRUE(offline.filter);
  EXPECT_GT(offline.filter->of(FilterSensor::kPose).accepted, 40U)
      << "the filter must use the poses";
  const Trajectory live = runLive();
  ASSERT_FALSE(motions_.empty());
  EXPECT_EQ(motions_.front().stamp, motions.front().stamp);
  EXPECT_EQ(motions_.back().stamp, motions.back().stamp);
  ASSERT_EQ(motions_.size(), motions.size());
  for (std::size_t i = 0; i < motions.size(); ++i) {
    ASSERT_EQ(motions_[i].stamp, motions[i].stamp) << i;
    ASSERT_EQ(motions_[i].odom_T_base, motions[i].odom_T_base)
        << "state " << i << " at " << motions[i].stamp;
  }
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
