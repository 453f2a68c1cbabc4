// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/projector/height_input.h"

#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/ros/common/guarded.h"
#include "kestrel_slam/ros/common/wall_throttle.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kQueue = 20;
constexpr double kComplainEvery = 30.0;  // s

}  // namespace

HeightInput::HeightInput(ros::NodeHandle nh, const ProjectorNodeConfig& config,
                         const Mountings& mountings, ProjectionStage& projection)
    : stabilized_frame_(config.base_stabilized_frame),
      footprint_frame_(config.base_footprint_frame),
      mounting_(mountings, config.height_sensor_z),
      projection_(projection) {
  if (config.height_topic.empty() || config.hasMirror()) return;
  subscriber_ = subscribeGuarded<sensor_msgs::Range>(
      nh, config.height_topic, kQueue,
      [this](const sensor_msgs::RangeConstPtr& message) { onRange(message); });
}

/// A range finder on the vehicle measures along its tilted axis. A height in a level frame is
/// vertical.
void HeightInput::onRange(const sensor_msgs::RangeConstPtr& message) {
  const std::string frame = withoutSlash(message->header.frame_id);
  const bool is_upright = frame == stabilized_frame_ || frame == footprint_frame_;
  const std::optional<double> sensor_z = is_upright ? std::optional(0.0) : mounting_.sensorZ(frame);
  if (!sensor_z) {
    KESTREL_WARN_THROTTLE(kComplainEvery, "Height: %s.", mounting_.error().c_str());
    return;
  }
  is_unusable_ = !projection_.addRange(toHeightSample(*message, *sensor_z), is_upright);
}

void HeightInput::describe(double time, ProjectorReport& report) const {
  const HeightTracker& heights = projection_.heights();
  report.height_counts = heights.counts();
  report.height_m = heights.height(time);
  report.height_source = toString(heights.source(time));
  if (!mounting_.error().empty()) {
    report.height_error = mounting_.error();
  } else if (is_unusable_) {
    report.height_error =
        "the last reading on " + subscriber_.getTopic() +
        " is not used (see the counts for the reason); it must be a finite distance to the "
        "floor";
  }
}

}  // namespace kestrel
