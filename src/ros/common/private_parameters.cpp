// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/private_parameters.h"

#include <ros/console.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <variant>

namespace kestrel {
namespace {

/// Of diagnostic_updater, which reads it from the same namespace.
constexpr char kDiagnosticPeriod[] = "diagnostic_period";

/// The shorter of the two decimal forms that give the same number when they are read.
std::string numberText(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.15g", value);
  if (std::strtod(text, nullptr) != value) std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string textOf(const std::string& name, XmlRpc::XmlRpcValue& value) {
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeBoolean:
      return static_cast<bool>(value) ? "true" : "false";
    case XmlRpc::XmlRpcValue::TypeInt:
      return std::to_string(static_cast<int>(value));
    case XmlRpc::XmlRpcValue::TypeDouble:
      return numberText(static_cast<double>(value));
    case XmlRpc::XmlRpcValue::TypeString:
      return static_cast<std::string>(value);
    default:
      throw std::invalid_argument(name + ": must be a single value, not a list or a dictionary");
  }
}

/// A list may stand where a text does that holds several items.
std::string textOf(const Parameter& parameter, XmlRpc::XmlRpcValue& value) {
  const bool joins =
      std::holds_alternative<std::string*>(parameter.value) && parameter.choices.empty();
  if (!joins || value.getType() != XmlRpc::XmlRpcValue::TypeArray) {
    return textOf(parameter.name, value);
  }
  std::string joined;
  for (int i = 0; i < value.size(); ++i) {
    joined += (i == 0 ? "" : ",") + textOf(parameter.name, value[i]);
  }
  return joined;
}

/// The names in the private namespace, without it.
std::vector<std::string> privateNames(const ros::NodeHandle& private_nh) {
  const std::string prefix = private_nh.getNamespace() + "/";
  std::vector<std::string> all, names;
  private_nh.getParamNames(all);
  for (const std::string& name : all) {
    if (name.compare(0, prefix.size(), prefix) == 0) names.push_back(name.substr(prefix.size()));
  }
  std::sort(names.begin(), names.end());
  return names;
}

void reportUnused(const ros::NodeHandle& private_nh, const std::vector<Parameter>& parameters,
                  const std::map<std::string, std::string>& unneeded) {
  std::vector<std::string> valid;
  for (const Parameter& parameter : parameters) valid.push_back(parameter.name);
  for (const std::string& name : privateNames(private_nh)) {
    if (name == kDiagnosticPeriod) continue;
    if (std::find(valid.begin(), valid.end(), name) != valid.end()) continue;
    const auto reason = unneeded.find(name);
    if (reason != unneeded.end()) {
      ROS_INFO("The parameter ~%s has no effect: %s.", name.c_str(), reason->second.c_str());
    } else {
      ROS_WARN("Unknown parameter ~%s; did you mean ~%s?", name.c_str(),
               nearestName(name, valid).c_str());
    }
  }
}

}  // namespace

void readPrivateParameters(const ros::NodeHandle& private_nh,
                           const std::vector<Parameter>& parameters,
                           const std::map<std::string, std::string>& unneeded) {
  reportUnused(private_nh, parameters, unneeded);
  for (const Parameter& parameter : parameters) {
    XmlRpc::XmlRpcValue value;
    if (private_nh.getParam(parameter.name, value)) setValue(parameter, textOf(parameter, value));
  }
}

void requireName(const std::string& parameter, const std::string& value) {
  if (value.empty()) throw std::invalid_argument(parameter + " = '': must not be empty");
}

void requireDistinct(const std::string& parameter, const std::string& frame,
                     const std::string& other) {
  if (frame != other) return;
  throw std::invalid_argument(parameter + " = " + frame +
                              ": another frame has this name too, one must change");
}

}  // namespace kestrel
