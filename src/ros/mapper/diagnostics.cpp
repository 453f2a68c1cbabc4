// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/diagnostics.h"

#include <ros/console.h>

#include <exception>
#include <utility>

#include "kestrel_slam/ros/common/wall_throttle.h"

namespace kestrel {
namespace {

using diagnostic_msgs::DiagnosticStatus;

constexpr double kPeriod = 1.0;          // s
constexpr double kLookEvery = 0.2;       // s; whether scans still come
constexpr double kComplainEvery = 15.0;  // s
constexpr double kBytesPerMegabyte = 1e6;

unsigned char levelOf(const ScanReport& report) {
  if (report.state == MatchState::kLost) return DiagnosticStatus::ERROR;
  return report.state == MatchState::kOk ? DiagnosticStatus::OK : DiagnosticStatus::WARN;
}

std::string summaryOf(const ScanReport& report) {
  if (report.state == MatchState::kLost) return "lost: the scan fits nowhere near the last pose";
  if (report.state == MatchState::kOk) return "ok";
  return report.degenerate ? "degraded: the scan does not constrain every direction"
                           : "degraded: the scan fits poorly";
}

}  // namespace

Diagnostics::Diagnostics(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh,
                         const NeededTopic& scan_topic, const std::string& topic_parameter,
                         ScanStatistics& statistics, std::function<unsigned()> publisher_count,
                         std::function<MapSize()> map_size, std::function<bool()> is_localizing)
    : scan_topic_(scan_topic.name),
      statistics_(statistics),
      publisher_count_(std::move(publisher_count)),
      map_size_(std::move(map_size)),
      is_localizing_(std::move(is_localizing)),
      watch_("scan", {scan_topic}, topic_parameter),
      updater_(nh, private_nh,
               private_nh.getNamespace()) {  // a nodelet needs its own name
  updater_.setHardwareID(scan_topic_);
  updater_.add("Scans", [this](Status& status) { fillScans(status); });
  updater_.add("Match", [this](Status& status) { fillMatch(status); });
  updater_.add("Map", [this](Status& status) { fillMap(status); });
  timer_ = nh.createWallTimer(ros::WallDuration(kLookEvery),
                              [this](const ros::WallTimerEvent&) { look(); });
}

/// Every second, and as soon as scans stay away or come again.
void Diagnostics::look() {
  const ros::WallTime now = ros::WallTime::now();
  if ((now - updated_).toSec() < kPeriod && statistics_.stale() == report_.stale) return;
  updated_ = now;
  update();
}

void Diagnostics::update() {
  try {
    report_ = statistics_.take();
    silence_ = checkSilence();
    updater_.force_update();
  } catch (const std::exception& error) {
    KESTREL_ERROR_THROTTLE(kComplainEvery, "No diagnostics: %s", error.what());
  }
}

std::string Diagnostics::checkSilence() {
  const double waited = (ros::WallTime::now() - started_).toSec();
  const std::string reason = watch_.check(report_.silence_s.value_or(waited), publisher_count_());
  return reason.empty() && report_.stale && !report_.paused
             ? "no scan on " + scan_topic_ + " for 1 s"
             : reason;
}

void Diagnostics::fillScans(Status& status) const {
  status.summary(DiagnosticStatus::OK, "scans are matched");
  if (report_.paused) status.summary(DiagnosticStatus::OK, "paused");
  if (report_.dropped_lately > 0 && !report_.paused) {
    status.summaryf(DiagnosticStatus::WARN, "%zu scans dropped recently, the last one: %s",
                    report_.dropped_lately, report_.last_reason.c_str());
  }
  if (!silence_.empty()) status.summary(DiagnosticStatus::WARN, silence_);
  // The transform is still missing when the scans stay away.
  if (!report_.waiting_for.empty()) {
    status.summary(DiagnosticStatus::ERROR, report_.waiting_for);
  }
  status.add("topic", scan_topic_);
  status.add("received", report_.received);
  status.add("used", report_.used);
  for (const auto& [reason, count] : report_.dropped) status.add("dropped: " + reason, count);
  status.add("seconds since the last scan",
             report_.silence_s ? std::to_string(*report_.silence_s) : "never");
  status.add("ms per scan, mean", report_.mean_ms);
  status.add("ms per scan, max", report_.max_ms);
}

void Diagnostics::fillMatch(Status& status) const {
  status.add("mode", is_localizing_() ? "localization" : "mapping");
  if (!report_.state) {
    status.summary(DiagnosticStatus::OK, "no scan has been matched yet");
    return;
  }
  status.summary(levelOf(report_), summaryOf(report_));
  status.add("state", toString(*report_.state));
  status.add("reason", report_.reason);
  status.add("stale", report_.stale ? "true" : "false");
  status.add("score", report_.score);
  status.add("degenerate", report_.degenerate);
}

void Diagnostics::fillMap(Status& status) const {
  const MapSize size = map_size_();
  status.summary(DiagnosticStatus::OK, "ok");
  if (report_.map_full) {
    status.summary(DiagnosticStatus::ERROR,
                   "full: the map does not grow any more; raise map_memory_limit_mb");
  }
  status.add("width (m)", size.width * size.resolution_m);
  status.add("height (m)", size.height * size.resolution_m);
  status.add("resolution (m)", size.resolution_m);
  if (size.loops) {
    status.add("loops closed", size.loops->closed);
    status.add("loops refused", size.loops->refused);
  }
  status.add("memory (MB)", static_cast<double>(size.memory_bytes) / kBytesPerMegabyte);
}

}  // namespace kestrel
