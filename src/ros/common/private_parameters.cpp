// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/private_parameters.h"

#include <ros/console.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <stdexcept>
#include <variant>

namespace kestrel {
namespace {

/// A parameter that diagnostic_updater reads from the same namespace.
constexpr char kDiagnosticPeriod[] = "diagnostic_period";

/// The shortest of two decimal formats that gives the same number when it is read again.
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

/// A text parameter with several items can also be given as a list.
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

/// The parameter names in the private namespace, without the namespace.
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

std::vector<std::string> validNames(const std::vector<Parameter>& parameters) {
  std::vector<std::string> names;
  for (const Parameter& parameter : parameters) names.push_back(parameter.name);
  return names;
}

bool isKnown(const std::string& name, const std::vector<Parameter>& parameters) {
  const auto has_name = [&name](const Parameter& parameter) {
    const auto& old = parameter.old_names;
    return parameter.name == name || std::find(old.begin(), old.end(), name) != old.end();
  };
  return name == kDiagnosticPeriod || std::any_of(parameters.begin(), parameters.end(), has_name);
}

/// Logs one line for all parameters with the same reason.
void reportUnneeded(const std::vector<std::string>& names, const std::string& reason) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "~" : ", ~") + name;
  if (names.size() == 1) {
    ROS_INFO("The parameter %s has no effect: %s.", list.c_str(), reason.c_str());
  } else {
    ROS_INFO("The parameters %s have no effect: %s.", list.c_str(), reason.c_str());
  }
}

void reportUnused(const ros::NodeHandle& private_nh, const std::vector<Parameter>& parameters,
                  const UnneededParameters& unneeded) {
  std::map<std::string, std::vector<std::string>> names_by_reason;
  for (const std::string& name : privateNames(private_nh)) {
    if (isKnown(name, parameters)) continue;
    const auto reason = unneeded.find(name);
    if (reason != unneeded.end()) {
      names_by_reason[reason->second].push_back(name);
    } else {
      ROS_WARN("Unknown parameter ~%s; did you mean ~%s?", name.c_str(),
               nearestName(name, validNames(parameters)).c_str());
    }
  }
  for (const auto& [reason, names] : names_by_reason) reportUnneeded(names, reason);
}

/// The number that replaces a text outside of the limits of a parameter: the nearest limit, or the
/// default if the number has the wrong sign. Empty: the text must be refused.
std::optional<double> limitedNumber(const Parameter& parameter, const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  const bool is_number = !text.empty() && *end == '\0' && std::isfinite(value);
  if (!is_number || (value < 0.0 && parameter.min > 0.0)) return std::nullopt;
  const double limit = std::clamp(value, parameter.min, parameter.max);
  return limit == 0.0 ? std::strtod(valueText(parameter).c_str(), nullptr) : limit;
}

/// Sets a parameter of an older node. A number outside of the limits is limited.
void setLimited(const Parameter& parameter, const std::string& text) {
  try {
    setValue(parameter, text);
  } catch (const std::invalid_argument& error) {
    const std::optional<double> number = limitedNumber(parameter, text);
    if (!number) throw;
    setValue(parameter, numberText(*number));
    ROS_WARN("The parameter ~%s; %s is used.", error.what(), valueText(parameter).c_str());
  }
}

void readOldNames(const ros::NodeHandle& private_nh, const Parameter& parameter) {
  for (const std::string& name : parameter.old_names) {
    XmlRpc::XmlRpcValue value;
    if (!private_nh.getParam(name, value)) continue;
    ROS_WARN("The parameter ~%s is deprecated; its new name is ~%s.", name.c_str(),
             parameter.name.c_str());
    setValue(parameter, textOf(parameter, value));
  }
}

}  // namespace

void addUnneeded(const std::vector<Parameter>& table, const std::string& reason,
                 UnneededParameters& unneeded) {
  for (const Parameter& parameter : table) unneeded.emplace(parameter.name, reason);
}

void readPrivateParameters(const ros::NodeHandle& private_nh,
                           const std::vector<Parameter>& parameters,
                           const UnneededParameters& unneeded,
                           const std::set<std::string>& limited) {
  reportUnused(private_nh, parameters, unneeded);
  for (const Parameter& parameter : parameters) {
    readOldNames(private_nh, parameter);
    XmlRpc::XmlRpcValue value;
    if (!private_nh.getParam(parameter.name, value)) continue;
    const bool is_limited = limited.count(parameter.name) > 0;
    (is_limited ? setLimited : setValue)(parameter, textOf(parameter, value));
  }
}

void requireName(const std::string& parameter, const std::string& value) {
  if (value.empty()) throw std::invalid_argument(parameter + " = '': must not be empty");
}

void requireDistinct(const std::string& parameter, const std::string& frame,
                     const std::string& other) {
  if (frame != other) return;
  throw std::invalid_argument(parameter + " = " + frame +
                              ": another frame has the same name; the names must differ");
}

}  // namespace kestrel
