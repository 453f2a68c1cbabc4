// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/projector/projector_diagnostics.h"

#include <ros/console.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

using diagnostic_msgs::DiagnosticStatus;

constexpr double kPeriod = 1.0;       // s
constexpr double kSilentAfter = 2.0;  // s without a message
constexpr double kWarnEvery = 15.0;   // s

}  // namespace

ProjectorDiagnostics::ProjectorDiagnostics(const ros::NodeHandle& nh,
                                           const ros::NodeHandle& private_nh,
                                           const std::string& hardware_id,
                                           std::function<ProjectorReport()> report,
                                           std::function<void()> on_reported)
    : take_report_(std::move(report)),
      on_reported_(std::move(on_reported)),
      updater_(nh, private_nh, private_nh.getNamespace()) {  // a nodelet needs its own name
  updater_.setHardwareID(hardware_id);
  updater_.add("Scans", [this](Status& status) { fillScans(status); });
  updater_.add("Attitude", [this](Status& status) { fillAttitude(status); });
  updater_.add("Height", [this](Status& status) { fillHeight(status); });
  timer_ = nh.createSteadyTimer(ros::WallDuration(kPeriod),
                                [this](const ros::SteadyTimerEvent&) { update(); });
}

void ProjectorDiagnostics::update() {
  try {
    report_ = take_report_();
    warn();
    updater_.force_update();
    on_reported_();
  } catch (const std::exception& error) {
    ROS_ERROR_THROTTLE(kWarnEvery, "No diagnostics: %s", error.what());
  }
}

/// The reason why there are no scans; empty if scans arrive.
std::string ProjectorDiagnostics::silence() const {
  const double seconds =
      std::min(report_.statistics.since_received.seconds(), since_start_.seconds());
  if (seconds < kSilentAfter) return "";
  return "no scan on " + report_.topics + " for " + std::to_string(static_cast<int>(seconds)) +
         " s: " +
         (report_.publishers == 0
              ? "nobody publishes it (wrong scan_topics or cloud_topic?)"
              : std::to_string(report_.publishers) + " publisher(s), but no message");
}

void ProjectorDiagnostics::warn() const {
  const std::string text = silence();
  if (!text.empty()) ROS_WARN_THROTTLE(kWarnEvery, "There is %s", text.c_str());
  if (!report_.attitude_error.empty() && since_start_.seconds() > kSilentAfter) {
    ROS_WARN_THROTTLE(kWarnEvery, "Attitude: %s", report_.attitude_error.c_str());
  }
}

void ProjectorDiagnostics::fillScans(Status& status) const {
  const ProjectorStatistics& statistics = report_.statistics;
  status.summary(DiagnosticStatus::OK, "scans are projected");
  if (!statistics.warning.empty()) status.summary(DiagnosticStatus::WARN, statistics.warning);
  if (statistics.dropped_lately > 0) {
    status.summaryf(DiagnosticStatus::WARN, "%zu scans dropped recently, the last one: %s",
                    statistics.dropped_lately, statistics.last_drop.c_str());
  }
  const std::string text = silence();
  if (!text.empty()) status.summary(DiagnosticStatus::WARN, text);
  if (!report_.waiting_for.empty()) status.summary(DiagnosticStatus::ERROR, report_.waiting_for);
  status.add("topics", report_.topics);
  status.add("received", statistics.received);
  status.add("projected", statistics.projected);
  status.add("projected by the filter", statistics.projected_filtered);
  status.add("projected without attitude", statistics.projected_level);
  for (const auto& [reason, count] : statistics.dropped) status.add("dropped: " + reason, count);
  const BeamCounts& beams = statistics.beams;
  const std::pair<const char*, std::size_t> kinds[] = {
      {"hits", beams.hits},     {"without a return", beams.clears}, {"invalid", beams.invalid},
      {"masked", beams.masked}, {"too close", beams.too_close},     {"mixed", beams.mixed},
      {"floor", beams.floor},   {"ceiling", beams.ceiling},         {"outside", beams.outside}};
  for (const auto& [kind, count] : kinds) status.add(std::string("beams: ") + kind, count);
}

void ProjectorDiagnostics::fillAttitude(Status& status) const {
  status.summary(DiagnosticStatus::OK, "ok");
  if (!report_.attitude_error.empty()) {
    status.summary(DiagnosticStatus::ERROR, report_.attitude_error);
  }
  status.add("source", report_.attitude_hint);
  if (report_.tilt_rad) status.add("tilt (deg)", radToDeg(*report_.tilt_rad));
  if (report_.imu) fillImu(status);
}

void ProjectorDiagnostics::fillImu(Status& status) const {
  const ImuStatus& imu = *report_.imu;
  status.add("topic", report_.imu_topic);
  status.add("publishers", report_.imu_publishers);
  status.add("health", toString(imu.health));
  status.add("received", imu.received);
  status.add("used", imu.used);
  for (const auto& [reason, count] : imu.rejected) status.add("rejected: " + reason, count);
  status.add("from", imu.estimated ? "gyro and accelerometer" : "orientation");
}

void ProjectorDiagnostics::fillHeight(Status& status) const {
  status.summary(DiagnosticStatus::OK,
                 report_.height_m ? "ok" : "unknown; the floor is not removed");
  if (!report_.height_error.empty()) status.summary(DiagnosticStatus::WARN, report_.height_error);
  if (report_.height_m) status.add("height (m)", *report_.height_m);
  status.add("source", report_.height_source);
  for (const auto& [kind, count] : report_.height_counts) status.add(kind, count);
}

}  // namespace kestrel
