// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/projector/height_input.h"

#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/recording/bag/bag_imu.h"
#include "kestrel_slam/recording/bag/bag_transforms.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kQueue = 20, kFilterQueue = 400;

HeightConfig heightConfigOf(const ProjectorNodeConfig& config) {
  HeightConfig height;
  height.fixed_m = config.slam.projector.height_m;
  return height;
}

}  // namespace

HeightInput::HeightInput(ros::NodeHandle nh, const ProjectorNodeConfig& config,
                         const Mountings& mountings, const AttitudeBuffer& attitude)
    : stabilized_frame_(config.base_stabilized_frame),
      footprint_frame_(config.base_footprint_frame),
      mountings_(mountings),
      attitude_(attitude),
      tracker_(heightConfigOf(config)) {
  if (!config.filter_height_topic.empty()) {
    filter_subscriber_ =
        nh.subscribe(config.filter_height_topic, kFilterQueue, &HeightInput::onFiltered, this,
                     ros::TransportHints().tcpNoDelay());
  }
  if (config.height_topic.empty() || config.hasMirror()) return;
  subscriber_ = nh.subscribe(config.height_topic, kQueue, &HeightInput::onRange, this,
                             ros::TransportHints().tcpNoDelay());
}

void HeightInput::onFiltered(const sensor_msgs::RangeConstPtr& message) {
  const HeightSample sample = toHeightSample(*message, 0.0);
  newest_ = sample.stamp;
  tracker_.addFiltered(sample);
}

/// A sensor on the vehicle measures along its slanted axis; a height in a level frame is upright.
void HeightInput::onRange(const sensor_msgs::RangeConstPtr& message) {
  const std::string frame = withoutSlash(message->header.frame_id);
  const bool is_upright = frame == stabilized_frame_ || frame == footprint_frame_;
  double sensor_z = 0.0;
  if (!is_upright) {
    const std::optional<Eigen::Isometry3d> base_T_sensor = mountings_.lookup(frame);
    if (base_T_sensor) sensor_z = base_T_sensor->translation().z();
  }
  const HeightSample sample = toHeightSample(*message, sensor_z);
  newest_ = sample.stamp;
  is_unusable_ = !tracker_.addRange(sample, is_upright ? nullptr : &attitude_);
}

void HeightInput::add(const Projection& projection) {
  newest_ = projection.scan.stamp;
  tracker_.addProjection(newest_, projection);
}

std::optional<double> HeightInput::height(double time) const { return tracker_.height(time); }

void HeightInput::describe(ProjectorReport& report) const {
  report.height_counts = tracker_.counts();
  report.height_m = tracker_.height(newest_);
  report.height_source = toString(tracker_.source(newest_));
  if (is_unusable_) {
    report.height_error = "the last reading on " + subscriber_.getTopic() +
                          " is not used (the counts say why); it must be a finite distance to the "
                          "floor";
  }
}

}  // namespace kestrel
