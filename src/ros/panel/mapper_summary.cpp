// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/panel/mapper_summary.h"

#include <cstdlib>

namespace kestrel {
namespace {

using diagnostic_msgs::DiagnosticStatus;

std::string valueOf(const DiagnosticStatus& status, const std::string& key) {
  for (const auto& entry : status.values) {
    if (entry.key == key) return entry.value;
  }
  return "";
}

double numberOf(const DiagnosticStatus& status, const std::string& key) {
  return std::atof(valueOf(status, key).c_str());
}

/// "12.3" for "12.345678".
std::string rounded(const std::string& number) { return number.substr(0, number.find('.') + 2); }

void takeScans(const DiagnosticStatus& status, MapperSummary& summary) {
  const std::string dropped = "dropped: ";
  summary.received = numberOf(status, "received");
  summary.used = numberOf(status, "used");
  summary.ms = numberOf(status, "ms per scan, mean");
  summary.dropped.clear();
  for (const auto& entry : status.values) {
    if (entry.key.compare(0, dropped.size(), dropped) != 0) continue;
    summary.dropped.emplace_back(entry.key.substr(dropped.size()), entry.value);
  }
  if (status.level != DiagnosticStatus::OK) summary.problem = status.message;
  if (status.message == "paused") summary.state = "paused";
}

void takeMatch(const DiagnosticStatus& status, MapperSummary& summary) {
  if (summary.state != "paused") summary.state = valueOf(status, "state");
  summary.reason = valueOf(status, "reason");
  if (summary.state != "paused" && valueOf(status, "stale") == "true") {
    summary.reason = "no scan arrives; the last one was " + summary.state;
    summary.state = "stale";
  }
  summary.mode = valueOf(status, "mode");
}

void takeMap(const DiagnosticStatus& status, MapperSummary& summary) {
  summary.map = rounded(valueOf(status, "width (m)")) + " m x " +
                rounded(valueOf(status, "height (m)")) + " m, " +
                rounded(valueOf(status, "memory (MB)")) + " MB";
  const std::string closed = valueOf(status, "loops closed");
  summary.loops =
      closed.empty() ? "" : closed + " closed, " + valueOf(status, "loops refused") + " refused";
  if (status.level != DiagnosticStatus::OK) summary.problem = status.message;
}

/// "/mapper: Scans" is ("/mapper", "Scans"). diagnostic_updater leaves out the slash or not.
std::pair<std::string, std::string> splitName(const std::string& name) {
  const std::size_t colon = name.find(": ");
  if (colon == std::string::npos) return {"", name};
  const std::string node = name.substr(0, colon);
  return {node.empty() || node[0] != '/' ? "/" + node : node, name.substr(colon + 2)};
}

/// The scan projector has an item "Scans" too; only the mapper has "Match".
std::string mapperIn(const diagnostic_msgs::DiagnosticArray& message) {
  for (const DiagnosticStatus& status : message.status) {
    const auto [node, item] = splitName(status.name);
    if (item == "Match") return node;
  }
  return "";
}

std::string namespaceOf(const std::string& node) { return node.substr(0, node.rfind('/') + 1); }

/// The tracker is another node, with an item "Tracker"; the one beside the mapper counts.
void takeTracks(const diagnostic_msgs::DiagnosticArray& message, const std::string& mapper,
                MapperSummary& summary) {
  for (const DiagnosticStatus& status : message.status) {
    const auto [node, item] = splitName(status.name);
    if (item != "Tracker" || (!mapper.empty() && namespaceOf(node) != namespaceOf(mapper)))
      continue;
    summary.tracks = valueOf(status, "moving objects");
  }
}

}  // namespace

bool takeOver(const diagnostic_msgs::DiagnosticArray& message, const std::string& node,
              MapperSummary& summary) {
  takeTracks(message, node.empty() ? summary.node : node, summary);
  const std::string mapper = mapperIn(message);
  if (mapper.empty() || (!node.empty() && mapper != node)) return false;
  summary.node = mapper;
  summary.problem.clear();
  summary.state.clear();
  for (const DiagnosticStatus& status : message.status) {
    const auto [owner, item] = splitName(status.name);
    if (owner != mapper) continue;
    if (item == "Scans") takeScans(status, summary);
    if (item == "Match") takeMatch(status, summary);
    if (item == "Map") takeMap(status, summary);
  }
  return true;
}

}  // namespace kestrel
