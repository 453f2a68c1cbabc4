// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/parameters/parameters.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <locale>
#include <numeric>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "kestrel_slam/sensor/range_correction.h"

namespace kestrel {
namespace {

/// Longest piece of a user's text that a message repeats.
constexpr std::size_t kMaxQuotedLength = 60;

std::string format(double value, int digits) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(digits);
  text << value;
  return text.str();
}

/// A number that is the whole text; independent of the locale, unlike strtod.
std::optional<double> parseDouble(const std::string& text) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  double value = 0.0;
  if (!(stream >> std::noskipws >> value) ||
      stream.peek() != std::istringstream::traits_type::eof())
    return std::nullopt;
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::optional<int> parseInt(const std::string& text) {
  int value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end ? std::optional(value) : std::nullopt;
}

std::optional<bool> parseBool(const std::string& text) {
  if (text == "true" || text == "1") return true;
  if (text == "false" || text == "0") return false;
  return std::nullopt;
}

/// The shortest decimal text that reads back as exactly `value`.
std::string shortestText(double value) {
  for (int digits = std::numeric_limits<double>::digits10;
       digits < std::numeric_limits<double>::max_digits10; ++digits) {
    const std::string text = format(value, digits);
    if (parseDouble(text) == value) return text;
  }
  return format(value, std::numeric_limits<double>::max_digits10);
}

std::string limitsText(const Parameter& parameter) {
  return "between " + shortestText(parameter.min) + " and " + shortestText(parameter.max) +
         (parameter.unit.empty() ? "" : " " + parameter.unit);
}

/// What a user wrote, fit for one line of a message.
std::string oneLine(const std::string& text) {
  std::string result = text.substr(0, kMaxQuotedLength);
  for (char& c : result) {
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0) c = '?';
  }
  if (text.size() > kMaxQuotedLength) result += "...";
  return result;
}

[[noreturn]] void refuse(const Parameter& parameter, const std::string& text,
                         const std::string& requirement) {
  throw std::invalid_argument(parameter.name + " = " + (text.empty() ? "''" : oneLine(text)) +
                              ": must be " + requirement);
}

bool isWithin(const Parameter& parameter, double value) {
  return value >= parameter.min && value <= parameter.max;  // false for NaN
}

template <typename T>
void assignNumber(const Parameter& parameter, T* target, const std::optional<T>& value,
                  const std::string& text, const std::string& kind) {
  if (!value) refuse(parameter, text, kind + " " + limitsText(parameter));
  if (!isWithin(parameter, static_cast<double>(*value))) {
    refuse(parameter, text, limitsText(parameter));
  }
  *target = *value;
}

void checkChoice(const Parameter& parameter, const std::string& text) {
  const auto& choices = parameter.choices;
  if (choices.empty()) return;
  if (std::find(choices.begin(), choices.end(), text) != choices.end()) return;
  std::string list;
  for (const std::string& allowed : choices) list += (list.empty() ? "" : ", ") + allowed;
  refuse(parameter, text, "one of " + list);
}

/// Parses, checks and stores the text of one parameter, according to the type of its place.
struct Assignment {
  const Parameter& parameter;
  const std::string& text;

  void operator()(double* target) const {
    assignNumber(parameter, target, parseDouble(text), text, "a number");
  }
  void operator()(int* target) const {
    assignNumber(parameter, target, parseInt(text), text, "a whole number");
  }
  void operator()(bool* target) const {
    const std::optional<bool> value = parseBool(text);
    if (!value) refuse(parameter, text, "true or false");
    *target = *value;
  }
  void operator()(std::string* target) const {
    checkChoice(parameter, text);
    *target = text;
  }
};

struct ValueText {
  std::string operator()(const double* value) const { return shortestText(*value); }
  std::string operator()(const int* value) const { return std::to_string(*value); }
  std::string operator()(const bool* value) const { return *value ? "true" : "false"; }
  std::string operator()(const std::string* value) const { return *value; }
};

/// Levenshtein distance: insertions, deletions and replacements that turn `a` into `b`.
std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0U : 1U);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

void requireLess(const char* name_a, double a, const char* name_b, double b) {
  if (a < b) return;
  throw std::invalid_argument(std::string(name_a) + " = " + shortestText(a) +
                              ": must be less than " + name_b + " = " + shortestText(b));
}

}  // namespace

std::string valueText(const Parameter& parameter) {
  return std::visit(ValueText{}, parameter.value);
}

void setValue(const Parameter& parameter, const std::string& text) {
  std::visit(Assignment{parameter, text}, parameter.value);
}

void setParameter(const std::vector<Parameter>& table, const std::string& name,
                  const std::string& text) {
  std::vector<std::string> names;
  for (const Parameter& parameter : table) {
    if (parameter.name == name) return setValue(parameter, text);
    names.push_back(parameter.name);
  }
  throw std::invalid_argument("unknown parameter '" + oneLine(name) + "'; did you mean '" +
                              nearestName(name, names) + "'?");
}

void setParameter(SlamConfig& config, const std::string& name, const std::string& text) {
  setParameter(parametersOf(config), name, text);
}

void applySettings(const std::vector<std::string>& settings, const std::vector<Parameter>& table) {
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos) {
      throw std::invalid_argument("setting '" + oneLine(setting) + "': must be name=value");
    }
    setParameter(table, setting.substr(0, equals), setting.substr(equals + 1));
  }
}

void applySettings(const std::vector<std::string>& settings, SlamConfig& config) {
  applySettings(settings, parametersOf(config));
  validate(config);
}

std::string nearestName(const std::string& name, const std::vector<std::string>& names) {
  const auto nearer = [&name](const std::string& a, const std::string& b) {
    return editDistance(a, name) < editDistance(b, name);
  };
  return *std::min_element(names.begin(), names.end(), nearer);
}

void validate(const SlamConfig& config) {
  // Setting every value to itself applies each parameter's own limits to configs made in code.
  SlamConfig copy = config;
  for (const Parameter& parameter : parametersOf(copy)) {
    setParameter(copy, parameter.name, valueText(parameter));
  }
  requireLess("laser_min_dist", config.projector.beams.min_range_m, "laser_max_dist",
              config.projector.beams.max_range_m);
  requireLess("laser_z_min_value", config.projector.slice_min_m, "laser_z_max_value",
              config.projector.slice_max_m);
  for (const std::string& angles :
       {config.projector.ignored_angles, config.projector.mirror_angles}) {
    parseAngleRanges(angles);
  }
  RangeCorrection(config.projector.range_correction);
  requireLess("map_min_probability", config.mapper.grid.min_probability, "map_max_probability",
              config.mapper.grid.max_probability);
}

}  // namespace kestrel
