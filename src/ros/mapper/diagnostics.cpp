// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/diagnostics.h"

#include <ros/console.h>

#include <exception>
#include <utility>

#include "kestrel_slam/ros/common/wall_throttle.h"

namespace kestrel {
namespace {

using diagnostic_msgs::DiagnosticStatus;

constexpr double kPeriod = 1.0;         // s
constexpr double kSilentAfter = 2.0;    // s without a scan
constexpr double kSilenceEvery = 15.0;  // s between two warnings
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
                         const std::string& scan_topic, ScanStatistics& statistics,
                         std::function<unsigned()> publisher_count,
                         std::function<MapSize()> map_size)
    : scan_topic_(scan_topic),
      statistics_(statistics),
      publisher_count_(std::move(publisher_count)),
      map_size_(std::move(map_size)),
      updater_(nh, private_nh,
               private_nh.getNamespace()) {  // a nodelet needs its own name
  updater_.setHardwareID(scan_topic);
  updater_.add("Scans", [this](Status& status) { fillScans(status); });
  updater_.add("Match", [this](Status& status) { fillMatch(status); });
  updater_.add("Map", [this](Status& status) { fillMap(status); });
  timer_ = nh.createWallTimer(ros::WallDuration(kPeriod),
                              [this](const ros::WallTimerEvent&) { update(); });
}

void Diagnostics::update() {
  try {
    report_ = statistics_.take();
    warnOfSilence();
    updater_.force_update();
  } catch (const std::exception& error) {
    KESTREL_ERROR_THROTTLE(kSilenceEvery, "No diagnostics: %s", error.what());
  }
}

/// The reason why there are no scans; empty if scans arrive.
std::string Diagnostics::silence() const {
  const double waited = (ros::WallTime::now() - started_).toSec();
  const double seconds = report_.silence_s ? *report_.silence_s : waited;
  if (seconds < kSilentAfter) return "";
  const unsigned publishers = publisher_count_();
  return "no scan on " + scan_topic_ + " for " + std::to_string(static_cast<int>(seconds)) +
         " s: " +
         (publishers == 0 ? "nobody publishes it (wrong scan_topic?)"
                          : std::to_string(publishers) + " publisher(s), but no message");
}

void Diagnostics::warnOfSilence() const {
  const std::string text = silence();
  if (!text.empty()) KESTREL_WARN_THROTTLE(kSilenceEvery, "There is %s", text.c_str());
}

void Diagnostics::fillScans(Status& status) const {
  status.summary(DiagnosticStatus::OK, "scans are matched");
  if (report_.paused) status.summary(DiagnosticStatus::OK, "paused");
  if (report_.dropped_lately > 0 && !report_.paused) {
    status.summaryf(DiagnosticStatus::WARN, "%zu scans dropped recently, the last one: %s",
                    report_.dropped_lately, report_.last_reason.c_str());
  }
  if (!report_.waiting_for.empty()) {
    status.summary(DiagnosticStatus::ERROR, report_.waiting_for);
  }
  const std::string text = silence();
  if (!text.empty()) status.summary(DiagnosticStatus::WARN, text);
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
  if (!report_.state) {
    status.summary(DiagnosticStatus::OK, "no scan has been matched yet");
    return;
  }
  status.summary(levelOf(report_), summaryOf(report_));
  status.add("state", toString(*report_.state));
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
  status.add("memory (MB)", static_cast<double>(size.memory_bytes) / kBytesPerMegabyte);
}

}  // namespace kestrel
