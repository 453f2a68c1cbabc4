// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/projector/planar_scan_publisher.h"

#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/Range.h>

#include <boost/make_shared.hpp>

#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/messages/planar_scan_message.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kQueue = 10;

}  // namespace

PlanarScanPublisher::PlanarScanPublisher(ros::NodeHandle nh, const ProjectorNodeConfig& config)
    : frame_(config.base_stabilized_frame),
      view_increment_rad_(config.view_increment_rad),
      range_max_m_(config.slam.projector.beams.max_range_m) {
  scan_publisher_ = nh.advertise<kestrel_slam::PlanarScan>("planar_scan", kQueue);
  view_publisher_ = nh.advertise<sensor_msgs::LaserScan>("planar_scan_view", kQueue);
  if (config.hasMirror() && !config.height_topic.empty()) {
    height_publisher_ = nh.advertise<sensor_msgs::Range>(config.height_topic, kQueue);
  }
  floor_height_publisher_ = nh.advertise<sensor_msgs::Range>("floor_height", kQueue);
}

void PlanarScanPublisher::publish(const ros::Time& stamp, const PlanarScan& scan) {
  // A pointer to const is passed to a mapper in the same process without a copy.
  const kestrel_slam::PlanarScanConstPtr message = toPlanarScanMessage(scan, frame_, stamp);
  scan_publisher_.publish(message);
  if (view_publisher_.getNumSubscribers() == 0) return;
  view_publisher_.publish(toLaserScanView(scan, frame_, stamp, view_increment_rad_, range_max_m_));
}

void PlanarScanPublisher::publishHeights(const ros::Time& stamp, const Projection& projection) {
  publishHeight(stamp, projection.mirror_height_m, height_publisher_);
  publishHeight(stamp, projection.floor_height_m, floor_height_publisher_);
}

void PlanarScanPublisher::publishHeight(const ros::Time& stamp,
                                        const std::optional<double>& height_m,
                                        ros::Publisher& publisher) {
  if (height_m && publisher) {
    publisher.publish(boost::make_shared<const sensor_msgs::Range>(
        toRangeMessage(stamp, frame_, *height_m, range_max_m_)));
  }
}

}  // namespace kestrel
