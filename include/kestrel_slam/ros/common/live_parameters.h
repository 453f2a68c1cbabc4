// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/ConfigDescription.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/node_handle.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {

/// Parameters that may change while a node runs, for the clients of dynamic_reconfigure
/// (rqt_reconfigure, dynparam, the Python client). Their description comes from the parameter
/// table, so that no default is written twice.
///
/// A request with a value that is not allowed changes nothing: the call fails, and its error says
/// why.
class LiveParameters {
 public:
  /// Changes the rows of `table` with `live`. `on_change`: called after new values are in their
  /// places; if it throws std::invalid_argument, the old values come back. Both run on the thread
  /// of `private_nh`.
  LiveParameters(ros::NodeHandle private_nh, std::vector<Parameter> table,
                 std::function<void()> on_change);

 private:
  using Config = dynamic_reconfigure::Config;
  using Texts = std::vector<std::pair<std::string, std::string>>;  ///< names and values

  bool set(dynamic_reconfigure::Reconfigure::Request& request,
           dynamic_reconfigure::Reconfigure::Response& response);
  void change(const Texts& wanted);
  const Parameter& liveRow(const std::string& name) const;
  Texts values() const;
  void store(const Parameter& row);

  ros::NodeHandle private_nh_;
  std::vector<Parameter> table_;
  std::function<void()> on_change_;
  ros::Publisher description_publisher_, update_publisher_;
  ros::ServiceServer server_;
};

/// What clients of dynamic_reconfigure show: the rows of `table` with `live`, with their limits.
dynamic_reconfigure::ConfigDescription descriptionOf(const std::vector<Parameter>& table);

}  // namespace kestrel
