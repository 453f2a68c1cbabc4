// SPDX-License-Identifier: BSD-3-Clause
#include "timeline.h"

#include <algorithm>
#include <utility>

namespace kestrel {
namespace {

constexpr std::size_t kMaxWaiting = 1000;  // more measurements cannot come from a sensor

/// An order that does not depend on the order of arrival.
bool isBefore(const Measurement& a, const Measurement& b) {
  return a.stamp != b.stamp ? a.stamp < b.stamp : a.sensor < b.sensor;
}

/// Returns false if there is already a measurement of the same sensor with this stamp.
bool insertSorted(const Measurement& measurement, std::vector<Measurement>& list) {
  const auto place = std::lower_bound(list.begin(), list.end(), measurement, isBefore);
  if (place != list.end() && !isBefore(measurement, *place) && !measurement.bypass_gate)
    return false;
  list.insert(place, measurement);
  return true;
}

}  // namespace

Timeline::Timeline(const PoseFilterConfig& config, Judge judge)
    : config_(config), judge_(std::move(judge)) {}

void Timeline::clear() {
  nodes_.clear();
  waiting_.clear();
}

void Timeline::begin(const FilterState& state, const Eigen::Isometry3d& odom_T_base) {
  nodes_.clear();
  Node node;
  node.state = state;
  node.odom_T_base = odom_T_base;
  nodes_.push_back(std::move(node));
  while (!waiting_.empty() && waiting_.front().stamp <= state.stamp) {
    judge_(waiting_.front(), {"before the start"});
    waiting_.erase(waiting_.begin());
  }
}

void Timeline::step(double stamp, const InertialInput& input, bool gap) {
  Node node;
  node.input = input;
  node.is_gap = gap;
  node.state.stamp = stamp;
  const auto is_due = [&](const Measurement& m) { return m.stamp <= stamp; };
  const auto due = std::find_if_not(waiting_.begin(), waiting_.end(), is_due);
  node.measurements.assign(waiting_.begin(), due);
  waiting_.erase(waiting_.begin(), due);
  compute(nodes_.back().state, node);
  nodes_.push_back(std::move(node));
  while (nodes_.size() > 2 && nodes_[1].state.stamp < stamp - config_.gate.history_s) {
    nodes_.pop_front();
  }
}

void Timeline::compute(const FilterState& before, Node& node) {
  const double stamp = node.state.stamp;
  FilterState state = before;
  if (node.is_gap) addGap(stamp - state.stamp, state);
  for (Measurement& measurement : node.measurements) {
    const double dt = measurement.stamp - state.stamp;
    if (dt > 0.0) propagate(node.input, dt, config_, state);
    const Verdict verdict = apply(measurement, config_, state);
    if (!measurement.counted) judge_(measurement, verdict);
    measurement.counted = true;
  }
  if (stamp > state.stamp) propagate(node.input, stamp - state.stamp, config_, state);
  state.stamp = stamp;  // removes rounding errors of the summed steps
  node.state = state;
}

std::string Timeline::insert(const Measurement& measurement) {
  if (nodes_.empty() || measurement.stamp > nodes_.back().state.stamp) {
    return keepForLater(measurement);
  }
  if (measurement.stamp <= nodes_.front().state.stamp) return "too old";
  const auto is_earlier = [](const Node& n, double t) { return n.state.stamp < t; };
  auto node = std::lower_bound(nodes_.begin(), nodes_.end(), measurement.stamp, is_earlier);
  if (!insertSorted(measurement, node->measurements)) return "repeated";
  for (; node != nodes_.end(); ++node) compute((node - 1)->state, *node);
  return "";
}

std::string Timeline::keepForLater(const Measurement& measurement) {
  if (!nodes_.empty() && measurement.stamp > nodes_.back().state.stamp + config_.gate.history_s) {
    return "from the future";
  }
  if (waiting_.size() >= kMaxWaiting) waiting_.erase(waiting_.begin());
  return insertSorted(measurement, waiting_) ? "" : "repeated";
}

const Timeline::Node* Timeline::lastNotAfter(double stamp) const {
  const auto is_later = [](double t, const Node& n) { return t < n.state.stamp; };
  const auto after = std::upper_bound(nodes_.begin(), nodes_.end(), stamp, is_later);
  return after == nodes_.begin() ? nullptr : &*(after - 1);
}

const Timeline::Node* Timeline::after(const Node& node) const {
  const auto is_later = [](double t, const Node& n) { return t < n.state.stamp; };
  const auto next = std::upper_bound(nodes_.begin(), nodes_.end(), node.state.stamp, is_later);
  return next == nodes_.end() ? nullptr : &*next;
}

}  // namespace kestrel
