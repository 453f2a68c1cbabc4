// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/live_parameters.h"

#include <ros/console.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>
#include <variant>

namespace kestrel {
namespace {

using dynamic_reconfigure::Config;
using dynamic_reconfigure::ConfigDescription;
using dynamic_reconfigure::ParamDescription;

/// The names that dynamic_reconfigure gives to the group of all parameters.
constexpr char kGroup[] = "Default";

/// Calls `use` for each row that may change.
template <typename Use>
void forEachLive(const std::vector<Parameter>& table, Use use) {
  for (const Parameter& row : table) {
    if (row.live) use(row);
  }
}

/// Appends name and value to one of the lists of a Config.
template <typename List, typename Value>
void append(List& list, const std::string& name, const Value& value) {
  auto& entry = list.emplace_back();
  entry.name = name;
  entry.value = value;
}

enum class Which { kValue, kMin, kMax };

double limitOf(const Parameter& row, Which which) {
  const double limit = which == Which::kMin ? row.min : row.max;
  return std::min(limit, std::numeric_limits<double>::max());
}

/// Appends the value or a limit of a row to a Config, in the list of its type.
struct Appender {
  const Parameter& row;
  Which which;
  Config& config;

  void operator()(const double* value) const {
    append(config.doubles, row.name, which == Which::kValue ? *value : limitOf(row, which));
  }
  void operator()(const int* value) const {
    const double most = std::numeric_limits<int>::max();
    const auto limit = static_cast<int>(std::min(limitOf(row, which), most));
    append(config.ints, row.name, which == Which::kValue ? *value : limit);
  }
  void operator()(const bool* value) const {
    append(config.bools, row.name, which == Which::kValue ? *value : which == Which::kMax);
  }
  void operator()(const std::string* value) const {
    append(config.strs, row.name, which == Which::kValue ? *value : std::string());
  }
};

Config configOf(const std::vector<Parameter>& table, Which which) {
  Config config;
  forEachLive(table, [&](const Parameter& row) {
    std::visit(Appender{row, which, config}, row.value);
  });
  auto& group = config.groups.emplace_back();
  group.name = kGroup;
  group.state = true;
  return config;
}

std::string typeOf(const Parameter& row) {
  constexpr const char* kTypes[] = {"double", "int", "bool", "str"};  // in the order of Place
  return kTypes[row.value.index()];
}

ParamDescription describe(const Parameter& row) {
  ParamDescription description;
  description.name = row.name;
  description.type = typeOf(row);
  description.description = row.description + (row.unit.empty() ? "" : " [" + row.unit + "]");
  return description;
}

/// Names and values of a request as text.
std::vector<std::pair<std::string, std::string>> textsOf(const Config& config) {
  std::vector<std::pair<std::string, std::string>> texts;
  for (const auto& entry : config.bools)
    texts.emplace_back(entry.name, entry.value != 0 ? "true" : "false");
  for (const auto& entry : config.ints) texts.emplace_back(entry.name, std::to_string(entry.value));
  for (const auto& entry : config.strs) texts.emplace_back(entry.name, entry.value);
  for (const auto& entry : config.doubles) {
    double value = entry.value;
    Parameter number;
    number.value = &value;
    texts.emplace_back(entry.name, valueText(number));
  }
  return texts;
}

}  // namespace

ConfigDescription descriptionOf(const std::vector<Parameter>& table) {
  ConfigDescription description;
  auto& group = description.groups.emplace_back();
  group.name = kGroup;
  forEachLive(table, [&](const Parameter& row) { group.parameters.push_back(describe(row)); });
  description.min = configOf(table, Which::kMin);
  description.max = configOf(table, Which::kMax);
  description.dflt = configOf(table, Which::kValue);
  return description;
}

LiveParameters::LiveParameters(ros::NodeHandle private_nh, std::vector<Parameter> table,
                               std::function<void()> on_change)
    : private_nh_(std::move(private_nh)),
      table_(std::move(table)),
      on_change_(std::move(on_change)) {
  constexpr bool kLatched = true;
  description_publisher_ =
      private_nh_.advertise<ConfigDescription>("parameter_descriptions", 1, kLatched);
  update_publisher_ = private_nh_.advertise<Config>("parameter_updates", 1, kLatched);
  server_ = private_nh_.advertiseService("set_parameters", &LiveParameters::set, this);
  forEachLive(table_, [this](const Parameter& row) { store(row); });
  description_publisher_.publish(descriptionOf(table_));
  update_publisher_.publish(configOf(table_, Which::kValue));
}

/// An exception of a service reaches the client as the error of its call.
bool LiveParameters::set(dynamic_reconfigure::Reconfigure::Request& request,
                         dynamic_reconfigure::Reconfigure::Response& response) {
  try {
    change(textsOf(request.config));
  } catch (const std::invalid_argument& error) {
    ROS_WARN("The parameters stay as they are: %s", error.what());
    throw;
  }
  response.config = configOf(table_, Which::kValue);
  update_publisher_.publish(response.config);
  return true;
}

void LiveParameters::change(const Texts& wanted) {
  const Texts before = values();
  try {
    for (const auto& [name, text] : wanted) setValue(liveRow(name), text);
    on_change_();
  } catch (const std::invalid_argument&) {
    for (const auto& [name, text] : before) setValue(liveRow(name), text);
    throw;
  }
  for (const auto& [name, text] : before) {
    const Parameter& row = liveRow(name);
    if (valueText(row) == text) continue;
    store(row);
    ROS_INFO("The parameter ~%s is now %s.", name.c_str(), valueText(row).c_str());
  }
}

const Parameter& LiveParameters::liveRow(const std::string& name) const {
  std::vector<std::string> names;
  for (const Parameter& row : table_) {
    if (row.name == name && row.live) return row;
    if (row.name == name) {
      throw std::invalid_argument(name +
                                  " cannot change while the node runs; set it before the start");
    }
    if (row.live) names.push_back(row.name);
  }
  throw std::invalid_argument("unknown parameter " + name + "; did you mean " +
                              nearestName(name, names) + "?");
}

LiveParameters::Texts LiveParameters::values() const {
  Texts texts;
  forEachLive(table_, [&](const Parameter& row) { texts.emplace_back(row.name, valueText(row)); });
  return texts;
}

/// The parameter server shows what the node uses.
void LiveParameters::store(const Parameter& row) {
  std::visit([&](const auto* value) { private_nh_.setParam(row.name, *value); }, row.value);
}

}  // namespace kestrel
