// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/parameters/parameters_text.h"

#include <sstream>

namespace kestrel {
namespace {

constexpr std::size_t kWidth = 100, kIndent = 6;  // characters

/// The text in lines of at most `kWidth` characters, each indented.
std::string wrapped(const std::string& text) {
  std::istringstream words(text);
  std::string result, line;
  for (std::string word; words >> word;) {
    if (!line.empty() && kIndent + line.size() + 1 + word.size() > kWidth) {
      result += std::string(kIndent, ' ') + line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return result + std::string(kIndent, ' ') + line + "\n";
}

/// "0.1 to 5 m", with the unit where there is one.
std::string withUnit(const std::string& text, const Parameter& parameter) {
  return parameter.unit.empty() || text.empty() ? text : text + " " + parameter.unit;
}

/// What is said of a parameter after its effect.
std::string notesOf(const Parameter& parameter, const std::string& quote) {
  std::string text = parameter.live ? " (May change in flight.)" : "";
  for (const std::string& name : parameter.old_names) {
    text += " (Old name: " + quote + name + quote + ".)";
  }
  return text;
}

std::string helpOf(const Parameter& parameter) {
  const std::string value = valueText(parameter);
  const std::string limits = withUnit(limitsText(parameter), parameter);
  return "  " + parameter.name + ": " + (value.empty() ? "''" : withUnit(value, parameter)) +
         (limits.empty() ? "" : " (" + limits + ")") + "\n" +
         wrapped(parameter.description + notesOf(parameter, ""));
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '|' ? std::string("\\|") : std::string(1, c);
  return result;
}

/// One row of a Markdown table. Code spans keep signs such as '_' as they are.
std::string rowOf(const Parameter& parameter) {
  const std::string value = valueText(parameter);
  return "| `" + parameter.name + "` | " + (value.empty() ? "empty" : "`" + value + "`") + " | " +
         parameter.unit + " | " + escaped(limitsText(parameter)) + " | " +
         escaped(parameter.description) + notesOf(parameter, "`") + " |\n";
}

template <typename Heading, typename Row>
std::string listOf(const std::vector<Parameter>& table, Heading heading, Row row) {
  std::string result, group;
  for (const Parameter& parameter : table) {
    if (result.empty() || parameter.group != group) {
      group = parameter.group;
      result += (result.empty() ? "" : "\n") + heading(group);
    }
    result += row(parameter);
  }
  return result;
}

}  // namespace

std::string parametersHelp(const std::vector<Parameter>& table) {
  return listOf(
      table, [](const std::string& group) { return group + "\n"; }, helpOf);
}

std::string parametersMarkdown(const std::vector<Parameter>& table) {
  const auto heading = [](const std::string& group) {
    return "**" + group +
           "**\n\n| name | default | unit | limits | effect |\n|---|---|---|---|---|\n";
  };
  return listOf(table, heading, rowOf);
}

}  // namespace kestrel
